#include "scenario/read_scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <sstream>

#include "odeval/error.hpp"
#include "scenario/nearest.hpp"
#include "scenario/one_line.hpp"
#include "scenario/toml_tree.hpp"

namespace odeval {

namespace {

std::string joined(std::string_view section, std::string_view name) {
  return section.empty() ? std::string(name) : fmt::format("{}.{}", section, name);
}

// As TOML, but numbers as short as the user wrote them, and 20.0 not as the whole number 20.
std::string text_of(const toml::node& node) {
  if (node.is_floating_point()) {
    const std::string text = fmt::format("{}", node.as_floating_point()->get());
    return text + (text.find_first_not_of("-0123456789") == std::string::npos ? ".0" : "");
  }
  if (const toml::array* list = node.as_array()) {
    std::string text;
    for (const toml::node& element : *list) text += (text.empty() ? "" : ", ") + text_of(element);
    return "[" + text + "]";
  }
  std::ostringstream out;
  node.visit([&out](const auto& value) { out << value; });
  return out.str();
}

std::string shown(const toml::node& node) { return one_line(text_of(node), 60); }

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
void lay_on_ground(Scenario& scenario) {
  const Ground& ground = *scenario.ground;
  const Vec3 downhill = ground.downhill();
  const Vec3 normal = ground.normal();
  const auto into_world = [&](const Vec3& v) {
    return Vec3{v[0] * downhill[0] + v[2] * normal[0], v[1], v[0] * downhill[2] + v[2] * normal[2]};
  };
  for (Body& body : scenario.bodies) {
    body.position_m = into_world(body.position_m);
    body.velocity_m_s = into_world(body.velocity_m_s);
    body.spin_rad_s = into_world(body.spin_rad_s);
    body.turn_rad = turn_after(body.turn_rad, {0, ground.slope_rad, 0});
  }
}

bool is_or_holds(std::string_view key, std::string_view path) {
  return path == key || (path.starts_with(key) && path[key.size()] == '.');
}

class Reader {
 public:
  Reader(const std::filesystem::path& file, const std::vector<Override>& overrides, const Names& names)
      : file_(file), overrides_(overrides), names_(names) {}

  /// `tree` is the file's; the overrides are put on top.
  Scenario read(toml::table tree) {
    apply(tree, overrides_);
    scenario_.name = file_.stem().string();
    scenario_.file = file_.string();
    check_name();
    read_table(tree, "", "");
    for (const SectionRow& section : section_table()) {
      if (const toml::node* node = tree.get(section.name)) read_section(section, *node);
    }
    choose_softness(tree);
    if (scenario_.family() == Family::pendulum) {
      settle_chain(tree);
      check_shapes();
      settle_depths(tree);
    } else {
      make_thin();
    }
    check_against_problem(tree);
    check_tolerances();
    check_grid();
    if (scenario_.ground) lay_on_ground(scenario_);
    put_joint();
    return scenario_;
  }

 private:
  void put_joint() {
    if (!scenario_.joint) return;
    Vec3& axis = scenario_.joint->axis;
    const double length = std::sqrt(dot(axis, axis));
    for (std::size_t k = 0; k < 3; ++k) {
      axis[k] /= length;
      scenario_.bodies.front().position_m[k] += scenario_.joint->displacement_m[k];
    }
  }

  enum class Blame { whole, parts };

  /// The last setting that gave the value at the path, or with Blame::parts something inside it; null: the file did.
  const Override* setting_of(std::string_view path, Blame blame = Blame::whole) const {
    for (auto setting = overrides_.rbegin(); setting != overrides_.rend(); ++setting) {
      if (is_or_holds(setting->key, path)) return &*setting;
      if (blame == Blame::parts && is_or_holds(path, setting->key)) return &*setting;
    }
    return nullptr;
  }

