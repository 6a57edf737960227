// What every method promises on every scenario it does: the same columns, finite numbers, times on the grid, the
// start it was given, the same result twice.
#include "catalogue/paths.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "output/trace_csv.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

std::string header_of(const Trace& trace) {
  const std::string csv = trace_csv(trace);
  return csv.substr(0, csv.find('\n'));
}

std::string wanted_header(std::size_t links, bool joint_coordinates) {
  std::string header = "t";
  const auto each = [&](const std::string& name) {
    for (std::size_t i = 1; i <= links; ++i) header += "," + name + std::to_string(i);
  };
  each("q");
  each("qd");
  header += ",kinetic,potential,energy,energy_drift,gap,out_of_plane";
  each("error_q");
  header += ",contacts,condition,manipulability";
  if (joint_coordinates) return header;
  for (std::size_t i = 1; i <= links; ++i) {
    const std::string link = std::to_string(i);
    for (const char* name : {"x", "y", "z"}) header += "," + std::string(name) + link;
    for (const char* entry : {"11", "12", "13", "21", "22", "23", "31", "32", "33"}) header += ",r" + link + entry;
    for (const char* name : {"vx", "vy", "vz", "wx", "wy", "wz", "fx", "fy", "fz"}) {
      header += "," + std::string(name) + link;
    }
  }
  return header;
}

// Row 0 shows the first step's force; one sampled sparsely, the same one.
void check_first_force(const Trace& sparse) {
  for (const BodyColumns& body : sparse.bodies) {
    CHECK(body.joint_force[2][0] != 0);
    CHECK_NEAR(body.joint_force[2][0], body.joint_force[2][1], 5);  // 10 ms later
  }
}

void check_contract(const Scenario& scenario, const catalogue::Method& method) {
  catalogue::Evaluator evaluator(scenario);
  const auto run = evaluator.evaluate(method);
  std::printf("%s %s\n", scenario.name.c_str(), std::string(method.name).c_str());

  const PlanarView& view = *scenario.planar;
  const SampleShape shape = evaluator.make(method)->shape();
  CHECK_EQUAL(shape.coordinates, shape.bodies == 0 ? view.links.size() : 0);
  CHECK_EQUAL(shape.joints, shape.bodies);  // a link, a hinge
  CHECK_EQUAL(header_of(run.trace), wanted_header(view.links.size(), shape.coordinates > 0));
  CHECK_EQUAL(run.trace.rows(), std::size_t{101});
  CHECK(!run.outcome.diverged);
  CHECK(run.outcome.steps > 0);
  const CsvColumns table = parse_csv(trace_csv(run.trace), "trace");
  for (const Column& column : table.columns) {
    for (const double value : column) CHECK(std::isfinite(value));
  }
  for (std::size_t k = 0; k < run.trace.rows(); ++k) {
    CHECK_EQUAL(run.trace.t[k], static_cast<double>(10 * k) * 1e-3);
  }
  // The start, to the rounding of the engine's own numbers: 1e-7 in single precision, seen through two angles.
  const bool single = method.name.ends_with("single");
  for (std::size_t i = 0; i < view.links.size(); ++i) {
    CHECK_NEAR(run.trace.q[i][0], view.q0[i], single ? 1e-6 : 1e-14);
    CHECK_NEAR(run.trace.qd[i][0], view.qd0[i], single ? 1e-6 : 1e-14);
  }
  // Whatever the method, this second is followed to a tenth of a radian and a tenth of the energy. But MuJoCo's
  // contacts are springs, which hold a link of 3.8 rad/s for up to pi times 20 ms, and its energy with it.
  const Metrics metrics = evaluator.measure(run, 1.0);
  const bool springs = view.wall && method.name.starts_with("mujoco");
  CHECK(metrics[quantity::max_error_q].value() < (springs ? 0.5 : 0.1));
  const bool keeps_energy = !view.wall || view.wall->restitution == 1;
  if (keeps_energy && !springs) CHECK(*metrics[quantity::max_energy_drift] < 1.0);
  CHECK(metrics[quantity::max_gap].value() <
        (method.name == "maximal-euler" ? 4e-3 : 1e-3));  // explicit Euler opens its joints: 2.9 mm

  const auto again = catalogue::Evaluator(scenario).evaluate(method);
  CHECK(trace_csv(run.trace) == trace_csv(again.trace));
  if (!run.trace.bodies.empty()) check_first_force(run.trace);
}

/// Columns of any run of bodies, by their names where columns have them.
std::vector<std::string> wanted_of_bodies(const Scenario& scenario) {
  const Mechanism& mechanism = scenario.mechanism;
  std::vector<std::string> wanted{"contacts"};
  for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
    const std::string& name = mechanism.bodies[i].name;
    for (const std::string column : {"error_position", "error_turn", "x"}) {
      wanted.push_back(scenario.named ? name + "." + column : column + std::to_string(i + 1));
    }
  }
  const bool joints = !mechanism.joints.empty();
  if (joints) wanted.push_back("gap");
  if (!mechanism.obstacles.empty()) {
    wanted.push_back("penetration");
  } else if (!joints) {
    wanted.push_back("angular_momentum_drift");
  }
  return wanted;
}

