#pragma once
// Joints as pictures show them: a pin along each axis of a hinge, which stands out of the bodies around it and goes on
// as a centre line; a ball; a rail along a way.
#include <optional>
#include <span>
#include <vector>

#include "odeval/mechanism.hpp"
#include "render/brush.hpp"

namespace odeval::render {

/// Of a pin, along its axis from the joint, m.
struct Ends {
  double low, high;
};

/// An axis goes on beyond both ends of its pin as a thin line.
void add_centre_line(Layer& layer, const Brush& brush, const Vec3& at, const Vec3& axis, const Ends& pin, double radius,
                     double edge_px);

class JointMarks {
 public:
  JointMarks() = default;

  /// Each keeps its place in the second body, or the world, so that a joint that opens is seen to open; an axis that is
  /// fixed in the first body turns with that.
  explicit JointMarks(const Mechanism& mechanism);

  /// Bodies of which `seen` is false are left out with their joints. `reach_m`: half the size of the scene.
  void add(Layer& layer, const Brush& brush, const Pose& pose, const std::vector<bool>& seen, double reach_m,
           double edge_px) const;

 private:
  enum class Kind { pin, ball, rail };
  struct Mark {
    Kind kind = Kind::pin;
    std::size_t first = 0;
    std::optional<std::size_t> second = {};      // none: the world
    Vec3 at{};                                   // in the axes of the second from its centre, or in the world
    std::optional<std::size_t> turns_with = {};  // none: the world
    Vec3 axis{};                                 // unit, in the axes of that body; of a ball none
  };

  void add_mark(Kind kind, const Joint& joint, const Vec3& axis, std::optional<std::size_t> turns_with);
  double radius(const Mark& mark, double reach_m) const;
  Ends ends(const Mark& mark, const Pose& pose, const Vec3& at, const Vec3& axis, double radius) const;

  std::vector<Body> bodies_;
  std::vector<Mark> marks_;
};

}  // namespace odeval::render
