#pragma once
// The names under which `odeval audit` tells the library what to do, in the program's environment.

namespace odeval::audit::environment {

inline constexpr const char* refine = "ODEVAL_AUDIT_REFINE";          // steps in the place of one; default: 1
inline constexpr const char* hold = "ODEVAL_AUDIT_HOLD";              // "springs" (default) or "numbers"
inline constexpr const char* contacts = "ODEVAL_AUDIT_CONTACTS";      // "renewed" (default) or "held" within a step
inline constexpr const char* until = "ODEVAL_AUDIT_UNTIL";            // simulated s, then the program ends
inline constexpr const char* move = "ODEVAL_AUDIT_MOVE";              // m, bodies at the start
inline constexpr const char* record = "ODEVAL_AUDIT_RECORD";          // file; without it nothing is recorded
inline constexpr const char* most_bytes = "ODEVAL_AUDIT_MOST_BYTES";  // of the file

}  // namespace odeval::audit::environment
