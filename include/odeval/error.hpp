#pragma once
// What can go wrong, by who can mend it: the exit status of the program follows the type.
#include <stdexcept>

namespace odeval {

/// Bad input: names the file or flag, the key, the value and what would be right. Exit status 2.
class UserError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The machine or a library failed: a full disk, a solver that gave up. Exit status 3.
class MachineError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace odeval
