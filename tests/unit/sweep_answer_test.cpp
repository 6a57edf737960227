// What a sweep says of its runs: which share a reference, and what the tables, the front and the exit status make of a
// journal with runs of every kind, whose numbers are chosen here.
#include "cli/sweep_answer.hpp"

#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <set>
#include <sstream>

#include "catalogue/grid_runs.hpp"
#include "catalogue/paths.hpp"
#include "catalogue/reference_bytes.hpp"
#include "cli/settings.hpp"
#include "model/find_scenario.hpp"
#include "output/sweep_table.hpp"
#include "reference/providers.hpp"
#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using namespace odeval;
using sweep::Status;
namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

ScenarioFile file_of(const std::string& scenario) {
  return ScenarioFile(find_scenario(scenario, catalogue::scenario_folder()));
}

/// The results of a run with these numbers and no others.
std::string cells(std::optional<double> error, double uncertainty, double gap, double energy = 0) {
  Outcome outcome;
  outcome.steps = 1000;
  Metrics metrics;
  metrics[quantity::max_error_q] = error;
  if (error) metrics[quantity::reference_uncertainty] = uncertainty;
  metrics[quantity::max_gap] = gap;
  metrics[quantity::final_energy_drift] = energy;
  return result_cells(outcome, metrics);
}

constexpr double infinity = std::numeric_limits<double>::infinity();

// Three methods at four values each, so that run 3 i + j is method j at value i.
const std::vector<std::string> erps{"0.1", "0.2", "0.4", "0.8"};
const std::vector<std::string> methods{"lagrange-cvode", "lagrange-rk4", "ode-step-double"};
const std::vector<sweep::Row> rows{
    {Status::ok, "", 1, cells(0, 1e-9, 0)},  // the reference, which is the cheapest and without error
    {Status::ok, "", 4000, cells(1e-3, 1e-9, 0, 0.5)},
    {Status::ok, "", 2000, cells(2e-2, 1e-9, 3e-3, -2)},
    {Status::ok, "", 2, cells(0, 1e-9, 0)},
    {Status::ok, "", 5000, cells(5e-3, 1e-9, 0, 1)},  // dearer and worse than run 1
    {Status::diverged, "not finite at t = 1 s", 10, cells(infinity, 1e-9, 1e141, infinity)},  // cheaper than all
    {Status::timeout, "what its runs share: took longer than 0.5 s", 500000, ""},
    {Status::crashed, "ended by signal 11 (Segmentation fault)", 0, ""},
    {Status::timeout, "took longer than 0.5 s", 500000, ""},
    {Status::ok, "", 3, cells(0, 1e-9, 0)},
    {Status::ok, "", 9000, cells(4e-10, 1e-9, 0, 0.5)},  // below what the reference knows
    {Status::ok, "", 9500, cells(3e-10, 1e-9, 1e-4, 0.5)},
};

sweep::Head head_of_rows() {
  return {"double_pendulum",
          {},
          {{"ode.erp", erps}, {"method", methods}},
          result_columns(),
          file_of("double_pendulum").text({}),
          "odeval 1\n"};
}

/// Cells of a row in a table of this sweep: run, its values, status, reason, results.
std::string line_of(std::size_t run) {
  const sweep::Row& row = rows[run];
  const std::string results = row.cells.empty() ? std::string(result_columns().size() - 1, ',') : row.cells;
  return std::to_string(run) + "," + erps[run / 3] + "," + methods[run % 3] + "," +
         std::string(sweep::status_name(row.status)) + "," + row.reason + "," + results + "\n";
}

struct Answer {
  int status;
  std::string said;
  std::string table, timing, front, ode_front;
};

/// What is answered to a journal with those of the rows.
Answer answer_to(const fs::path& folder, const std::vector<std::size_t>& runs, const cli::AnswerOptions& options) {
  fs::remove_all(folder);
  sweep::Journal journal(cli::journal_file(folder, "double_pendulum"), head_of_rows());
  for (const std::size_t run : runs) journal.append(static_cast<long>(run), rows[run]);
  std::ostringstream said;
  std::streambuf* const before = std::cout.rdbuf(said.rdbuf());
  const int status = cli::answer(journal, folder, options);
  std::cout.rdbuf(before);
  const auto file = [&](const char* end) { return text_of(folder / "sweep" / (std::string("double_pendulum") + end)); };
  return {status,
          said.str(),
          file(".csv"),
          file("-timing.csv"),
          file("-front.csv"),
          fs::exists(folder / "sweep/double_pendulum-front-ode.csv") ? file("-front-ode.csv") : ""};
}

