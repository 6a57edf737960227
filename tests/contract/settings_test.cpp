// Every setting in every family of scenarios: it changes what it should, the reference included, and nothing else; or
// it is refused; and where it changes a motion, the summary shows what took effect, and the method's own table of
// settings has it.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "catalogue/paths.hpp"
#include "catalogue/summaries.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "output/summary.hpp"
#include "output/trace_csv.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using nlohmann::json;

/// A method by the letter that stands for it below; R is the reference.
struct Letter {
  char letter;
  std::string_view method;
};
constexpr Letter letters[] = {{'S', "ode-step-double"},  {'Q', "ode-quickstep-double"}, {'A', "ode-rk4-double"},
                              {'M', "maximal-rk4"},      {'L', "lagrange-rk4"},         {'D', "lagrange-ode45"},
                              {'O', "maximal-ode-step"}, {'C', "lagrange-cvode"},       {'B', "bullet-hinge-double"},
                              {'X', "simbody-merson"},   {'J', "mujoco-euler"}};
/// Engines that a build may lack, and whom what is no engine's setting moves as well: which no row says again.
struct Like {
  char letter;
  char other;
};
constexpr Like beside_ode[] = {{'B', 'S'}, {'X', 'R'}, {'J', 'S'}};

/// A family of scenarios by one that has what its keys act on: an impact, a slide, a pull.
struct Stage {
  const char* scenario;
  std::vector<Override> settings;
};
const Stage stages[] = {
    {"double_pendulum", {{"duration", "0.2", ""}}},
    {"chain", {{"duration", "0.1", ""}, {"n", "3", ""}}},
    {"wall_pendulum", {{"duration", "0.6", ""}, {"wall.restitution", "0.8", ""}}},
    {"free_box", {{"duration", "0.2", ""}}},
    {"bouncing_ball", {{"duration", "0.6", ""}}},
    {"friction_slide", {{"duration", "0.2", ""}, {"bodies.0.velocity", "[2.0, 1.0, 0.0]", ""}}},
    {"spring_joint", {{"duration", "0.2", ""}}},
    {"open_hinge", {{"duration", "0.05", ""}}},
    {"three_link_arm", {{"duration", "0.1", ""}}},
};
constexpr std::size_t stage_count = std::size(stages);

/// What a value does in each of them: the letters of what moves otherwise; "" nothing does; "-" it is refused. After a
/// ! stand engines beside ODE that do not move as whom they are like.
struct Row {
  const char* key;
  const char* value;
  std::array<const char*, stage_count> moves;
};

