#include "model/import_robot.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <set>

#include "model/inertia.hpp"
#include "model/joint_kinds.hpp"
#include "model/mesh_box.hpp"
#include "model/one_line.hpp"
#include "model/robot_reader.hpp"
#include "model/rotation_vector.hpp"
#include "odeval/error.hpp"

namespace odeval {
namespace {

using Kind = Robot::Joint::Kind;
using Form = Robot::Solid::Form;

/// A symmetric tensor, by rows.
Rotation tensor_of(const Robot::Inertia& i) { return {i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2]}; }

/// How a joint's halves stand against each other.
Frame moved(const Robot::Joint& joint) {
  if (joint.kind == Kind::hinge) return {{}, rotation_about(joint.axis, joint.start)};
  if (joint.kind == Kind::slider) return {joint.start * joint.axis, Frame{}.rotation};
  return {};
}

/// Words of a scenario file made of those of a robot's, no two the same.
class NamesInFile {
 public:
  explicit NamesInFile(Robot& robot) : robot_(robot) {}

  std::string of(const std::string& name, const std::string& fallback) {
    std::string word = name.empty() ? fallback : name;
    for (char& letter : word) {
      const auto code = static_cast<unsigned char>(letter);
      if (std::isalnum(code) == 0 && letter != '_' && letter != '-') letter = '_';
    }
    constexpr std::size_t longest = 40;
    if (word.size() > longest) word.resize(longest);
    const std::string cut = word.substr(0, longest - 4);
    for (int number = 2; used_.contains(word) || word == world_name; ++number) word = fmt::format("{}_{}", cut, number);
    used_.insert(word);
    if (!name.empty() && word != name) {
      robot_.remark("names", "written with letters, digits, '_' and '-', at most 40",
                    fmt::format("{} as {}", one_line(name, 60), word));
    }
    return word;
  }

 private:
  Robot& robot_;
  std::set<std::string> used_;
};

/// Links that move as one.
struct Lump {
  std::size_t base = 0;  // number of its first link
  std::string name;
  std::vector<std::size_t> links = {};
  double mass_kg = 0;
  Vec3 centre_m{};                        // in the frame of the first
  Rotation inertia{};                     // about it, along the axes of the first
  std::vector<Robot::Solid> solids = {};  // in the frame of the first; a mesh is the box around it
};

class Import {
 public:
  Import(const std::filesystem::path& file, Robot robot, const ImportOptions& options)
      : file_(file),
        options_(options),
        out_{std::move(robot)},
        robot_(out_.robot),
        body_names_(robot_),
        joint_names_(robot_) {}

  Imported run() {
    set_base();
    settle_joints();
    place_links();
    lump_links();
    for (Lump& lump : lumps_) weigh(lump);
    for (Lump& lump : lumps_) collect_solids(lump);
    remark_shapes();
    write();
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw UserError(fmt::format("{}: {}", one_line(file_.string()), what));
  }
  static std::string named(const std::string& name) { return one_line(name, 60); }

  void set_base() {
    if (robot_.format != "URDF") return;
    Robot::Joint& base = robot_.joints.front();
    const std::string& link = robot_.links.front().name;
    if (options_.base_free) {
      base.kind = Kind::free;
      robot_.remark("root link", "flies, as --base free asks", link);
    } else {
      robot_.remark("root link", "fixed in the world; --base free lets it fly", link);
    }
  }

  void check_number(const Robot::Joint& joint, const char* key, double value, double least, double most) const {
    if (value >= least && value <= most) return;
    fail(fmt::format("joint '{}': {} = {}: must be from {:g} to {:g}", named(joint.name), key, value, least, most));
  }

  void settle_joints() {
    std::size_t moving = 0;
    for (Robot::Joint& joint : robot_.joints) {
      if (joint.kind != Kind::fixed && joint.kind != Kind::free) ++moving;
      if (joint.kind == Kind::fixed && !joint.name.empty()) {
        robot_.remark("fixed joints", "none in the scenario: what they hold together is one body", joint.name);
      }
      settle(joint, joint.acting);
      settle(joint, joint.acting2);
    }
    if (moving == 0) fail("has no joint that moves; one is wanted that is not fixed or floating");
  }

  static std::string word_of(const Robot::Joint& joint, const Robot::Acting& acting) {
    return &acting == &joint.acting2 ? joint.name + " axis2" : joint.name;
  }

