#include <cmath>
#include <string>

#include "model/generate.hpp"
#include "model/joint_kinds.hpp"

namespace odeval {
namespace {

std::optional<std::array<double, 9>> tensor_of(const BodyTable& table) {
  if (!table.inertia_kgm2) return std::nullopt;
  const auto [xx, yy, zz, xy, xz, yz] = *table.inertia_kgm2;
  return std::array{xx, xy, xz, xy, yy, yz, xz, yz, zz};
}

Body body_of(const BodyTable& table, std::size_t number) {
  const Shape shape = table.sphere ? Shape(Sphere{table.size_m[0]}) : Shape(Box{table.size_m});
  return {.shape = shape,
          .mass_kg = table.mass_kg,
          .position_m = table.position_m,
          .attitude = table.turn_rad,
          .velocity_m_s = table.velocity_m_s,
          .spin_rad_s = table.spin_rad_s,
          .inertia_kgm2 = tensor_of(table),
          .name = table.name.empty() ? "body" + std::to_string(number) : table.name};
}

Joint joint_of(const JointTable& table, bool pair) {
  return {.kind = table.kind->make(table),
          .first = 0,
          .second = pair ? std::optional<std::size_t>(1) : std::nullopt,
          .opening_m = table.displacement_m};
}

Signal turned_round(Signal signal) {
  signal.constant = -signal.constant;
  signal.amplitude = -signal.amplitude;
  for (double& value : signal.values) value = -value;
  return signal;
}

/// The same motor, stop and loads told of the second body against the first.
Joint turned_round(Joint joint) {
  if (joint.motor) joint.motor->speed = -joint.motor->speed;
  if (joint.stop) *joint.stop = {-joint.stop->high, -joint.stop->low, joint.stop->restitution};
  for (JointSpring& spring : joint.springs) spring.rest = -spring.rest;
  for (Signal& torque : joint.torques) torque = turned_round(torque);
  for (Controller& controller : joint.controllers) controller.target = turned_round(controller.target);
  return joint;
}

template <class Load>
std::vector<Load> loads_of(const std::string& joint, const std::vector<LoadTable<Load>>& tables) {
  std::vector<Load> loads;
  for (const LoadTable<Load>& table : tables) {
    if (table.joint == joint) loads.push_back(table.load);
  }
  return loads;
}

/// The parent is the joint's first body, or its second where it is the world, which is never the first.
Joint joint_of_tree(const Description& said, const JointTable& table) {
  const std::size_t child = said.body_named(table.child).value();
  const std::optional<std::size_t> parent = said.body_named(table.parent);
  Joint joint{.kind = table.kind->make(table),
              .first = child,
              .second = {},
              .motor = table.motor,
              .stop = table.stop,
              .springs = loads_of(table.name, said.springs),
              .torques = loads_of(table.name, said.torques),
              .controllers = loads_of(table.name, said.controllers),
              .name = table.name};
  if (!parent) return joint;
  joint.first = *parent;
  joint.second = child;
  return turned_round(std::move(joint));
}

/// The child is the strut's first body: the world is its second at most.
Strut strut_of(const Description& said, const StrutTable& table) {
  return {.first = said.body_named(table.child).value(),
          .second = said.body_named(table.parent),
          .first_end_m = table.to_m,
          .second_end_m = table.from_m,
          .stiffness_N_m = table.stiffness,
          .damping_Ns_m = table.damping,
          .rest_m = table.rest_m.value_or(distance(table.from_m, table.to_m))};
}

void put_ground(Scenario& scenario, const GroundTable& table, bool friction) {
  const HalfSpace plane = sloping(table.slope_rad);
  scenario.mechanism.obstacles.push_back({plane, "ground"});
  Contact contact{.restitution = table.restitution};
  if (friction) contact.friction = Friction{table.friction, table.friction_model};
  scenario.mechanism.contacts.push_back(contact);
  scenario.impact_views.push_back({.normal = plane.normal});
}

void put_contacts(Mechanism& mechanism, const Description& said) {
  for (const PlaneTable& plane : said.planes) {
    mechanism.obstacles.push_back({HalfSpace{plane.normal, dot(plane.normal, plane.point_m)}, plane.name});
  }
  for (const ContactTable& table : said.contacts) {
    Contact contact{.restitution = table.restitution};
    if (table.friction) contact.friction = Friction{*table.friction, FrictionModel::pyramid};
    if (!table.between.empty()) {
      contact.first = table.between[0];
      contact.second = table.between[1];
    }
    mechanism.contacts.push_back(contact);
  }
}

}  // namespace

HalfSpace sloping(double slope_rad) { return {{std::sin(slope_rad), 0, std::cos(slope_rad)}, 0}; }

void set_slope(Scenario& scenario, double slope_rad) {
  const HalfSpace plane = sloping(slope_rad);
  scenario.mechanism.obstacles.front().shape = plane;
  scenario.impact_views.front().normal = plane.normal;
}

void put_bodies(Scenario& scenario, const Description& description) {
  scenario.mechanism = {};
  scenario.impact_views.clear();
  scenario.planar.reset();
  scenario.named = description.problem->joints;
  std::size_t number = 0;
  for (const BodyTable& table : description.bodies) scenario.mechanism.bodies.push_back(body_of(table, ++number));
  if (description.joint) {
    scenario.mechanism.joints.push_back(joint_of(*description.joint, description.bodies.size() > 1));
  }
  for (const JointTable& table : description.joints) {
    scenario.mechanism.joints.push_back(joint_of_tree(description, table));
  }
  put_contacts(scenario.mechanism, description);
  for (const StrutTable& table : description.struts) {
    scenario.mechanism.struts.push_back(strut_of(description, table));
  }
  if (description.ground) put_ground(scenario, *description.ground, description.problem->friction);
}

}  // namespace odeval
