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

BodySample sample_of(const Body& body) {
  BodySample sample{};
  sample.body = body.number;
  sample.kinematic = dBodyIsKinematic(body.id) != 0 ? 1 : 0;
  std::copy_n(dBodyGetPosition(body.id), 3, sample.position);
  std::copy_n(dBodyGetQuaternion(body.id), 4, sample.quaternion);
  return sample;
}

MotionSample motion_of(const Body& body) {
  MotionSample sample{};
  std::copy_n(dBodyGetLinearVel(body.id), 3, sample.velocity);
  std::copy_n(dBodyGetAngularVel(body.id), 3, sample.spin);
  return sample;
}

/// And what each joint's gap came to at most.
Account account_of(World& world, const Sampler::Step& step) {
  Account account{};
  for (Joint& joint : world.joints) {
    const double its = gap(joint);
    if (joint.part != nullptr && its > joint.part->largest_m) {
      joint.part->largest_m = its;
      joint.part->largest_t = world.t;
    }
    if (its <= account.gap) continue;
    account.gap = its;
    account.gap_joint = joint.number + 1;
  }
  account.quick = step.quick ? 1 : 0;
  account.joints = static_cast<std::uint32_t>(world.joints.size());
  account.contacts = world.contacts;
  account.messages = step.messages;
  account.depth = world.depth;
  account.work_added = world.work.added;
  account.work_motors = world.work.motors;
  account.work_stops = world.work.stops;
  account.work_joints = world.work.joints;
  account.work_contacts = world.work.contacts;
  account.work_damping = world.work.damping;
  account.work_program = world.work.program;
  return account;
}

}  // namespace

Energy energy_of(const World& world) {
  dVector3 gravity;
  dWorldGetGravity(world.id, gravity);
  Energy energy;
  for (const Body& body : world.bodies) add_energy(body, gravity, energy);
  return energy;
}

Energy energy_of(const World& world, const Body& body) {
  dVector3 gravity;
  dWorldGetGravity(world.id, gravity);
  Energy energy;
  add_energy(body, gravity, energy);
  return energy;
}

const std::vector<char>& Sampler::take(World& world, const Step& step) {
  const std::size_t of_body = sizeof(BodySample) + (motions_ ? sizeof(MotionSample) : 0);
  bytes_.resize(sizeof(Frame) + world.bodies.size() * of_body + (account_ ? sizeof(Account) : 0));
  char* place = bytes_.data();
  const auto put = [&place](const auto& what) {
    std::memcpy(place, &what, sizeof what);
    place += sizeof what;
  };
  const Energy energy = energy_of(world);
  world.energy = energy.sum();
  put(Frame{.bytes = static_cast<std::uint32_t>(bytes_.size()),
            .world = world.number,
            .step = world.steps,
            .t = world.t,
            .h = step.h,
            .kinetic = energy.kinetic,
            .potential = energy.potential,
            .ode_s = step.ode_s,
            .bodies = static_cast<std::uint32_t>(world.bodies.size()),
            .has_motions = motions_,
            .has_account = account_});
  for (const Body& body : world.bodies) put(sample_of(body));
  if (motions_) {
    for (const Body& body : world.bodies) put(motion_of(body));
  }
  if (account_) put(account_of(world, step));
  return bytes_;
}

}  // namespace odeval::audit