  void settle(Robot::Joint& joint, Robot::Acting& acting) {
    check_number(joint, "damping", acting.damping, 0, 1e12);
    check_number(joint, "friction", acting.friction, 0, 1e9);
    check_number(joint, "spring_stiffness", acting.stiffness, 0, 1e12);
    if (acting.friction > 0 && options_.drop_friction) {
      robot_.remark("friction", "not taken, as --friction drop asks", word_of(joint, acting));
      acting.friction = 0;
    }
    if (acting.limits_q && !keeps_limits(joint, acting)) acting.limits_q.reset();
  }

  /// A joint starts at 0, or where it may not at the middle of its way; a universal one at 0.
  bool keeps_limits(Robot::Joint& joint, const Robot::Acting& acting) {
    const auto [low, high] = *acting.limits_q;
    check_number(joint, "limit lower", low, -1e300, 1e300);
    check_number(joint, "limit upper", high, -1e300, 1e300);
    const auto leaves = [&](const char* why) {
      robot_.remark("limits", why, word_of(joint, acting));
      return false;
    };
    if (low > high) {
      fail(fmt::format("joint '{}': limit lower = {}: must be at most upper, {}", named(joint.name), low, high));
    }
    if (low == high) return leaves("not taken: the lower is the upper one");
    const bool outside = low > 0 || high < 0;
    if (outside && joint.kind == Kind::universal) {
      return leaves("not taken: of a universal joint, which starts at 0, outside of them");
    }
    if (outside) {
      joint.start = low + (high - low) / 2;
      robot_.remark("start", "at the middle of the limits, which 0 is outside of; stops and columns count from there",
                    fmt::format("{} at {:.6g}", joint.name, joint.start));
    }
    const bool turns = joint.kind != Kind::slider;
    const double most = turns ? std::numbers::pi : 1e4;  // of a file's stops
    if (low - joint.start > -most && high - joint.start < most) return true;
    return leaves(turns ? "not taken: ODE has no stops beyond half a turn from the start"
                        : "not taken: 10 km or more from the start");
  }

  void place_links() {
    for (const Robot::Joint& joint : robot_.joints) {
      const Frame half = (joint.parent ? places_[*joint.parent] : Frame{}) * joint.frame;
      joint_places_.push_back(half);
      places_.push_back(half * moved(joint) * joint.link);
      for (const double x : places_.back().position_m) {
        if (!(std::fabs(x) <= 1e4)) {
          fail(fmt::format("joint '{}': origin: puts a link {:g} m away; at most 10 km are allowed", named(joint.name),
                           x));
        }
      }
    }
  }

  void lump_links() {
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      const Robot::Joint& joint = robot_.joints[i];
      if (joint.kind == Kind::fixed) {
        out_.body_of.push_back(joint.parent ? out_.body_of[*joint.parent] : std::nullopt);
      } else {
        out_.body_of.push_back(lumps_.size());
        lumps_.push_back({.base = i, .name = body_names_.of(robot_.links[i].name, "link")});
      }
      if (out_.body_of[i]) {
        lumps_[*out_.body_of[i]].links.push_back(i);
      } else if (robot_.links[i].mass && robot_.links[i].mass->mass_kg > 0) {
        robot_.remark("mass", "not taken: the link stands in the world", robot_.links[i].name);
      }
    }
    constexpr std::size_t most = 1024;
    if (lumps_.size() > most) fail(fmt::format("has {} links that move; at most {} are taken", lumps_.size(), most));
  }

  void check_mass(const Robot::Link& link) const {
    const Robot::Mass& mass = *link.mass;
    if (!(mass.mass_kg >= 0 && mass.mass_kg <= 1e6)) {
      fail(fmt::format("link '{}': mass = {}: must be from 0 to 1e6 kg", named(link.name), mass.mass_kg));
    }
    if (is_inertia(mass.inertia_kgm2, false)) return;
    const Robot::Inertia& i = mass.inertia_kgm2;
    fail(
        fmt::format("link '{}': inertia ixx {}, iyy {}, izz {}, ixy {}, ixz {}, iyz {}: is of no body: each principal "
                    "moment must be at most the sum of the other two",
                    named(link.name), i[0], i[1], i[2], i[3], i[4], i[5]));
  }

