#pragma once
// Paints layers as a camera sees them.
#include <memory>
#include <span>
#include <string>

#include "render/camera.hpp"
#include "render/image.hpp"
#include "render/layer.hpp"

namespace odeval::render {

class Painter {
 public:
  virtual ~Painter() = default;

  /// On white. Same layers and camera, same bytes. Throws MachineError when OpenGL fails.
  Image paint(std::span<const Layer> layers, const Camera& camera) {
    return paint(layers, camera, {0, 0, camera.width(), camera.height()});
  }
  /// The same bytes in that part of the picture, and nothing elsewhere.
  virtual Image paint(std::span<const Layer> layers, const Camera& camera, const Tile& part) = 0;

  /// OpenGL's own words: "4.5 (Compatibility Profile) Mesa 25.0.7".
  virtual std::string version() const = 0;
};

/// For pictures up to this size. Loads OpenGL, which only pictures need and which takes longer to load than a run takes
/// to compute. Throws MachineError when there is no OpenGL.
std::unique_ptr<Painter> open_painter(int width, int height);

/// The painter's version, or why there is none.
std::string opengl_version();

}  // namespace odeval::render
