#include "engines/ode/joint_loads.hpp"

#include <cmath>
#include <numbers>

#include "engines/ode/build_mechanism.hpp"
#include "engines/ode/joint_axis.hpp"

namespace odeval::engine_ode {
namespace {

/// Where a point of a body, or of the world, is, and how fast.
struct Moving {
  Vec3 place;
  Vec3 velocity{};
};
Moving moving(dBodyID body, const Vec3& point) {
  if (body == nullptr) return {point};
  dVector3 place;
  dVector3 velocity;
  dBodyGetRelPointPos(body, real(point[0]), real(point[1]), real(point[2]), place);
  dBodyGetRelPointVel(body, real(point[0]), real(point[1]), real(point[2]), velocity);
  return {vector(place), vector(velocity)};
}

Vec3 in_body(dBodyID body, const Vec3& point) {
  if (body == nullptr) return point;
  dVector3 inside;
  dBodyGetPosRelPoint(body, real(point[0]), real(point[1]), real(point[2]), inside);
  return vector(inside);
}

}  // namespace

void JointLoads::add(dBodyID first, dBodyID second, const Strut& strut) {
  struts_.push_back({first, second, strut, {in_body(first, strut.first_end_m), in_body(second, strut.second_end_m)}});
}

JointLoads::Line JointLoads::line_of(const Ends& ends) {
  const Moving a = moving(ends.first, ends.at[0]);
  const Moving b = moving(ends.second, ends.at[1]);
  Line line{{a.place, b.place}};
  const Vec3 between = b.place - a.place;
  line.long_m = length(between);
  if (line.long_m == 0) return line;
  line.along = (1 / line.long_m) * between;
  line.longer_m_s = dot(line.along, b.velocity - a.velocity);
  return line;
}

void JointLoads::apply(const Ends& ends) {
  const Line line = line_of(ends);
  if (line.long_m == 0) return;
  const double pull =
      ends.strut.stiffness_N_m * (line.long_m - ends.strut.rest_m) + ends.strut.damping_Ns_m * line.longer_m_s;
  const auto add = [&](dBodyID body, double force, const Vec3& at) {
    if (body == nullptr) return;
    const auto& [x, y, z] = line.along;
    dBodyAddForceAtPos(body, real(force * x), real(force * y), real(force * z), real(at[0]), real(at[1]), real(at[2]));
  };
  add(ends.first, pull, line.ends[0]);
  add(ends.second, -pull, line.ends[1]);
}

void JointLoads::add(dJointID made, const Joint& joint) {
  if (joint.loaded()) loads_.push_back({made, joint, dJointGetType(made) == dJointTypeHinge});
  for (const AxisDrive& drive : joint.drives) {
    const Joint one = alone(joint, drive);
    if (!one.loaded()) continue;
    const bool turns = !driveable_of(joint.kind)[drive.motion].slides;
    loads_.push_back({made, one, turns, drive.motion, engine_ode::way_of(made, joint.kind, drive.motion)});
  }
}

void JointLoads::sample(double t) {
  for (Load& load : loads_) {
    load.near = way(load);
    load.held = load.joint.sampled_load(t, load.near, rate(load));
  }
}

void JointLoads::apply(double t) const {
  for (const Load& load : loads_) {
    apply(load, load.held + load.joint.steady_load(t, way(load), rate(load)));
  }
  for (const Ends& ends : struts_) apply(ends);
}

// Of joints with several motions ODE's own functions are not all there, and a force on a way acts half-way between the
// bodies' centres, which turns what may turn there.
void JointLoads::apply(const Load& load, double force) {
  if (!load.motion) {
    if (load.turns) {
      dJointAddHingeTorque(load.made, real(force));
    } else {
      dJointAddSliderForce(load.made, real(force));
    }
    return;
  }
  const auto [axis, at] = axis_of(load.made, load.joint.kind, *load.motion);
  for (const int k : {0, 1}) {
    const dBodyID body = dJointGetBody(load.made, k);
    if (body == nullptr) continue;
    const Vec3 push = (k == 0 ? force : -force) * axis;
    const auto& [x, y, z] = push;
    if (load.turns) {
      dBodyAddTorque(body, real(x), real(y), real(z));
    } else {
      dBodyAddForceAtPos(body, real(x), real(y), real(z), real(at[0]), real(at[1]), real(at[2]));
    }
  }
}

Works JointLoads::by_kind(std::size_t load, double t) const {
  const Load& of = loads_[load];
  return loads_by_kind(of.joint, t, way(of), rate(of), of.held);
}

// Less than half a turn a step, so the nearest branch is the right one.
double JointLoads::way(const Load& load) {
  const auto told = [&] { return engine_ode::way_of(load.made, load.joint.kind, *load.motion) - load.start; };
  if (!load.turns) return load.motion ? told() : dJointGetSliderPosition(load.made);
  constexpr double full_turn = 2 * std::numbers::pi;
  const double angle = load.motion ? told() : dJointGetHingeAngle(load.made);
  return angle + full_turn * std::round((load.near - angle) / full_turn);
}

// The rate of a slider between two bodies that turn is not what dJointGetSliderPositionRate says: that is the
// difference of their centres' velocities along the axis, which has the turning in it.
double JointLoads::rate(const Load& load) {
  if (load.motion) return rate_of(load.made, load.joint.kind, *load.motion);
  if (load.turns) return dJointGetHingeAngleRate(load.made);
  const dBodyID first = dJointGetBody(load.made, 0);
  const dBodyID second = dJointGetBody(load.made, 1);
  if (second == nullptr) return dJointGetSliderPositionRate(load.made);
  dVector3 axis;
  dJointGetSliderAxis(load.made, axis);
  const Vec3 apart = vector(dBodyGetPosition(first)) - vector(dBodyGetPosition(second));
  const Vec3 parting = vector(dBodyGetLinearVel(first)) - vector(dBodyGetLinearVel(second));
  return dot(vector(axis), parting - cross(vector(dBodyGetAngularVel(second)), apart));
}

}  // namespace odeval::engine_ode
