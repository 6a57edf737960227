#include "catalogue/paths.hpp"

namespace odeval::catalogue {

// Beside the program when it is installed, wherever that was moved to; else in the source tree it was built from.
std::filesystem::path scenario_folder() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = program.parent_path().parent_path() / ODEVAL_INSTALLED_DATA / "scenarios";
  if (fs::is_directory(installed, ignored)) return installed;
  return fs::path(ODEVAL_SOURCE_DIR) / "scenarios";
}

}  // namespace odeval::catalogue