  /// All masses of the lump as one, about their common centre.
  void weigh(Lump& lump) const {
    const Frame from_world = inverse(places_[lump.base]);
    const auto each = [&](auto use) {
      for (const std::size_t i : lump.links) {
        if (const auto& mass = robot_.links[i].mass) use(*mass, from_world * places_[i] * mass->frame);
      }
    };
    for (const std::size_t i : lump.links) {
      if (robot_.links[i].mass) check_mass(robot_.links[i]);
    }
    each([&](const Robot::Mass& mass, const Frame& at) {
      lump.mass_kg += mass.mass_kg;
      lump.centre_m = lump.centre_m + mass.mass_kg * at.position_m;
    });
    const Robot::Link& base = robot_.links[lump.base];
    const Robot::Joint& joint = robot_.joints[lump.base];
    const std::string on = joint.name.empty() ? "freely" : fmt::format("on joint '{}'", named(joint.name));
    if (lump.mass_kg == 0) {
      fail(fmt::format("link '{}': moves {} and has no mass, nor has what is fixed to it; it needs an <inertial>",
                       named(base.name), on));
    }
    if (!(lump.mass_kg >= 1e-6 && lump.mass_kg <= 1e6)) {
      fail(fmt::format("link '{}': mass = {}: must be from 1e-6 to 1e6 kg, with what is fixed to it", named(base.name),
                       lump.mass_kg));
    }
    lump.centre_m = (1 / lump.mass_kg) * lump.centre_m;
    each([&](const Robot::Mass& mass, const Frame& at) {
      const Rotation own = at.rotation * tensor_of(mass.inertia_kgm2) * transposed(at.rotation);
      const Vec3 arm = at.position_m - lump.centre_m;
      for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 3; ++column) {
          const double steiner = (row == column ? dot(arm, arm) : 0) - arm[row] * arm[column];
          lump.inertia[3 * row + column] += own[3 * row + column] + mass.mass_kg * steiner;
        }
      }
    });
    if (is_inertia(inertia_of(lump), true)) return;
    fail(fmt::format("link '{}': inertia: moves {} and has a moment of inertia of 0, with what is fixed to it",
                     named(base.name), on));
  }

  static Robot::Inertia inertia_of(const Lump& lump) {
    const Rotation& i = lump.inertia;
    return {i[0], i[4], i[8], (i[1] + i[3]) / 2, (i[2] + i[6]) / 2, (i[5] + i[7]) / 2};
  }

  void collect_solids(Lump& lump) {
    const Frame from_world = inverse(places_[lump.base]);
    for (const std::size_t i : lump.links) {
      for (const Robot::Solid& said : robot_.links[i].solids) {
        auto solid = with_sides(robot_.links[i], said);
        if (!solid) continue;
        if (std::ranges::any_of(solid->sides_m, [](double side) { return side != in_file(side); })) {
          robot_.remark("collision shapes", "with sides from 0.1 mm to 1 km: shorter and longer ones are as these",
                        robot_.links[i].name);
        }
        solid->frame = from_world * places_[i] * solid->frame;
        lump.solids.push_back(std::move(*solid));
      }
    }
  }

  /// Of a box that has the moments of a lump without shapes.
  static Vec3 sides_of(const Lump& lump) {
    Vec3 sides{};
    const double trace = lump.inertia[0] + lump.inertia[4] + lump.inertia[8];
    for (std::size_t k = 0; k < 3; ++k) {
      sides[k] = in_file(std::sqrt(std::fmax(0, 6 * (trace - 2 * lump.inertia[4 * k]) / lump.mass_kg)));
    }
    return sides;
  }
  static double in_file(double side_m) { return std::clamp(side_m, 1e-4, 1e3); }  // what a file may have

  /// With the sides of a mesh; nothing where those are not known.
  std::optional<Robot::Solid> with_sides(const Robot::Link& link, const Robot::Solid& said) {
    if (said.form == Form::plane || said.form == Form::other) return std::nullopt;
    if (said.form != Form::mesh) return said;
    if (options_.refuse_meshes) {
      fail(
          fmt::format("link '{}': mesh = {}: is refused, as --meshes refuse asks", named(link.name), named(said.file)));
    }
    const std::optional<MeshBox> box = mesh_box(file_, said.file, fmt::format("link '{}'", named(link.name)));
    if (!box) return std::nullopt;
    Robot::Solid solid = said;
    Vec3 centre = box->centre_m;
    for (std::size_t k = 0; k < 3; ++k) {
      centre[k] *= said.scale[k];
      solid.sides_m[k] = std::fabs(said.scale[k]) * box->sides_m[k];
    }
    solid.frame = said.frame * Frame{centre, Frame{}.rotation};
    return solid;
  }

  void remark_shapes() {
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      const Robot::Link& link = robot_.links[i];
      if (!out_.body_of[i] && !link.solids.empty()) {
        robot_.remark("collision shapes", "not taken: the link stands in the world", link.name);
        continue;
      }
      for (const Robot::Solid& solid : link.solids) {
        const bool mesh = solid.form == Form::mesh;
        if (mesh && !has_mesh_box(solid.file)) {
          robot_.remark("meshes", "not taken: of a format that is not read; STL and OBJ are", solid.file);
        } else if (mesh) {
          robot_.remark("meshes", "as the box around them; --meshes refuse refuses them", solid.file);
        } else if (solid.form == Form::plane || solid.form == Form::other) {
          robot_.remark("shapes", "not taken: no box stands around them", link.name);
        }
      }
      const auto boxed = [](const Robot::Solid& solid) {
        return solid.form != Form::plane && solid.form != Form::other;
      };
      if (std::ranges::none_of(link.solids, boxed)) continue;
      robot_.remark("collision shapes",
                    "as [[bodies.shapes]], which are drawn and touch nothing until [[contacts]] are added", link.name);
    }
  }

  void write();
  void write_bodies(std::string& text);
  static void write_shape(std::string& text, const Lump& lump, const Robot::Solid& solid, const std::string& name);
  void write_joint(std::string& text, std::size_t link, const std::string& name) const;
  void write_spring(std::string& text, const Robot::Joint& joint, const Robot::Acting& acting, const std::string& name,
                    int motion);

  const std::filesystem::path& file_;
  const ImportOptions& options_;
  Imported out_;
  Robot& robot_;
  NamesInFile body_names_;
  NamesInFile joint_names_;
  std::vector<Frame> places_;        // of links in the world at t = 0
  std::vector<Frame> joint_places_;  // of the joints' halves that their parents carry
  std::vector<Lump> lumps_;
};

