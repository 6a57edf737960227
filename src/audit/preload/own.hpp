#pragma once
// ODE's own functions, behind those that this library puts before them.
#include <ode/ode.h>

namespace odeval::audit {

/// The next function of that name after this library. Ends the program when there is none.
void* behind(const char* name);

}  // namespace odeval::audit

// In a program that is linked to a static ODE the linker puts them there: --wrap=NAME has calls of NAME go to
// __wrap_NAME, and of __real_NAME to ODE's.
#ifdef ODEVAL_AUDIT_WRAP
#define ODEVAL_BEFORE(function) __wrap_##function
#define ODEVAL_OWN(function)                                                  \
  ([] {                                                                       \
    extern decltype(::function) real_##function __asm__("__real_" #function); \
    return &real_##function;                                                  \
  }())
#else
#define ODEVAL_BEFORE(function) function
#define ODEVAL_OWN(function)                                                                             \
  ([] {                                                                                                  \
    static const auto own = reinterpret_cast<decltype(&::function)>(::odeval::audit::behind(#function)); \
    return own;                                                                                          \
  }())
#endif
