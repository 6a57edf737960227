#pragma once
// What can go wrong, by who can mend it: the exit status of the program follows the type.
//
// Whatever a function of odeval throws is one of these two, or a standard exception for a mistake of ours (a logic
// error). Their text is one line for the terminal, without the program's name and without a full stop.
#include <stdexcept>

namespace odeval {

/// Bad input. Names the file or flag, the key, the value and what would be right. Exit status 2.
class UserError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;  // the whole line
};

/// The machine or a library failed: a full disk, a solver that gave up. Exit status 3.
class MachineError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;  // the whole line
};

}  // namespace odeval