std::string shown(const Vec3& v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); }

void Import::write_bodies(std::string& text) {
  for (const Lump& lump : lumps_) {
    const Frame& place = places_[lump.base];
    text += fmt::format("\n[[bodies]]\nname     = \"{}\"\nmass     = {}\nposition = {}\nturn     = {}\n", lump.name,
                        lump.mass_kg, shown(place.position_m + turned(place.rotation, lump.centre_m)),
                        shown(rotation_vector_of(place.rotation)));
    text += lump.solids.empty() ? fmt::format("size     = {}\n", shown(sides_of(lump))) : "shape    = \"none\"\n";
    text += fmt::format("inertia  = [{}]\n", fmt::join(inertia_of(lump), ", "));
    NamesInFile names(robot_);
    for (const Robot::Solid& solid : lump.solids) {
      write_shape(text, lump, solid, solid.name.empty() ? "" : names.of(solid.name, ""));
    }
  }
}

void Import::write_shape(std::string& text, const Lump& lump, const Robot::Solid& solid, const std::string& name) {
  Vec3 sides = solid.sides_m;
  for (double& side : sides) side = in_file(side);
  const char* word = "box";
  if (solid.form == Form::cylinder) word = "cylinder";
  if (solid.form == Form::capsule) word = sides[2] > sides[0] ? "capsule" : "sphere";
  if (solid.form == Form::sphere) word = "sphere";
  text += fmt::format("\n[[bodies.shapes]]\nshape    = \"{}\"\nsize     = {}\nposition = {}\n", word, shown(sides),
                      shown(solid.frame.position_m - lump.centre_m));
  if (word != std::string_view("sphere")) {
    text += fmt::format("turn     = {}\n", shown(rotation_vector_of(solid.frame.rotation)));
  }
  if (!name.empty()) text += fmt::format("name     = \"{}\"\n", name);
}