  /// `where` is the path of the value at fault, `value` its text or empty when there is none.
  [[noreturn]] void fail(const std::string& where, const std::string& value, const std::string& rule,
                         Blame blame = Blame::whole) const {
    const std::string path = one_line(where);
    if (const Override* setting = setting_of(where, blame)) {
      throw UserError(fmt::format("{}: {} {}", typed(*setting), path, rule));
    }
    const std::string file = one_line(file_.string());
    throw UserError(value.empty() ? fmt::format("{}: {} {}", file, path, rule)
                                  : fmt::format("{}: {} = {}: {}", file, path, value, rule));
  }

  // The name becomes a folder below the output folder and a cell of tables.
  void check_name() const {
    const bool plain = std::all_of(scenario_.name.begin(), scenario_.name.end(), [](unsigned char letter) {
      return std::isalnum(letter) != 0 || letter == '_' || letter == '-' || letter == '.';
    });
    if (!plain || scenario_.name.empty() || scenario_.name.front() == '.') {
      throw UserError(
          fmt::format("{}: a scenario file is named with letters, digits, '_' and '-'", one_line(file_.string())));
    }
  }

  /// Reads one table: `section` names its rows, `path` says where it stands ("links.0").
  void read_table(const toml::table& table, std::string_view section, const std::string& path) {
    for (const auto& [key, node] : table) {
      const KeyRow* row = row_named(section, key.str());
      if (row != nullptr) {
        row->put(scenario_, value_of(*row, node, joined(path, key.str())));
      } else if (!(section.empty() && is_section(key.str()))) {
        fail_unknown(section, path, key.str(), node);
      }
    }
    for (const KeyRow& row : key_table()) {
      if (row.section == section && row.required() && !table.contains(row.name)) {
        fail(joined(path, row.name), "", fmt::format("is missing; it {}", rule_of(row, names_)));
      }
    }
  }

  void read_section(const SectionRow& section, const toml::node& node) {
    const std::string name(section.name);
    if (!section.list) {
      const toml::table* table = node.as_table();
      if (table == nullptr) fail(name, shown(node), fmt::format("must be a table [{}]", name));
      if (name == "wall") scenario_.wall.emplace();
      if (name == "ground") scenario_.ground.emplace();
      if (name == "joint") scenario_.joint.emplace();
      read_table(*table, name, name);
      return;
    }
    const toml::array* list = node.as_array();
    if (list == nullptr) fail(name, shown(node), fmt::format("must be tables [[{}]]", name));
    for (std::size_t i = 0; i < list->size(); ++i) {
      const std::string path = fmt::format("{}.{}", name, i);
      const toml::table* table = (*list)[i].as_table();
      if (table == nullptr) fail(path, shown((*list)[i]), fmt::format("must be a table [[{}]]", name));
      if (name == "links") {
        scenario_.links.emplace_back();
      } else if (name == "bodies") {
        scenario_.bodies.emplace_back();
      } else {
        scenario_.tolerances.emplace_back();
      }
      read_table(*table, name, path);
    }
  }

  /// What `aspect` says goes into the sides, which are held to the least size again.
  void make_thin() {
    constexpr double least_m = 1e-4;
    for (std::size_t i = 0; i < scenario_.bodies.size(); ++i) {
      Body& body = scenario_.bodies[i];
      for (const std::size_t side : {0, 1}) {
        body.size_m[side] /= body.aspect;
        if (body.size_m[side] >= least_m) continue;
        fail(fmt::format("bodies.{}.aspect", i), fmt::format("{}", body.aspect),
             fmt::format("makes a side {:.6g} m thin; it must leave at least {} m", body.size_m[side], least_m));
      }
    }
  }

  static const KeyRow* row_named(std::string_view section, std::string_view name) {
    for (const KeyRow& row : key_table()) {
      if (row.section == section && row.name == name) return &row;
    }
    return nullptr;
  }

  static bool is_section(std::string_view name) {
    return std::any_of(section_table().begin(), section_table().end(),
                       [name](const SectionRow& section) { return section.name == name; });
  }

