#include <dlfcn.h>

#include <filesystem>

#include "odeval/error.hpp"
#include "reference/tree/simbody_tree.hpp"

namespace odeval::reference {
namespace {

// By its full path, as pictures do it: beside the installed program, or in the build tree.
std::string module_path() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = program.parent_path().parent_path() / ODEVAL_INSTALLED_SIMBODY;
  return fs::is_regular_file(installed, ignored) ? installed.string() : ODEVAL_BUILT_SIMBODY;
}

}  // namespace

// The module stays loaded: the trees it made are its own code.
std::unique_ptr<SimbodyTree> open_simbody_tree(const Mechanism& mechanism, const std::vector<Branch>& tree,
                                               double gravity) {
  void* const module = dlopen(module_path().c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) throw MachineError(std::string("reference: ") + dlerror());
  using Make = SimbodyTree* (*)(const Mechanism*, const std::vector<Branch>*, double);
  const auto make = reinterpret_cast<Make>(dlsym(module, "odeval_make_simbody_tree"));
  if (make == nullptr) throw MachineError(std::string("reference: ") + dlerror());
  return std::unique_ptr<SimbodyTree>(make(&mechanism, &tree, gravity));
}

}  // namespace odeval::reference
