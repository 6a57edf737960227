// OSMesa: Mesa's software rasteriser draws into plain memory.
#include <GL/osmesa.h>

#include <string>
#include <vector>

#include "odeval/error.hpp"
#include "render/offscreen_context.hpp"

namespace odeval::render {

struct OffscreenContext::Library {
  OSMesaContext context = nullptr;
  std::vector<GLubyte> memory;

  ~Library() {
    if (context != nullptr) OSMesaDestroyContext(context);
  }
};

OffscreenContext::OffscreenContext(int width, int height)
    : width_(width), height_(height), library_(std::make_unique<Library>()) {
  constexpr int attributes[] = {OSMESA_FORMAT,
                                OSMESA_RGBA,
                                OSMESA_DEPTH_BITS,
                                24,
                                OSMESA_STENCIL_BITS,
                                8,
                                OSMESA_PROFILE,
                                OSMESA_COMPAT_PROFILE,
                                0};
  library_->context = OSMesaCreateContextAttribs(attributes, nullptr);
  library_->memory.resize(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (library_->context == nullptr ||
      OSMesaMakeCurrent(library_->context, library_->memory.data(), GL_UNSIGNED_BYTE, width, height) == GL_FALSE) {
    throw MachineError("OSMesa gives no OpenGL context of " + std::to_string(width) + "x" + std::to_string(height));
  }
}

OffscreenContext::~OffscreenContext() = default;

}  // namespace odeval::render
