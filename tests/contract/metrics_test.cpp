// What METHOD.json says, in every family of scenarios, against the columns of the trace, and summary.csv against it.
#include <cmath>
#include <limits>
#include <map>

#include "measure/metrics.hpp"
#include "tests/cells.hpp"
#include "tests/results.hpp"

namespace {

using namespace odeval;
using namespace odeval::test;
using nlohmann::json;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Of numbers that differ by a few roundings where they were made.
constexpr double rounding = 1e-13;

/// Every impact of an engine that steps stands in the trace: the row it starts from, and the one behind.
void impacts_are_those_of_the_trace(const Results& results) {
  const Table table(results.csv);
  const json impacts = json::parse(results.summary)["impacts"];
  const Scenario& s = results.scenario;
  const bool ball = !s.planar;
  CHECK(!impacts.empty());
  for (const json& impact : impacts) {
    const auto k = static_cast<std::size_t>(std::lround(impact["t"].get<double>() / s.step_s));
    CHECK_NEAR(impact["t"].get<double>(), table["t"][k], 1e-12);
    CHECK_EQUAL(table["contacts"][k], 0.0);
    CHECK(table["contacts"][k + 1] > 0);
    CHECK_NEAR(impact["q1"].get<double>(), table[ball ? "z1" : "q1"][k], rounding);
    CHECK_NEAR(impact["qd_before"].get<double>(), table[ball ? "vz1" : "qd1"][k], rounding);
    CHECK_NEAR(impact["qd_after"].get<double>(), table[ball ? "vz1" : "qd1"][k + 1], rounding);
    CHECK_NEAR(impact["restitution"].get<double>(),
               -impact["qd_after"].get<double>() / impact["qd_before"].get<double>(), rounding);
    double depth = ball ? table["penetration"][k] : 0;
    for (const double side : {-0.5, 0.5}) {  // the corners at the link's end
      if (ball) continue;
      const Vec3 end = table.vector("", "1", k) + s.planar->links[0].beyond_centre_m() * table.axis("1", 0, k);
      depth = std::fmax(
          depth, s.planar->wall->face_m - (end + (side * s.planar->links[0].width_m) * table.axis("1", 2, k))[0]);
    }
    CHECK(depth > 0);
    CHECK_NEAR(impact["depth"].get<double>(), depth, rounding);
  }
}

/// Steps and evaluations of a method with a fixed step, without a row left out.
void check_counts(const Results& results, const Table& table, const json& run) {
  const auto steps = static_cast<long>(table.rows() - 1);
  if (results.method->order > 0) CHECK_EQUAL(run["steps"].get<long>(), steps);
  if (results.method->name == "lagrange-rk4" && !results.scenario.planar->wall)
    CHECK_EQUAL(run["evaluations"].get<long>(), 4 * steps);
  if (results.method->name == "lagrange-euler") CHECK_EQUAL(run["evaluations"].get<long>(), steps);
  CHECK_EQUAL(run["messages"].get<long>(), 0);
  CHECK(!run["diverged"].get<bool>() && run["reason"].is_null());
  CHECK_EQUAL(run["scenario"].get<std::string>(), results.scenario.name);
  CHECK_EQUAL(run["method"].get<std::string>(), std::string(results.method->name));
  CHECK_EQUAL(run["is_reference"].get<bool>(), results.method->name == "analytic");
  CHECK_EQUAL(run["reference"].get<std::string>(), results.reference.origin);
}

using Value = std::optional<double>;

double largest(const Column& column, std::size_t rows) {
  double most = 0;
  for (std::size_t k = 0; k < rows; ++k) most = std::fmax(most, std::fabs(column[k]));
  return most;
}

Value largest_of(const Table& table, const std::string& column, std::size_t rows) {
  return table.has(column) ? Value(largest(table[column], rows)) : std::nullopt;
}

Value largest_of_each(const Table& table, const std::string& column, std::size_t rows) {
  Value most;
  for (std::size_t i = 0; table.has(column + number(i)); ++i) {
    most = std::fmax(most.value_or(0), largest(table[column + number(i)], rows));
  }
  return most;
}

Value largest_known(const Column& uncertainty, std::size_t rows) {
  return uncertainty.empty() ? std::nullopt : Value(largest(uncertainty, rows));
}

/// How far a body goes from where it is in the row after the last one in which the reference moves.
Value creep_of(const Results& results, const Table& table, std::size_t rows) {
  if (!table.has("penetration")) return std::nullopt;
  std::size_t rests = 0;
  const std::vector<BodyColumns>& wanted = results.reference.trace.bodies;
  for (std::size_t k = 0; k < rows; ++k) {
    for (const BodyColumns& body : wanted) {
      if (length({body.velocity[0][k], body.velocity[1][k], body.velocity[2][k]}) > 1e-3) rests = k + 1;
    }
  }
  if (wanted.empty() || rests == rows) return std::nullopt;
  double most = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    for (std::size_t k = rests; k < rows; ++k) {
      most = std::fmax(most, length(table.vector("", number(i), k) - table.vector("", number(i), rests)));
    }
  }
  return most;
}