const std::string table_header = [] {
  std::string header = "run,ode.erp,method,status,reason";
  for (const std::string& column : result_columns()) header += "," + column;
  return header + "\n";
}();

void every_run_has_its_row(const fs::path& folder) {
  const Answer all = answer_to(folder, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, {});
  CHECK_EQUAL(all.status, 1);
  std::string wanted = table_header;
  for (std::size_t run = 0; run < rows.size(); ++run) wanted += line_of(run);
  CHECK_EQUAL(all.table, wanted);
  CHECK_EQUAL(all.timing,
              "run,cpu_s\n0,1e-06\n1,0.004\n2,0.002\n3,2e-06\n4,0.005\n5,1e-05\n6,\n7,0\n8,\n9,3e-06\n10,0.009\n"
              "11,0.0095\n");
  CHECK(all.said.starts_with(
      "double_pendulum: 12 runs (4 ode.erp × 3 method): 8 ok, 1 diverged, 1 crashed, 2 timeout\n"));

  // Rows that came in another order, and not all of them.
  const Answer some = answer_to(folder, {11, 4, 1}, {"", true});
  CHECK_EQUAL(some.status, 0);
  CHECK_EQUAL(some.table, table_header + line_of(1) + line_of(4) + line_of(11));
  CHECK_EQUAL(some.timing, "run,cpu_s\n1,0.004\n4,0.005\n11,0.0095\n");
  CHECK_EQUAL(some.said, "");
  // No status but `ok` is a success.
  for (const std::size_t bad : {5U, 6U, 7U}) CHECK_EQUAL(answer_to(folder, {1, bad}, {"", true}).status, 1);
}

/// A key that a method does not read does not multiply its runs: what is printed adds up to them.
void the_header_counts_the_runs(const fs::path& folder) {
  sweep::Head head = head_of_rows();
  head.axes = {{"step", {"0.001", "0.002"}},
               {"ode.erp", {"0.1", "0.2", "0.4"}, {"lagrange-cvode", "lagrange-rk4"}},
               {"rtol", {"1e-3", "1e-6"}, {"lagrange-rk4", "ode-step-double"}},
               {"method", {"lagrange-cvode", "ode-step-double", "lagrange-rk4", "ode-quickstep-double"}}};
  head.axes[2].unread_by.emplace_back("ode-quickstep-double");
  CHECK_EQUAL(sweep::Grid(head.axes).runs(), 2 * 2 + 2 * 3 * 2 + 2);
  sweep::Journal journal(cli::journal_file(folder, "double_pendulum"), head);
  for (long run = 0; run < journal.runs(); ++run) journal.append(run, rows[1]);
  std::ostringstream said;
  std::streambuf* const before = std::cout.rdbuf(said.rdbuf());
  cli::answer(journal, folder, {});
  std::cout.rdbuf(before);
  CHECK_EQUAL(said.str().substr(0, said.str().find('\n')),
              "double_pendulum: 18 runs (2 step × 2 rtol × 1 method without ode.erp + 2 step × 3 ode.erp × 2 method "
              "without rtol + 2 step × 1 method without ode.erp, rtol): 18 ok");
}

