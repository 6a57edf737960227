#pragma once
// What is seen of a scenario.
#include <memory>
#include <span>
#include <vector>

#include "render/camera.hpp"
#include "render/layer.hpp"
#include "render/pose.hpp"

namespace odeval::render {

/// The unmoving part of a scenario's pictures, ready to receive poses.
class Stage {
 public:
  virtual ~Stage() = default;

  /// How the scene lies in the world; its hinge is what a camera looks at.
  virtual const PlanarFrame& frame() const = 0;

  /// Points around all that will be seen.
  virtual std::vector<Vec3> extent() const = 0;

  /// Whether all of the bodies are drawn, and within the picture.
  virtual bool inside(const Camera& camera, const Pose& pose) const = 0;

  /// The pose, and over it the edges of a second one where there is one. Bodies of which a number is beyond drawing
  /// (a run that blew up) are left out.
  virtual std::vector<Layer> layers(const Camera& camera, const Pose& pose, const Pose* outline) const = 0;
};

/// `shown` are poses that pictures will show, or poses near them, which the camera then holds. Without them it holds
/// all that a pendulum can reach; where bodies will be, only they tell.
std::unique_ptr<Stage> make_stage(const Scenario& scenario, std::span<const Pose> shown);

}  // namespace odeval::render
