#pragma once
// Links, hinges, wall, ground, shadows.
#include <optional>
#include <span>
#include <vector>

#include "render/brush.hpp"
#include "render/scenery.hpp"
#include "render/stage.hpp"

namespace odeval::render {

class PendulumStage final : public Stage {
 public:
  PendulumStage(const Scenario& scenario, std::span<const Pose> shown);

  const PlanarFrame& frame() const override { return frame_; }
  std::vector<Vec3> extent() const override { return extent_; }
  bool inside(const Camera& camera, const Pose& pose) const override;
  std::vector<Layer> layers(const Camera& camera, const Pose& pose, const Pose* outline) const override;

 private:
  struct Block {
    LinkPose pose;
    BoxSize half;
  };

  Block wall_of(const PlanarView& view) const;
  std::vector<Vec3> reachable() const;
  std::vector<Vec3> around(std::span<const Pose> shown) const;
  bool drawable(const LinkPose& link) const;
  Block block(const Pose& pose, std::size_t link) const;
  Block rod(const Pose& pose, std::size_t link) const;
  std::vector<Quad> casters_of(const Pose& pose) const;
  void add_floor(std::vector<Layer>& layers, const Brush& brush, const Camera& camera, std::vector<Quad> casters,
                 const Vec3& towards_lamp) const;
  void add_wall(std::vector<Layer>& layers, const Brush& brush, const Camera& camera, const std::vector<Quad>& casters,
                const Vec3& towards_lamp) const;
  void add_links(Layer& links, const Brush& brush, const Pose& pose, double edge_px) const;
  void add_wires(Layer& wires, const Brush& brush, const Pose& pose, const Colour& colour, double px) const;
  void add_hinges(Layer& layer, const Brush& brush, const Pose& pose, double edge_px) const;

  PlanarFrame frame_;
  std::vector<Link> links_;
  double reach_m_;
  double ground_m_;  // height: a little below what links can reach; z = 0 in the report's double pendulum
  std::optional<Block> wall_;
  std::vector<Vec3> extent_;
};

}  // namespace odeval::render
