#include "audit/library.hpp"

#include <filesystem>

#include "odeval/error.hpp"

namespace odeval::audit {

// Beside the installed program, wherever that was moved to, or in the build tree.
std::string library_file() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = program.parent_path().parent_path() / ODEVAL_INSTALLED_AUDIT;
  const std::string file = fs::is_regular_file(installed, ignored) ? installed.string() : ODEVAL_BUILT_AUDIT;
  if (!fs::is_regular_file(file, ignored)) throw MachineError(file + ": is not there; it is built with odeval");
  if (file.find_first_of(" :") != std::string::npos) {
    throw UserError(file +
                    ": has a space or a colon in its name, with which no program can load it; move it elsewhere");
  }
  return file;
}

}  // namespace odeval::audit
