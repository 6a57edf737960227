// Scenario files: the three that come with odeval, every kind of mistake and its message, settings on top.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "model/find_scenario.hpp"
#include "model/nearest.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "odeval/metrics.hpp"
#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using namespace odeval;
namespace fs = std::filesystem;

const fs::path shipped = fs::path(ODEVAL_SOURCE_DIR) / "scenarios";

const Names names{
    {"ode-step-double", "ode-step-single", "ode-quickstep-double", "ode-quickstep-single", "ode-rk4-double",
     "lagrange-cvode", "lagrange-quad", "lagrange-ode45", "lagrange-rk4", "lagrange-euler", "lagrange-symplectic-euler",
     "dh-ode45", "maximal-euler", "maximal-rk4", "maximal-ode-step", "mechanism-cvode", "analytic"},
    [] {
      std::vector<std::string> all;
      for (const Quantity& row : quantities) all.emplace_back(row.name);
      return all;
    }()};

const std::string single = R"(
problem = "single_pendulum"
duration = 10
q0 = [0.0]
qd0 = [0.0]
[[links]]
mass = 1
length = 1.0
width = 0.1
depth = 0.1
)";

const std::string wall = R"(
problem = "wall_pendulum"
duration = 5
q0 = [0.0]
qd0 = [0.0]
[[links]]
mass = 1
length = 1.0
width = 0.1
depth = 0.1
[wall]
face = 0.9
)";

/// A folder for this test's files; the current folder while it lives, so that messages hold short names.
class Folder {
 public:
  Folder() { fs::current_path(folder_.path()); }
  ~Folder() { fs::current_path("/"); }

 private:
  test::TemporaryFolder folder_;
};

void write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

Scenario read(const std::string& text, const std::vector<Override>& overrides = {}) {
  write("x.toml", text);
  return read_scenario("x.toml", overrides, names);
}

