#include "engines/ode/joint_loads.hpp"

#include <cmath>
#include <numbers>

#include "engines/ode/build_mechanism.hpp"

namespace odeval::engine_ode {

void JointLoads::add(dJointID made, const Joint& joint) {
  if (joint.loaded()) loads_.push_back({made, joint, dJointGetType(made) == dJointTypeHinge});
}

void JointLoads::sample(double t) {
  for (Load& load : loads_) {
    load.near = way(load);
    load.held = load.joint.sampled_load(t, load.near, rate(load));
  }
}

void JointLoads::apply(double t) const {
  for (const Load& load : loads_) {
    const dReal force = real(load.held + load.joint.steady_load(t, way(load), rate(load)));
    if (load.turns) {
      dJointAddHingeTorque(load.made, force);
    } else {
      dJointAddSliderForce(load.made, force);
    }
  }
}

// Less than half a turn a step, so the nearest branch is the right one.
double JointLoads::way(const Load& load) {
  if (!load.turns) return dJointGetSliderPosition(load.made);
  constexpr double full_turn = 2 * std::numbers::pi;
  const double angle = dJointGetHingeAngle(load.made);
  return angle + full_turn * std::round((load.near - angle) / full_turn);
}

// The rate of a slider between two bodies that turn is not what dJointGetSliderPositionRate says: that is the
// difference of their centres' velocities along the axis, which has the turning in it.
double JointLoads::rate(const Load& load) {
  if (load.turns) return dJointGetHingeAngleRate(load.made);
  const dBodyID first = dJointGetBody(load.made, 0);
  const dBodyID second = dJointGetBody(load.made, 1);
  if (second == nullptr) return dJointGetSliderPositionRate(load.made);
  const auto vector = [](const dReal* v) { return Vec3{v[0], v[1], v[2]}; };
  dVector3 axis;
  dJointGetSliderAxis(load.made, axis);
  const Vec3 apart = vector(dBodyGetPosition(first)) - vector(dBodyGetPosition(second));
  const Vec3 parting = vector(dBodyGetLinearVel(first)) - vector(dBodyGetLinearVel(second));
  return dot(vector(axis), parting - cross(vector(dBodyGetAngularVel(second)), apart));
}

}  // namespace odeval::engine_ode
