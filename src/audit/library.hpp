#pragma once
// The library that is loaded beside a program.
#include <string>

namespace odeval::audit {

/// Its full path. Throws UserError where LD_PRELOAD cannot name it.
std::string library_file();

}  // namespace odeval::audit
