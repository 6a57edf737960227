#pragma once
// A setting from the command line that replaces one of the scenario file.
#include <string>

namespace odeval {

struct Override {
  std::string key;     // as in the file, dotted: "duration", "ode.erp", "links.0.mass", "q0", "q0.1"
  std::string value;   // as in the file: 2, [1.0, 0.5], "half-step"; a bare word needs no quotes
  std::string origin;  // what the user typed: --erp, --set
};

/// The setting as the user typed it: `--erp 1.5`, `--set q0=[1.0]`.
std::string typed(const Override& setting);

}  // namespace odeval
