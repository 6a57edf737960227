#pragma once
// Solids of any kind that bodies carry, over what stands in the world.
#include <optional>

#include "render/brush.hpp"
#include "render/joint_marks.hpp"
#include "render/scenery.hpp"
#include "render/stage.hpp"

namespace odeval::render {

struct Solid {
  enum class Kind { box, sphere, capsule, cylinder };
  Kind kind = Kind::box;
  Vec3 size_m{};                      // sides; of others radius, and length along z without a capsule's ends
  LinkPose place;                     // in the body's frame, or the world's; across, hinge and along are its x, y and z
  std::optional<std::size_t> body{};  // of the pose; none: it stands in the world
};

/// What is above `normal . p >= offset` is free, below is ground.
struct Ground {
  Vec3 normal;
  double offset_m;
};

class SolidStage final : public Stage {
 public:
  /// `up` is a unit vector. The camera holds the bodies of `shown`; what stands in the world is seen where it is no
  /// larger than the scene.
  SolidStage(std::vector<Solid> solids, const std::vector<Ground>& grounds, const Vec3& up, std::span<const Pose> shown,
             JointMarks joints = {});

  const PlanarFrame& frame() const override { return frame_; }
  std::vector<Vec3> extent() const override;
  bool inside(const Camera& camera, const Pose& pose) const override;
  std::vector<Layer> layers(const Camera& camera, const Pose& pose, const Pose* outline) const override;

 private:
  bool seen(const Solid& solid, const Pose& pose) const;

  std::vector<Solid> solids_;
  JointMarks joints_;
  PlanarFrame frame_ = space_frame;  // its hinge is the middle of what is shown
  double reach_m_ = 0;
  std::optional<GroundPlane> ground_;
};

}  // namespace odeval::render
