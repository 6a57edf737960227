#pragma once
// The names under which `odeval audit` tells the library what to do, in the program's environment.

#include <array>

namespace odeval::audit::environment {

inline constexpr const char* refine = "ODEVAL_AUDIT_REFINE";          // steps in the place of one; default: 1
inline constexpr const char* hold = "ODEVAL_AUDIT_HOLD";              // "springs" (default) or "numbers"
inline constexpr const char* contacts = "ODEVAL_AUDIT_CONTACTS";      // "renewed" (default) or "held" within a step
inline constexpr const char* until = "ODEVAL_AUDIT_UNTIL";            // simulated s, then the program ends
inline constexpr const char* set = "ODEVAL_AUDIT_SET";                // "erp=0.8,stepper=quick", of `tries`
inline constexpr const char* move = "ODEVAL_AUDIT_MOVE";              // m, bodies at the start
inline constexpr const char* record = "ODEVAL_AUDIT_RECORD";          // file; without it nothing is recorded
inline constexpr const char* ledger = "ODEVAL_AUDIT_LEDGER";          // "1": works, joints, contacts and geoms as well
inline constexpr const char* motions = "ODEVAL_AUDIT_MOTIONS";        // "1": velocities as well; with a ledger always
inline constexpr const char* timed = "ODEVAL_AUDIT_TIMED";            // "1": some steps, within ODE
inline constexpr const char* most_bytes = "ODEVAL_AUDIT_MOST_BYTES";  // of the file

// Of the simulated clock, a library of its own.
inline constexpr const char* tick = "ODEVAL_AUDIT_TICK";  // s, of a reading before which nothing was simulated

// Of the step that stepper=accurate stands for.
inline constexpr const char* accurate = "ODEVAL_AUDIT_ACCURATE";  // its library's file

/// A setting of the program that can be tried otherwise: a number within a range, or one of the words.
struct Try {
  const char* key;
  double least;
  double most;
  const char* words;  // with commas; empty: a number
  bool whole = false;
};
inline constexpr std::array tries{
    Try{"erp", 0, 1, ""},
    Try{"cfm", 0, 1e9, ""},
    Try{"iterations", 1, 1e6, "", true},
    Try{"w", 1e-3, 2, ""},
    Try{"max_correcting_vel", 0, 1e9, ""},
    Try{"surface_layer", 0, 1e9, ""},
    Try{"stepper", 0, 0, "step,quick,accurate"},
    Try{"rotation", 0, 0, "finite,infinitesimal"},
    Try{"start", 0, 0, "half-step"},
};

}  // namespace odeval::audit::environment
