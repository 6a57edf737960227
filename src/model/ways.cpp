#include "odeval/ways.hpp"

#include <cmath>

#include "odeval/work.hpp"

namespace odeval {
namespace {

/// A direction of the world in the body's own axes.
Vec3 inside(const BodyState& body, const Vec3& v) {
  return {dot(v, axis_of(body.rotation, 0)), dot(v, axis_of(body.rotation, 1)), dot(v, axis_of(body.rotation, 2))};
}

/// A direction at right angles to a unit one.
Vec3 across(const Vec3& axis) {
  const bool along_x = std::fabs(axis[0]) > 0.7;
  return unit(cross(axis, along_x ? Vec3{0, 1, 0} : Vec3{1, 0, 0}));
}

/// The world as a body.
const BodyState world{.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};

const BodyState& second_of(std::optional<std::size_t> second, std::span<const BodyState> bodies) {
  return second ? bodies[*second] : world;
}

/// Of a point that is fixed in a body: where it is and how fast.
struct Point {
  Vec3 place;
  Vec3 velocity;

  Point(const BodyState& body, const Vec3& own)
      : place(body.position + turned(body.rotation, own)),
        velocity(body.velocity + cross(body.spin, place - body.position)) {}
};

Vec3 axis_of_kind(const JointKind& kind) {
  if (const auto* const hinge = std::get_if<HingeJoint>(&kind)) return hinge->axis;
  if (const auto* const slider = std::get_if<SliderJoint>(&kind)) return slider->axis;
  if (const auto* const wheel = std::get_if<Hinge2Joint>(&kind)) return wheel->axis1;
  return {0, 0, 1};  // of others nothing is read
}

}  // namespace

Works loads_by_kind(const Joint& joint, double t, double q, double rate, double held) {
  Works loads{};
  for (const JointSpring& spring : joint.springs) {
    of(loads, Work::springs) -= spring.stiffness * (q - spring.rest);
    of(loads, Work::dampers) -= spring.damping * rate;
  }
  for (const Signal& torque : joint.torques) of(loads, Work::torques) += torque.at(t);
  of(loads, Work::controllers) = held;
  for (const Controller& controller : joint.controllers) {
    if (controller.sampled) continue;
    of(loads, Work::controllers) += controller.kp * (controller.target.at(t) - q) - controller.kd * rate;
  }
  return loads;
}

double elastic_energy(const Joint& joint, double q) {
  double energy = 0;
  for (const JointSpring& spring : joint.springs) {
    energy += spring.stiffness * (q - spring.rest) * (q - spring.rest) / 2;
  }
  return energy;
}

bool has_one_way(const JointKind& kind) {
  return std::holds_alternative<HingeJoint>(kind) || std::holds_alternative<SliderJoint>(kind);
}

std::string_view word_of(const JointKind& kind) {
  struct Word {
    std::string_view operator()(const BallJoint&) const { return "ball"; }
    std::string_view operator()(const HingeJoint&) const { return "hinge"; }
    std::string_view operator()(const SliderJoint&) const { return "slider"; }
    std::string_view operator()(const UniversalJoint&) const { return "universal"; }
    std::string_view operator()(const FixedJoint&) const { return "fixed"; }
    std::string_view operator()(const PistonJoint&) const { return "piston"; }
    std::string_view operator()(const SlidingHingeJoint&) const { return "pr"; }
    std::string_view operator()(const SlidingUniversalJoint&) const { return "pu"; }
    std::string_view operator()(const Hinge2Joint&) const { return "hinge2"; }
    std::string_view operator()(const PlaneJoint&) const { return "plane2d"; }
  };
  return std::visit(Word{}, kind);
}

WayReader::WayReader(const Mechanism& mechanism, std::span<const BodyState> start) : mechanism_(mechanism) {
  for (const Joint& joint : mechanism.joints) {
    const Vec3& anchor = anchor_m(joint.kind);
    Pair& made =
        joints_.emplace_back(pair(joint.first, joint.second, {anchor, anchor}, axis_of_kind(joint.kind), start));
    if (std::holds_alternative<SliderJoint>(joint.kind)) made.start = this->joint(joints_.size() - 1, start).q;
  }
  for (const Strut& strut : mechanism.struts) {
    struts_.push_back(pair(strut.first, strut.second, {strut.first_end_m, strut.second_end_m}, {0, 0, 1}, start));
  }
}

WayReader::Pair WayReader::pair(std::size_t first, std::optional<std::size_t> second, const std::array<Vec3, 2>& ends,
                                const Vec3& axis, std::span<const BodyState> start) const {
  Pair made{.first = first, .second = second};
  for (const std::size_t i : {0U, 1U}) {
    const BodyState& body = i == 0 ? start[first] : second_of(second, start);
    made.ends[i] = inside(body, ends[i] - body.position);
    made.axes[i] = inside(body, axis);
    made.across[i] = inside(body, across(axis));
  }
  return made;
}

Way WayReader::joint(std::size_t number, std::span<const BodyState> bodies) const {
  const Pair& pair = joints_[number];
  const BodyState& first = bodies[pair.first];
  const BodyState& second = second_of(pair.second, bodies);
  const Vec3 axis = turned(second.rotation, pair.axes[1]);
  if (std::holds_alternative<SliderJoint>(mechanism_.joints[number].kind)) {
    const Vec3 apart = first.position - second.position;
    return {dot(axis, apart) - pair.start, dot(axis, first.velocity - second.velocity - cross(second.spin, apart))};
  }
  const Vec3 turned_to = turned(first.rotation, pair.across[0]);
  const Vec3 from = turned(second.rotation, pair.across[1]);
  return {std::atan2(dot(axis, cross(from, turned_to)), dot(from, turned_to)), dot(axis, first.spin - second.spin)};
}

Way WayReader::suspension(std::size_t number, std::span<const BodyState> bodies) const {
  const Pair& pair = joints_[number];
  const Vec3 axis = turned(bodies[pair.first].rotation, pair.axes[0]);
  const Point hub(bodies[pair.first], pair.ends[0]);
  const Point wheel(second_of(pair.second, bodies), pair.ends[1]);
  const Vec3 apart = wheel.place - hub.place;
  return {dot(axis, apart),
          dot(axis, wheel.velocity - hub.velocity) + dot(cross(bodies[pair.first].spin, axis), apart)};
}

Way WayReader::strut(std::size_t number, std::span<const BodyState> bodies) const {
  const Pair& pair = struts_[number];
  const Point first(bodies[pair.first], pair.ends[0]);
  const Point second(second_of(pair.second, bodies), pair.ends[1]);
  const Vec3 between = second.place - first.place;
  const double long_m = length(between);
  if (long_m == 0) return {};  // ends that meet have no line between them
  return {long_m, dot(between, second.velocity - first.velocity) / long_m};
}

double WayReader::elastic_energy(std::span<const BodyState> bodies) const {
  double energy = 0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const auto* const wheel = std::get_if<Hinge2Joint>(&mechanism_.joints[j].kind);
    if (wheel == nullptr) continue;
    const double q = suspension(j, bodies).q;
    energy += wheel->stiffness * q * q / 2;
  }
  for (std::size_t i = 0; i < struts_.size(); ++i) {
    const double longer = strut(i, bodies).q - mechanism_.struts[i].rest_m;
    energy += mechanism_.struts[i].stiffness_N_m * longer * longer / 2;
  }
  return energy;
}

double WayReader::damping_power(std::span<const BodyState> bodies) const {
  double power = 0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const auto* const wheel = std::get_if<Hinge2Joint>(&mechanism_.joints[j].kind);
    if (wheel == nullptr) continue;
    const double rate = suspension(j, bodies).rate;
    power -= wheel->damping * rate * rate;
  }
  for (std::size_t i = 0; i < struts_.size(); ++i) {
    const double rate = strut(i, bodies).rate;
    power -= mechanism_.struts[i].damping_Ns_m * rate * rate;
  }
  return power;
}

}  // namespace odeval
