#include <cmath>
#include <string>
#include <utility>

#include "model/generate.hpp"
#include "model/joint_kinds.hpp"
#include "model/start_pose.hpp"

namespace odeval {
namespace {

std::optional<std::array<double, 9>> tensor_of(const BodyTable& table) {
  if (!table.inertia_kgm2) return std::nullopt;
  const auto [xx, yy, zz, xy, xz, yz] = *table.inertia_kgm2;
  return std::array{xx, xy, xz, xy, yy, yz, xz, yz, zz};
}

Shape shape_of(BodyShape shape, const Vec3& size_m) {
  switch (shape) {
    case BodyShape::sphere:
      return Sphere{size_m[0]};
    case BodyShape::cylinder:
      return Cylinder{size_m[0], size_m[2]};
    case BodyShape::capsule:
      return Capsule{size_m[0], size_m[2]};
    case BodyShape::box:
    case BodyShape::none:  // a box of no size, until it has others
      break;
  }
  return Box{size_m};
}

Body body_of(const BodyTable& table, std::size_t number) {
  return {.shape = shape_of(table.shape, table.size_m),
          .mass_kg = table.mass_kg,
          .position_m = table.position_m,
          .attitude = table.turn_rad,
          .velocity_m_s = table.velocity_m_s,
          .spin_rad_s = table.spin_rad_s,
          .inertia_kgm2 = tensor_of(table),
          .name = table.name.empty() ? "body" + std::to_string(number) : table.name};
}

/// A tensor along one frame's axes along those of the frame that it is in, of a mass that is so far from the point
/// about which it is told.
Rotation moved(const Rotation& tensor, double mass_kg, const Frame& place) {
  Rotation sum = place.rotation * tensor * transposed(place.rotation);
  const Vec3& at = place.position_m;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      sum[3 * row + column] += mass_kg * ((row == column ? dot(at, at) : 0) - at[row] * at[column]);
    }
  }
  return sum;
}

Rotation tensor_of(const Shape& shape, double mass_kg) {
  const Vec3 moments = uniform_moments_kgm2(shape, mass_kg);
  return {moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]};
}

/// The box about the origin that holds all of them.
Box box_around(const std::vector<Part>& parts) {
  Box box;
  for (const Part& part : parts) {
    const Vec3 sides = sides_m(part.shape);
    for (std::size_t k = 0; k < 3; ++k) {
      double half = std::fabs(part.place.position_m[k]);
      for (std::size_t side = 0; side < 3; ++side)
        half += std::fabs(part.place.rotation[3 * k + side]) * sides[side] / 2;
      box.sides_m[k] = std::fmax(box.sides_m[k], 2 * half);
    }
  }
  return box;
}

/// A mass about its own centre.
struct Lump {
  double mass_kg = 0;
  Frame place;      // of its centre, and of the axes of its tensor
  Rotation tensor;  // about it
};

