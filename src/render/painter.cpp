#include "render/painter.hpp"

#include <dlfcn.h>

#include <string>

#include "odeval/error.hpp"

namespace odeval::render {

// The module stays loaded: the painters it made are its own code.
std::unique_ptr<Painter> open_painter(int width, int height) {
  void* const module = dlopen(ODEVAL_PAINTER, RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) throw MachineError(std::string("pictures: ") + dlerror());
  using Make = Painter* (*)(int, int);
  const auto make = reinterpret_cast<Make>(dlsym(module, "odeval_make_painter"));
  if (make == nullptr) throw MachineError(std::string("pictures: ") + dlerror());
  return std::unique_ptr<Painter>(make(width, height));
}

}  // namespace odeval::render