// Bodies as their scenario file has them, for its first tenth.
void check_bodies(Scenario scenario, const catalogue::Method& method) {
  scenario.duration_s /= 10;
  const auto run = catalogue::Evaluator(scenario).evaluate(method);
  std::printf("%s %s\n", scenario.name.c_str(), std::string(method.name).c_str());

  const std::string header = header_of(run.trace) + ",";
  CHECK(header.starts_with("t,kinetic,potential,energy,energy_drift,"));
  for (const std::string& column : wanted_of_bodies(scenario)) CHECK(header.find("," + column + ",") != header.npos);
  CHECK(!run.outcome.diverged);
  CHECK(run.outcome.steps > 0);
  const std::vector<Body>& bodies = scenario.mechanism.bodies;
  CHECK_EQUAL(run.trace.bodies.size(), bodies.size());
  for (const Column& column : parse_csv(trace_csv(run.trace), "trace").columns) {
    for (const double value : column) CHECK(std::isfinite(value));
  }
  const double exact = method.name.ends_with("single") ? 1e-6 : 1e-14;
  const auto& column = run.trace.bodies[0];
  const auto changes = [](const Column& values) { return values.back() != values.front(); };
  CHECK(std::ranges::any_of(column.position, changes) || changes(column.rotation[0]));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    CHECK_NEAR(run.trace.error_position[i][0], 0, exact);
    CHECK_NEAR(run.trace.error_turn[i][0], 0, exact);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK_NEAR(run.trace.bodies[i].position[k][0], bodies[i].position_m[k], exact);
    }
  }
  const auto again = catalogue::Evaluator(scenario).evaluate(method);
  CHECK(trace_csv(run.trace) == trace_csv(again.trace));
}

// Rows are a choice of what to keep, not of what happens: those that two samplings share are equal, turns included.
void check_sampling(const char* name) {
  if (!test::in_this_build(name)) return;
  Scenario scenario = test::report_scenario("double_pendulum", 10.0, 1e-3);
  const auto every = catalogue::Evaluator(scenario).evaluate(catalogue::find_method(name));
  scenario.sample_s = 1.0;
  const auto sparse = catalogue::Evaluator(scenario).evaluate(catalogue::find_method(name));
  CHECK_EQUAL(sparse.trace.rows(), std::size_t{11});
  for (std::size_t k = 0; k < sparse.trace.rows(); ++k) {
    for (std::size_t i = 0; i < 2; ++i) CHECK_EQUAL(sparse.trace.q[i][k], every.trace.q[i][1000 * k]);
  }
  for (std::size_t d = 0; d < 3; ++d) {
    CHECK_EQUAL(sparse.trace.bodies[1].joint_force[d][0], every.trace.bodies[1].joint_force[d][0]);
    CHECK_EQUAL(every.trace.bodies[1].joint_force[d][0], every.trace.bodies[1].joint_force[d][1]);
  }
}

// The seed is the scenario's: another one gives QuickStep another order of its rows, and other last digits.
void check_seed() {
  Scenario scenario = test::report_scenario("double_pendulum", 1.0, 1e-3);
  const auto run = [&] {
    return trace_csv(catalogue::Evaluator(scenario).evaluate(catalogue::find_method("ode-quickstep-double")).trace);
  };
  const std::string zero = run();
  scenario.ode.seed = 1;
  const std::string one = run();
  CHECK(zero != one);
  scenario.ode.seed = 0;
  CHECK(run() == zero);
}

}  // namespace

int main() {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  for (const std::string& name : scenario_names(catalogue::scenario_folder())) {
    const Scenario scenario = read_scenario(find_scenario(name, catalogue::scenario_folder()), {}, names);
    if (scenario.planar || !test::has_reference(scenario)) continue;
    for (const std::string& method : scenario.methods) {
      if (test::in_this_build(method)) check_bodies(scenario, catalogue::find_method(method));
    }
    for (const catalogue::Method& method : catalogue::methods()) {  // the engines beside ODE
      if (method.tells && method.make != nullptr && catalogue::does(method, scenario)) check_bodies(scenario, method);
    }
  }
  for (const Problem& problem : test::planar_problems()) {
    Scenario scenario = test::report_scenario(problem.name, 1.0, 1e-3);
    scenario.sample_s = 1e-2;
    for (const catalogue::Method& method : catalogue::methods()) {
      if (method.make != nullptr && catalogue::does(method, scenario)) check_contract(scenario, method);
    }
  }
  check_sampling("ode-step-double");
  check_sampling("ode-quickstep-single");
  check_sampling("maximal-ode-step");
  check_sampling("mujoco-rk4");
  check_sampling("bullet-hinge-double");
  check_sampling("simbody-merson");
  check_seed();
  return test::verdict();
}