  // The nearest key by its full name or by its own: `erp` means `ode.erp`. Inside a list the same element is meant.
  [[noreturn]] void fail_unknown(std::string_view section, const std::string& path, std::string_view key,
                                 const toml::node& node) const {
    std::string best;
    std::size_t least = 0;
    for (const KeyRow& row : key_table()) {
      const bool here = row.section == section;
      const std::size_t distance = std::min(edit_distance(key, row.name) + (here ? 0 : 1),
                                            edit_distance(joined(section, key), joined(row.section, row.name)));
      if (best.empty() || distance < least) {
        least = distance;
        best = here ? joined(path, row.name) : joined(row.section, row.name);
      }
    }
    const bool alike = least <= 1 + key.size() / 2;
    fail(joined(path, key), shown(node),
         alike ? fmt::format("is no known key (nearest: '{}')", best) : "is no known key", Blame::parts);
  }

  double number_of(const KeyRow& row, const toml::node& node, const std::string& path) const {
    if (row.kind == KeyKind::whole ? node.is_integer() : node.is_number()) {
      // A whole number beyond 2^53 is rounded; the library would have it no number at all.
      const double number =
          node.is_integer() ? static_cast<double>(node.as_integer()->get()) : node.as_floating_point()->get();
      const bool inside = row.ends_excluded ? number > row.least && number < row.greatest
                                            : number >= row.least && number <= row.greatest;
      if (inside) return number;
    }
    KeyRow one = row;
    if (one.kind == KeyKind::numbers) one.kind = KeyKind::number;
    fail(path, shown(node), rule_of(one, names_));
  }

  std::string word_of(const KeyRow& row, const toml::node& node, const std::string& path) const {
    const std::vector<std::string> allowed = row.allowed(names_);
    const auto word = node.value<std::string>();
    if (word && std::find(allowed.begin(), allowed.end(), *word) != allowed.end()) return *word;
    KeyRow one = row;
    one.kind = KeyKind::word;
    constexpr std::size_t readable = 4;
    if (!word || allowed.size() <= readable) fail(path, shown(node), rule_of(one, names_));
    fail(path, shown(node), fmt::format("is not known (nearest: '{}')", nearest(*word, allowed)));
  }

  KeyValue value_of(const KeyRow& row, const toml::node& node, const std::string& path) const {
    KeyValue value;
    if (row.kind == KeyKind::number || row.kind == KeyKind::whole) {
      value.number = number_of(row, node, path);
    } else if (row.kind == KeyKind::word) {
      value.word = word_of(row, node, path);
    } else {
      const toml::array* list = node.as_array();
      if (list == nullptr || (row.count != 0 && list->size() != row.count)) {
        fail(path, shown(node), rule_of(row, names_));
      }
      for (std::size_t i = 0; i < list->size(); ++i) {
        const std::string element = fmt::format("{}.{}", path, i);
        if (row.kind == KeyKind::numbers) {
          value.numbers.push_back(number_of(row, (*list)[i], element));
        } else {
          value.words.push_back(word_of(row, (*list)[i], element));
        }
      }
    }
    return value;
  }

  // One table stands for all links of a chain, and angles that are not named are 0.
  void settle_chain(const toml::table& tree) {
    const Problem& problem = *scenario_.problem;
    std::vector<Link>& links = scenario_.links;
    if (problem.links != 0) {
      if (scenario_.n) fail("n", shown(*tree.get("n")), fmt::format("has no meaning for {}; remove it", problem.name));
      return;
    }
    const auto most = static_cast<std::size_t>(row_named("", "n")->greatest);
    const auto n = static_cast<std::size_t>(scenario_.n.value_or(static_cast<int>(std::min(links.size(), most))));
    if (links.empty() || links.size() > most) {
      fail("links", fmt::format("{} tables", links.size()), fmt::format("must be 1 to {} tables [[links]]", most));
    }
    if (links.size() == 1) links.resize(n, links.front());
    if (links.size() != n) {
      fail("links", fmt::format("{} tables", links.size()),
           fmt::format("must be one table [[links]] or n = {} of them", n));
    }
    for (const auto& [name, column] : {std::pair{"q0", &scenario_.q0}, std::pair{"qd0", &scenario_.qd0}}) {
      if (column->size() > n) {
        fail(name, shown(*tree.get(name)), fmt::format("must be a list of at most n = {} numbers", n));
      }
      column->resize(n, 0.0);
    }
    scenario_.n = static_cast<int>(n);
  }

