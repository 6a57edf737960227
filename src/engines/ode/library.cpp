#include "engines/ode/library.hpp"

#include <ode/ode.h>

#include <cstdarg>
#include <cstdio>
#include <utility>

namespace odeval::engine_ode {
namespace {

Messages messages;

std::string text_of(const char* format, va_list arguments) {
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  return text;
}

void count_message(int, const char* format, va_list arguments) {
  if (messages.count++ == 0) messages.first = text_of(format, arguments);
}

// ODE aborts when this handler returns, so it does not. Every frame between here and the caller is C++ with unwind
// tables, in ODE as in this project.
[[noreturn]] void throw_fault(int number, const char* format, va_list arguments) {
  throw Fault("ODE gave up (" + std::to_string(number) + "): " + text_of(format, arguments));
}

// Never closed: a world left behind by a fault would make dCloseODE abort, and the process ends soon after anyway.
struct Library {
  Library() {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    dSetMessageHandler(count_message);
    dSetDebugHandler(throw_fault);
    dSetErrorHandler(throw_fault);
  }
};

}  // namespace

void use_library() { static const Library library; }

Messages take_messages() { return std::exchange(messages, {}); }

}  // namespace odeval::engine_ode