/// The farthest that an impact is from one of the same link on the other side, or from the end.
Value impact_error_of(const Results& results, const Table& table, std::size_t rows) {
  const std::vector<Impact>& wanted = results.reference.impacts;
  if (wanted.empty()) return std::nullopt;
  const double end = table["t"][rows - 1];
  using Times = std::vector<std::pair<int, double>>;
  Times ours, theirs;
  const json run = json::parse(results.summary);
  for (const json& impact : run["impacts"]) {
    ours.emplace_back(impact.contains("link") ? impact["link"].get<int>() : 0, impact["t"].get<double>());
  }
  for (const Impact& impact : wanted) theirs.emplace_back(impact.link.value_or(0), impact.t);
  double most = 0;
  for (const auto& [some, others] : {std::pair{ours, theirs}, std::pair{theirs, ours}}) {
    for (const auto& [link, t] : some) {
      double nearest = end - t;
      for (const auto& [other_link, other] : others) {
        if (link == other_link) nearest = std::fmin(nearest, std::fabs(t - other));
      }
      if (t <= end) most = std::fmax(most, nearest);
    }
  }
  return most;
}

Value impact_uncertainty_of(const Reference& reference, double end) {
  if (reference.impacts.empty() || reference.impact_uncertainty_s.empty()) return std::nullopt;
  double most = 0;
  for (std::size_t i = 0; i < reference.impacts.size(); ++i) {
    if (reference.impacts[i].t <= end) most = std::fmax(most, reference.impact_uncertainty_s[i]);
  }
  return most;
}

