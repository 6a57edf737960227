#include "render/painter.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <string>

#include "odeval/error.hpp"

namespace odeval::render {

namespace {

// By its full path: beside the installed program, wherever that was moved to, or in the build tree.
std::string module_path() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = program.parent_path().parent_path() / ODEVAL_INSTALLED_PAINTER;
  return fs::is_regular_file(installed, ignored) ? installed.string() : ODEVAL_BUILT_PAINTER;
}

}  // namespace

// The module stays loaded: the painters it made are its own code.
std::unique_ptr<Painter> open_painter(int width, int height) {
  void* const module = dlopen(module_path().c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) throw MachineError(std::string("pictures: ") + dlerror());
  using Make = Painter* (*)(int, int);
  const auto make = reinterpret_cast<Make>(dlsym(module, "odeval_make_painter"));
  if (make == nullptr) throw MachineError(std::string("pictures: ") + dlerror());
  return std::unique_ptr<Painter>(make(width, height));
}

std::string opengl_version() {
  try {
    return open_painter(1, 1)->version();
  } catch (const MachineError& error) {
    return std::string("none: ") + error.what();
  }
}

}  // namespace odeval::render
