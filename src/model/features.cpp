#include <algorithm>
#include <array>
#include <numeric>
#include <variant>
#include <vector>

#include "odeval/engine.hpp"

namespace odeval {
namespace {

constexpr std::array<std::string_view, 24> names{
    "bodies in space",
    "more than one link",
    "more than two links",
    "contacts of a link",
    "contacts of more than one link",
    "contacts of bodies in space",
    "friction",
    "friction of a constant force",
    "joints of bodies in space",
    "joints that start open",
    "motors",
    "stops",
    "stops that bounce",
    "springs, torques and controllers of joints",
    "inertia tensors of their own",
    "joints that close loops",
    "joints piston, pr, pu, hinge2 or plane2d",
    "struts",
    "contacts of cylinders, capsules or several shapes of a body",
    "motors, stops, springs, torques and controllers of joints with several motions",
    "stops of turns of joints universal and pu",
    "motors of joints plane2d",
    "contacts with erp and cfm of their own",
    "contacts with kp and kd of their own",
};

static_assert(names.size() == static_cast<std::size_t>(Feature::sprung_contacts) + 1, "a name for each");

void add_of_links(Features& asked, std::size_t links, bool touching) {
  if (links > 1) asked.add(Feature::several_links);
  if (links > 2) asked.add(Feature::many_links);
  if (touching) asked.add(Feature::wall);
  if (touching && links > 1) asked.add(Feature::wall_of_several);
}

/// Whether a joint connects what hangs together without it.
bool closes_loops(const Mechanism& mechanism) {
  const std::size_t world = mechanism.bodies.size();
  std::vector<std::size_t> leader(world + 1);
  std::iota(leader.begin(), leader.end(), std::size_t{0});
  const auto leader_of = [&](std::size_t member) {
    while (leader[member] != member) member = leader[member];
    return member;
  };
  return std::ranges::any_of(mechanism.joints, [&](const Joint& joint) {
    const std::size_t from = leader_of(joint.first);
    const std::size_t to = leader_of(joint.second.value_or(world));
    leader[from] = to;
    return from == to;
  });
}

void add_of_space(Features& asked, const Mechanism& mechanism) {
  asked.add(Feature::space);
  if (!mechanism.contacts.empty()) asked.add(Feature::ground);
  if (!mechanism.joints.empty()) asked.add(Feature::joints_in_space);
  if (closes_loops(mechanism)) asked.add(Feature::loops);
}

struct IsRare {
  bool operator()(const BallJoint&) const { return false; }
  bool operator()(const HingeJoint&) const { return false; }
  bool operator()(const SliderJoint&) const { return false; }
  bool operator()(const UniversalJoint&) const { return false; }
  bool operator()(const FixedJoint&) const { return false; }
  bool operator()(const PistonJoint&) const { return true; }
  bool operator()(const SlidingHingeJoint&) const { return true; }
  bool operator()(const SlidingUniversalJoint&) const { return true; }
  bool operator()(const Hinge2Joint&) const { return true; }
  bool operator()(const PlaneJoint&) const { return true; }
};

void add_of_drive(Features& asked, const Joint& joint) {
  if (joint.motor) asked.add(Feature::motors);
  if (joint.stop) asked.add(Feature::stops);
  if (joint.stop && joint.stop->restitution > 0) asked.add(Feature::bouncing_stops);
  if (joint.loaded()) asked.add(Feature::loads);
}

void add_of_drives(Features& asked, const Joint& joint) {
  add_of_drive(asked, joint);
  const bool crosses =
      std::holds_alternative<UniversalJoint>(joint.kind) || std::holds_alternative<SlidingUniversalJoint>(joint.kind);
  const std::vector<Driveable> motions = driveable_of(joint.kind);
  for (const AxisDrive& drive : joint.drives) {
    asked.add(Feature::axis_drives);
    add_of_drive(asked, alone(joint, drive));
    if (drive.stop && crosses && !motions[drive.motion].slides) asked.add(Feature::cross_stops);
    if (drive.motor && std::holds_alternative<PlaneJoint>(joint.kind)) asked.add(Feature::plane_motors);
  }
}

}  // namespace

std::span<const std::string_view> feature_names() { return names; }

Features features_of(const Scenario& scenario) {
  const Mechanism& mechanism = scenario.mechanism;
  Features asked;
  if (scenario.planar) {
    add_of_links(asked, scenario.planar->links.size(), !mechanism.contacts.empty());
  } else {
    add_of_space(asked, mechanism);
  }
  for (const Contact& contact : mechanism.contacts) {
    if (contact.softness) asked.add(Feature::soft_contacts);
    if (contact.spring) asked.add(Feature::sprung_contacts);
    if (!contact.friction) continue;
    asked.add(contact.friction->model == FrictionModel::constant ? Feature::constant_friction : Feature::friction);
  }
  for (const Joint& joint : mechanism.joints) {
    if (joint.opening_m != Vec3{}) asked.add(Feature::open_joints);
    add_of_drives(asked, joint);
    if (std::visit(IsRare{}, joint.kind)) asked.add(Feature::rare_joints);
  }
  if (!mechanism.struts.empty()) asked.add(Feature::struts);
  for (const Body& body : mechanism.bodies) {
    if (body.inertia_kgm2) asked.add(Feature::inertia);
    if (!mechanism.contacts.empty() && (is_bar(body.shape) || !body.several.empty())) asked.add(Feature::rare_shapes);
  }
  return asked;
}

std::string listed(Features features) {
  std::string words;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto feature = static_cast<Feature>(i);
    const bool said = feature == Feature::many_links && features.has(Feature::several_links);
    if (!features.has(feature) || said) continue;
    words += (words.empty() ? "" : ", ") + std::string(names[i]);
  }
  return words;
}

}  // namespace odeval