void Import::write_joint(std::string& text, std::size_t link, const std::string& name) const {
  const Robot::Joint& joint = robot_.joints[link];
  const Frame& place = joint_places_[link];
  static constexpr std::array words{"fixed", "hinge", "slider", "ball", "universal", "free"};
  std::string parent(world_name);
  if (joint.parent && out_.body_of[*joint.parent]) parent = lumps_[*out_.body_of[*joint.parent]].name;
  text += fmt::format(
      "\n[[joints]]\nname     = \"{}\"\nkind     = \"{}\"\nparent   = \"{}\"\nchild    = \"{}\"\nanchor   = {}\n", name,
      words[static_cast<std::size_t>(joint.kind)], parent, lumps_[*out_.body_of[link]].name, shown(place.position_m));
  if (joint.kind != Kind::ball) text += fmt::format("axis     = {}\n", shown(turned(place.rotation, joint.axis)));
  if (joint.kind == Kind::universal) text += fmt::format("axis2    = {}\n", shown(turned(place.rotation, joint.axis2)));
  const auto add = [&](const Robot::Acting& acting, const char* number) {
    if (acting.limits_q) {
      const auto [low, high] = *acting.limits_q;
      text += fmt::format("{:<9}= [{}, {}]\n", fmt::format("stops{}", number), low - joint.start, high - joint.start);
    }
    if (acting.friction == 0) return;
    text += fmt::format("{:<9}= {{ velocity = 0.0, force = {} }}\n", fmt::format("motor{}", number), acting.friction);
  };
  add(joint.acting, "");
  if (joint.kind == Kind::universal) add(joint.acting2, "2");
}

/// Damping and springs of a joint, or of one of its motions by its number.
void Import::write_spring(std::string& text, const Robot::Joint& joint, const Robot::Acting& acting,
                          const std::string& name, int motion) {
  if (acting.friction > 0) {
    robot_.remark("friction", "as a motor that keeps a speed of 0 by at most that much; --friction drop leaves it out",
                  word_of(joint, acting));
  }
  if (acting.damping == 0 && acting.stiffness == 0) return;
  robot_.remark("damping and springs", "as [[springs]]", word_of(joint, acting));
  text += fmt::format("\n[[springs]]\njoint     = \"{}\"\n", name);
  if (motion != 0) text += fmt::format("motion    = {}\n", motion);
  text += fmt::format("stiffness = {}\ndamping   = {}\nrest      = {}\n", acting.stiffness, acting.damping,
                      acting.rest - joint.start);
}

void Import::write() {
  std::string bodies;
  write_bodies(bodies);
  std::string joints;
  std::string springs;
  for (const Lump& lump : lumps_) {
    const Robot::Joint& joint = robot_.joints[lump.base];
    if (joint.kind == Kind::free) continue;
    const std::string name = joint_names_.of(joint.name, "joint");
    write_joint(joints, lump.base, name);
    const bool two = joint.kind == Kind::universal;
    write_spring(springs, joint, joint.acting, name, two ? 1 : 0);
    if (two) write_spring(springs, joint, joint.acting2, name, 2);
  }
  std::string& text = out_.toml;
  text = fmt::format("# {} by odeval convert, from {}\n", one_line(robot_.name, 60), robot_.format);
  for (const Robot::Remark& remark : robot_.remarks) {
    text += fmt::format("# {}: {}{}{}\n", one_line(remark.what), one_line(remark.rule), remark.of.empty() ? "" : ": ",
                        one_line(fmt::format("{}", fmt::join(remark.of, ", ")), 2000));
  }
  text += "problem  = \"mechanism\"\nduration = 1.0\n";
  const auto methods = std::ranges::find(robot_.settings, "methods", &std::pair<std::string, std::string>::first);
  if (methods == robot_.settings.end()) text += "methods  = [\"ode-step-double\", \"ode-quickstep-double\"]\n";
  text += fmt::format("gravity  = {}\n", robot_.gravity);
  for (const auto& [key, value] : robot_.settings) text += fmt::format("{} = {}\n", key, value);
  text += bodies + joints + springs;
}

}  // namespace

Imported import_robot(const std::filesystem::path& file, Robot robot, const ImportOptions& options) {
  return Import(file, std::move(robot), options).run();
}

Imported import_robot(const std::filesystem::path& file, const ImportOptions& options) {
  return import_robot(file, read_robot(file), options);
}

}  // namespace odeval
