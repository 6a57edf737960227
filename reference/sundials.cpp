#include "reference/sundials.hpp"

#include <cvodes/cvodes.h>

#include "odeval/error.hpp"

namespace odeval::reference {
namespace {

#if SUNDIALS_VERSION_MAJOR >= 7
const SUNComm no_communicator = SUN_COMM_NULL;

void keep(int, const char*, const char*, const char* message, SUNErrCode, void* last, SUNContext) {
  *static_cast<std::string*>(last) = message;
}
#else
void* const no_communicator = nullptr;

void keep(int, const char*, const char*, char* message, void* last) { *static_cast<std::string*>(last) = message; }
#endif

}  // namespace

SUNContext make_sundials_context() {
  SUNContext context = nullptr;
  if (SUNContext_Create(no_communicator, &context) != 0) {
    throw MachineError("CVODE: could not create a SUNDIALS context");
  }
  return context;
}

#if SUNDIALS_VERSION_MAJOR >= 7
void keep_last_message(SUNContext context, void*, std::string& last) {
  SUNContext_ClearErrHandlers(context);  // of the one that prints to stderr
  if (SUNContext_PushErrHandler(context, keep, &last) != 0 ||
      SUNContext_SetLogger(context, nullptr) != 0) {  // whose warnings go to stdout
    throw MachineError("CVODE: SUNDIALS takes no handler of messages");
  }
}
#else
void keep_last_message(SUNContext, void* cvodes, std::string& last) {
  if (CVodeSetErrHandlerFn(cvodes, keep, &last) != CV_SUCCESS) {
    throw MachineError("CVODE: SUNDIALS takes no handler of messages");
  }
}
#endif

}  // namespace odeval::reference
