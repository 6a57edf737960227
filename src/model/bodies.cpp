#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/draft.hpp"
#include "model/generate.hpp"
#include "model/joint_kinds.hpp"

namespace odeval {

namespace {

/// The rotation vector of one turn and then another, by the product of their quaternions.
Vec3 turn_after(const Vec3& first, const Vec3& then) {
  const auto half = [](const Vec3& v) {
    const double angle = std::sqrt(dot(v, v));
    const double part = angle == 0 ? 0.5 : std::sin(angle / 2) / angle;
    return std::pair{std::cos(angle / 2), Vec3{part * v[0], part * v[1], part * v[2]}};
  };
  const auto [a, u] = half(then);
  const auto [b, v] = half(first);
  const Vec3 turning = cross(u, v);
  Vec3 w{};
  for (std::size_t k = 0; k < 3; ++k) w[k] = a * v[k] + b * u[k] + turning[k];
  const double sine = std::sqrt(dot(w, w));
  const double angle = 2 * std::atan2(sine, a * b - dot(u, v));
  const double part = sine == 0 ? 0 : angle / sine;
  return {part * w[0], part * w[1], part * w[2]};
}

/// What stands in the file along the ground (downhill, across, away) into the world.
void lay_on_ground(Description& said) {
  const Vec3 normal = sloping(said.ground->slope_rad).normal;
  const Vec3 downhill{normal[2], 0, -normal[0]};
  const auto into_world = [&](const Vec3& v) {
    return Vec3{v[0] * downhill[0] + v[2] * normal[0], v[1], v[0] * downhill[2] + v[2] * normal[2]};
  };
  for (BodyTable& body : said.bodies) {
    body.position_m = into_world(body.position_m);
    body.velocity_m_s = into_world(body.velocity_m_s);
    body.spin_rad_s = into_world(body.spin_rad_s);
    body.turn_rad = turn_after(body.turn_rad, {0, said.ground->slope_rad, 0});
  }
}

/// What `aspect` says goes into the sides, which are held to the least size again.
void make_thin(Draft& draft) {
  constexpr double least_m = 1e-4;
  for (std::size_t i = 0; i < draft.said.bodies.size(); ++i) {
    BodyTable& body = draft.said.bodies[i];
    if (body.size_m == Vec3{}) continue;  // has none, or lacks it
    for (const std::size_t side : {0, 1}) {
      body.size_m[side] /= body.aspect;
      if (body.size_m[side] >= least_m) continue;
      draft.fail(fmt::format("bodies.{}.aspect", i), fmt::format("{}", body.aspect),
                 fmt::format("makes a side {:.6g} m thin; it must leave at least {} m", body.size_m[side], least_m));
    }
  }
}

/// Of a shape whose size is not one of its kind, the setting that made it so is blamed, or the size.
void check_size(const Draft& draft, const std::string& path, BodyShape shape, const Vec3& size) {
  const auto& [x, y, z] = size;
  const auto fail = [&](const char* rule) {
    if (!draft.setting_of(path + ".size") && draft.setting_of(path + ".shape")) {
      draft.fail(path + ".shape", word_of(shape), fmt::format("needs another size: {}", rule));
    }
    draft.fail(path + ".size", fmt::format("[{}, {}, {}]", x, y, z), rule);
  };
  if (shape == BodyShape::sphere && (x != y || x != z)) fail("must be the diameter, three times, for a sphere");
  if (shape == BodyShape::cylinder && x != y) fail("must be the diameter, twice, and the length, for a cylinder");
  if (shape == BodyShape::capsule && (x != y || z <= x)) {
    fail("must be the diameter, twice, and the length with both ends, which is longer, for a capsule");
  }
}

/// What stands in plane2d's plane is the centre of mass, which a mass beside it would move.
void check_held_by_plane(const Draft& draft, std::size_t number) {
  const BodyTable& body = draft.said.bodies[number];
  for (const JointTable& joint : draft.said.joints) {
    if (joint.kind->parent != Carries::the_world || joint.child != body.name) continue;
    const auto fail = [&](const std::string& key, const std::string& value) {
      draft.fail(fmt::format("bodies.{}.{}", number, key), value,
                 fmt::format("must be 0 for a body that kind {} holds by its centre", joint.kind->word));
    };
    const auto& [x, y, z] = body.centre_m;
    if (body.centre_m != Vec3{}) fail("centre", fmt::format("[{}, {}, {}]", x, y, z));
    for (std::size_t i = 0; i < body.shapes.size(); ++i) {
      const double mass_kg = body.shapes[i].mass_kg;
      if (mass_kg != 0) fail(fmt::format("shapes.{}.mass", i), fmt::format("{}", mass_kg));
    }
  }
}

void check_shapes(const Draft& draft, std::size_t number) {
  const std::vector<ShapeTable>& shapes = draft.said.bodies[number].shapes;
  const toml::table& body = *draft.tree["bodies"][number].as_table();
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const std::string path = fmt::format("bodies.{}.shapes.{}", number, i);
    check_size(draft, path, shapes[i].shape, shapes[i].size_m);
    if (shapes[i].shape == BodyShape::sphere && body["shapes"][i].as_table()->contains("turn")) {
      draft.fail(path + ".turn", "", "has no effect on a sphere; remove it");
    }
    const auto same = std::ranges::find(shapes, shapes[i].name, &ShapeTable::name) - shapes.begin();
    if (shapes[i].name.empty() || same == static_cast<std::ptrdiff_t>(i)) continue;
    draft.fail(path + ".name", shapes[i].name, fmt::format("is the name of bodies.{}.shapes.{} as well", number, same));
  }
}

/// A body has a size, or no shape of its own and then others.
void check_has_size(const Draft& draft, std::size_t number) {
  const BodyTable& body = draft.said.bodies[number];
  const toml::table& table = *draft.tree["bodies"][number].as_table();
  const auto fail = [&](const char* key, const std::string& rule) {
    draft.fail(fmt::format("bodies.{}.{}", number, key), "", rule, Draft::Blame::parts);
  };
  if (body.shape != BodyShape::none) {
    if (table.contains("size")) return check_size(draft, fmt::format("bodies.{}", number), body.shape, body.size_m);
    fail("size", fmt::format("is missing; it {}", rule_of(*find_key("bodies", "size"), draft.names)));
  }
  if (!draft.said.problem->joints) {
    draft.fail(fmt::format("bodies.{}.shape", number), "none",
               fmt::format("has no meaning for {}", draft.said.problem->name));
  }
  for (const char* key : {"size", "aspect"}) {
    if (table.contains(key)) fail(key, "has no meaning for shape none; remove it");
  }
  if (body.shapes.empty()) fail("shape", "must not be none for a body without [[bodies.shapes]]");
}

/// A body has a mass of its own, uniform in its shape or with an inertia, or its shapes have all of it.
void check_has_mass(const Draft& draft, std::size_t number) {
  const BodyTable& body = draft.said.bodies[number];
  const auto fail = [&](const char* key, const std::string& rule) {
    draft.fail(fmt::format("bodies.{}.{}", number, key), "", rule);
  };
  const auto missing = [](const char* key) {
    return fmt::format("is missing; it {}", rule_of(*find_key("bodies", key), Names{}));
  };
  const bool none = body.shape == BodyShape::none;
  if (body.mass_kg == 0 && !none) fail("mass", missing("mass"));
  if (body.mass_kg > 0 && none && !body.inertia_kgm2)
    fail("inertia", missing("inertia") + ", of a mass without a shape");
  if (body.mass_kg == 0 && body.inertia_kgm2) fail("mass", missing("mass") + ", of an inertia");
  if (body.centre_m != Vec3{} && !body.inertia_kgm2) {
    fail("centre", "needs an inertia: a uniform solid has its centre of mass in its own centre");
  }
  double sum = body.mass_kg;
  for (const ShapeTable& shape : body.shapes) sum += shape.mass_kg;
  const KeyRow& row = *find_key("bodies", "mass");
  if (sum < row.least) fail("mass", missing("mass") + ", or else that of its [[bodies.shapes]] together");
}

void check_bodies(const Draft& draft) {
  for (const char* key : {"n", "links", "q0", "qd0", "maximal"}) draft.refuse(key);
  if (draft.said.bodies.empty()) {
    draft.fail("bodies", "0 tables",
               fmt::format("must be tables [[bodies]], at least one, for {}", draft.said.problem->name));
  }
  constexpr std::size_t most = 1024;  // as links of a chain
  if (draft.said.bodies.size() > most) {
    draft.fail("bodies", fmt::format("{} tables", draft.said.bodies.size()),
               fmt::format("must be at most {} tables [[bodies]]", most));
  }
  std::size_t shapes = 0;
  for (std::size_t i = 0; i < draft.said.bodies.size(); ++i) {
    const BodyTable& body = draft.said.bodies[i];
    shapes += body.shapes.size();
    if (shapes > most) {
      draft.fail(fmt::format("bodies.{}.shapes", i), "",
                 fmt::format("makes {} tables [[bodies.shapes]]; at most {} are taken", shapes, most));
    }
    check_has_size(draft, i);
    check_has_mass(draft, i);
    check_shapes(draft, i);
    if (draft.said.ground && body.shape != BodyShape::box && body.shape != BodyShape::sphere) {
      draft.fail(fmt::format("bodies.{}.shape", i), word_of(body.shape),
                 "must be box or sphere on a [ground]; the [[planes]] of a mechanism bear all shapes");
    }
  }
}

void check_joint(const Draft& draft) {
  if (draft.said.bodies.size() > 2) {
    draft.fail("bodies", fmt::format("{} tables", draft.said.bodies.size()),
               fmt::format("must be one table [[bodies]] or two for {}", draft.said.problem->name));
  }
  if (dot(draft.said.joint->axis, draft.said.joint->axis) == 0) {
    draft.fail("joint.axis", "[0, 0, 0]", "must have a direction");
  }
}

void pull_out_of_joint(Description& said) {
  Vec3& axis = said.joint->axis;
  const double length = std::sqrt(dot(axis, axis));
  for (std::size_t k = 0; k < 3; ++k) {
    axis[k] /= length;
    said.bodies.front().position_m[k] += said.joint->displacement_m[k];
  }
}

}  // namespace