/// Makes the body, which is its own shape about its centre of mass so far, what its table says of its centre and its
/// other shapes: its mass, its centre of mass and its inertia are those of all together.
void add_shapes(Body& body, const BodyTable& said) {
  if (said.shapes.empty() && said.centre_m == Vec3{}) return;
  std::vector<Part> parts{{body.shape}};
  std::vector<Lump> lumps{{body.mass_kg,
                           {said.centre_m, Frame{}.rotation},
                           body.inertia_kgm2.value_or(tensor_of(body.shape, body.mass_kg))}};
  for (const ShapeTable& table : said.shapes) {
    const Shape shape = shape_of(table.shape, table.size_m);
    parts.push_back({shape, {table.position_m, rotation_of_vector(table.turn_rad)}, table.name});
    lumps.push_back({table.mass_kg, parts.back().place, tensor_of(shape, table.mass_kg)});
  }
  Vec3 centre{};
  body.mass_kg = 0;
  for (const Lump& lump : lumps) {
    centre = centre + lump.mass_kg * lump.place.position_m;
    body.mass_kg += lump.mass_kg;
  }
  centre = (1 / body.mass_kg) * centre;
  Rotation whole{};
  for (Lump& lump : lumps) {
    lump.place.position_m = lump.place.position_m - centre;
    const Rotation part = moved(lump.tensor, lump.mass_kg, lump.place);
    for (std::size_t k = 0; k < whole.size(); ++k) whole[k] += part[k];
  }
  for (Part& part : parts) part.place.position_m = part.place.position_m - centre;
  for (const auto& [upper, lower] : {std::pair{1, 3}, {2, 6}, {5, 7}}) whole[lower] = whole[upper];
  const Vec3 away = turned(rotation_of_vector(rotation_vector(body.attitude)), centre);
  body.position_m = body.position_m + away;
  body.velocity_m_s = body.velocity_m_s + cross(body.spin_rad_s, away);
  body.inertia_kgm2 = whole;
  if (said.shape == BodyShape::none) parts.erase(parts.begin());
  body.shape = box_around(parts);
  body.several = std::move(parts);
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

/// Of the motion with that number in files; of a joint with one, 0.
template <class Load>
std::vector<Load> loads_of(const std::string& joint, std::size_t motion, const std::vector<LoadTable<Load>>& tables) {
  std::vector<Load> loads;
  for (const LoadTable<Load>& table : tables) {
    if (table.joint == joint && table.motion == motion) loads.push_back(table.load);
  }
  return loads;
}

/// A joint that only this motion is told of.
Joint told_of(const Description& said, const JointTable& table, std::size_t motion) {
  const std::size_t k = motion == 0 ? 0 : motion - 1;
  Joint joint{.kind = table.kind->make(table),
              .first = 0,
              .second = {},
              .motor = table.motors[k],
              .stop = table.stops[k],
              .springs = loads_of(table.name, motion, said.springs),
              .torques = loads_of(table.name, motion, said.torques),
              .controllers = loads_of(table.name, motion, said.controllers),
              .name = table.name};
  count_from(joint, start_of(table, k));
  return joint;
}

/// Of a kind with several motions, told the other way round where the parent is a body. The axes of a universal joint
/// on the world change places: joint_kinds.hpp.
std::vector<AxisDrive> axis_drives(const Description& said, const JointTable& table, bool round) {
  std::vector<AxisDrive> drives;
  const std::size_t last = table.kind->motions;
  const std::vector<Driveable> motions = driveable_of(table.kind->make(table));
  for (std::size_t k = 0; k < last; ++k) {
    Joint one = told_of(said, table, k + 1);
    if (!one.driven()) continue;
    if (round) one = turned_round(std::move(one));
    const bool turns_of_two = !motions[k].slides && !motions[last - 1].slides && !motions[last - 2].slides;
    const bool other = turns_of_two && table.kind->parent == Carries::anything && table.parent == world_name;
    const std::size_t motion = other ? (last - 1) + (last - 2) - k : k;
    drives.push_back({motion, k + 1, one.motor, one.stop, one.springs, one.torques, one.controllers});
  }
  return drives;
}

/// The parent is the joint's first body, or its second where it is the world, which is never the first.
Joint joint_of_tree(const Description& said, const JointTable& table) {
  const std::size_t child = said.body_named(table.child).value();
  const std::optional<std::size_t> parent = said.body_named(table.parent);
  const bool several = table.kind->motions > 1;
  Joint joint{.kind = table.kind->make(table), .first = child, .second = {}, .name = table.name};
  if (!several) joint = told_of(said, table, 0);
  if (several) joint.drives = axis_drives(said, table, parent.has_value());
  joint.first = parent.value_or(child);
  if (!parent) return joint;
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
    Contact contact{.restitution = table.restitution, .softness = table.softness, .spring = table.spring};
    if (table.friction) contact.friction = Friction{*table.friction, FrictionModel::pyramid};
    if (!table.between.empty()) {
      contact.first = table.between[0];
      contact.second = table.between[1];
    }
    mechanism.contacts.push_back(contact);
  }
}

void tell(const MendedStart& mended, Definition& definition) {
  if (!mended.body.empty()) {
    definition.emplace_back("changed_at_start.velocity", mended.speed_m_s);
    definition.emplace_back("changed_at_start.spin", mended.spin_rad_s);
    definition.emplace_back("changed_at_start.body", mended.body);
  }
  if (mended.joint.empty()) return;
  definition.emplace_back("closed_at_start.turn", mended.turned_rad);
  definition.emplace_back("closed_at_start.way", mended.moved_m);
  definition.emplace_back("closed_at_start.joint", mended.joint);
  definition.emplace_back("closed_at_start.q", mended.q);
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
  for (std::size_t i = 0; i < description.bodies.size(); ++i)
    add_shapes(scenario.mechanism.bodies[i], description.bodies[i]);
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
  if (!description.joints.empty()) tell(bring_to_start(scenario.mechanism, description), scenario.definition);
}

}  // namespace odeval
