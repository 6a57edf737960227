#pragma once
// What SUNDIALS 6 and 7 do each in their own way: the context, and where messages go.
#include <sundials/sundials_context.h>

#include <string>

namespace odeval::reference {

/// A context of one process. Throws MachineError when there is no memory for it.
SUNContext make_sundials_context();

/// From now on `last` holds what CVODES said last, which is printed nowhere. `cvodes` was made in `context`; `last` has
/// to outlive both.
void keep_last_message(SUNContext context, void* cvodes, std::string& last);

}  // namespace odeval::reference
