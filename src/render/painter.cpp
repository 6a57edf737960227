#include "render/painter.hpp"

#include <string>

#include "odeval/part.hpp"

namespace odeval::render {

std::unique_ptr<Painter> open_painter(int width, int height) {
  using Make = Painter* (*)(int, int);
  const std::string module = part_file(ODEVAL_INSTALLED_PAINTER, ODEVAL_BUILT_PAINTER);
  return std::unique_ptr<Painter>(part_function<Make>(module, "odeval_make_painter", "pictures")(width, height));
}

std::string opengl_version() {
  try {
    return open_painter(1, 1)->version();
  } catch (const MachineError& error) {
    return std::string("none: ") + error.what();
  }
}

}  // namespace odeval::render
