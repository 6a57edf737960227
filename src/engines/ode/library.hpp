#pragma once
// ODE's process-wide parts: initialisation, error handlers, and what its faults become.
#include <stdexcept>
#include <string>

namespace odeval::engine_ode {

/// ODE gave up inside a call: an assertion of the library that would have aborted the process. The world it happened in
/// must not be used or destroyed any more.
class Fault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Initialises ODE and installs the handlers, once a process. Call it before any other function of ODE.
void use_library();

/// Messages (such as "LCP internal error"); each is counted instead of printed, since printing flushes a stream in the
/// middle of a step.
struct Messages {
  long count = 0;
  std::string first;  // the text of the first
};

/// Those since the last call.
Messages take_messages();

}  // namespace odeval::engine_ode