/// Run 2 is the cheapest that went through and is no reference. Run 1 is dearer and better; of runs 10 and 11 the
/// reference knows no more than that they are good to 2e-9, and 10 is the cheaper one.
void the_front_is_of_runs_that_went_through(const fs::path& folder) {
  const std::vector<std::size_t> all{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  const Answer angles = answer_to(folder, all, {});
  CHECK_EQUAL(angles.front, "cpu_s,max_error_q,reference_uncertainty," + table_header + "0.002,0.02,1e-09," +
                                line_of(2) + "0.004,0.001,1e-09," + line_of(1) + "0.009,4e-10,1e-09," + line_of(10));
  CHECK(angles.said.find("CPU, ms  max_error_q, rad  ode.erp  method           steps  run\n"
                         "      2      0.02 ± 1e-09  0.1      ode-step-double   1000    2\n"
                         "      4     0.001 ± 1e-09  0.1      lagrange-rk4      1000    1\n"
                         "      9     4e-10 ± 1e-09  0.8      lagrange-rk4      1000   10\n") != std::string::npos);
  // Of ODE's own methods alone, beside that: what a user of ODE can have.
  CHECK_EQUAL(angles.ode_front, "cpu_s,max_error_q,reference_uncertainty," + table_header + "0.002,0.02,1e-09," +
                                    line_of(2) + "0.0095,3e-10,1e-09," + line_of(11));
  CHECK(angles.said.find("against CPU time, ODE's own methods\n") != std::string::npos);
  // Nothing but ODE's: one front.
  CHECK_EQUAL(answer_to(folder, {2, 5}, {}).ode_front, "");
  // An error that needs no reference: the run that blew up has one, 1e141 m, and was the cheapest.
  CHECK_EQUAL(
      answer_to(folder, all, {"max_gap", true}).front,
      "cpu_s,max_gap,reference_uncertainty," + table_header + "0.002,0.003,," + line_of(2) + "0.004,0,," + line_of(1));
  // A size counts, not a sign: a loss of 2 J is worse than a gain of half of one.
  CHECK_EQUAL(answer_to(folder, all, {"final_energy_drift", true}).front,
              "cpu_s,final_energy_drift,reference_uncertainty," + table_header + "0.002,2,," + line_of(2) +
                  "0.004,0.5,," + line_of(1));
  const Answer none = answer_to(folder, {0, 5, 6, 7, 8}, {});
  CHECK_EQUAL(none.front, "cpu_s,max_error_q,reference_uncertainty," + table_header);
  CHECK(none.said.find("no run that is ok has a value of max_error_q: there is no front\n") != std::string::npos);
  CHECK(answer_to(folder, {5, 8}, {}).said.find("no run is ok: there is no front\n") != std::string::npos);
}

// Keys of a scenario with two values each: those that change the true motion, or the times at which it is looked at;
// those of the engine; and those that would change another motion but not this one.
struct Case {
  const char* scenario;
  const char* settings;  // KEY=VALUE, or nothing
  std::vector<const char*> motion;
  std::vector<const char*> engine;
  std::vector<const char*> in_vain = {};
};

const std::vector<Case> cases{
    {"double_pendulum",
     "duration=0.05",
     {"q0=[0.5,0.5],[0.1,1.0]", "qd0=[0.5,0.5],[0.1,1.0]", "gravity=9.8,3.7", "links.0.mass=1.0,2.0",
      "links.1.length=1.0,1.5", "links.0.width=0.1,0.2", "links.1.shape=\"box\",\"sphere\"", "step=0.001,0.002",
      "sample=0.01,0.005"},
     {"ode.erp=0.1,0.8",
      "ode.cfm=1e-5,1e-9",
      "ode.iterations=10,50",
      "ode.sor_w=1.0,1.3",
      "ode.bounce=0.5,0.7",
      "ode.bounce_vel=0.0,0.1",
      "ode.max_correcting_vel=0.1,inf",
      "ode.surface_layer=0.0,0.001",
      "ode.friction_axes=\"plane-space\",\"sliding\"",
      "ode.start=\"as-given\",\"half-step\"",
      "ode.seed=1,2",
      "ode.gyroscopic=\"on\",\"off\"",
      "ode.rotation=\"infinitesimal\",\"finite\"",
      "bullet.iterations=10,50",
      "bullet.erp=0.2,0.5",
      "mujoco.time_constant=0.02,0.05",
      "mujoco.cone=\"pyramidal\",\"elliptic\"",
      "maximal.ks=400.0,100.0",
      "maximal.kd=40.0,20.0",
      "rtol=1e-3,1e-6",
      "atol=1e-6,1e-9"},
     {"links.0.depth=0.1,0.2"}},
    {"single_pendulum", "", {"duration=0.1,0.2"}, {}},
    {"double_pendulum", "ode.kd=10.0", {}, {"ode.kp=100.0,1000.0"}},
    {"double_pendulum", "ode.kp=100.0", {}, {"ode.kd=1.0,10.0"}},
    {"chain", "duration=0.05", {"n=3,4"}, {}},
    {"wall_pendulum", "duration=0.6", {"wall.face=0.9,0.8", "wall.restitution=1.0,0.5"}, {"ode.bounce=0.9,0.5"}},
    {"free_box",
     "duration=0.1",
     {"bodies.0.size=[0.2,0.3,0.4],[0.2,0.3,0.5]", "bodies.0.position=[0,0,1],[0,0,2]",
      "bodies.0.turn=[0,0,0],[0.1,0,0]", "bodies.0.velocity=[0,0,1],[0,0,2]", "bodies.0.spin=[0,0,1],[0,0,2]"},
     {"ode.gyroscopic=\"on\",\"off\""},
     {"bodies.0.mass=1.0,2.0"}},
    {"free_box", "bodies.0.size=[0.2,0.2,0.2]", {}, {}, {"bodies.0.shape=\"box\",\"sphere\""}},
    {"thin_body", "duration=0.1", {"bodies.0.aspect=10.0,100.0"}, {}},
    {"bouncing_ball",
     "",
     {"ground.restitution=0.5,0.8"},
     {"ode.erp=0.2,0.5", "ode.bounce=0.5,0.7", "ode.cfm=0.0,1e-5"}},
    {"friction_slide", "", {"ground.slope=0.0,0.1", "ground.friction=0.1,0.2"}, {}},
    {"friction_slide", "ground.friction_model=\"constant\"", {"bodies.0.mass=1.0,2.0"}, {}},
    {"friction_slide", "", {"ground.friction_model=\"pyramid\",\"constant\""}, {}},
    // The spring that ODE makes of a joint is the truth's as well.
    {"spring_joint",
     "",
     {"joint.displacement=[0,0,0.01],[0,0,0.02]", "ode.kp=100.0,200.0", "ode.kd=1.0,2.0"},
     {"ode.iterations=10,50"}},
    {"open_hinge",
     "",
     {"ode.erp=0.2,0.5", "ode.cfm=0.0,1e-5"},
     {"ode.sor_w=1.0,1.3"},
     {"joint.anchor=[0,0,1.5],[0,0,1.4]", "joint.axis=[0,1,0],[1,0,0]", "joint.kind=\"hinge\",\"ball\""}},
    {"three_link_arm",
     "duration=0.05",
     {"bodies.0.inertia=[0.03,0.03,0.03,0,0,0],[0.03,0.03,0.04,0,0,0]", "joints.0.kind=\"hinge\",\"universal\"",
      "joints.1.q=[0],[0.1]", "joints.1.qd=[0],[0.1]", "joints.1.anchor=[0,0,1],[0,0,1.1]",
      "joints.1.axis=[0,1,0],[1,1,0]"},
     {"ode.erp=0.2,0.5"}},
    {"three_link_arm", "joints.0.kind=\"universal\"", {"joints.0.axis2=[1,0,0],[0,1,0]"}, {}},
    {"three_link_arm", "joints.1.kind=\"pr\"", {"joints.1.axis2=[1,0,0],[0,0,1]"}, {}},
    {"three_link_arm", "joints.1.kind=\"pu\"", {"joints.1.axis3=[0,0,1],[0,1,1]"}, {}},
    {"three_link_arm", "joints.1.kind=\"hinge2\"", {"joints.1.suspension=[100,1],[200,1]"}, {}},
    {"three_link_arm",
     "joints.1={kind=\"pu\", parent=\"shoulder\", child=\"upper\", anchor=[0,0,1], motor2={velocity=1, force=1}, "
     "motor3={velocity=1, force=1}}",
     {"joints.1.motor2.velocity=1,2", "joints.1.motor2.force=1,2", "joints.1.motor3.velocity=1,2",
      "joints.1.motor3.force=1,2"},
     {}},
    {"iftomm_governor",
     "duration=0.001",
     {"struts.0.stiffness=8e5,7e5", "struts.0.damping=4e4,3e4", "struts.0.rest=0.5,0.51",
      "struts.0.from=[0,0,0.5],[0,0,0.4]", "struts.0.to=[0.4,0,0.7],[0.4,0,0.8]"},
     {"ode.erp=0.2,0.5"}},
    {"cart_pole",
     "duration=0.1",
     {"joints.0.stops=[-0.001,0.001],[-0.002,0.002]", "joints.0.motor.velocity=0.0,0.1",
      "joints.0.motor.force=0.01,1.0", "springs.0.stiffness=1,2", "springs.0.damping=0.1,0.2",
      "torques.0.amplitude=5,10", "torques.0.constant=0,1", "torques.0.frequency=1,2", "torques.0.phase=0,1"},
     {"ode.erp=0.2,0.5"}},
    {"cart_pole", "joints.0.stops=[-0.001,0.001]", {"joints.0.stop_restitution=0.5,0.8"}, {}},
    {"cart_pole", "springs.0.stiffness=1.0", {"springs.0.rest=0,0.1"}, {}},
    {"cart_pole", "torques.0.times=[0.0,1.0]", {"torques.0.values=[0,1],[0,2]"}, {}},
    {"cart_pole", "torques.0.values=[0.0,1.0]", {"torques.0.times=[0,1],[0,2]"}, {}},
    {"acrobot",
     "duration=0.1",
     {"controllers.0.kp=60,50", "controllers.0.kd=8,7", "controllers.0.target=0,0.1", "controllers.0.amplitude=1,2",
      "controllers.0.frequency=0.35,0.4", "controllers.0.phase=0,1", "controllers.0.sampling=\"step\",\"continuous\""},
     {"ode.erp=0.2,0.5"}},
    {"acrobot", "controllers.0.times=[0.0,1.0]", {"controllers.0.values=[0,1],[0,2]"}, {}},
    {"acrobot", "controllers.0.values=[0.0,1.0]", {"controllers.0.times=[0,1],[0,2]"}, {}},
    // Another step is another controller, also where the rows stand at the same times.
    {"acrobot", "sample=0.01", {"step=0.001,0.002"}, {}},
    // ERP is another spring at another step, also where the rows stand at the same times.
    {"open_hinge", "sample=0.01", {"step=0.001,0.002"}, {}},
};

/// No scenario that is shipped has [[planes]] or [[bodies.shapes]]: a ball that is about to strike a floor that slides
/// beneath it, one that falls beside it, and one that swings with what is fastened to it.
constexpr const char* dropped_file = R"(
problem = "mechanism"
duration = 0.12
step = 0.001
[[bodies]]
name = "ball"
shape = "sphere"
mass = 1.0
size = [0.2, 0.2, 0.2]
position = [0.0, 0.0, 0.15]
velocity = [1.0, 0.0, 0.0]
[[bodies]]
name = "other"
shape = "sphere"
mass = 1.0
size = [0.2, 0.2, 0.2]
position = [0.0, 1.0, 0.14]
[[bodies]]
name = "bob"
shape = "sphere"
mass = 1.0
size = [0.2, 0.2, 0.2]
position = [0.5, 2.0, 3.0]
inertia = [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]
[[bodies.shapes]]
mass = 0.5
size = [0.1, 0.2, 0.1]
position = [0.1, 0.0, 0.0]
[[joints]]
name = "pivot"
kind = "hinge"
parent = "world"
child = "bob"
anchor = [0.0, 2.0, 3.0]
axis = [0.0, 1.0, 0.0]
[[planes]]
name = "floor"
[[contacts]]
between = ["ball", "floor"]
restitution = 0.5
[ode]
cfm = 1e-5
)";

