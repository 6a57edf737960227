#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "model/draft.hpp"
#include "model/generate.hpp"
#include "model/inertia.hpp"
#include "model/joint_kinds.hpp"
#include "model/nearest.hpp"
#include "model/start_pose.hpp"

namespace odeval {
namespace {

/// "joints.2.axis"
std::string path_of(const char* list, std::size_t number, const char* key) {
  return fmt::format("{}.{}.{}", list, number, key);
}

std::string shown(const Vec3& v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); }

/// A name for each body, no two the same.
void name_bodies(Draft& draft) {
  std::vector<BodyTable>& bodies = draft.said.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    std::string& name = bodies[i].name;
    if (name.empty()) name = fmt::format("body{}", i + 1);
    if (name == world_name) draft.fail(path_of("bodies", i, "name"), name, "is what nothing moves; name it otherwise");
    const std::size_t before = draft.said.body_named(name).value();
    if (before == i) continue;
    draft.fail(path_of("bodies", i, "name"), name, fmt::format("is the name of bodies.{} as well", before));
  }
}

/// A name for each joint, no two the same.
void name_joints(Draft& draft) {
  std::vector<JointTable>& joints = draft.said.joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    std::string& name = joints[i].name;
    if (name.empty()) name = fmt::format("joint{}", i + 1);
    const auto before = std::ranges::find(joints, name, &JointTable::name) - joints.begin();
    if (before == static_cast<std::ptrdiff_t>(i)) continue;
    draft.fail(path_of("joints", i, "name"), name, fmt::format("is the name of joints.{} as well", before));
  }
}

/// No moment of a body is zero.
void check_inertia(const Draft& draft, std::size_t body) {
  const auto& inertia = draft.said.bodies[body].inertia_kgm2;
  if (!inertia || is_inertia(*inertia, true)) return;
  draft.fail(path_of("bodies", body, "inertia"), fmt::format("[{}]", fmt::join(*inertia, ", ")),
             "is of no body: each principal moment must be above 0, and at most the sum of the other two");
}

void body_called(const Draft& draft, const char* list, std::size_t number, const char* key, const std::string& name) {
  if (draft.said.body_named(name)) return;
  std::vector<std::string> names;
  for (const BodyTable& body : draft.said.bodies) names.push_back(body.name);
  draft.fail(path_of(list, number, key), name,
             name == world_name ? "carries and is not carried; it is a parent"
                                : "is the name of no body" + nearest_hint(name, names));
}

/// Two that are there, and not the same: joints may make a tree, or close loops.
template <class Table>
void check_ends(const Draft& draft, const char* list, const std::vector<Table>& tables) {
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const Table& table = tables[i];
    if (table.parent != world_name) body_called(draft, list, i, "parent", table.parent);
    body_called(draft, list, i, "child", table.child);
    if (table.parent == table.child) draft.fail(path_of(list, i, "child"), table.child, "is its parent as well");
  }
}

void check_parent(const Draft& draft, std::size_t number) {
  const JointTable& joint = draft.said.joints[number];
  const bool on_world = joint.parent == world_name;
  if (joint.kind->parent == (on_world ? Carries::a_body : Carries::the_world)) {
    draft.fail(path_of("joints", number, "parent"), joint.parent,
               fmt::format("must be {} for kind {}", on_world ? "a body" : "the world", joint.kind->word));
  }
  const Vec3& position = draft.said.bodies[draft.said.body_named(joint.child).value()].position_m;
  if (joint.kind->parent == Carries::the_world && position[2] != 0) {
    draft.fail(path_of("joints", number, "child"), joint.child,
               fmt::format("must start with its centre in the plane z = 0, which kind {} holds it in, not at z = {}",
                           joint.kind->word, position[2]));
  }
}

void check_suspension(const Draft& draft, std::size_t number) {
  const JointTable& joint = draft.said.joints[number];
  const std::string path = path_of("joints", number, "suspension");
  if (draft.tree["joints"][number].as_table()->contains("suspension") != joint.kind->suspended) {
    draft.fail(path, "",
               joint.kind->suspended ? fmt::format("is missing; kind {} needs it", joint.kind->word)
                                     : fmt::format("has no meaning for kind {}; remove it", joint.kind->word));
  }
  const auto& [stiffness, damping] = joint.suspension;
  if (joint.kind->suspended && stiffness + damping == 0) {
    draft.fail(path, fmt::format("[{}, {}]", stiffness, damping), "must have a stiffness or a damping above 0");
  }
}

