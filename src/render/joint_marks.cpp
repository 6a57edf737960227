#include "render/joint_marks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "odeval/frame.hpp"
#include "render/scenery.hpp"

namespace odeval::render {
namespace {

/// In its radii: how far a pin stands out, and the centre line beyond it; half a pin that is in no body.
constexpr double stands_out = 0.8;
constexpr double centre_line = 3;
constexpr double alone = 4;
// In reaches of the scene: where a pin ends inside a body that is longer, and what a rail goes on by.
constexpr double longest = 0.25;
constexpr double beyond = 0.3;

Vec3 in_world(const LinkPose& body, const Vec3& v) {
  return v[0] * body.across + v[1] * body.hinge + v[2] * body.along;
}

/// As a body has it at the start.
Vec3 in_body(const Body& body, const Vec3& v) {
  const Rotation rotation = rotation_of_vector(rotation_vector(body.attitude));
  return {dot(v, axis_of(rotation, 0)), dot(v, axis_of(rotation, 1)), dot(v, axis_of(rotation, 2))};
}

Vec3 half_m(const Body& body) { return 0.5 * sides_m(body.shape); }

}  // namespace

void add_centre_line(Layer& layer, const Brush& brush, const Vec3& at, const Vec3& axis, const Ends& pin, double radius,
                     double edge_px) {
  const double more = centre_line * radius;
  for (const auto& [from, to] : {std::pair{pin.low, pin.low - more}, {pin.high, pin.high + more}}) {
    brush.line(layer, at + from * axis, at + to * axis, 1.5 * edge_px, joint_colour, joint_colour);
  }
}

JointMarks::JointMarks(const Mechanism& mechanism) : bodies_(mechanism.bodies) {
  for (const Joint& joint : mechanism.joints) {
    const Freedom freedom = freedom_of(joint.kind);
    if (freedom.ways.size() == 1 && freedom.turns.size() < 2) {
      add_mark(Kind::rail, joint, freedom.ways.front(), joint.second);
    }
    if (freedom.turns.size() == 3) {
      add_mark(Kind::ball, joint, {}, joint.second);
    } else if (freedom.ways.size() < 2) {
      for (std::size_t k = 0; k < freedom.turns.size(); ++k) {
        const bool with_first = freedom.turns.size() == 2 && k == 0;
        add_mark(Kind::pin, joint, freedom.turns[k], with_first ? std::optional(joint.first) : joint.second);
      }
    }
  }
}

void JointMarks::add_mark(Kind kind, const Joint& joint, const Vec3& axis, std::optional<std::size_t> turns_with) {
  Mark mark{kind, joint.first, joint.second, anchor_m(joint.kind), turns_with, axis};
  if (joint.second) mark.at = in_body(bodies_[*joint.second], mark.at - bodies_[*joint.second].position_m);
  if (turns_with) mark.axis = in_body(bodies_[*turns_with], axis);
  marks_.push_back(mark);
}

/// Of a pin a third of the thinnest half of its bodies, of a ball so much that it stands out of them; never too small
/// to see, nor so large that it hides them.
double JointMarks::radius(const Mark& mark, double reach_m) const {
  double thinnest = std::ranges::min(half_m(bodies_[mark.first]));
  if (mark.second) thinnest = std::min(thinnest, std::ranges::min(half_m(bodies_[*mark.second])));
  if (mark.kind == Kind::ball) return std::clamp(1.25 * thinnest, 0.02 * reach_m, 0.06 * reach_m);
  return std::clamp(0.35 * thinnest, 0.012 * reach_m, 0.035 * reach_m);
}

/// Where the axis leaves the boxes of the bodies around the joint.
Ends JointMarks::ends(const Mark& mark, const Pose& pose, const Vec3& at, const Vec3& axis, double radius) const {
  Ends ends{-alone * radius, alone * radius};
  const auto reach_through = [&](std::size_t number) {
    const LinkPose& body = pose[number];
    const Vec3 half = half_m(bodies_[number]);
    const std::array directions{body.across, body.hinge, body.along};
    double low = -std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::size_t k = 0; k < 3; ++k) {
      const double from = dot(at - body.centre_m, directions[k]);
      const double rate = dot(axis, directions[k]);
      if (std::fabs(rate) < 1e-9) {
        if (std::fabs(from) > half[k]) return;
        continue;
      }
      const double one = (-half[k] - from) / rate;
      const double other = (half[k] - from) / rate;
      low = std::max(low, std::min(one, other));
      high = std::min(high, std::max(one, other));
    }
    if (low > high || low > radius || high < -radius || !std::isfinite(high - low)) return;  // elsewhere
    ends.low = std::min(ends.low, low);
    ends.high = std::max(ends.high, high);
  };
  reach_through(mark.first);
  if (mark.second) reach_through(*mark.second);
  return ends;
}

void JointMarks::add(Layer& layer, const Brush& brush, const Pose& pose, const std::vector<bool>& seen, double reach_m,
                     double edge_px) const {
  for (const Mark& mark : marks_) {
    if (!seen[mark.first] || (mark.second && !seen[*mark.second])) continue;
    const Vec3 at = mark.second ? pose[*mark.second].centre_m + in_world(pose[*mark.second], mark.at) : mark.at;
    const Vec3 axis = mark.turns_with ? in_world(pose[*mark.turns_with], mark.axis) : mark.axis;
    const double thick = radius(mark, reach_m);
    if (mark.kind == Kind::ball) {
      brush.sphere(layer, {at, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, thick, joint_colour, edge_px);
      continue;
    }
    auto [low, high] = ends(mark, pose, at, axis, thick);
    const bool slides = mark.kind == Kind::rail;
    const double more = slides ? beyond * reach_m : stands_out * thick;
    low = std::max(low, -longest * reach_m) - more;
    high = std::min(high, longest * reach_m) + more;
    brush.cylinder(layer, at + (low + high) / 2 * axis, axis, slides ? thick / 2 : thick, (high - low) / 2,
                   joint_colour, edge_px);
    if (!slides) add_centre_line(layer, brush, at, axis, {low, high}, thick, edge_px);
  }
}

}  // namespace odeval::render
