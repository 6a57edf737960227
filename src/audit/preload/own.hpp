#pragma once
// ODE's own functions, behind those that this library puts before them.
#include <ode/ode.h>

namespace odeval::audit {

/// The next function of that name after this library. Ends the program when there is none.
void* behind(const char* name);

}  // namespace odeval::audit

#define ODEVAL_OWN(function)                                                                             \
  ([] {                                                                                                  \
    static const auto own = reinterpret_cast<decltype(&::function)>(::odeval::audit::behind(#function)); \
    return own;                                                                                          \
  }())