void check_struts(const Draft& draft) {
  const std::vector<StrutTable>& struts = draft.said.struts;
  check_ends(draft, "struts", struts);
  for (std::size_t i = 0; i < struts.size(); ++i) {
    if (struts[i].from_m != struts[i].to_m) continue;
    draft.fail(path_of("struts", i, "to"), shown(struts[i].to_m), "is where the other end is: it must have a length");
  }
}

struct NamedAxis {
  const char* key;
  Vec3& axis;
};

/// The second one, against the first, which is a unit one.
void make_right_angle(const Draft& draft, std::size_t joint, const NamedAxis& first, const NamedAxis& second) {
  const Vec3 said = second.axis;
  draft.make_unit(path_of("joints", joint, second.key), second.axis);
  constexpr double rounding = 1e-6;  // of the numbers in a file
  const double along = dot(first.axis, second.axis);
  if (std::fabs(along) > rounding) {
    draft.fail(path_of("joints", joint, second.key), shown(said),
               fmt::format("must be at right angles to {}, the cosine between them is {:.3g}", first.key, along));
  }
  second.axis = unit(second.axis - along * first.axis);
}

void settle_axes(Draft& draft, std::size_t number) {
  JointTable& joint = draft.said.joints[number];
  const toml::table& table = *draft.tree["joints"][number].as_table();
  int axes = 0;
  for (const char* key : {"axis", "axis2", "axis3"}) {
    if (axes++ < joint.kind->axes || !table.contains(key)) continue;
    draft.fail(path_of("joints", number, key), "",
               fmt::format("has no meaning for kind {}; remove it", joint.kind->word));
  }
  if (joint.kind->axes > 0) draft.make_unit(path_of("joints", number, "axis"), joint.axis);
  if (joint.kind->axes < 2) return;
  if (joint.kind->axes == 2) {
    make_right_angle(draft, number, {"axis", joint.axis}, {"axis2", joint.axis2});
  } else {
    draft.make_unit(path_of("joints", number, "axis2"), joint.axis2);
    make_right_angle(draft, number, {"axis2", joint.axis2}, {"axis3", joint.axis3});
  }
}

void check_motors(const Draft& draft, std::size_t number) {
  const JointTable& joint = draft.said.joints[number];
  for (std::size_t k = 0; k < joint.motors.size(); ++k) {
    if (!joint.motors[k]) continue;
    if (k >= joint.kind->motions) {
      draft.fail(path_of("joints", number, motor_keys[k]), "",
                 fmt::format("has no meaning for kind {}; remove it", joint.kind->word), Draft::Blame::parts);
    }
    if (joint.motors[k]->most != 0) continue;
    draft.fail(path_of("joints", number, motor_keys[k]) + ".force", "0",
               fmt::format("does nothing; it must be above 0, or the table {} is to be removed", motor_keys[k]));
  }
}

/// Whether a motion of a kind, counted from 0, is a turn.
bool turns(const JointTable& joint, std::size_t motion) {
  const JointKind kind = joint.kind->make(joint);
  const std::vector<Driveable> several = driveable_of(kind);
  return several.empty() ? std::holds_alternative<HingeJoint>(kind) : !several[motion].slides;
}

/// Where it starts and how fast: a number for each of its motions.
void check_start_of(const Draft& draft, std::size_t number) {
  const JointTable& joint = draft.said.joints[number];
  const toml::table& table = *draft.tree["joints"][number].as_table();
  const std::size_t motions = joint.kind->motions;
  for (const auto& [key, list, instead] : {std::tuple{"q", &joint.q, "turn"}, std::tuple{"qd", &joint.qd, "spin"}}) {
    const toml::node* const node = table.get(key);
    if (node == nullptr) continue;
    const auto fail = [&](const std::string& rule) {
      draft.fail(path_of("joints", number, key), odeval::shown(*node), rule, Draft::Blame::parts);
    };
    if (motions == 0) {
      fail(joint.kind->axes == 0 && freedom_of(joint.kind->make(joint)).turns.empty()
               ? fmt::format("has no meaning for kind {}, which leaves nothing that moves; remove it", joint.kind->word)
               : fmt::format("has no meaning for kind {}, whose turns have no order; give bodies.{} '{}' another {}",
                             joint.kind->word, draft.said.body_named(joint.child).value(), joint.child, instead));
    }
    if (motions == 1 && list->size() != 1) fail(fmt::format("must be one number for kind {}", joint.kind->word));
    if (list->size() == motions && (motions == 1 || !node->is_number())) continue;
    fail(fmt::format("must be a list of {} numbers for kind {}: {}", motions, joint.kind->word, joint.kind->order));
  }
}