/// Every metric of the table over the first rows, from the columns of the file and the reference.
std::map<std::string, Value> metrics_of(const Results& results, const Table& table, std::size_t rows) {
  const Scenario& s = results.scenario;
  const Reference& reference = results.reference;
  std::map<std::string, Value> all;
  const auto root_mean_square = [&](const std::string& column) {
    double squares = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; table.has(column + number(i)); ++i) {
      for (std::size_t k = 0; k < rows; ++k, ++count) squares += std::pow(table[column + number(i)][k], 2);
    }
    return count == 0 ? std::nullopt : Value(std::sqrt(squares / static_cast<double>(count)));
  };
  all["max_error_q"] = largest_of_each(table, "error_q", rows);
  all["rms_error_q"] = root_mean_square("error_q");
  all["reference_uncertainty"] = largest_known(reference.uncertainty_q, rows);
  all["divergence_time"] = std::nullopt;
  for (std::size_t k = 0; k < rows && !all["divergence_time"]; ++k) {
    for (std::size_t i = 0; table.has("error_q" + number(i)); ++i) {
      if (std::fabs(table["error_q" + number(i)][k]) > 0.1) all["divergence_time"] = table["t"][k];
    }
  }
  all["max_energy_drift"] = largest(table["energy_drift"], rows);
  double squares = 0;
  for (std::size_t k = 0; k < rows; ++k) squares += std::pow(table["energy_drift"][k], 2);
  all["rms_energy_drift"] = std::sqrt(squares / static_cast<double>(rows));
  all["final_energy_drift"] = table["energy_drift"][rows - 1];
  all["max_gap"] = largest_of(table, "gap", rows);
  all["max_out_of_plane"] = largest_of(table, "out_of_plane", rows);
  all["max_angular_momentum_drift"] = largest_of(table, "angular_momentum_drift", rows);
  all["max_penetration"] = largest_of(table, "penetration", rows);
  all["max_error_position"] = largest_of_each(table, "error_position", rows);
  all["max_error_turn"] = largest_of_each(table, "error_turn", rows);
  all["position_uncertainty"] = largest_known(reference.uncertainty_position, rows);
  all["turn_uncertainty"] = largest_known(reference.uncertainty_turn, rows);
  all["spin_uncertainty"] = largest_known(reference.uncertainty_spin, rows);

  all["max_reaction_error"] = std::nullopt;
  for (std::size_t i = 0; table.has("fx1") && i < reference.joint_force.size(); ++i) {
    Value& most = all["max_reaction_error"];
    for (std::size_t k = 1; k < rows; ++k) {
      if (table["contacts"][k] > 0) continue;
      const auto& wanted = reference.joint_force[i];
      const Vec3 here = table.vector("f", number(i), k);
      most = std::fmax(most.value_or(0), length(here - Vec3{wanted[0][k], wanted[1][k], wanted[2][k]}));
    }
  }

  all["max_long_axis_spin"] = std::nullopt;
  for (std::size_t i = 0; table.has("wx" + number(i)); ++i) {
    Value& most = all["max_long_axis_spin"];
    const bool pendulum = s.planar != nullptr;
    const Vec3& along = s.frame().along_body;
    std::size_t axis = 0;  // along the longest side; of equal ones the last
    for (std::size_t a = 1; a < 3; ++a) {
      if (pendulum ? along[a] != 0
                   : sides_m(s.mechanism.bodies[i].shape)[a] >= sides_m(s.mechanism.bodies[i].shape)[axis])
        axis = a;
    }
    for (std::size_t k = 0; k < rows; ++k) {
      double spin = dot(table.vector("w", number(i), k), table.axis(number(i), axis, k));
      if (!pendulum) {
        const BodyColumns& wanted = reference.trace.bodies[i];
        for (std::size_t d = 0; d < 3; ++d) spin -= wanted.spin[d][k] * wanted.rotation[3 * d + axis][k];
      }
      most = std::fmax(most.value_or(0), std::fabs(spin));
    }
  }

  all["max_unaccounted_energy"] = std::nullopt;
  if (table.has("unaccounted")) {
    double most = 0;
    for (std::size_t k = 0; k < rows; ++k) most = std::fmax(most, std::fabs(table["unaccounted"][k]));
    all["max_unaccounted_energy"] = most;
  }
  all["max_creep"] = creep_of(results, table, rows);
  all["max_impact_error"] = impact_error_of(results, table, rows);
  all["impact_uncertainty"] = impact_uncertainty_of(reference, table["t"][rows - 1]);
  all["rest_time"] = std::nullopt;
  if (!s.planar && !s.mechanism.obstacles.empty()) {
    std::size_t moves = rows;  // the last row in which any does
    for (std::size_t k = 0; k < rows; ++k) {
      for (std::size_t i = 0; i < s.mechanism.bodies.size(); ++i) {
        if (length(table.vector("v", number(i), k)) > 1e-3) moves = k;
      }
    }
    if (moves + 1 < rows) all["rest_time"] = table["t"][moves + 1];
  }
  return all;
}