const std::vector<Case> cases_of_contacts{
    {"",
     "",
     {"planes.0.normal=[0,0,1],[0.1,0,1]", "planes.0.point=[0,0,0],[0,0,0.01]",
      "contacts.0.between=[\"ball\",\"floor\"],[\"other\",\"floor\"]", "contacts.0.restitution=0.5,0.8",
      "contacts.0.friction=0.1,0.2", "bodies.2.centre=[0,0,0],[0,0,0.1]", "bodies.2.shapes.0.mass=0.5,0.6",
      "bodies.2.shapes.0.size=[0.1,0.2,0.1],[0.1,0.2,0.2]", "bodies.2.shapes.0.position=[0.1,0,0],[0.2,0,0]",
      "bodies.2.shapes.0.turn=[0,0,0],[0.5,0,0]"},
     {},
     {"ode.erp=0.2,0.5", "limit=\"springs\",\"numbers\""}},  // of what may need ODE's own limit as its reference
    {"", "bodies.2.shapes.0.size=[0.1,0.1,0.1]", {"bodies.2.shapes.0.shape=\"box\",\"sphere\""}, {}},
    {"", "contacts.0.cfm=1e-6", {}, {}, {"contacts.0.erp=0.2,0.5"}},
    {"", "contacts.0.erp=0.2", {}, {}, {"contacts.0.cfm=1e-6,1e-7"}},
    {"", "contacts.0={between=[\"ball\", \"floor\"], kd=10.0}", {"contacts.0.kp=1e4,2e4"}, {}},
    {"", "contacts.0={between=[\"ball\", \"floor\"], kp=1e4}", {"contacts.0.kd=10.0,20.0"}, {}},
    {"", "", {}, {}, {"bodies.2.shapes.0.name=\"one\",\"two\""}},
    // What rubs has ODE's own limit as its reference, which everything moves.
    {"", "contacts.0.friction=0.1", {"limit=\"springs\",\"numbers\"", "ode.erp=0.2,0.5"}, {}},
};