/// Of one motion, which starts between its ends.
void check_stop(const Draft& draft, std::size_t number, std::size_t k) {
  const JointTable& joint = draft.said.joints[number];
  const toml::table& table = *draft.tree["joints"][number].as_table();
  for (const char* key : {stop_keys[k], restitution_keys[k]}) {
    if (!table.contains(key) || k < joint.kind->stopped) continue;
    draft.fail(path_of("joints", number, key), "",
               fmt::format("has no meaning for kind {}{}; remove it", joint.kind->word,
                           k < joint.kind->motions ? ", for which ODE has no such stops" : ""),
               Draft::Blame::parts);
  }
  if (!joint.stops[k]) return;
  const auto& [low, high, restitution] = *joint.stops[k];
  const std::string path = path_of("joints", number, stop_keys[k]);
  if (!table.contains(stop_keys[k])) {
    draft.fail(path, "", fmt::format("is missing, or {} is to be removed", restitution_keys[k]));
  }
  const std::string said = fmt::format("[{}, {}]", low, high);
  const double start = start_of(joint, k);
  if (!(low <= start && high >= start && low < high)) {
    draft.fail(path, said,
               fmt::format("must be a low and a high end with {}, where the joint starts, between them", start));
  }
  const double half_turn = std::numbers::pi;  // beyond, ODE counts an angle from the other side
  if (turns(joint, k) && !(low - start > -half_turn && high - start < half_turn)) {
    draft.fail(path, said,
               fmt::format("must lie within half a turn of a {}, between {:.6g} and {:.6g} rad", joint.kind->word,
                           start - half_turn, start + half_turn));
  }
}

void check_drive(const Draft& draft, std::size_t number) {
  check_motors(draft, number);
  for (std::size_t k = 0; k < stop_keys.size(); ++k) check_stop(draft, number, k);
}

void check_signal(const Draft& draft, const std::string& path, const Signal& signal) {
  if (signal.times_s.size() != signal.values.size()) {
    draft.fail(path + ".values", fmt::format("{} numbers", signal.values.size()),
               fmt::format("must be as many as times, {}", signal.times_s.size()));
  }
  if (std::ranges::adjacent_find(signal.times_s, std::greater_equal()) != signal.times_s.end()) {
    draft.fail(path + ".times", "", "must rise from each to the next");
  }
}
/// Whether it is 0 at every time.
bool is_nothing(const Signal& signal) {
  const bool swings = signal.amplitude != 0 && (signal.frequency_Hz != 0 || std::sin(signal.phase_rad) != 0);
  return signal.constant == 0 && !swings && std::ranges::all_of(signal.values, [](double value) { return value == 0; });
}

void check_load(const Draft& draft, const std::string& path, const JointSpring& spring) {
  if (spring.stiffness != 0 || spring.damping != 0) return;
  draft.fail(path, "", "does nothing: stiffness and damping are 0; give one of them, or remove it",
             Draft::Blame::parts);
}
void check_load(const Draft& draft, const std::string& path, const Signal& torque) {
  check_signal(draft, path, torque);
  if (!is_nothing(torque)) return;
  draft.fail(path, "", "does nothing: give a constant, an amplitude with a frequency, or values; or remove it",
             Draft::Blame::parts);
}
void check_load(const Draft& draft, const std::string& path, const Controller& controller) {
  check_signal(draft, path, controller.target);
  if (controller.kp != 0 || controller.kd != 0) return;
  draft.fail(path, "", "does nothing: kp and kd are 0; give one of them, or remove it", Draft::Blame::parts);
}

