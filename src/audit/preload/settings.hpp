#pragma once
// What the audit asks of the library, in the program's environment.
#include <string>

namespace odeval::audit {

struct Settings {
  int refinement = 1;          // steps in the place of one
  bool hold_springs = true;    // else the numbers ERP, CFM, damping
  bool renew_contacts = true;  // between those steps
  double until_s = 0;          // simulated, then the program ends; 0: as it likes
  std::string set;             // in place of the program's settings
  bool timed = false;          // some steps, within ODE
  double move_m = 0;           // bodies at the start
  std::string record;          // file; empty: nothing is recorded
  bool motions = false;        // velocities are recorded as well
  bool ledger = false;         // of what acts on the bodies; with motions; needs the record and a refinement of 1
  double most_bytes = 0;       // of the record; 0: as many as there are
};

Settings read_settings();

}  // namespace odeval::audit