Scenario with(const std::string& text, const std::string& key, const std::string& value) {
  return read(text, {{key, value, "--set"}});
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

void shipped_files_hold_the_reports_values() {
  for (const std::string& name : scenario_names(shipped)) {
    const Scenario scenario = read_scenario(shipped / (name + ".toml"), {}, names);
    CHECK_EQUAL(scenario.name, name);
    CHECK(!scenario.methods.empty());
  }
  const Scenario twin = read_scenario(shipped / "double_pendulum.toml", {}, names);
  CHECK_EQUAL(twin.planar->links.size(), 2u);
  CHECK_EQUAL(twin.planar->frame.hinge_m[2], 2.1);
  for (const Link& link : twin.planar->links) {
    CHECK_EQUAL(link.mass_kg, 1.0);
    CHECK_EQUAL(link.length_m, 1.0);
    CHECK_EQUAL(link.width_m, 0.1);
    CHECK_EQUAL(link.depth_m, 0.1);
  }
  CHECK_EQUAL(twin.planar->q0.at(0), std::atan(1.0));
  CHECK_EQUAL(twin.planar->q0.at(1), -std::atan(1.0));
  CHECK_EQUAL(twin.gravity, 9.81);
  CHECK_EQUAL(twin.ode.erp, 0.2);
  CHECK_EQUAL(twin.ode.cfm, 1e-5);
  CHECK_EQUAL(twin.ode.max_correcting_vel, 0.1);
  CHECK_EQUAL(twin.ode.surface_layer, 1e-4);
  CHECK_EQUAL(sample_grid(twin).rows, 10001);

  const Scenario against_wall = read_scenario(shipped / "wall_pendulum.toml", {}, names);
  CHECK_EQUAL(against_wall.gravity, 9.8);
  CHECK_EQUAL(against_wall.planar->wall.value().face_m, 0.9);
  CHECK_EQUAL(against_wall.planar->wall.value().restitution, 1.0);
  CHECK_EQUAL(against_wall.ode.cfm, 1e-10);
  CHECK(std::isinf(against_wall.ode.max_correcting_vel));
  CHECK_EQUAL(sample_grid(against_wall).rows, 5001);
}

// What a missing key means stands in the table (for help) and in Scenario (for use): the two must agree.
void fallbacks_are_what_the_table_says() {
  const Scenario bare = read(wall);
  std::string text = wall;
  std::string ode = "[ode]\n";
  std::string bullet = "[bullet]\n";
  std::string mujoco = "[mujoco]\n";
  std::string maximal = "[maximal]\n";
  for (const KeyRow& row : key_table()) {
    const bool is_value = row.kind == KeyKind::number || row.kind == KeyKind::whole || row.name == "start";
    const bool is_word = row.name == "sample" || row.name == "bounce" || row.name.ends_with("tol") || row.name == "n" ||
                         row.name == "depth" || row.fallback == "erp and cfm";
    if (row.required() || !is_value || is_word || row.section == "tolerances") continue;
    const std::string quote = row.kind == KeyKind::word ? "\"" : "";
    const std::string line = std::string(row.name) + " = " + quote + std::string(row.fallback) + quote + "\n";
    if (row.section.empty()) text = line + text;
    if (row.section == "wall") text += line;
    if (row.section == "ode") ode += line;
    if (row.section == "bullet") bullet += line;
    if (row.section == "mujoco") mujoco += line;
    if (row.section == "maximal") maximal += line;
  }
  const Scenario full = read(text + ode + bullet + mujoco + maximal);
  CHECK_EQUAL(full.step_s, bare.step_s);
  CHECK_EQUAL(full.gravity, bare.gravity);
  CHECK_EQUAL(full.planar->wall->restitution, bare.planar->wall->restitution);
  CHECK_EQUAL(full.ode.erp, bare.ode.erp);
  CHECK_EQUAL(full.ode.cfm, bare.ode.cfm);
  CHECK_EQUAL(full.ode.iterations, bare.ode.iterations);
  CHECK_EQUAL(full.ode.sor_w, bare.ode.sor_w);
  CHECK_EQUAL(full.ode.bounce_vel, bare.ode.bounce_vel);
  CHECK_EQUAL(full.ode.max_correcting_vel, bare.ode.max_correcting_vel);
  CHECK_EQUAL(full.ode.surface_layer, bare.ode.surface_layer);
  CHECK(full.ode.start == bare.ode.start);
  CHECK_EQUAL(full.ode.seed, bare.ode.seed);
  CHECK_EQUAL(full.bullet.iterations, bare.bullet.iterations);
  CHECK_EQUAL(full.bullet.erp, bare.bullet.erp);
  CHECK_EQUAL(full.mujoco.time_constant_s, bare.mujoco.time_constant_s);
  CHECK_EQUAL(full.maximal.ks, bare.maximal.ks);
  CHECK_EQUAL(full.maximal.kd, bare.maximal.kd);
  CHECK(!bare.sample_s && !bare.rtol && !bare.atol && !bare.ode.bounce && bare.methods.empty());
}

void every_key_arrives() {
  const Scenario all =
      read("step = 0.002\nsample = 0.01\ngravity = 3\nrtol = 1e-9\natol = 1e-10\nmethods = [\"analytic\"]\n" + wall +
           "restitution = 0.5\n[ode]\nerp = 0.1\ncfm = 1e-3\niterations = 7\nsor_w = 1.1\nbounce = 0.25\n"
           "bounce_vel = 0.01\nmax_correcting_vel = 5\nsurface_layer = 1e-3\nstart = \"half-step\"\nseed = 4294967295\n"
           "[bullet]\niterations = 17\nerp = 0.3\n[mujoco]\ntime_constant = 0.003\ncone = \"elliptic\"\n"
           "[maximal]\nks = 25\nkd = 0\n"
           "[[tolerances]]\nmethod = \"analytic\"\nmetric = \"max_gap\"\nuntil = 2\nat_most = 1e-6\n"
           "[[tolerances]]\nmethod = \"lagrange-rk4\"\nmetric = \"divergence_time\"\nuntil = 3\nat_least = 2.5\n");
  CHECK_EQUAL(all.step_s, 0.002);
  CHECK_EQUAL(all.sample_s.value(), 0.01);
  CHECK_EQUAL(all.gravity, 3.0);
  CHECK_EQUAL(all.rtol.value(), 1e-9);
  CHECK_EQUAL(all.atol.value(), 1e-10);
  CHECK_EQUAL(all.methods.at(0), "analytic");
  CHECK_EQUAL(all.planar->wall.value().restitution, 0.5);
  CHECK_EQUAL(all.ode.erp, 0.1);
  CHECK_EQUAL(all.ode.cfm, 1e-3);
  CHECK_EQUAL(all.ode.iterations, 7);
  CHECK_EQUAL(all.ode.sor_w, 1.1);
  CHECK_EQUAL(all.ode.bounce.value(), 0.25);
  CHECK_EQUAL(all.ode.bounce_vel, 0.01);
  CHECK_EQUAL(all.ode.max_correcting_vel, 5.0);
  CHECK_EQUAL(all.ode.surface_layer, 1e-3);
  CHECK(all.ode.start == Start::half_step);
  CHECK_EQUAL(all.ode.seed, 4294967295u);
  CHECK_EQUAL(all.bullet.iterations, 17);
  CHECK_EQUAL(all.bullet.erp, 0.3);
  CHECK_EQUAL(all.mujoco.time_constant_s, 0.003);
  CHECK(all.mujoco.elliptic);
  CHECK_EQUAL(all.maximal.ks, 25.0);
  CHECK_EQUAL(all.maximal.kd, 0.0);
  CHECK_EQUAL(all.tolerances.size(), 2u);
  CHECK_EQUAL(all.tolerances.at(0).method, "analytic");
  CHECK_EQUAL(all.tolerances.at(0).metric, "max_gap");
  CHECK_EQUAL(all.tolerances.at(0).until_s, 2.0);
  CHECK_EQUAL(all.tolerances.at(0).at_most.value(), 1e-6);
  CHECK(!all.tolerances.at(0).at_least);
  CHECK_EQUAL(all.tolerances.at(1).at_least.value(), 2.5);
}

void settings_replace_the_files_values() {
  CHECK_EQUAL(with(single, "links.0.mass", "2").planar->links.at(0).mass_kg, 2.0);
  CHECK_EQUAL(with(single, "q0", "[-1.5]").planar->q0.at(0), -1.5);
  CHECK_EQUAL(with(single, "q0.0", "0.25").planar->q0.at(0), 0.25);
  CHECK_EQUAL(with(single, "ode.erp", "0.8").ode.erp, 0.8);  // the file has no [ode]
  CHECK_EQUAL(with(single, "duration", ".5").duration_s, 0.5);
  CHECK_EQUAL(with(single, "duration", "1.").duration_s, 1.0);
  CHECK(with(single, "ode.start", "half-step").ode.start == Start::half_step);
  CHECK(with(single, "ode.start", "\"half-step\"").ode.start == Start::half_step);
  CHECK_EQUAL(with(wall, "wall.face", "0.5").planar->wall->face_m, 0.5);
  const std::vector<Override> twice{{"ode.erp", "0.1", "--erp"}, {"ode.erp", "0.3", "--set"}};
  CHECK_EQUAL(read(single, twice).ode.erp, 0.3);
  // A setting mends the file's own mistake.
  CHECK_EQUAL(with(replaced(single, "duration = 10", "duration = -1"), "duration", "3").duration_s, 3.0);
}

void errors_name_the_flag() {
  CHECK_THROWS(read(single, {{"ode.erp", "1.5", "--erp"}}), UserError,
               "--erp 1.5: ode.erp must be a number from 0 to 1");
  CHECK_THROWS(with(single, "links.0.mass", "-1"), UserError,
               "--set links.0.mass=-1: links.0.mass must be a number from 1e-06 to 1e6 kg");
  CHECK_THROWS(with(single, "q0.0", "nan"), UserError, "--set q0.0=nan: q0.0 must be a number from -1000 to 1000 rad");
  CHECK_THROWS(with(single, "q0", "[1, 2]"), UserError, "q0 must be a list of 1 number for single_pendulum");
  CHECK_THROWS(with(single, "ode.erpp", "1"), UserError, "ode.erpp is no known key (nearest: 'ode.erp')");
  CHECK_THROWS(with(single, "erp", "1"), UserError, "erp is no known key (nearest: 'ode.erp')");
  CHECK_THROWS(with(single, "a.b.c", "1"), UserError, "--set a.b.c=1: a is no known key");
  CHECK_THROWS(with(single, "links.1.mass", "1"), UserError,
               "--set links.1.mass=1: the scenario has no 'links.1.mass'");
  CHECK_THROWS(with(single, "duration.x", "1"), UserError, "the scenario has no 'duration.x'");
  CHECK_THROWS(with(single, "tolerances.0.until", "1"), UserError, "the scenario has no 'tolerances.0.until'");
  CHECK_THROWS(with(single, "", "1"), UserError, "--set =1: a key like");
  CHECK_THROWS(with(single, "ode..erp", "1"), UserError, "a key like");
  for (const char* value : {"", "[1.0,", "1\nstep = 2", "a b", "= 3", "{", "\"", "1 2"}) {
    CHECK_THROWS(with(single, "duration", value), UserError, "not a value");
  }
  CHECK_THROWS(with(single, "duration", "long"), UserError, "--set duration=long: duration must be a number");
  CHECK_THROWS(with(single, "wall.face", "0.5"), UserError,
               "--set wall.face=0.5: wall has no meaning for single_pendulum; remove it");
  CHECK_THROWS(with(single, "step", "20"), UserError, "step must be a number from 1e-07 to 1 s");
  CHECK_THROWS(with(single, "sample", "0.0015"), UserError, "must be a whole number of steps of 0.001 s");
  CHECK_THROWS(with(single, "step", "1e-7"), UserError, "--set step=1e-7: a row every 1e-07 s");
  // A setting is not blamed for what the file does wrong beside it.
  CHECK_THROWS(with(single + "[ode]\nsor_w = 2\n", "ode.erp", "0.1"), UserError, "x.toml: ode.sor_w = 2");
  CHECK_THROWS(with(replaced(single, "[0.0]", "[0.0, 1]"), "q0.0", "1"), UserError, "x.toml: q0 = ");
}

void wrong_values_are_refused() {
  const auto refuses = [](const std::string& line, const std::string& message) {
    CHECK_THROWS(read(line + "\n" + single), UserError, "x.toml: " + message);
  };
  refuses("gravity = -1", "gravity = -1: must be a number from 0 to 10000 m/s²");
  refuses("gravity = nan", "gravity = nan: must be a number");
  refuses("gravity = inf", "gravity = inf: must be a number");
  refuses("gravity = \"9\"", "gravity = '9': must be a number");
  refuses("gravity = true", "gravity = true: must be a number");
  refuses("gravity = 1979-05-27", "gravity = 1979-05-27: must be a number");
  refuses("gravity = [9.81]", "gravity = [9.81]: must be a number");
  refuses("step = 0", "step = 0: must be a number from 1e-07 to 1 s");
  refuses("step = 1.5", "step = 1.5: must be a number from 1e-07 to 1 s");
  refuses("rtol = 1e-16", "rtol = 1e-16: must be a number from 1e-15 to 0.1");
  refuses("atol = 1", "atol = 1: must be a number from 1e-20 to 0.1");
  refuses("methods = [\"ode-stp-double\"]", "methods.0 = 'ode-stp-double': is not known (nearest: 'ode-step-double')");
  refuses("methods = \"analytic\"", "methods = 'analytic': must be a list");
  refuses("methods = [1]", "methods.0 = 1: must be one of");
  refuses("stpe = 1", "stpe = 1: is no known key (nearest: 'step')");
  refuses("\"ode.erp\" = 1", "ode.erp = 1: is no known key");
  refuses("\"a\\nb\" = 1", "a b = 1: is no known key");
  refuses("ode = 1", "ode = 1: must be a table [ode]");

  const auto refuses_at_end = [](const std::string& lines, const std::string& message) {
    CHECK_THROWS(read(single + lines + "\n"), UserError, "x.toml: " + message);
  };
  refuses_at_end("colour = 1", "links.0.colour = 1: is no known key");
  refuses_at_end("[ode]\niterations = 20.0", "ode.iterations = 20.0: must be a whole number from 1 to 1e5");
  refuses_at_end("[maximal]\nks = -1", "maximal.ks = -1: must be a number from 0 to 1e14 1/s²");
  refuses_at_end("[maximal]\nksd = 1", "maximal.ksd = 1: is no known key (nearest: 'maximal.k");
  refuses_at_end("[ode]\niterations = 0", "ode.iterations = 0: must be a whole number");
  refuses_at_end("[ode]\nseed = 1.0", "ode.seed = 1.0: must be a whole number from 0 to 4294967295");
  refuses_at_end("[ode]\nseed = 4294967296", "ode.seed = 4294967296: must be a whole number");
  refuses_at_end("[ode]\nsor_w = 0", "ode.sor_w = 0: must be a number between 0 and 2, ends excluded");
  refuses_at_end("[ode]\nsor_w = 2", "ode.sor_w = 2: must be a number between 0 and 2, ends excluded");
  refuses_at_end("[ode]\nsurface_layer = inf", "ode.surface_layer = inf: must be a number");
  refuses_at_end("[ode]\nmax_correcting_vel = nan", "ode.max_correcting_vel = nan: must be a number from 0 to inf m/s");
  refuses_at_end("[ode]\nstart = \"half\"", "ode.start = 'half': must be one of as-given, half-step");
  refuses_at_end("[ode]\nmass = 1", "ode.mass = 1: is no known key");
  refuses_at_end("[wall]\nface = 0", "wall has no meaning for single_pendulum; remove it");
  const std::string tolerance = "[[tolerances]]\nmethod = \"analytic\"\nuntil = 1\n";
  refuses_at_end(tolerance + "metric = \"max_gap\"", "tolerances.0 must have at_most or at_least");
  refuses_at_end(tolerance + "metric = \"max_gapp\"\nat_most = 1", "tolerances.0.metric = 'max_gapp': is not known");
  refuses_at_end(tolerance + "at_most = 1", "tolerances.0.metric is missing");
  refuses_at_end("[[links]]\nmass = 1\nlength = 1\nwidth = 1\ndepth = 1",
                 "links = 2 tables: must be 1 table [[links]]");
}

const std::string chain = replaced(replaced(single, "single_pendulum", "chain"), "problem", "n = 5\nproblem");

void a_chain_has_as_many_links_as_it_says() {
  const Scenario five = read(replaced(chain, "q0 = [0.0]", "q0 = [0.3, 0.2]"));
  CHECK_EQUAL(five.planar->links.size(), 5u);
  CHECK_EQUAL(five.planar->links.back().width_m, five.planar->links.front().width_m);
  CHECK_EQUAL(five.planar->q0.size(), 5u);
  CHECK_EQUAL(five.planar->q0[1], 0.2);
  CHECK_EQUAL(five.planar->q0[4], 0.0);
  CHECK_EQUAL(five.planar->qd0.size(), 5u);
  CHECK_EQUAL(with(chain, "n", "1").planar->links.size(), 1u);
  CHECK_EQUAL(with(chain, "n", "1024").planar->links.size(), 1024u);
  CHECK_EQUAL(read(replaced(chain, "n = 5\n", "")).planar->links.size(), 1u);
  for (const char* n : {"0", "1025", "100000", "2.5", "-1"}) {
    CHECK_THROWS(with(chain, "n", n), UserError, "n must be a whole number from 1 to 1024");
  }
  CHECK_THROWS(with(chain, "q0", "[1, 2, 3, 4, 5, 6]"), UserError, "q0 must be a list of at most n = 5 numbers");
  CHECK_THROWS(read("n = 2\n" + single), UserError, "n = 2: has no meaning for single_pendulum; remove it");
  const std::string link = "[[links]]\nmass = 1\nlength = 1\nwidth = 0.1\ndepth = 0.1\n";
  CHECK_THROWS(read(chain + link), UserError, "links = 2 tables: must be one table [[links]] or n = 5 of them");
}

void a_ball_is_as_deep_as_wide() {
  const std::string ball = replaced(single, "depth = 0.1", "shape = \"sphere\"");
  const Link link = read(ball).planar->links.at(0);
  CHECK_EQUAL(link.depth_m, link.width_m);
  CHECK_EQUAL(link.centre_m(), link.length_m);
  CHECK_EQUAL(link.beyond_centre_m(), 0.0);
  CHECK_NEAR(link.inertia_kgm2(), 0.4 * link.mass_kg * link.width_m * link.width_m / 4, 1e-18);
  CHECK_THROWS(read(replaced(single, "depth = 0.1", "depth = 0.2\nshape = \"sphere\"")), UserError,
               "links.0.depth = 0.2: must be left out or be the width: the link is a ball");
  CHECK_THROWS(with(ball, "links.0.shape", "\"egg\""), UserError, "links.0.shape must be one of box, sphere");
  CHECK_THROWS(with(wall, "links.0.shape", "\"sphere\""), UserError, "links.0.shape must be box for wall_pendulum");
}

void missing_keys_are_named() {
  for (const char* line : {"problem = \"single_pendulum\"\n", "duration = 10\n", "q0 = [0.0]\n", "qd0 = [0.0]\n"}) {
    const std::string key = std::string(line).substr(0, std::string(line).find(' '));
    CHECK_THROWS(read(replaced(single, line, "")), UserError, "x.toml: " + key + " is missing; it must be");
  }
  CHECK_THROWS(read(replaced(single, "depth = 0.1", "")), UserError, "x.toml: links.0.depth is missing; it must be");
  CHECK_THROWS(read(replaced(wall, "face = 0.9", "")), UserError, "x.toml: wall.face is missing; it must be");
  CHECK_THROWS(read(replaced(wall, "[wall]\nface = 0.9", "")), UserError,
               "wall is missing; wall_pendulum needs [wall]");
  CHECK_THROWS(read(""), UserError, "x.toml: problem is missing; it must be one of single_pendulum, double_pendulum");
}

void a_link_may_not_start_inside_the_wall() {
  // Hinge at x = 1. Level: the hinge's own end at x = 1 is nearest. Straight down: the side, half a width nearer.
  CHECK_EQUAL(with(wall, "wall.face", "1.0").planar->wall->face_m, 1.0);
  CHECK_THROWS(with(wall, "wall.face", "1.01"), UserError,
               "--set wall.face=1.01: wall.face must be at most 1 m, or the link starts inside the wall");
  CHECK_THROWS(read(replaced(wall, "face = 0.9", "face = 2")), UserError, "x.toml: wall.face = 2: must be at most 1 m");
  const std::string down = replaced(wall, "q0 = [0.0]", "q0 = [-1.5707963267948966]");
  CHECK_EQUAL(with(down, "wall.face", "0.9499999").planar->wall->face_m, 0.9499999);
  CHECK_THROWS(with(down, "wall.face", "0.9500001"), UserError, "must be at most 0.95 m");
  // Past the vertical a corner of the far end: 1 + cos 2 - 0.05 sin 2.
  CHECK_THROWS(with(wall, "q0", "[-2.0]"), UserError, "--set q0=[-2.0]: q0 puts the link into the wall");
  CHECK_THROWS(with(wall, "q0", "[2.0]"), UserError, "may be at most 0.538388 m");
  // Two balls, hinge at x = 0: the first at 1/2, the second, at -120 degrees from there, at 0, and half a width nearer.
  const std::string ball = "[[links]]\nshape = \"sphere\"\nmass = 1\nlength = 1\nwidth = 0.1\n";
  const std::string balls =
      "problem = \"potra_pendulum\"\nduration = 1\nq0 = [-1.0471975511965976, -1.0471975511965976]\nqd0 = [0, 0]\n" +
      ball + ball + "[wall]\nface = -0.0500001\n";
  CHECK_EQUAL(read(balls).planar->wall->face_m, -0.0500001);
  CHECK_THROWS(with(balls, "wall.face", "-0.0499999"), UserError, "must be at most -0.05 m");
}

void files_that_are_no_scenarios() {
  CHECK_THROWS(read_scenario("absent.toml", {}, names), UserError, "absent.toml: cannot be read: No such file");
  fs::create_directory("folder.toml");
  CHECK_THROWS(read_scenario("folder.toml", {}, names), UserError, "folder.toml: is a directory");
  CHECK_THROWS(read_scenario("/dev/zero", {}, names), UserError, "/dev/zero: is longer than 1 MiB");
  CHECK_THROWS(read("duration = 1\nstep = \n"), UserError, "x.toml:2: not TOML: ");
  CHECK_THROWS(read("step = 1\nstep = 2\n"), UserError, "x.toml:2: not TOML: ");
  CHECK_THROWS(read("\xff\xfe"), UserError, "not TOML: ");
  CHECK_THROWS(read("a = " + std::string(5000, '[')), UserError, "not TOML: ");
  CHECK_THROWS(read("[[[1]]]"), UserError, "not TOML: ");  // breaks an assertion of a header-only toml++
  CHECK_THROWS(read("a = 9.8²"), UserError, "not TOML: ");
  write("two words.toml", single);
  CHECK_THROWS(read_scenario("two words.toml", {}, names), UserError, "is named with letters, digits");
}

// Whatever is wrong, the message is one line.
void messages_have_one_line() {
  for (const std::string& text : {std::string("a = \"\"\"x\ny\"\"\"\n"), std::string("step = \n"),
                                  "gravity = [1,\n2,\n3]\n" + single, "\"x\\ny\\tz\" = 1\n" + single}) {
    try {
      read(text);
      CHECK(false);
    } catch (const UserError& error) {
      const std::string message = error.what();
      CHECK(std::none_of(message.begin(), message.end(), [](char letter) { return letter >= 0 && letter < ' '; }));
    }
  }
}

long rows_of(double duration, double step, double sample = 0) {
  Scenario scenario;
  scenario.duration_s = duration;
  scenario.step_s = step;
  if (sample > 0) scenario.sample_s = sample;
  return sample_grid(scenario).rows;
}

void the_grid_reaches_the_duration() {
  CHECK_EQUAL(rows_of(10, 0.001), 10001);
  CHECK_EQUAL(rows_of(0.3, 0.1), 4);           // 0.3 / 0.1 is just below 3
  CHECK_EQUAL(rows_of(2.1, 0.3), 8);           // 2.1 / 0.3 is just above 7
  CHECK_EQUAL(rows_of(17.1, 1e-6), 17100001);  // 17.1 / 1e-6 is 4e-9 above
  CHECK_EQUAL(rows_of(1, 0.3), 5);             // the last row stands at 1.2
  CHECK_EQUAL(rows_of(1, 1), 2);
  CHECK_EQUAL(rows_of(10, 0.001, 0.01), 1001);
  CHECK_EQUAL(rows_of(10, 0.001, 0.3), 35);
  for (const double step : {1e-3, 1.7e-3, 1e-4, 3e-5, 1.0 / 3000}) {
    Scenario scenario;
    scenario.duration_s = 10;
    scenario.step_s = step;
    const SampleGrid grid = sample_grid(scenario);
    CHECK_BETWEEN(grid.time(grid.rows - 1), 10 - 1e-8 * step, 10 + step * (1 - 1e-8));
  }
  CHECK_THROWS(rows_of(10, 0.001, 0.0015), UserError, "whole number of steps");
  CHECK_THROWS(rows_of(10, 0.001, 0.0005), UserError, "whole number of steps");
  CHECK_THROWS(rows_of(1e5, 1e-7), UserError, "use --sample");
  CHECK_EQUAL(rows_of(1e5, 1e-7, 1), 100001);
  CHECK_THROWS(with(single, "duration", "1e-4"), UserError, "duration must be at least one step");
  CHECK_THROWS(with(single, "sample", "11"), UserError, "sample must not leave sample = 11 s above duration = 10 s");
}

void scenarios_are_found_by_name() {
  const std::vector<std::string> known = scenario_names(shipped);
  CHECK(std::is_sorted(known.begin(), known.end()));
  CHECK(std::find(known.begin(), known.end(), "double_pendulum") != known.end());
  CHECK(find_scenario("wall_pendulum", shipped) == shipped / "wall_pendulum.toml");
  CHECK(find_scenario("some/where", shipped) == "some/where");
  CHECK(find_scenario("here.toml", shipped) == "here.toml");
  CHECK_THROWS(find_scenario("doubel_pendulum", shipped), UserError,
               "no scenario named 'doubel_pendulum' (nearest: 'double_pendulum'); 'odeval list' shows all " +
                   std::to_string(known.size()));
  CHECK_THROWS(find_scenario("", shipped), UserError, "no scenario named ''");
  CHECK_THROWS(scenario_names("absent"), MachineError, "absent: cannot list the scenarios: No such file");
  fs::create_directory("empty");
  CHECK_THROWS(find_scenario("x", "empty"), UserError, "there is no scenario file in empty");
}

// A joint's spring: both values or none, and not beside erp and cfm but in their place.
void springs_take_the_place_of_erp_and_cfm() {
  const std::string spring = single + "[ode]\nkp = 100\nkd = 2\n";
  const Scenario scenario = read(spring);
  CHECK_EQUAL(scenario.ode.softness(1e-3).cfm, 1 / 2.1);
  CHECK_NEAR(scenario.ode.softness(1e-3).erp, 0.1 / 2.1, 1e-16);
  CHECK_NEAR(scenario.ode.softness(1e-2).erp, 1 / 3.0, 1e-16);  // of each step anew
  CHECK_EQUAL(read(single).ode.softness(1e-2).erp, 0.2);
  CHECK_EQUAL(with(spring, "ode.kp", "50").ode.spring->kp_N_m, 50.0);

  const std::vector<Override> replaced_by{{"ode.erp", "0.3", "--erp"}, {"ode.cfm", "0", "--cfm"}};
  CHECK(!read(spring, replaced_by).ode.spring);
  CHECK_EQUAL(read(spring, replaced_by).ode.softness(1e-3).erp, 0.3);
  // Found by the fuzz target: a whole number that no double is.
  CHECK_THROWS(read(single, {{"gravity", "9007199254740993", "--set"}}), UserError,
               "--set gravity=9007199254740993: gravity must be a number from 0 to 10000 m/s²");
  const std::string soft = single + "[ode]\nerp = 0.1\ncfm = 1e-3\n";
  const std::vector<Override> replacing{{"ode.kp", "100", "--kp"}, {"ode.kd", "2", "--kd"}};
  CHECK_EQUAL(read(soft, replacing).ode.softness(1e-3).cfm, 1 / 2.1);

  CHECK_THROWS(read(single, {{"ode.kp", "100", "--kp"}}), UserError, "--kp 100: ode.kp needs ode.kd beside it");
  CHECK_THROWS(read(single + "[ode]\nkd = 2\n"), UserError, "x.toml: ode.kd = 2: needs ode.kp beside it");
  CHECK_THROWS(read(spring, {{"ode.erp", "0.3", "--erp"}}), UserError,
               "--erp 0.3: ode.erp needs ode.cfm beside it, to replace the file's ode.kp and ode.kd");
  CHECK_THROWS(read(single, {replacing[0], replacing[1], replaced_by[0]}), UserError,
               "--erp 0.3: ode.erp says the same as ode.kp and ode.kd; give one pair or the other");
  CHECK_THROWS(read(spring + "erp = 0.2\n"), UserError, "x.toml: ode.erp = 0.2: says the same as ode.kp and ode.kd");
  CHECK_THROWS(read(single, {{"ode.kp", "0", "--kp"}, {"ode.kd", "0", "--kd"}}), UserError,
               "--kd 0: ode.kd must make step * kp + kd at least 0.001 N s/m; it is 0");
  CHECK_THROWS(with(spring, "ode.kd", "-1"), UserError, "ode.kd must be a number from 0 to");
}

void joints() {
  const std::string body = "[[bodies]]\nmass = 1\nsize = [1, 1, 1]\nposition = [0, 0, 2]\n";
  const std::string joint =
      "[joint]\nkind = \"hinge\"\nanchor = [0, 0, 1]\naxis = [0, 3, 4]\ndisplacement = [0, 0, 0.5]\n";
  const std::string text = "problem = \"spring_joint\"\nduration = 1\n";
  const Scenario scenario = read(text + body + joint);
  const Joint& only = scenario.mechanism.joints.at(0);
  CHECK(std::holds_alternative<HingeJoint>(only.kind));
  CHECK_NEAR(std::get<HingeJoint>(only.kind).axis[2], 0.8, 1e-16);
  CHECK_EQUAL(scenario.mechanism.bodies[0].position_m[2], 2.5);  // displaced
  CHECK_EQUAL(only.opening_m[2], 0.5);
  CHECK_EQUAL(anchor_m(only.kind)[2], 1.0);
  CHECK(only.first == 0 && !only.second);
  const Scenario two = read(text + body + body + joint);
  CHECK_EQUAL(two.mechanism.bodies[0].position_m[2], 2.5);
  CHECK_EQUAL(two.mechanism.bodies[1].position_m[2], 2.0);  // the first alone
  CHECK(two.mechanism.joints.at(0).second == std::optional<std::size_t>(1));
  CHECK_THROWS(read(text + body), UserError, "x.toml: joint is missing; spring_joint needs [joint]");
  CHECK_THROWS(read(text + body + body + body + joint), UserError, "must be one table [[bodies]] or two");
  CHECK_THROWS(with(text + body + joint, "joint.axis", "[0, 0, 0]"), UserError, "joint.axis must have a direction");
  CHECK_THROWS(with(text + body + joint, "joint.kind", "slider"), UserError, "must be one of ball, hinge");
  CHECK_THROWS(read(single + joint), UserError, "joint has no meaning for single_pendulum");
}

/// By Rodrigues' formula.
Vec3 turned(const Vec3& v, const Vec3& turn) {
  const double angle = std::sqrt(dot(turn, turn));
  const Vec3 axis{turn[0] / angle, turn[1] / angle, turn[2] / angle};
  const Vec3 across = cross(axis, v);
  Vec3 to{};
  for (std::size_t k = 0; k < 3; ++k) {
    to[k] = v[k] * std::cos(angle) + across[k] * std::sin(angle) + axis[k] * dot(axis, v) * (1 - std::cos(angle));
  }
  return to;
}

// What the file says along the ground stands in the world as one turn about y puts it there: downhill is +x and falls.
void bodies_are_laid_on_the_ground() {
  const Scenario scenario = read(
      "problem = \"friction_slide\"\nduration = 1\n[[bodies]]\nmass = 1\nsize = [0.4, 0.2, 0.1]\n"
      "position = [1, 2, 3]\nturn = [0.3, -0.5, 0.8]\nvelocity = [4, 5, 6]\nspin = [7, 8, 9]\n[ground]\nslope = 0.4\n");
  const Vec3 slope{0, 0.4, 0};
  const Body& body = scenario.mechanism.bodies[0];
  constexpr double rounding = 1e-14;  // a few roundings of numbers up to 11
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK_NEAR(body.position_m[k], turned({1, 2, 3}, slope)[k], rounding);
    CHECK_NEAR(body.velocity_m_s[k], turned({4, 5, 6}, slope)[k], rounding);
    CHECK_NEAR(body.spin_rad_s[k], turned({7, 8, 9}, slope)[k], rounding);
    for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      CHECK_NEAR(turned(axis, rotation_vector(body.attitude))[k], turned(turned(axis, {0.3, -0.5, 0.8}), slope)[k],
                 rounding);
    }
  }
  CHECK(body.position_m[2] < 3);
}

