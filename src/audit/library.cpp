#include "audit/library.hpp"

#include <filesystem>

#include "odeval/part.hpp"

namespace odeval::audit {

std::string library_file(const char* name) {
  const std::filesystem::path audit = part_file(ODEVAL_INSTALLED_AUDIT, ODEVAL_BUILT_AUDIT);
  const std::string file = (audit.parent_path() / name).string();  // all of them lie together
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored))
    throw MachineError(file + ": is not there; it is built with odeval");
  if (file.find_first_of(" :") != std::string::npos) {
    throw UserError(file +
                    ": has a space or a colon in its name, with which no program can load it; move it elsewhere");
  }
  return file;
}

}  // namespace odeval::audit
