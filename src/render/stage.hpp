#pragma once
// What is seen of a scenario: links, hinges, wall, ground, shadows.
#include <optional>
#include <vector>

#include "render/brush.hpp"
#include "render/camera.hpp"
#include "render/layer.hpp"
#include "render/pose.hpp"

namespace odeval::render {

/// The unmoving part of a scenario's pictures, ready to receive poses.
class Stage {
 public:
  explicit Stage(const Scenario& scenario);

  /// Points around all that links can reach about the first hinge, and the wall.
  std::vector<Vec3> extent() const;

  /// Whether all of the links are drawn, and within the picture.
  bool inside(const Camera& camera, const Pose& pose) const;

  /// The pose, and over it the edges of a second one where there is one. Links of which a number is beyond drawing
  /// (a run that blew up) are left out.
  std::vector<Layer> layers(const Camera& camera, const Pose& pose, const Pose* outline) const;

 private:
  struct Block {
    LinkPose pose;
    BoxSize half;
  };

  bool drawable(const LinkPose& link) const;
  Block block(const Pose& pose, std::size_t link) const;
  Block rod(const Pose& pose, std::size_t link) const;
  void add_ground(std::vector<Layer>& layers, const Brush& brush, const Camera& camera) const;
  void add_shadows(std::vector<Layer>& layers, const std::vector<Block>& casters, const HalfSpace& ground,
                   const std::vector<HalfSpace>& within) const;
  void add_hinges(Layer& layer, const Brush& brush, const Pose& pose, double edge_px) const;
  Vec3 lamp() const;

  PlanarFrame frame_;
  std::vector<Link> links_;
  double reach_m_;
  double ground_m_;  // height: a little below what links can reach; z = 0 in the report's double pendulum
  std::optional<Block> wall_;
};

}  // namespace odeval::render