  void settle_depths(const toml::table& tree) {
    const toml::array& tables = tree.contains("links") ? *tree.get("links")->as_array() : toml::array{};
    for (std::size_t i = 0; i < scenario_.links.size(); ++i) {
      Link& link = scenario_.links[i];
      const std::string path = fmt::format("links.{}.depth", std::min(i, tables.size() - 1));
      const bool given = link.depth_m != 0;  // a value is never 0
      if (link.shape == Shape::box && !given) {
        fail(path, "", fmt::format("is missing; it {}", rule_of(*row_named("links", "depth"), names_)));
      }
      if (link.shape == Shape::box) continue;
      if (given && link.depth_m != link.width_m) {
        fail(path, fmt::format("{}", link.depth_m), "must be left out or be the width: the link is a ball");
      }
      link.depth_m = link.width_m;
    }
  }

  /// ERP and CFM, or kp and kd: both or none. The command line may replace the file's pair by the other.
  void choose_softness(const toml::table& tree) {
    const auto given = [&](const char* key) { return static_cast<bool>(tree.at_path(key)); };
    const auto typed_key = [&](const char* one, const char* other) {
      const auto typed_one = [&](const char* key) { return given(key) && setting_of(key) != nullptr; };
      return typed_one(one) ? one : typed_one(other) ? other : nullptr;
    };
    if (!given("ode.kp") && !given("ode.kd")) return;
    for (const auto& [key, other] : {std::pair{"ode.kp", "ode.kd"}, std::pair{"ode.kd", "ode.kp"}}) {
      if (!given(key)) fail(other, shown(*tree.at_path(other).node()), fmt::format("needs {} beside it", key));
    }
    const char* const soft = typed_key("ode.erp", "ode.cfm");
    const bool spring = typed_key("ode.kp", "ode.kd") != nullptr;
    if (soft != nullptr && !spring) {
      for (const char* other : {"ode.erp", "ode.cfm"}) {
        if (!given(other)) {
          fail(soft, "", fmt::format("needs {} beside it, to replace the file's ode.kp and ode.kd", other));
        }
      }
      scenario_.ode.spring.reset();
      return;
    }
    const char* const both = given("ode.erp") ? "ode.erp" : given("ode.cfm") ? "ode.cfm" : nullptr;
    if (both != nullptr && (soft != nullptr || !spring)) {
      fail(soft != nullptr ? soft : both, shown(*tree.at_path(both).node()),
           "says the same as ode.kp and ode.kd; give one pair or the other");
    }
    constexpr double softest = 1e3;  // the greatest ode.cfm
    const double cfm = scenario_.ode.softness(scenario_.step_s).cfm;
    if (!(cfm <= softest)) {
      fail("ode.kd", fmt::format("{}", scenario_.ode.spring->kd_Ns_m),
           fmt::format("must make step * kp + kd at least {:g} N s/m; it is {:g}", 1 / softest, 1 / cfm), Blame::parts);
    }
  }