/// Nor does one load the motions of a joint with several.
constexpr const char* loaded_file = R"(
problem = "mechanism"
duration = 0.12
step = 0.001
[[bodies]]
name = "bob"
mass = 1.0
size = [0.2, 0.2, 0.2]
position = [0.1, 0.0, 1.0]
[[joints]]
name = "it"
kind = "pu"
parent = "world"
child = "bob"
anchor = [0.0, 0.0, 1.0]
axis = [0.0, 0.0, 1.0]
axis2 = [0.0, 1.0, 0.0]
axis3 = [1.0, 0.0, 0.0]
stops2 = [-0.001, 0.001]
stop_restitution2 = 0.5
stops3 = [-0.001, 0.001]
stop_restitution3 = 0.5
[[springs]]
joint = "it"
motion = 2
stiffness = 10.0
rest = 0.1
[[torques]]
joint = "it"
motion = 3
constant = 1.0
[[controllers]]
joint = "it"
motion = 2
kp = 5.0
target = 0.5
)";

const std::vector<Case> cases_of_motions{
    {"",
     "",
     {"joints.0.stops2=[-0.001,0.001],[-0.002,0.002]", "joints.0.stop_restitution2=0.5,0.8",
      "joints.0.stops3=[-0.001,0.001],[-0.002,0.002]", "joints.0.stop_restitution3=0.5,0.8", "springs.0.motion=1,2",
      "torques.0.motion=1,3", "controllers.0.motion=1,2"},
     {"ode.erp=0.2,0.5"}},
};

