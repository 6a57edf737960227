#include "audit/preload/sample.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace odeval::audit {
namespace {

double dot(const dReal* a, const dReal* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void add_energy(const Body& body, const dReal* gravity, Energy& energy) {
  if (dBodyIsKinematic(body.id)) return;
  dMass mass;
  dBodyGetMass(body.id, &mass);
  const dReal* velocity = dBodyGetLinearVel(body.id);
  dVector3 spin;
  dVector3 momentum;
  dMultiply1_331(spin, dBodyGetRotation(body.id), dBodyGetAngularVel(body.id));
  dMultiply0_331(momentum, mass.I, spin);
  energy.kinetic += 0.5 * (mass.mass * dot(velocity, velocity) + dot(spin, momentum));
  if (dBodyGetGravityMode(body.id)) energy.potential -= mass.mass * dot(gravity, dBodyGetPosition(body.id));
}

/// Of a joint with two anchors that should be one point.
using Anchor = void (*)(dJointID, dVector3);

double between(const Joint& joint, Anchor first, Anchor second) {
  dVector3 a{};
  dVector3 b{};
  first(joint.id, a);
  second(joint.id, b);
  const dVector3 apart{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return std::sqrt(dot(apart, apart));
}

/// The centre of the second body, or the world's origin, in the frame of the first.
Triple offset(dBodyID first, dBodyID second) {
  Triple seen{};
  dVector3 away{};
  const dReal* from = dBodyGetPosition(first);
  for (int i = 0; i < 3; ++i) away[i] = (second != nullptr ? dBodyGetPosition(second)[i] : 0) - from[i];
  dMultiply1_331(seen.data(), dBodyGetRotation(first), away);
  return seen;
}

/// Of a joint that lets the second body only turn with the first, or slide along `axis` as well: how far it has gone
/// elsewhere since it was first seen.
double strayed(Joint& joint, const dReal* axis) {
  dBodyID first = dJointGetBody(joint.id, 0);
  dBodyID second = dJointGetBody(joint.id, 1);
  if (first == nullptr) std::swap(first, second);
  const Triple now = offset(first, second);
  if (!joint.seen) joint.offset = now;
  joint.seen = true;
  dVector3 gone{};
  for (int i = 0; i < 3; ++i) gone[i] = now[i] - joint.offset[i];
  if (axis == nullptr) return std::sqrt(dot(gone, gone));
  dVector3 along{};
  dMultiply1_331(along, dBodyGetRotation(first), axis);
  return std::sqrt(std::max(0.0, dot(gone, gone) - std::pow(dot(gone, along), 2)));
}

double gap(Joint& joint) {
  dBodyID first = dJointGetBody(joint.id, 0);
  dBodyID second = dJointGetBody(joint.id, 1);
  if (first == nullptr && second == nullptr) return 0;
  switch (joint.type) {
    case dJointTypeBall:
      return between(joint, dJointGetBallAnchor, dJointGetBallAnchor2);
    case dJointTypeHinge:
      return between(joint, dJointGetHingeAnchor, dJointGetHingeAnchor2);
    case dJointTypeUniversal:
      return between(joint, dJointGetUniversalAnchor, dJointGetUniversalAnchor2);
    case dJointTypeFixed:
      return first != nullptr && second != nullptr ? strayed(joint, nullptr) : 0;
    case dJointTypeSlider: {
      if (first == nullptr || second == nullptr) return 0;
      dVector3 axis{};
      dJointGetSliderAxis(joint.id, axis);
      return strayed(joint, axis);
    }
    default:  // hinge2 has a suspension, and motors, pistons and the like no two points that belong together
      return 0;
  }
}

void sample_body(const Body& body, BodySample& sample) {
  sample.body = body.number;
  sample.kinematic = dBodyIsKinematic(body.id) != 0 ? 1 : 0;
  std::copy_n(dBodyGetPosition(body.id), 3, sample.position);
  std::copy_n(dBodyGetQuaternion(body.id), 4, sample.quaternion);
  std::copy_n(dBodyGetLinearVel(body.id), 3, sample.velocity);
  std::copy_n(dBodyGetAngularVel(body.id), 3, sample.spin);
}

}  // namespace

Energy energy_of(const World& world) {
  dVector3 gravity;
  dWorldGetGravity(world.id, gravity);
  Energy energy;
  for (const Body& body : world.bodies) add_energy(body, gravity, energy);
  return energy;
}

const std::vector<char>& Sampler::take(World& world, const Step& step) {
  Frame frame{};
  bytes_.resize(sizeof frame + world.bodies.size() * sizeof(BodySample));
  auto* sample = reinterpret_cast<BodySample*>(bytes_.data() + sizeof frame);
  for (const Body& body : world.bodies) sample_body(body, *sample++);
  const Energy energy = energy_of(world);
  world.energy = energy.sum();
  frame.gap_joint = -1;
  for (Joint& joint : world.joints) {
    const double its = gap(joint);
    if (joint.part != nullptr && its > joint.part->largest_m) {
      joint.part->largest_m = its;
      joint.part->largest_t = world.t;
    }
    if (its <= frame.gap) continue;
    frame.gap = its;
    frame.gap_joint = static_cast<std::int32_t>(joint.number);
  }
  frame.bytes = static_cast<std::uint32_t>(bytes_.size());
  frame.world = world.number;
  frame.step = world.steps;
  frame.t = world.t;
  frame.h = step.h;
  frame.kinetic = energy.kinetic;
  frame.potential = energy.potential;
  frame.quick = step.quick ? 1 : 0;
  frame.bodies = static_cast<std::uint32_t>(world.bodies.size());
  frame.joints = static_cast<std::uint32_t>(world.joints.size());
  frame.contacts = world.contacts;
  frame.messages = step.messages;
  frame.depth = world.depth;
  frame.ode_s = step.ode_s;
  frame.work_added = world.work.added;
  frame.work_motors = world.work.motors;
  frame.work_joints = world.work.joints;
  frame.work_contacts = world.work.contacts;
  frame.work_damping = world.work.damping;
  frame.work_program = world.work.program;
  std::memcpy(bytes_.data(), &frame, sizeof frame);
  return bytes_;
}

}  // namespace odeval::audit