  void check_against_problem(const toml::table& tree) const {
    const Problem& problem = *scenario_.problem;
    if (problem.family == Family::pendulum) {
      check_pendulum(tree);
    } else {
      check_bodies(tree);
    }
    for (const auto& [section, needed] :
         {std::pair{"wall", problem.wall}, std::pair{"ground", problem.ground}, std::pair{"joint", problem.joint}}) {
      if (needed && !tree.contains(section)) {
        fail(section, "", fmt::format("is missing; {} needs [{}]", problem.name, section));
      }
      if (!needed) refuse(tree, section);
    }
    if (problem.ground && !problem.friction) {
      for (const char* key : {"friction", "friction_model"}) refuse(tree, "ground", key);
      refuse(tree, "ode", "friction_axes");
    }
    if (problem.wall) check_clear_of_wall();
    if (problem.joint) check_joint();
  }

  /// A key that another kind of problem has.
  void refuse(const toml::table& tree, const char* key) const {
    if (!tree.contains(key)) return;
    fail(key, "", fmt::format("has no meaning for {}; remove it", scenario_.problem->name), Blame::parts);
  }

  void refuse(const toml::table& tree, const char* section, const char* key) const {
    const toml::table* const table = tree[section].as_table();
    if (table == nullptr || !table->contains(key)) return;
    fail(joined(section, key), "", fmt::format("has no meaning for {}; remove it", scenario_.problem->name));
  }

  void check_pendulum(const toml::table& tree) const {
    const Problem& problem = *scenario_.problem;
    const std::size_t count = problem.links == 0 ? scenario_.links.size() : static_cast<std::size_t>(problem.links);
    refuse(tree, "bodies");
    if (scenario_.links.size() != count) {
      fail("links", fmt::format("{} tables", scenario_.links.size()),
           fmt::format("must be {} table{} [[links]] for {}", count, count == 1 ? "" : "s", problem.name));
    }
    for (const auto& [name, column] : {std::pair{"q0", &scenario_.q0}, std::pair{"qd0", &scenario_.qd0}}) {
      const std::string rule =
          fmt::format("must be a list of {} number{} for {}", count, count == 1 ? "" : "s", problem.name);
      if (!tree.contains(name)) fail(name, "", "is missing; it " + rule);
      if (column->size() != count) fail(name, shown(*tree.get(name)), rule);
    }
  }

  void check_bodies(const toml::table& tree) const {
    for (const char* key : {"links", "q0", "qd0", "maximal"}) refuse(tree, key);
    if (scenario_.bodies.empty()) {
      fail("bodies", "0 tables",
           fmt::format("must be tables [[bodies]], at least one, for {}", scenario_.problem->name));
    }
    for (std::size_t i = 0; i < scenario_.bodies.size(); ++i) {
      const auto& [x, y, z] = scenario_.bodies[i].size_m;
      if (scenario_.bodies[i].shape == Shape::sphere && (x != y || x != z)) {
        fail(fmt::format("bodies.{}.size", i), fmt::format("[{}, {}, {}]", x, y, z),
             "must be the diameter, three times, for a sphere");
      }
    }
  }

  // Against a wall: the outlines that the references know.
  void check_shapes() const {
    const Problem& problem = *scenario_.problem;
    if (!problem.wall) return;
    const Shape shape = problem.links == 1 ? Shape::box : Shape::sphere;
    for (std::size_t i = 0; i < scenario_.links.size(); ++i) {
      if (scenario_.links[i].shape == shape) continue;
      fail(fmt::format("links.{}.shape", i), "",
           fmt::format("must be {} for {}", shape == Shape::box ? "box" : "sphere", scenario_.problem->name));
    }
  }

  // The corner of the box, or the side of the balls, that is nearest the wall, which fills x <= face.
  double least_x() const {
    double x = scenario_.problem->frame.hinge_m[0];
    double least = std::numeric_limits<double>::infinity();
    double angle = 0;
    for (std::size_t i = 0; i < scenario_.links.size(); ++i) {
      const Link& link = scenario_.links[i];
      angle += scenario_.q0[i];
      const double end = x + link.length_m * std::cos(angle);
      const bool box = link.shape == Shape::box;
      least = std::fmin(
          least, box ? std::fmin(x, end) - link.width_m / 2 * std::fabs(std::sin(angle)) : end - link.width_m / 2);
      x = end;
    }
    return least;
  }