struct Pair {
  bool shared;  // one reference for both
  bool same;    // their references, each solved for its own run, are equal to the last bit
};

Pair of_grid(const ScenarioFile& file, const Case& one, const char* axis) {
  std::vector<Override> settings;
  const std::string setting = one.settings;
  if (const std::size_t equals = setting.find('='); equals != std::string::npos) {
    settings.push_back({setting.substr(0, equals), setting.substr(equals + 1), "--set"});
  }
  catalogue::GridRuns runs(file, settings, cli::known_names(),
                           sweep::Grid({sweep::parse_axis(axis, [](const std::string&) { return false; }),
                                        {"method", {"ode-step-double"}}}));
  const std::vector<std::uint32_t> groups = runs.groups();
  const auto truth = [&](long run) {
    return catalogue::reference_bytes(catalogue::Evaluator(runs.scenario(run)).reference());
  };
  return {groups[0] == groups[1], truth(0) == truth(1)};
}

/// KEY of KEY=VALUES, without the numbers of links, bodies and shapes.
std::string key_of(const std::string& axis) {
  std::string key = axis.substr(0, axis.find('='));
  for (const char* number : {".0.", ".1.", ".2."}) {
    for (std::size_t at; (at = key.find(number)) != std::string::npos;) key.erase(at, 2);
  }
  return key;
}

