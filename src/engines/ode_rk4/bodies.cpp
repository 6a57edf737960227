#include "engines/ode_rk4/bodies.hpp"

#include <algorithm>

#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

bool finite_body(const BodyNow& body) {
  return body.pose.position.allFinite() && body.pose.turn.allFinite() && body.twist.linear.allFinite() &&
         body.twist.angular.allFinite();
}

}  // namespace

void read_state(const Mechanism& mechanism, State& state) {
  state.resize(mechanism.bodies.size());
  for (std::size_t i = 0; i < state.size(); ++i) {
    const dBodyID id = mechanism.bodies[i].id;
    const dReal* q = dBodyGetQuaternion(id);
    state[i] = {{vector(dBodyGetPosition(id)), {q[0], q[1], q[2], q[3]}},
                {vector(dBodyGetLinearVel(id)), vector(dBodyGetAngularVel(id))}};
    if (mechanism.bodies[i].asleep) state[i].twist = {Vector3d::Zero(), Vector3d::Zero()};
    if (!finite_body(state[i])) refuse("a position or velocity of body " + std::to_string(i) + " is not finite", id);
  }
}

void read_forces(dWorldID world, const Mechanism& mechanism, std::vector<Wrench>& forces) {
  dVector3 gravity;
  dWorldGetGravity(world, gravity);
  forces.resize(mechanism.bodies.size());
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const dBodyID id = mechanism.bodies[i].id;
    if (mechanism.bodies[i].asleep) {
      forces[i] = {Vector3d::Zero(), Vector3d::Zero()};
      continue;
    }
    forces[i] = {vector(dBodyGetForce(id)), vector(dBodyGetTorque(id))};
    if (dBodyGetGravityMode(id) != 0 && mechanism.bodies[i].inverse_mass > 0)
      forces[i].force += vector(gravity) / mechanism.bodies[i].inverse_mass;
    if (!forces[i].force.allFinite() || !forces[i].torque.allFinite()) {
      refuse("the force on body " + std::to_string(i) + " is not finite", id);
    }
  }
}

void show_poses(const Mechanism& mechanism, const State& state) {
  for (std::size_t i = 0; i < state.size(); ++i) {
    const dBodyID id = mechanism.bodies[i].id;
    const Pose& pose = state[i].pose;
    const dQuaternion q = {pose.turn[0], pose.turn[1], pose.turn[2], pose.turn[3]};
    dBodySetPosition(id, pose.position[0], pose.position[1], pose.position[2]);
    dBodySetQuaternion(id, q);
  }
}

void show_twists(const Mechanism& mechanism, const State& state) {
  for (std::size_t i = 0; i < state.size(); ++i) {
    const dBodyID id = mechanism.bodies[i].id;
    const Twist& twist = state[i].twist;
    dBodySetLinearVel(id, twist.linear[0], twist.linear[1], twist.linear[2]);
    dBodySetAngularVel(id, twist.angular[0], twist.angular[1], twist.angular[2]);
  }
}

bool finite(const State& state) { return std::ranges::all_of(state, finite_body); }

void Saved::save(const Mechanism& mechanism) {
  bodies_.resize(mechanism.bodies.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const dBodyID id = mechanism.bodies[i].id;
    Exact& body = bodies_[i];
    body.id = id;
    std::copy_n(dBodyGetRotation(id), 12, body.rotation);
    std::copy_n(dBodyGetForce(id), 3, body.force);
    std::copy_n(dBodyGetTorque(id), 3, body.torque);
  }
}

void Saved::restore(const State& state) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const dBodyID id = bodies_[i].id;
    const auto& [pose, twist] = state[i];
    dBodySetPosition(id, pose.position[0], pose.position[1], pose.position[2]);
    dBodySetLinearVel(id, twist.linear[0], twist.linear[1], twist.linear[2]);
    dBodySetAngularVel(id, twist.angular[0], twist.angular[1], twist.angular[2]);
    // Setting a quaternion normalises it and computes the matrix anew, which may change a last digit of either.
    std::copy_n(pose.turn.data(), 4, const_cast<dReal*>(dBodyGetQuaternion(id)));
    std::copy_n(bodies_[i].rotation, 12, const_cast<dReal*>(dBodyGetRotation(id)));
  }
  restore_forces();
}

void Saved::restore_forces() const {
  for (const Exact& body : bodies_) {
    dBodySetForce(body.id, body.force[0], body.force[1], body.force[2]);
    dBodySetTorque(body.id, body.torque[0], body.torque[1], body.torque[2]);
  }
}

}  // namespace odeval::engine_rk4