  void check_joint() const {
    if (scenario_.bodies.size() > 2) {
      fail("bodies", fmt::format("{} tables", scenario_.bodies.size()),
           fmt::format("must be one table [[bodies]] or two for {}", scenario_.problem->name));
    }
    if (dot(scenario_.joint->axis, scenario_.joint->axis) == 0) {
      fail("joint.axis", "[0, 0, 0]", "must have a direction");
    }
  }

  void check_clear_of_wall() const {
    const double least_x = this->least_x();
    if (scenario_.wall->face_m > least_x) {
      const Override* setting = setting_of("wall.face");
      for (const char* path : {"q0", "links.0.length", "links.0.width"}) {
        if (setting == nullptr && setting_of(path) != nullptr) {
          fail(path, "",
               fmt::format("puts the link into the wall; wall.face is {:.6g} m and may be at most {:.6g} m",
                           scenario_.wall->face_m, least_x));
        }
      }
      fail("wall.face", fmt::format("{}", scenario_.wall->face_m),
           fmt::format("must be at most {:.6g} m, or the link starts inside the wall", least_x));
    }
  }

  void check_tolerances() const {
    for (std::size_t i = 0; i < scenario_.tolerances.size(); ++i) {
      const Tolerance& tolerance = scenario_.tolerances[i];
      if (!tolerance.at_most && !tolerance.at_least) {
        fail(fmt::format("tolerances.{}", i), "", "must have at_most or at_least");
      }
    }
  }

  // What no single key can be blamed for is blamed on a setting if there is one.
  void check_grid() const {
    if (scenario_.duration_s < scenario_.step_s) {
      const bool step_typed = setting_of("step") != nullptr && setting_of("duration") == nullptr;
      const std::string rule = fmt::format("step is {} s and duration {} s", scenario_.step_s, scenario_.duration_s);
      if (step_typed) fail("step", "", "must be at most the duration: " + rule);
      fail("duration", fmt::format("{}", scenario_.duration_s), "must be at least one step: " + rule);
    }
    if (scenario_.sample_s.value_or(0) > scenario_.duration_s) {
      fail(
          setting_of("sample") == nullptr && setting_of("duration") != nullptr ? "duration" : "sample",
          fmt::format("{}", *scenario_.sample_s),
          fmt::format("must not leave sample = {} s above duration = {} s", *scenario_.sample_s, scenario_.duration_s));
    }
    try {
      sample_grid(scenario_);
    } catch (const UserError& error) {
      for (const char* path : {"sample", "step", "duration"}) {
        if (const Override* setting = setting_of(path)) {
          throw UserError(fmt::format("{}: {}", typed(*setting), error.what()));
        }
      }
      throw UserError(fmt::format("{}: {}", one_line(file_.string()), error.what()));
    }
  }

  const std::filesystem::path& file_;
  const std::vector<Override>& overrides_;
  const Names& names_;
  Scenario scenario_;
};

}  // namespace

Scenario read_scenario(const std::filesystem::path& file, const std::vector<Override>& overrides, const Names& names) {
  return ScenarioFile(file).read(overrides, names);
}

struct ScenarioFile::Tree {
  toml::table table;
};

ScenarioFile::ScenarioFile(std::filesystem::path file) : ScenarioFile(file, scenario_text(file)) {}

ScenarioFile::ScenarioFile(std::filesystem::path file, std::string_view text)
    : file_(std::move(file)), tree_(new Tree{toml_tree(file_, text)}) {}

ScenarioFile::~ScenarioFile() = default;

Scenario ScenarioFile::read(const std::vector<Override>& overrides, const Names& names) const {
  return Reader(file_, overrides, names).read(tree_->table);
}

std::string ScenarioFile::text(const std::vector<Override>& overrides) const {
  toml::table table = tree_->table;
  apply(table, overrides);
  std::ostringstream out;
  out << table;
  return out.str();
}

}  // namespace odeval