void aspect_makes_two_sides_thin() {
  const Scenario scenario =
      read("problem = \"thin_body\"\nduration = 1\n[[bodies]]\nmass = 1\nsize = [0.5, 0.2, 1.0]\naspect = 10\n");
  CHECK_EQUAL(sides_m(scenario.mechanism.bodies[0].shape)[0], 0.05);
  CHECK_EQUAL(sides_m(scenario.mechanism.bodies[0].shape)[1], 0.02);
  CHECK_EQUAL(sides_m(scenario.mechanism.bodies[0].shape)[2], 1.0);
}

void nearest_words() {
  CHECK_EQUAL(edit_distance("kitten", "sitting"), 3u);
  CHECK_EQUAL(edit_distance("", "abc"), 3u);
  CHECK_EQUAL(edit_distance("abc", ""), 3u);
  CHECK_EQUAL(edit_distance("same", "same"), 0u);
  CHECK_EQUAL(nearest("stpe", std::vector<std::string>{"seed", "step", "erp"}), "step");
  CHECK_EQUAL(nearest("x", std::vector<std::string>{}), "");
}

}  // namespace

int main() {
  const Folder folder;
  shipped_files_hold_the_reports_values();
  fallbacks_are_what_the_table_says();
  every_key_arrives();
  settings_replace_the_files_values();
  errors_name_the_flag();
  wrong_values_are_refused();
  a_chain_has_as_many_links_as_it_says();
  a_ball_is_as_deep_as_wide();
  missing_keys_are_named();
  a_link_may_not_start_inside_the_wall();
  files_that_are_no_scenarios();
  messages_have_one_line();
  the_grid_reaches_the_duration();
  scenarios_are_found_by_name();
  nearest_words();
  springs_take_the_place_of_erp_and_cfm();
  joints();
  bodies_are_laid_on_the_ground();
  aspect_makes_two_sides_thin();
  return odeval::test::verdict();
}