void refuse_misplaced(const Draft& draft) {
  if (draft.tree.contains("shapes")) {
    draft.fail("shapes", "", "is no table of a file; the shapes of a body are tables [[bodies.shapes]] below it",
               Draft::Blame::parts);
  }
  const auto refuse_plane = [&](const toml::node_view<const toml::node>& table, const std::string& path) {
    if (table["shape"].value<std::string_view>() != "plane") return;
    draft.fail(path + ".shape", "plane",
               "is of no body: ODE's planes stand still; write it as [[planes]], which [[contacts]] name");
  };
  const auto bodies = draft.tree["bodies"];
  const auto count = [](const auto& node) { return node.is_array() ? node.as_array()->size() : 0; };
  for (std::size_t i = 0; i < count(bodies); ++i) {
    refuse_plane(bodies[i], fmt::format("bodies.{}", i));
    const auto shapes = bodies[i]["shapes"];
    for (std::size_t k = 0; k < count(shapes); ++k) refuse_plane(shapes[k], fmt::format("bodies.{}.shapes.{}", i, k));
  }
}

void settle_shapes(Draft& draft) {
  for (std::size_t i = 0; i < draft.said.bodies.size(); ++i) {
    const toml::table& table = *draft.tree["bodies"][i].as_table();
    BodyTable& body = draft.said.bodies[i];
    if (!body.shapes.empty() && !table.contains("shape") && !table.contains("size")) body.shape = BodyShape::none;
  }
}

void settle_bodies(Draft& draft) {
  make_thin(draft);
  check_bodies(draft);
}

void place_bodies(Draft& draft) {
  if (draft.said.problem->joints) {
    settle_joints(draft);
    settle_contacts(draft);
    for (std::size_t i = 0; i < draft.said.bodies.size(); ++i) check_held_by_plane(draft, i);
  }
  if (draft.said.joint) check_joint(draft);
  if (draft.said.ground) lay_on_ground(draft.said);
  if (draft.said.joint) pull_out_of_joint(draft.said);
}

}  // namespace odeval