// clang-format off
//                                                     double pendulum, chain, wall, free box, ball, sliding box, spring, rigid joint, arm
const Row rows[] = {
    {"duration",               "0.04",             {"RSQAMLDOC", "RSQALDOC", "RSQALDOC", "RSQAC", "RSQA", "RSQA", "RSQ", "RSQ", "RSQA"}},
    {"step",                   "0.0005",           {"RSQAMLDOC", "RSQALDOC", "RSQALDOC", "RSQAC", "RSQA", "RSQA", "RSQ", "RSQ", "RSQA"}},
    {"sample",                 "0.01",             {"RSQAMLDOC", "RSQALDOC", "RSQALDOC", "RSQAC", "RSQA", "RSQA", "RSQ", "RSQ", "RSQA"}},
    {"gravity",                "5",                {"RSQAMLDOC", "RSQALDOC", "RSQALDOC", "RSQAC", "RSQA", "RSQA", "RSQ", "RSQ", "RSQA"}},
    {"n",                      "4",                {"-",         "RSQALDOC", "-",        "-",     "-",    "-",   "-",   "-", "-"}},
    {"q0.0",                   "0.3",              {"RSQAMLDOC", "RSQALDOC", "RSQALDOC", "-",     "-",    "-",   "-",   "-", "-"}},
    {"qd0.0",                  "0.5",              {"RSQAMLDOC", "-",        "RSQALDOC", "-",     "-",    "-",   "-",   "-", "-"}},
    {"rtol",                   "1e-5",             {"DCX",       "DCX",      "DC",       "CX",    "",     "",    "",    "", "X"}},
    {"atol",                   "1e-4",             {"DC",        "DC",       "DC",       "C",     "",     "",    "",    "", ""}},
    {"limit",                  "numbers",          {"", "", "", "", "", "", "", "", ""}},
    {"links.0.mass",           "2",                {"RSQAMLDOC", "RSQALDOC", "RSQALDOC", "-",     "-",    "-",   "-",   "-", "-"}},
    {"links.0.length",         "1.1",              {"RSQAMLDOC", "RSQALDOC", "RSQALDOC", "-",     "-",    "-",   "-",   "-", "-"}},
    {"links.0.width",          "0.2",              {"RSQAMLDOC", "RSQALDOC", "RSQALDOC", "-",     "-",    "-",   "-",   "-", "-"}},
    {"links.0.depth",          "0.2",              {"SQAO!J",    "SQAO!J",   "SQAO!J",   "-",     "-",    "-",   "-",   "-", "-"}},
    {"links.0.shape",          "sphere",           {"RSQAMLDOC", "RSQALDOC", "-",        "-",     "-",    "-",   "-",   "-", "-"}},
    {"wall.face",              "0.85",             {"-",         "-",        "RSQALDOC", "-",     "-",    "-",   "-",   "-", "-"}},
    {"wall.restitution",       "0.5",              {"-",         "-",        "RSQALDOC", "-",     "-",    "-",   "-",   "-", "-"}},
    {"bodies.0.shape",         "sphere",           {"-",         "-",        "-",        "-",     "",     "-",   "",    "-", "-"}},
    {"bodies.0.mass",          "3",                {"-",         "-",        "-",        "RSQAC", "SQA",  "SQA", "RSQ", "RSQ", "RSQA"}},
    {"bodies.0.size",          "[0.3, 0.3, 0.3]",  {"-",         "-",        "-",        "RSQAC", "RSQA", "-",   "",    "", "RSQA"}},
    {"bodies.0.position",      "[0.0, 0.0, 3.0]",  {"-",         "-",        "-",        "RSQAC", "RSQA", "-",   "-",   "RSQ", "RSQA"}},
    {"bodies.0.turn",          "[0.0, 0.0, 0.5]",  {"-",         "-",        "-",        "RSQAC", "RSQA", "RSQA", "RSQ", "RSQ", "RSQA"}},
    {"bodies.0.velocity",      "[0.5, 0.0, 0.0]",  {"-",         "-",        "-",        "RSQAC", "RSQA", "RSQA", "RSQ", "-", "-"}},
    {"bodies.0.spin",          "[0.0, 0.0, 1.0]",  {"-",         "-",        "-",        "RSQAC", "RSQA", "-",   "-",   "-", ""}},
    {"bodies.0.aspect",        "2",                {"-",         "-",        "-",        "RSQAC", "-",    "SQA", "",    "", "RSQA"}},
    {"bodies.0.name", "shoulder", {"-", "-", "-", "-", "-", "-", "-", "-", ""}},
    {"bodies.0.inertia", "[0.03, 0.03, 0.03, 0.0, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "RSQA"}},
    {"bodies.0.centre", "[0.1, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"bodies.0.shapes.0.shape", "sphere", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"bodies.0.shapes.0.mass", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"bodies.0.shapes.0.size", "[0.1, 0.1, 0.1]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"bodies.0.shapes.0.position", "[0.1, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"bodies.0.shapes.0.turn", "[0.1, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"bodies.0.shapes.0.name", "foot", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.kind", "universal", {"-", "-", "-", "-", "-", "-", "-", "-", "RSQA"}},
    {"joints.0.parent", "upper", {"-", "-", "-", "-", "-", "-", "-", "-", "RSQA"}},
    {"joints.0.child", "upper", {"-", "-", "-", "-", "-", "-", "-", "-", "RSQA"}},
    {"joints.1.anchor", "[0.0, 0.0, 1.1]", {"-", "-", "-", "-", "-", "-", "-", "-", "RSQA"}},
    {"joints.2.axis", "[1.0, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "RSQA"}},
    {"joints.0.axis2", "[1.0, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.axis3", "[1.0, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.suspension", "[1.0, 1.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.name", "base", {"-", "-", "-", "-", "-", "-", "-", "-", ""}},
    {"joints.1.q", "0.1", {"-", "-", "-", "-", "-", "-", "-", "-", "RSQA"}},
    {"joints.1.qd", "0.1", {"-", "-", "-", "-", "-", "-", "-", "-", "RSQA"}},
    {"joints.1.stops", "[-0.01, 0.01]", {"-", "-", "-", "-", "-", "-", "-", "-", "RSQA"}},
    {"joints.0.stop_restitution", "0.5", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.stops2", "[-0.1, 0.1]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.stop_restitution2", "0.5", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.stops3", "[-0.1, 0.1]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.stop_restitution3", "0.5", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.motor.velocity", "2", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.motor.force", "2", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.motor2.velocity", "2", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.motor2.force", "2", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.motor3.velocity", "2", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"joints.0.motor3.force", "2", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"springs.0.joint", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"springs.0.motion", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"springs.0.stiffness", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"springs.0.damping", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"springs.0.rest", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"torques.0.joint", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"torques.0.motion", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"torques.0.constant", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"torques.0.amplitude", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"torques.0.frequency", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"torques.0.phase", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"torques.0.times", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"torques.0.values", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.joint", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.motion", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.kp", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.kd", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.sampling", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.target", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.amplitude", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.frequency", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.phase", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.times", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"controllers.0.values", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"struts.0.parent", "upper", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"struts.0.child", "upper", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"struts.0.from", "[1.0, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"struts.0.to", "[1.0, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"struts.0.stiffness", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"struts.0.damping", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"struts.0.rest", "1", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"planes.0.name", "floor", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"planes.0.normal", "[0.0, 0.0, 1.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"planes.0.point", "[0.0, 0.0, 0.0]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"contacts.0.between", "[\"upper\", \"floor\"]", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"contacts.0.restitution", "0.5", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"contacts.0.friction", "0.5", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"contacts.0.erp", "0.5", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"contacts.0.cfm", "0.5", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"contacts.0.kp", "0.5", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"contacts.0.kd", "0.5", {"-", "-", "-", "-", "-", "-", "-", "-", "-"}},
    {"ground.slope",           "0.1",              {"-",         "-",        "-",        "-",     "RSQA", "RSQA", "-",   "-", "-"}},
    {"ground.restitution",     "0.5",              {"-",         "-",        "-",        "-",     "RSQA", "SQ!B", "-",   "-", "-"}},
    {"ground.friction",        "0.2",              {"-",         "-",        "-",        "-",     "-",    "RSQA", "-",   "-", "-"}},
    {"ground.friction_model",  "constant",         {"-",         "-",        "-",        "-",     "-",    "RSQ", "-",   "-", "-"}},
    {"joint.kind",             "hinge",            {"-",         "-",        "-",        "-",     "-",    "-",   "",    "", "-"}},
    {"joint.anchor",           "[0.0, 0.0, 1.6]",  {"-",         "-",        "-",        "-",     "-",    "-",   "-",   "", "-"}},
    {"joint.axis",             "[0.0, 0.6, 0.8]",  {"-",         "-",        "-",        "-",     "-",    "-",   "",    "", "-"}},
    {"joint.displacement",     "[0.0, 0.0, 0.01]", {"-",         "-",        "-",        "-",     "-",    "-",   "RSQ", "RSQ", "-"}},
    {"ode.erp",                "0.5",              {"SQO",       "SQO",      "SQO",      "",      "",     "SQ",  "-",   "RSQ", "SQ"}},
    {"ode.cfm",                "0.001",            {"SQO",       "SQO",      "SQO",      "",      "SQ",   "SQ",  "-",   "RSQ", "SQ"}},
    {"ode.kp",                 "200",              {"-",         "-",        "-",        "-",     "-",    "-",   "RSQ", "-", "-"}},
    {"ode.kd",                 "5",                {"-",         "-",        "-",        "-",     "-",    "-",   "RSQ", "-", "-"}},
    {"ode.iterations",         "3",                {"Q",         "Q",        "Q",        "",      "Q",    "Q",   "Q",   "Q", "Q"}},
    {"ode.sor_w",              "0.5",              {"Q",         "Q",        "Q",        "",      "Q",    "Q",   "Q",   "Q", "Q"}},
    {"ode.bounce",             "0.4",              {"",          "",         "SQAO",     "",      "SQA",  "SQ",  "",    "", ""}},
    {"ode.bounce_vel",         "1000",             {"",          "",         "SQO",      "",      "SQ",   "",    "",    "", ""}},
    {"ode.max_correcting_vel", "0",                {"",          "",         "",         "",      "",     "SQ",  "",    "", ""}},
    {"ode.surface_layer",      "0.01",             {"",          "",         "",         "",      "",     "SQ",  "",    "", ""}},
    {"ode.friction_axes",      "sliding",          {"",          "",         "",         "",      "-",    "SQ",  "",    "", ""}},
    {"ode.start",              "half-step",        {"SQO",       "SQO",      "SQO",      "SQ",    "SQ",   "SQ",  "SQ",  "SQ", "SQ"}},
    {"ode.seed",               "1",                {"Q",         "Q",        "Q",        "",      "",     "Q",   "",    "", "Q"}},
    {"ode.gyroscopic",         "off",              {"SQO",       "SQO",      "SQO",      "SQ",    "",     "SQ",  "",    "", "SQ"}},
    {"ode.rotation",           "finite",           {"SQ",        "SQ",       "SQ",       "SQ",    "",     "SQ",  "",    "", "SQ"}},
    {"bullet.iterations",      "3",                {"B",         "B",        "B",        "",      "",     "B",   "",    "", "B"}},
    {"bullet.erp",             "0.5",              {"B",         "B",        "B",        "",      "B",    "B",   "",    "", "B"}},
    {"mujoco.time_constant",   "0.01",             {"",          "",         "J",        "",      "J",    "J",   "",    "", ""}},
    {"mujoco.cone",            "elliptic",         {"",          "",         "",         "",      "",     "J",   "",    "", ""}},
    {"maximal.ks",             "1",                {"M",         "",         "",         "-",     "-",    "-",   "-",   "-", "-"}},
    {"maximal.kd",             "1",                {"M",         "",         "",         "-",     "-",    "-",   "-",   "-", "-"}},
};
// clang-format on

const Names& names() {
  static const Names all = [] {
    Names names{catalogue::method_names(), {}};
    for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
    return names;
  }();
  return all;
}

/// What a method yields but for its errors, and the settings that its summary shows.
struct Run {
  std::string trace;
  json settings;
};

using Runs = std::map<char, Run>;

Runs runs_of(const Stage& stage, const std::vector<Override>& settings) {
  std::vector<Override> all = stage.settings;
  for (const Override& one : settings) {
    std::erase_if(all, [&](const Override& other) { return other.key == one.key; });
    all.push_back(one);
  }
  const Scenario scenario = read_scenario(find_scenario(stage.scenario, catalogue::scenario_folder()), all, names());
  catalogue::Evaluator evaluator(scenario);
  const auto text_of = [](Trace trace) {
    trace.error_q.clear();
    trace.error_position.clear();
    trace.error_turn.clear();
    for (JointColumns& joint : trace.joints) joint.error_q.clear();
    const std::string text = trace_csv(trace);
    return text.substr(text.find('\n'));  // a name is in the heads of columns, and moves nothing
  };
  Runs runs;
  runs['R'].trace = text_of(evaluator.reference().trace);
  for (const auto& [letter, name] : letters) {
    if (!test::in_this_build(name)) continue;
    const catalogue::Method& method = catalogue::find_method(name);
    if (!catalogue::does(method, scenario)) continue;
    const auto run = evaluator.evaluate(method);
    runs[letter] = {text_of(run.trace), json::parse(summary_json(catalogue::summarise(run, evaluator)))["settings"]};
  }
  return runs;
}

bool shows(const json& settings, std::string key, const std::string& value) {
  std::ranges::replace(key, '.', '/');
  const json::json_pointer at("/" + key);
  if (!settings.contains(at)) return false;
  const json number = json::parse(value, nullptr, false);
  if (number.is_discarded()) return settings[at] == value;
  if (!number.is_number() || !settings[at].is_number()) return settings[at] == number;
  return std::fabs(settings[at].get<double>() - number.get<double>()) < 1e-12;  // the duration is a product
}

Scenario read(const Stage& stage) {
  return read_scenario(find_scenario(stage.scenario, catalogue::scenario_folder()), stage.settings, names());
}

void check(const Row& row, const Stage& stage, const Runs& before, std::string wanted) {
  const auto say = [&](bool good, const std::string& what) {
    test::report(good, __FILE__, __LINE__,
                 std::string(stage.scenario) + ", " + row.key + " = " + row.value + ": " + what);
  };
  std::string moved = "R";
  const std::string unlike = wanted.substr(std::min(wanted.find('!'), wanted.size()));
  wanted.resize(wanted.size() - unlike.size());
  try {
    const Runs after = runs_of(stage, {{row.key, row.value, "--set"}});
    for (const auto& [letter, other] : beside_ode) {
      const bool runs = before.contains(letter) && after.contains(letter);
      if (!runs) std::erase(wanted, letter);
      const bool like = unlike.find(letter) == std::string::npos && wanted.find(other) != std::string::npos;
      if (runs && !catalogue::is_engine_setting(row.key) && like) wanted += letter;
    }
    moved = after.at('R').trace == before.at('R').trace ? "" : "R";
    for (const auto& [letter, method] : letters) {
      if (!before.contains(letter) || !after.contains(letter) || after.at(letter).trace == before.at(letter).trace)
        continue;
      moved += letter;
      say(!catalogue::is_engine_setting(row.key) ||
              catalogue::reads(catalogue::find_method(method), row.key, read(stage)),
          std::string(method) + " moves otherwise, and would refuse the setting as one that it does not read");
      say(shows(after.at(letter).settings, row.key, row.value),
          std::string(method) + " moves otherwise, and its summary does not show the value");
      say(!shows(before.at(letter).settings, row.key, row.value), std::string(method) + " has it without being told");
    }
  } catch (const UserError& error) {
    moved = "-";
    const std::string why = error.what();
    const std::string key = row.key;
    say(why.find(key.substr(0, key.find('.'))) != std::string::npos, "refused without its name: " + why);
  }
  say(moved == wanted, "moves '" + moved + "', expected '" + wanted + "'");
}

/// No key of a scenario file goes without a row.
void every_key_has_a_row() {
  for (const KeyRow& key : key_table()) {
    if (key.section == "tolerances" || key.name == "problem" || key.name == "methods") continue;
    const auto named = [&](const Row& row) {
      std::string text = row.key;
      for (const char* inner : {".0.motor", ".0.shapes"}) {
        if (const std::size_t number = text.find(inner); number != std::string::npos) text.erase(number, 2);
      }
      return text.starts_with(key.section) &&
             (text.ends_with("." + std::string(key.name)) || text == key.name || text == std::string(key.name) + ".0");
    };
    test::report(std::ranges::any_of(rows, named), __FILE__, __LINE__, "no row for " + std::string(key.name));
  }
}

/// kp and kd stand in the place of erp and cfm, and the summary shows both ways what ODE was told.
void springs_are_shown_as_told() {
  for (const char* scenario : {"double_pendulum", "spring_joint"}) {
    const Runs runs = runs_of({scenario, {{"duration", "0.01", ""}}}, {{"ode.kp", "1e4", ""}, {"ode.kd", "1", ""}});
    const json shown = runs.at('S').settings["ode"];
    CHECK_NEAR(shown["erp"].get<double>(), 10.0 / 11, 1e-15);  // h kp = 10
    CHECK_NEAR(shown["cfm"].get<double>(), 1.0 / 11, 1e-15);
    const Runs same = runs_of({scenario, {{"duration", "0.01", ""}}}, {{"ode.erp", test::shown(10.0 / 11), "--set"},
                                                                       {"ode.cfm", test::shown(1.0 / 11), "--set"}});
    CHECK(runs.at('S').trace == same.at('S').trace);
    CHECK_NEAR(same.at('S').settings["ode"]["kp"].get<double>(), 1e4, 1e-8);
    CHECK_NEAR(same.at('S').settings["ode"]["kd"].get<double>(), 1, 1e-12);
  }
}

/// The other way round: what a method is said to read moves it in some family. Of ODE's step, rebuilt for links, no
/// stage is deep enough in the wall for the two settings of overlaps, and none has springs.
void settings_act() {
  for (const Row& row : rows) {
    if (!catalogue::is_engine_setting(row.key)) continue;
    for (const auto& [letter, name] : letters) {
      if (!test::in_this_build(name)) continue;
      bool read_somewhere = false;
      bool moved = false;
      for (std::size_t i = 0; i < stage_count; ++i) {
        const Scenario scenario = read(stages[i]);
        const catalogue::Method& method = catalogue::find_method(name);
        read_somewhere =
            read_somewhere || (catalogue::does(method, scenario) && catalogue::reads(method, row.key, scenario));
        moved = moved || std::string_view(row.moves[i]).find(letter) != std::string_view::npos;
      }
      const std::string key = row.key;
      const bool no_stage = letter == 'O' && (key == "ode.max_correcting_vel" || key == "ode.surface_layer" ||
                                              key == "ode.kp" || key == "ode.kd");
      test::report(moved || !read_somewhere || no_stage, __FILE__, __LINE__,
                   std::string(name) + " reads " + key + ", which moves it nowhere");
    }
  }
}

}  // namespace

int main() {
  every_key_has_a_row();
  settings_act();
  springs_are_shown_as_told();
  for (std::size_t i = 0; i < stage_count; ++i) {
    if (!test::has_reference(read(stages[i]))) continue;
    const Runs before = runs_of(stages[i], {});
    for (const Row& row : rows) check(row, stages[i], before, row.moves[i] == nullptr ? "" : row.moves[i]);
  }
  return test::verdict();
}