/// What a build without Simbody has no reference for.
const std::set<std::string_view> mechanisms{"three_link_arm", "cart_pole", "acrobot", "iftomm_governor"};
const std::set<std::string_view> of_mechanisms{"joints",  "joints.motor2", "joints.motor3", "joints.motor",
                                               "springs", "torques",       "controllers",   "struts",
                                               "planes",  "contacts",      "bodies.shapes"};
const std::set<std::string_view> keys_of_mechanisms{"bodies.inertia", "bodies.centre", "limit"};

void runs_share_the_reference_of_their_motion(const fs::path& dropped) {
  // Names that refer to one another can not be changed alone.
  std::set<std::string> seen{"problem",           "methods",       "bodies.name",   "joints.parent",
                             "joints.child",      "joints.name",   "springs.joint", "torques.joint",
                             "controllers.joint", "struts.parent", "struts.child",  "planes.name"};
  const bool with_trees = reference::mechanism_cvode != nullptr;  // not in a build without Simbody
  const auto check_all = [&](const ScenarioFile& file, const Case& one) {
    const auto check = [&](const char* axis, const std::function<bool(const Pair&)>& right) {
      const Pair pair = of_grid(file, one, axis);
      if (!right(pair)) std::printf("%s --grid %s: shared %d, same %d\n", one.scenario, axis, pair.shared, pair.same);
      CHECK(right(pair));
      seen.insert(key_of(axis));
    };
    for (const char* axis : one.motion) check(axis, [](const Pair& p) { return !p.shared && !p.same; });
    for (const char* axis : one.engine) check(axis, [](const Pair& p) { return p.shared && p.same; });
    for (const char* axis : one.in_vain) check(axis, [](const Pair& p) { return p.same; });
  };
  for (const Case& one : cases) {
    if (with_trees || !mechanisms.contains(one.scenario)) check_all(file_of(one.scenario), one);
  }
  std::ofstream(dropped) << dropped_file;
  for (const Case& one : cases_of_contacts) {
    if (with_trees) check_all(ScenarioFile(dropped), one);
  }
  for (const Case& one : cases_of_motions) {
    if (with_trees) check_all(ScenarioFile("loaded.toml", loaded_file), one);
  }
  for (const KeyRow& row : key_table()) {
    const std::string key = (row.section.empty() ? "" : std::string(row.section) + ".") + std::string(row.name);
    if (row.section == "tolerances" || seen.contains(key)) continue;
    if (!with_trees && (of_mechanisms.contains(row.section) || keys_of_mechanisms.contains(key))) continue;
    std::printf("%s is in no case\n", key.c_str());
    CHECK(seen.contains(key));
  }
}

// The first point and the last have 11 rows each, at other times.
void as_many_rows_are_not_the_same_times() {
  const auto axis = [](const char* text) { return sweep::parse_axis(text, [](const std::string&) { return false; }); };
  const ScenarioFile file = file_of("double_pendulum");
  catalogue::GridRuns runs(
      file, {}, cli::known_names(),
      sweep::Grid({axis("duration=0.1,0.2"), axis("sample=0.01,0.02"), {"method", {"ode-step-double"}}}));
  const std::vector<std::uint32_t> wanted{0, 1, 2, 3};
  CHECK(runs.groups() == wanted);
}

}  // namespace

int main() {
  const test::TemporaryFolder folder;
  const std::string name = folder.path().string();
  every_run_has_its_row(name + "/rows");
  the_header_counts_the_runs(name + "/counts");
  the_front_is_of_runs_that_went_through(name + "/front");
  runs_share_the_reference_of_their_motion(name + "/dropped.toml");
  as_many_rows_are_not_the_same_times();
  return test::verdict();
}