/// The clock that is ahead: the shift that takes away most of the errors in the sense of least squares, where an error
/// is that of a clock, e = shift * rate. The next terms are smaller by frequency * shift and, in a spring whose error
/// is nearly all amplitude, by 3 % in all.
void check_time_shift(const Results& results) {
  const Table table(results.csv);
  const json run = json::parse(results.summary);
  const Trace& truth = results.reference.trace;
  double mixed = 0, squares = 0;
  const auto add = [&](double error, double rate) {
    mixed += error * rate;
    squares += rate * rate;
  };
  const bool angles = table.has("q1");
  for (std::size_t k = 0; k < table.rows(); ++k) {
    if (angles) {
      for (std::size_t i = 0; i < truth.q.size(); ++i) add(table["error_q" + number(i)][k], truth.qd[i][k]);
    } else {
      for (std::size_t d = 0; d < 3; ++d) {
        const BodyColumns& body = truth.bodies[0];
        add(table.vector("", "1", k)[d] - body.position[d][k], body.velocity[d][k]);
      }
    }
  }
  const double shift = mixed / squares;
  CHECK_NEAR(run["time_shift"].get<double>(), shift, 0.05 * std::fabs(shift));
  CHECK(run["time_shift_uncertainty"].get<double>() > 0);
  double left = 0;
  for (std::size_t k = 0; k < table.rows(); ++k) {
    for (std::size_t i = 0; angles && i < truth.q.size(); ++i) {
      left = std::fmax(left, std::fabs(table["error_q" + number(i)][k] - shift * truth.qd[i][k]));
    }
    for (std::size_t d = 0; !angles && d < 3; ++d) {
      const BodyColumns& body = truth.bodies[0];
      const double error = table.vector("", "1", k)[d] - body.position[d][k];
      left = std::fmax(left, std::fabs(error - shift * body.velocity[d][k]));
    }
  }
  const double error = run[angles ? "max_error_q" : "max_error_position"].get<double>();
  CHECK_NEAR(run[angles ? "error_q_after_shift" : "error_position_after_shift"].get<double>(), left, 0.02 * error);
}

Value value_of(const json& number) {
  if (number.is_null()) return std::nullopt;
  if (number.is_string()) return number == "inf" ? infinity : -infinity;
  return number.get<double>();
}

void check_metrics(const Results& results, const Table& table, const json& run) {
  const auto same = [&](const json& shown, const Value& wanted, const std::string& name) {
    const Value value = value_of(shown);
    const bool both = value && wanted && std::fabs(*value - *wanted) <= 1e-12 * std::fmax(1e-3, std::fabs(*wanted));
    test::report(both || (!value && !wanted), __FILE__, __LINE__,
                 results.scenario.name + ", " + std::string(results.method->name) + ": " + name + " is " +
                     shown.dump() + ", from the columns " + (wanted ? test::shown(*wanted) : "nothing"));
  };
  const auto whole = metrics_of(results, table, table.rows());
  for (const Quantity& row : quantities) {
    const std::string name(row.name);
    if (name.starts_with("time_shift") || name.ends_with("_after_shift")) continue;
    CHECK(whole.contains(name));
    same(run.at(name), whole.at(name), name);
  }
  std::vector<std::string> times, reached;
  for (const auto& [time, at] : run["error_at"].items()) times.push_back(time);
  for (const char* time : {"1", "2", "3", "5", "10"}) {
    if (std::stod(time) <= table["t"].back()) reached.emplace_back(time);
  }
  CHECK(times == reached);
  for (const auto& [time, at] : run["error_at"].items()) {
    const auto rows = static_cast<std::size_t>(std::lround(std::stod(time) / results.scenario.step_s)) + 1;
    const auto until = metrics_of(results, table, rows);
    for (const auto& [name, value] : at.items()) {
      if (until.contains(name)) same(value, until.at(name), "error_at." + time + "." + name);
    }
    CHECK(at.contains(table.has("q1") ? "max_error_q" : "max_error_position"));
  }
}

