#pragma once
// Boxes and spheres: on their ground, on a joint to the world, or in free flight, where the camera goes with them.
#include <optional>

#include "render/brush.hpp"
#include "render/joint_marks.hpp"
#include "render/scenery.hpp"
#include "render/stage.hpp"

namespace odeval::render {

class BodyStage final : public Stage {
 public:
  BodyStage(const Scenario& scenario, std::span<const Pose> shown);

  const PlanarFrame& frame() const override { return frame_; }
  std::vector<Vec3> extent() const override { return extent_; }
  bool inside(const Camera& camera, const Pose& pose) const override;
  std::vector<Layer> layers(const Camera& camera, const Pose& pose, const Pose* outline) const override;

 private:
  double radius(std::size_t body) const;
  BoxSize half(std::size_t body) const;
  bool drawable(const LinkPose& body) const;
  Vec3 shift(const Pose& pose) const;
  Pose moved(Pose pose, const Vec3& by) const;
  void add_body(Layer& layer, const Brush& brush, const Pose& pose, std::size_t body, double edge_px) const;
  void add_wires(Layer& layer, const Brush& brush, const Pose& pose, const Colour& colour, double px) const;

  std::vector<Body> bodies_;
  JointMarks joints_;
  PlanarFrame frame_;  // its hinge is the middle of what is shown
  std::vector<Vec3> extent_;
  double reach_m_ = 0;
  bool free_;                // nothing holds them in the world
  std::optional<Vec3> pin_;  // of a joint to the world, which the camera holds
  std::optional<GroundPlane> ground_;
};

}  // namespace odeval::render
