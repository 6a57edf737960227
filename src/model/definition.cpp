#include <fmt/format.h>

#include "model/generate.hpp"
#include "model/joint_kinds.hpp"

namespace odeval {
namespace {

/// Adds settings under a name: "links.0" and "mass" make "links.0.mass".
class Section {
 public:
  Section(Definition& definition, std::string name) : definition_(definition), name_(std::move(name)) {}

  Section& add(const char* key, SettingValue value) {
    definition_.emplace_back(fmt::format("{}.{}", name_, key), std::move(value));
    return *this;
  }
  Section& add(const char* key, const Vec3& vector) {
    return add(key, std::vector<double>(vector.begin(), vector.end()));
  }

 private:
  Definition& definition_;
  std::string name_;
};

void add_link(Section section, const Link& link) {
  section.add("mass", link.mass_kg).add("length", link.length_m).add("width", link.width_m).add("depth", link.depth_m);
  if (link.shape == LinkShape::sphere) section.add("shape", "sphere");
}

void add_body(Section section, const BodyTable& body) {
  section.add("shape", word_of(body.shape));
  if (body.mass_kg > 0) section.add("mass", body.mass_kg);
  if (body.shape != BodyShape::none) section.add("size", body.size_m);
  section.add("position", body.position_m)
      .add("turn", body.turn_rad)
      .add("velocity", body.velocity_m_s)
      .add("spin", body.spin_rad_s)
      .add("aspect", body.aspect);
  if (!body.name.empty()) section.add("name", body.name);
  if (body.inertia_kgm2)
    section.add("inertia", std::vector<double>(body.inertia_kgm2->begin(), body.inertia_kgm2->end()));
  if (body.centre_m != Vec3{}) section.add("centre", body.centre_m);
}

void add_shape(Section section, const ShapeTable& shape) {
  section.add("shape", word_of(shape.shape))
      .add("mass", shape.mass_kg)
      .add("size", shape.size_m)
      .add("position", shape.position_m);
  if (shape.shape != BodyShape::sphere) section.add("turn", shape.turn_rad);
  if (!shape.name.empty()) section.add("name", shape.name);
}

void add_ground(Section section, const GroundTable& ground, bool friction) {
  section.add("slope", ground.slope_rad).add("restitution", ground.restitution);
  if (!friction) return;
  section.add("friction", ground.friction)
      .add("friction_model", ground.friction_model == FrictionModel::constant ? "constant" : "pyramid");
}

void add_joint(Section section, const JointTable& joint) {
  section.add("kind", std::string(joint.kind->word))
      .add("anchor", joint.anchor_m)
      .add("displacement", joint.displacement_m);
  if (joint.kind->axes > 0) section.add("axis", joint.axis);
}

void add_signal(Section& section, const char* constant, const Signal& signal) {
  section.add(constant, signal.constant);
  if (signal.amplitude != 0) {
    section.add("amplitude", signal.amplitude).add("frequency", signal.frequency_Hz).add("phase", signal.phase_rad);
  }
  if (!signal.times_s.empty()) section.add("times", signal.times_s).add("values", signal.values);
}

void add_load(Section section, const JointSpring& spring) {
  section.add("stiffness", spring.stiffness).add("damping", spring.damping).add("rest", spring.rest);
}
void add_load(Section section, const Signal& torque) { add_signal(section, "constant", torque); }
void add_load(Section section, const Controller& controller) {
  section.add("kp", controller.kp).add("kd", controller.kd).add("sampling", controller.sampled ? "step" : "continuous");
  add_signal(section, "target", controller.target);
}

template <class Load>
void add_loads(Definition& all, const char* list, const std::vector<LoadTable<Load>>& tables) {
  for (std::size_t i = 0; i < tables.size(); ++i) {
    Section section(all, fmt::format("{}.{}", list, i));
    section.add("joint", tables[i].joint);
    if (tables[i].motion != 0) section.add("motion", static_cast<std::int64_t>(tables[i].motion));
    add_load(section, tables[i].load);
  }
}

void add_contact(Section section, const ContactTable& contact) {
  // Names are words, and a definition has no lists of them.
  for (std::size_t i = 0; i < contact.between.size(); ++i) {
    section.add(i == 0 ? "between.0" : "between.1", contact.between[i]);
  }
  if (!contact.spring) section.add("restitution", contact.restitution);
  if (contact.friction) section.add("friction", *contact.friction);
  if (contact.softness) section.add("erp", contact.softness->erp).add("cfm", contact.softness->cfm);
  if (contact.spring) section.add("kp", contact.spring->kp_N_m).add("kd", contact.spring->kd_Ns_m);
}

void add_joint_of_tree(Section section, const JointTable& joint) {
  section.add("kind", std::string(joint.kind->word))
      .add("parent", joint.parent)
      .add("child", joint.child)
      .add("anchor", joint.anchor_m);
  if (joint.kind->axes > 0) section.add("axis", joint.axis);
  if (joint.kind->axes > 1) section.add("axis2", joint.axis2);
  if (joint.kind->axes > 2) section.add("axis3", joint.axis3);
  if (joint.kind->suspended) section.add("suspension", std::vector(joint.suspension.begin(), joint.suspension.end()));
  if (!joint.name.empty()) section.add("name", joint.name);
  const auto add = [&](const char* key, const std::vector<double>& list) {
    if (list.size() == 1) section.add(key, list.front());
    if (list.size() > 1) section.add(key, list);
  };
  add("q", joint.q);
  add("qd", joint.qd);
  for (std::size_t k = 0; k < joint.stops.size(); ++k) {
    const auto& stop = joint.stops[k];
    if (!stop) continue;
    section.add(stop_keys[k], std::vector{stop->low, stop->high}).add(restitution_keys[k], stop->restitution);
  }
  for (std::size_t k = 0; k < joint.motors.size(); ++k) {
    const std::string key = motor_keys[k];
    const auto& motor = joint.motors[k];
    if (motor) section.add((key + ".velocity").c_str(), motor->speed).add((key + ".force").c_str(), motor->most);
  }
}

void add_strut(Section section, const StrutTable& strut) {
  section.add("parent", strut.parent)
      .add("child", strut.child)
      .add("from", strut.from_m)
      .add("to", strut.to_m)
      .add("stiffness", strut.stiffness)
      .add("damping", strut.damping)
      .add("rest", strut.rest_m.value_or(distance(strut.from_m, strut.to_m)));
}

}  // namespace

Definition definition_of(const Description& said) {
  Definition all;
  if (said.limit_of_numbers) all.emplace_back("limit", std::string("numbers"));
  if (said.n) all.emplace_back("n", std::int64_t{*said.n});
  std::size_t number = 0;
  for (const Link& link : said.links) add_link({all, fmt::format("links.{}", number++)}, link);
  number = 0;
  for (const BodyTable& body : said.bodies) {
    const std::string name = fmt::format("bodies.{}", number++);
    add_body({all, name}, body);
    for (std::size_t i = 0; i < body.shapes.size(); ++i)
      add_shape({all, fmt::format("{}.shapes.{}", name, i)}, body.shapes[i]);
  }
  number = 0;
  for (const JointTable& joint : said.joints) add_joint_of_tree({all, fmt::format("joints.{}", number++)}, joint);
  add_loads(all, "springs", said.springs);
  add_loads(all, "torques", said.torques);
  add_loads(all, "controllers", said.controllers);
  number = 0;
  for (const PlaneTable& plane : said.planes) {
    Section(all, fmt::format("planes.{}", number++))
        .add("name", plane.name)
        .add("normal", plane.normal)
        .add("point", plane.point_m);
  }
  number = 0;
  for (const ContactTable& contact : said.contacts) add_contact({all, fmt::format("contacts.{}", number++)}, contact);
  number = 0;
  for (const StrutTable& strut : said.struts) add_strut({all, fmt::format("struts.{}", number++)}, strut);
  if (said.ground) add_ground({all, "ground"}, *said.ground, said.problem->friction);
  if (said.joint) add_joint({all, "joint"}, *said.joint);
  if (said.wall) {
    Section(all, "wall").add("face", said.wall->face_m).add("restitution", said.wall->restitution);
  }
  return all;
}

}  // namespace odeval