/// Every cell of summary.csv is what METHOD.json says under that name.
void check_table(const Results& results, const json& run) {
  const std::size_t end = results.table.find('\n');
  const auto names = cells(results.table.substr(0, end));
  const auto values = cells(results.table.substr(end + 1, results.table.size() - end - 2));
  CHECK_EQUAL(values.size(), names.size());
  for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i) {
    json wanted;
    const std::size_t at = names[i].find("_at_");
    if (names[i] == "impacts") {
      if (run["impacts"].is_array()) wanted = run["impacts"].size();
    } else if (names[i] == "step" || names[i] == "duration") {
      wanted = run["settings"][names[i]];
    } else if (at != std::string::npos) {
      const std::string time = names[i].substr(at + 4);
      if (run["error_at"].contains(time)) wanted = run["error_at"][time].value(names[i].substr(0, at), json());
    } else {
      wanted = run.at(names[i]);
    }
    const bool same = wanted.is_null() ? values[i].empty()
                      : wanted.is_number()
                          ? std::stod(values[i]) == wanted.get<double>()
                          : values[i] == (wanted.is_string() ? wanted.get<std::string>() : wanted.dump());
    test::report(same, __FILE__, __LINE__,
                 results.scenario.name + ": " + names[i] + " is '" + values[i] + "' in summary.csv and " +
                     wanted.dump() + " in METHOD.json");
  }
}

void check_summary(const Results& results) {
  const Table table(results.csv);
  const json run = json::parse(results.summary);
  check_counts(results, table, run);
  check_metrics(results, table, run);
  check_table(results, run);
}

void check_known_values() {
  const auto summary = [](const char* scenario, const char* method) {
    return json::parse(results_of(scenario, {}, method).summary);
  };
  CHECK(summary("friction_slide", "ode-step-double")["rest_time"].is_number());  // it stops, and that is measured
  const json slid = summary("friction_slide", "analytic");
  CHECK_NEAR(slid["at_rest_from"].get<double>(), 2 / (0.3 * 9.81), 1e-12);  // v / (mu g)
  // It is slower than 1 mm/s from 1e-3 / (mu g) earlier on, and that shows in the next row.
  CHECK_BETWEEN(slid["at_rest_from"].get<double>() - slid["rest_time"].get<double>(), -1e-3, 1e-3 / (0.3 * 9.81));
  // It creeps on while the true one rests: ODE's contacts hold it by a spring of ERP and CFM.
  CHECK_BETWEEN(summary("friction_slide", "ode-step-double")["max_creep"].get<double>(), 1e-9, 1e-3);
  CHECK_NEAR(slid["max_creep"].get<double>(), 0, 1e-5);  // from 1 mm/s to rest: v^2 / (2 mu g)
  // An impact stands at the step that saw the overlap: within a step of the true one.
  CHECK_BETWEEN(summary("wall_pendulum", "ode-step-double")["max_impact_error"].get<double>(), 1e-6, 1e-3);
  CHECK(summary("double_pendulum", "ode-step-double")["max_impact_error"].is_null());
  // The law of a rigid joint is ODE's own, its force as well: to 1.5e-7 of 3000 N.
  CHECK_BETWEEN(summary("open_hinge", "ode-step-double")["max_reaction_error"].get<double>(), 0, 1e-6);
}

}  // namespace

int main() {
  check_all(check_summary);
  const std::vector<Override> second{{"duration", "1", ""}};
  check_time_shift(results_of("double_pendulum", {{"duration", "2", ""}}, "ode-step-double"));
  check_time_shift(results_of("spring_joint", second, "ode-step-double"));
  impacts_are_those_of_the_trace(results_of("wall_pendulum", second, "ode-step-double"));
  impacts_are_those_of_the_trace(results_of("bouncing_ball", second, "ode-step-double"));
  check_known_values();
  return verdict();
}
