#include "odeval/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace odeval {
namespace {

/// Calls the function of the alternative's type.
template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace

Vec3 sides_m(const Shape& shape) {
  return std::visit(Overloaded{[](const Box& box) { return box.sides_m; },
                               [](const Sphere& ball) {
                                 return Vec3{ball.diameter_m, ball.diameter_m, ball.diameter_m};
                               },
                               [](const auto& bar) {
                                 return Vec3{bar.diameter_m, bar.diameter_m, bar.length_m};
                               }},
                    shape);
}

Vec3 rotation_vector(const Attitude& attitude) {
  return std::visit(Overloaded{[](const Vec3& vector) { return vector; },
                               [](const AxisAngle& turn) { return turn.angle_rad * turn.axis; }},
                    attitude);
}

bool is_bar(const Shape& shape) {
  return std::holds_alternative<Cylinder>(shape) || std::holds_alternative<Capsule>(shape);
}

Vec3 uniform_moments_kgm2(const Shape& shape, double mass_kg) {
  const double m = mass_kg;
  return std::visit(
      Overloaded{[m](const Box& box) {
                   const auto& [x, y, z] = box.sides_m;
                   return Vec3{m * (y * y + z * z) / 12, m * (z * z + x * x) / 12, m * (x * x + y * y) / 12};
                 },
                 [m](const Sphere& ball) {
                   const double moment = m * ball.diameter_m * ball.diameter_m / 10;
                   return Vec3{moment, moment, moment};
                 },
                 [m](const Cylinder& bar) {
                   const double square = bar.diameter_m * bar.diameter_m / 4;
                   const double across = m * (3 * square + bar.length_m * bar.length_m) / 12;
                   return Vec3{across, across, m * square / 2};
                 },
                 [m](const Capsule& bar) {
                   // A cylinder and a ball of the same density, whose halves lie beyond the cylinder's ends.
                   const double r = bar.diameter_m / 2;
                   const double straight = bar.length_m - 2 * r;
                   const double ball = m * (4 * r / 3) / (straight + 4 * r / 3);
                   const double rod = m - ball;
                   const double across = rod * (3 * r * r + straight * straight) / 12 +
                                         ball * (2 * r * r / 5 + straight * straight / 4 + 3 * r * straight / 8);
                   return Vec3{across, across, rod * r * r / 2 + ball * 2 * r * r / 5};
                 }},
      shape);
}

std::vector<Driveable> driveable_of(const JointKind& kind) {
  using List = std::vector<Driveable>;
  const auto turn = [](const Vec3& axis) { return Driveable{false, axis}; };
  const auto way = [](const Vec3& axis) { return Driveable{true, axis}; };
  return std::visit(Overloaded{[](const BallJoint&) { return List{}; }, [](const HingeJoint&) { return List{}; },
                               [](const SliderJoint&) { return List{}; }, [](const FixedJoint&) { return List{}; },
                               [&](const PlaneJoint&) {
                                 return List{way({1, 0, 0}), way({0, 1, 0}), turn({0, 0, 1})};
                               },
                               [&](const UniversalJoint& joint) {
                                 return List{turn(joint.axis1), turn(joint.axis2)};
                               },
                               [&](const PistonJoint& joint) {
                                 return List{way(joint.axis), turn(joint.axis)};
                               },
                               [&](const SlidingHingeJoint& joint) {
                                 return List{way(joint.axis1), turn(joint.axis2)};
                               },
                               [&](const SlidingUniversalJoint& joint) {
                                 return List{way(joint.way), turn(joint.axis1), turn(joint.axis2)};
                               },
                               [&](const Hinge2Joint& joint) {
                                 return List{turn(joint.axis1), turn(joint.axis2)};
                               }},
                    kind);
}

std::vector<Part> Body::parts() const { return several.empty() ? std::vector{Part{shape}} : several; }

std::string Body::touches_as(const Part& part) const { return part.name.empty() ? name : name + "." + part.name; }

std::size_t Body::long_axis() const {
  const auto [x, y, z] = sides_m(shape);
  return z >= x && z >= y ? 2 : y >= x ? 1 : 0;
}

const Vec3& anchor_m(const JointKind& kind) {
  return std::visit([](const auto& joint) -> const Vec3& { return joint.anchor_m; }, kind);
}

double Signal::at(double t) const {
  const double steady = constant + amplitude * std::sin(2 * std::numbers::pi * frequency_Hz * t + phase_rad);
  if (times_s.empty()) return steady;
  const auto later = static_cast<std::size_t>(std::ranges::upper_bound(times_s, t) - times_s.begin());
  if (later == 0) return steady + values.front();
  if (later == times_s.size()) return steady + values.back();
  const double part = (t - times_s[later - 1]) / (times_s[later] - times_s[later - 1]);
  return steady + values[later - 1] + part * (values[later] - values[later - 1]);
}

namespace {

double load_of(const Controller& controller, double t, double q, double rate) {
  return controller.kp * (controller.target.at(t) - q) - controller.kd * rate;
}

}  // namespace

Joint alone(const Joint& joint, const AxisDrive& drive) {
  Joint one = joint;
  one.motor = drive.motor;
  one.stop = drive.stop;
  one.springs = drive.springs;
  one.torques = drive.torques;
  one.controllers = drive.controllers;
  one.drives.clear();
  return one;
}

bool Joint::sampled() const {
  const auto any = [](const auto& one) { return std::ranges::any_of(one.controllers, &Controller::sampled); };
  return any(*this) || std::ranges::any_of(drives, any);
}

double Joint::steady_load(double t, double q, double rate) const {
  double load = 0;
  for (const JointSpring& spring : springs) load -= spring.stiffness * (q - spring.rest) + spring.damping * rate;
  for (const Signal& torque : torques) load += torque.at(t);
  for (const Controller& controller : controllers) {
    if (!controller.sampled) load += load_of(controller, t, q, rate);
  }
  return load;
}

double Joint::sampled_load(double t, double q, double rate) const {
  double load = 0;
  for (const Controller& controller : controllers) {
    if (controller.sampled) load += load_of(controller, t, q, rate);
  }
  return load;
}

Freedom freedom_of(const JointKind& kind) {
  const std::vector<Vec3> all{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  return std::visit(Overloaded{[&](const BallJoint&) {
                                 return Freedom{{}, all};
                               },
                               [](const HingeJoint& hinge) {
                                 return Freedom{{}, {hinge.axis}};
                               },
                               [](const SliderJoint& slider) {
                                 return Freedom{{slider.axis}, {}};
                               },
                               [](const UniversalJoint& cross) {
                                 return Freedom{{}, {cross.axis1, cross.axis2}};
                               },
                               [](const FixedJoint&) { return Freedom{}; },
                               [](const PistonJoint& piston) {
                                 return Freedom{{piston.axis}, {piston.axis}};
                               },
                               [](const SlidingHingeJoint& joint) {
                                 return Freedom{{joint.axis1}, {joint.axis2}};
                               },
                               [](const SlidingUniversalJoint& joint) {
                                 return Freedom{{joint.way}, {joint.axis1, joint.axis2}};
                               },
                               [](const Hinge2Joint& wheel) {
                                 return Freedom{{wheel.axis1}, {wheel.axis1, wheel.axis2}};
                               },
                               [&](const PlaneJoint&) {
                                 return Freedom{{all[0], all[1]}, {all[2]}};
                               }},
                    kind);
}

Misfit misfit_of(const Mechanism& mechanism, const Joint& joint) {
  const auto minus = [](Vec3 vector, const std::vector<Vec3>& free) {
    for (const Vec3& direction : free) vector = vector - dot(vector, direction) * direction;
    return length(vector);
  };
  const Body& first = mechanism.bodies[joint.first];
  const Body world{};
  const Body& second = joint.second ? mechanism.bodies[*joint.second] : world;
  const auto at_anchor = [&](const Body& body) {
    return body.velocity_m_s + cross(body.spin_rad_s, anchor_m(joint.kind) - body.position_m);
  };
  const Freedom free = freedom_of(joint.kind);
  return {minus(at_anchor(first) - at_anchor(second), free.ways),
          minus(first.spin_rad_s - second.spin_rad_s, free.turns)};
}

double allowed_misfit(const Mechanism& mechanism) {
  double fastest = 1;
  for (const Body& body : mechanism.bodies) {
    fastest = std::max({fastest, length(body.velocity_m_s), length(body.spin_rad_s)});
  }
  return 1e-9 * fastest;
}

bool Contact::is_between(std::string_view a, std::string_view b) const {
  const auto is = [](std::string_view named, std::string_view name) {
    const bool its_body = name.size() > named.size() && name.starts_with(named) && name[named.size()] == '.';
    return named.empty() || named == name || its_body;
  };
  return (is(first, a) && is(second, b)) || (is(first, b) && is(second, a));
}

std::optional<Softness> Contact::softness_at(double step_s) const {
  return spring ? softness_of(*spring, step_s) : softness;
}

std::optional<Carrier> carrier_of(const Mechanism& mechanism, std::size_t body) {
  const std::vector<Joint>& joints = mechanism.joints;
  const auto find = [&](auto holds) {
    return static_cast<std::size_t>(std::ranges::find_if(joints, holds) - joints.begin());
  };
  const std::size_t carries = find([&](const Joint& joint) { return joint.carried() == body; });
  if (carries < joints.size()) return Carrier{carries, 1};
  const std::size_t holds = find([&](const Joint& joint) { return joint.first == body; });
  if (holds < joints.size()) return Carrier{holds, -1};
  return std::nullopt;
}

}  // namespace odeval
