#pragma once
// OpenGL without a display: the one class behind which OSMesa or EGL stands, as CMake's ODEVAL_OFFSCREEN says.
#include <memory>

namespace odeval::render {

/// A software framebuffer of colour, depth (24 bits) and stencil (8 bits), current from construction on.
/// One at a time in a process.
class OffscreenContext {
 public:
  /// Throws MachineError when the library gives no such context.
  OffscreenContext(int width, int height);
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  int width() const { return width_; }
  int height() const { return height_; }

 private:
  struct Library;  // what the library behind it needs
  int width_;
  int height_;
  std::unique_ptr<Library> library_;
};

}  // namespace odeval::render
