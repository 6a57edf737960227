#pragma once
// Links, hinges, wall, ground, shadows.
#include <optional>

#include "render/brush.hpp"
#include "render/stage.hpp"

namespace odeval::render {

class PendulumStage final : public Stage {
 public:
  explicit PendulumStage(const Scenario& scenario);

  const PlanarFrame& frame() const override { return frame_; }
  std::vector<Vec3> extent() const override;
  bool inside(const Camera& camera, const Pose& pose) const override;
  std::vector<Layer> layers(const Camera& camera, const Pose& pose, const Pose* outline) const override;

 private:
  struct Block {
    LinkPose pose;
    BoxSize half;
  };

  bool drawable(const LinkPose& link) const;
  Block block(const Pose& pose, std::size_t link) const;
  Block rod(const Pose& pose, std::size_t link) const;
  void add_hinges(Layer& layer, const Brush& brush, const Pose& pose, double edge_px) const;

  PlanarFrame frame_;
  std::vector<Link> links_;
  double reach_m_;
  double ground_m_;  // height: a little below what links can reach; z = 0 in the report's double pendulum
  std::optional<Block> wall_;
};

}  // namespace odeval::render
