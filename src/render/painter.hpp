#pragma once
// Paints layers as a camera sees them. Knows OpenGL and nothing of what the layers mean.
#include <span>
#include <vector>

#include "render/camera.hpp"
#include "render/image.hpp"
#include "render/layer.hpp"
#include "render/offscreen_context.hpp"

namespace odeval::render {

/// Holds the one OpenGL context. Every pixel is the mean of `samples` x `samples`; large pictures are painted in tiles,
/// so that memory does not grow with them.
class Painter {
 public:
  /// For pictures up to this size. Throws MachineError when there is no OpenGL context.
  Painter(int width, int height);

  /// On white. Same layers and camera, same bytes.
  Image paint(std::span<const Layer> layers, const Camera& camera);

 private:
  OffscreenContext context_;
  std::vector<std::uint8_t> read_back_;
};

}  // namespace odeval::render