/// A load's motion is one of its joint's.
void check_motion(const Draft& draft, const std::string& path, const JointTable& joint, std::size_t motion) {
  const std::size_t several = joint.kind->motions;
  if (several == 0) {
    draft.fail(path + ".joint", joint.name,
               fmt::format("is of kind {}, on which no load acts; it must be of another kind than ball and fixed",
                           joint.kind->word));
  }
  if (several == 1 && motion != 0) {
    draft.fail(path + ".motion", std::to_string(motion),
               fmt::format("has no meaning for kind {}, which has one motion; remove it", joint.kind->word));
  }
  if (several == 1 || (motion >= 1 && motion <= several)) return;
  draft.fail(path + ".motion", motion == 0 ? "" : std::to_string(motion),
             fmt::format("{} from 1 to {}, the number of a motion of joint '{}' of kind {}",
                         motion == 0 ? "is missing; it must be" : "must be", several, joint.name, joint.kind->word));
}

/// Each acts on a joint that is there, on one of its motions.
template <class Load>
void check_loads(const Draft& draft, const char* list, const std::vector<LoadTable<Load>>& tables) {
  const std::vector<JointTable>& joints = draft.said.joints;
  std::vector<std::string> names;
  for (const JointTable& joint : joints) names.push_back(joint.name);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const std::string path = fmt::format("{}.{}", list, i);
    const auto found = std::ranges::find(joints, tables[i].joint, &JointTable::name);
    if (found == joints.end()) {
      draft.fail(path + ".joint", tables[i].joint, "is the name of no joint" + nearest_hint(tables[i].joint, names));
    }
    check_motion(draft, path, *found, tables[i].motion);
    check_load(draft, path, tables[i].load);
  }
}

/// Whether a body hangs on the world by nothing.
bool something_flies(const Mechanism& mechanism) {
  std::vector<bool> hangs(mechanism.bodies.size());
  for (bool more = true; more;) {
    more = false;
    for (const Joint& joint : mechanism.joints) {
      const std::size_t second = joint.second.value_or(joint.first);
      if (hangs[joint.first] && hangs[second]) continue;
      if (joint.second && !hangs[joint.first] && !hangs[second]) continue;
      hangs[joint.first] = hangs[second] = more = true;
    }
  }
  return std::ranges::find(hangs, false) != hangs.end();
}

/// Something can move, and moves at first as the joints let it.
void check_start(const Draft& draft) {
  Scenario made;
  try {
    put_bodies(made, draft.said);
  } catch (const BadStart& bad) {
    const std::string table = fmt::format("joints.{}", bad.joint);
    draft.fail(bad.key_at_fault.empty() ? table : joined(table, bad.key_at_fault), "", bad.what(),
               bad.key_at_fault.empty() ? Draft::Blame::whole : Draft::Blame::parts);
  }
  const Mechanism& mechanism = made.mechanism;
  std::size_t free = something_flies(mechanism) ? 1 : 0;
  for (const Joint& joint : mechanism.joints) {
    const Freedom freedom = freedom_of(joint.kind);
    free += freedom.ways.size() + freedom.turns.size();
  }
  if (free == 0) draft.fail("joints", "", "leave nothing that can move; one of another kind than fixed is wanted");
}

}  // namespace

std::optional<std::size_t> Description::body_named(std::string_view name) const {
  const auto found = std::ranges::find(bodies, name, &BodyTable::name);
  if (found == bodies.end()) return std::nullopt;
  return static_cast<std::size_t>(found - bodies.begin());
}

void settle_joints(Draft& draft) {
  name_bodies(draft);
  for (std::size_t i = 0; i < draft.said.bodies.size(); ++i) check_inertia(draft, i);
  check_ends(draft, "joints", draft.said.joints);
  check_struts(draft);
  name_joints(draft);
  for (std::size_t i = 0; i < draft.said.joints.size(); ++i) {
    check_parent(draft, i);
    check_suspension(draft, i);
    settle_axes(draft, i);
    check_start_of(draft, i);
    check_drive(draft, i);
  }
  check_loads(draft, "springs", draft.said.springs);
  check_loads(draft, "torques", draft.said.torques);
  check_loads(draft, "controllers", draft.said.controllers);
  check_start(draft);
}

}  // namespace odeval
