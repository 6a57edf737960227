// What the files of results say, in every family of scenarios, against the same numbers got another way: columns of a
// trace from one another and from the laws they obey, metrics from the columns, the tables from METHOD.json. And odeval
// compare tells of any one of them that is changed.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "catalogue/paths.hpp"
#include "catalogue/summaries.hpp"
#include "measure/metrics.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "output/comparison.hpp"
#include "output/file.hpp"
#include "output/number.hpp"
#include "output/trace_csv.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using nlohmann::json;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A trace as its file has it.
class Table {
 public:
  explicit Table(const std::string& text) : csv_(parse_csv(text, "trace")) {}

  std::size_t rows() const { return csv_.columns[0].size(); }
  bool has(const std::string& name) const { return std::ranges::find(csv_.header, name) != csv_.header.end(); }
  const Column& operator[](const std::string& name) const {
    const auto found = std::ranges::find(csv_.header, name);
    if (found == csv_.header.end()) throw std::runtime_error("no column " + name);
    return csv_.columns[static_cast<std::size_t>(found - csv_.header.begin())];
  }
  Vec3 vector(const std::string& letter, const std::string& body, std::size_t row) const {
    return {(*this)[letter + "x" + body][row], (*this)[letter + "y" + body][row], (*this)[letter + "z" + body][row]};
  }
  /// Where an axis of the body points.
  Vec3 axis(const std::string& body, std::size_t axis, std::size_t row) const {
    const std::string column = std::to_string(axis + 1);
    return {(*this)["r" + body + "1" + column][row], (*this)["r" + body + "2" + column][row],
            (*this)["r" + body + "3" + column][row]};
  }

 private:
  CsvColumns csv_;
};

struct Results {
  Scenario scenario;
  const catalogue::Method* method;
  Reference reference;
  std::string csv;
  std::string summary;
  std::string table;  // summary.csv, with this method alone
};

Results results_of(const char* name, const std::vector<Override>& settings, const char* method) {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  const Scenario scenario = read_scenario(find_scenario(name, catalogue::scenario_folder()), settings, names);
  catalogue::Evaluator evaluator(scenario);
  const auto run = evaluator.evaluate(catalogue::find_method(method));
  const RunSummary summary = catalogue::summarise(run, evaluator);
  return {
      scenario, run.method, evaluator.reference(), trace_csv(run.trace), summary_json(summary), summary_csv({summary})};
}

std::string number(std::size_t i) { return std::to_string(i + 1); }

// Columns ---------------------------------------------------------------------------------------------------------

/// Largest difference of a column from what it should be, in parts of the column's largest value or of 1.
double off(const Table& table, const std::string& column, const std::function<double(std::size_t)>& wanted) {
  double worst = 0;
  double size = 1;
  for (std::size_t k = 0; k < table.rows(); ++k) {
    worst = std::fmax(worst, std::fabs(table[column][k] - wanted(k)));
    size = std::fmax(size, std::fabs(table[column][k]));
    if (std::isnan(table[column][k])) return infinity;
  }
  return worst / size;
}

// Sums of some products of doubles; of numbers that differ by a few roundings where they were made.
constexpr double rounding = 1e-13;

double largest_step(const Column& column) {
  double most = 0;
  for (std::size_t k = 1; k < column.size(); ++k) most = std::fmax(most, std::fabs(column[k] - column[k - 1]));
  return most;
}

/// A rate is the mean of the differences before and behind, but for at most what the rate itself changes by in a row.
void check_rate(const Column& value, const Column& rate, double spacing, double most) {
  double worst = 0;
  for (std::size_t k = 1; k + 1 < value.size(); ++k) {
    worst = std::fmax(worst, std::fabs((value[k + 1] - value[k - 1]) / (2 * spacing) - rate[k]));
  }
  CHECK_BETWEEN(worst, 0, 1.001 * most + 1e-9);  // 1e-9: positions of 10 m, good to 1e-15, over 2 ms and less
}

void energies_add_up(const Table& table) {
  CHECK_EQUAL(off(table, "energy", [&](std::size_t k) { return table["kinetic"][k] + table["potential"][k]; }), 0.0);
  CHECK_EQUAL(off(table, "energy_drift", [&](std::size_t k) { return table["energy"][k] - table["energy"][0]; }), 0.0);
}

void check_times(const Results& results, const Table& table) {
  CHECK_EQUAL(off(table, "t", [&](std::size_t k) { return static_cast<double>(k) * results.scenario.step_s; }), 0.0);
}

/// What a body's columns say of its kinetic energy.
double kinetic(const Table& table, std::size_t i, double mass, const Vec3& moments, std::size_t k) {
  const Vec3 v = table.vector("v", number(i), k);
  const Vec3 w = table.vector("w", number(i), k);
  double energy = mass * dot(v, v) / 2;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    energy += moments[axis] * std::pow(dot(w, table.axis(number(i), axis, k)), 2) / 2;
  }
  return energy;
}

/// Velocities are the rates of positions, spins those of attitudes, attitudes are rotations.
void bodies_move(const Results& results, const Table& table, std::size_t bodies) {
  const double h = results.scenario.step_s;
  for (std::size_t i = 0; i < bodies; ++i) {
    double spin = 0, spin_step = 0;
    for (const char* d : {"x", "y", "z"}) {
      const Column& velocity = table[std::string("v") + d + number(i)];
      check_rate(table[d + number(i)], velocity, h, largest_step(velocity));
      for (const double w : table[std::string("w") + d + number(i)]) spin = std::fmax(spin, std::fabs(w));
      spin_step += largest_step(table[std::string("w") + d + number(i)]);
    }
    for (std::size_t a = 0; a < 3; ++a) {
      std::array<Column, 3> rate;
      double skew = 0;
      for (std::size_t k = 0; k < table.rows(); ++k) {
        const Vec3 axis = table.axis(number(i), a, k);
        const Vec3 turning = cross(table.vector("w", number(i), k), axis);
        for (std::size_t d = 0; d < 3; ++d) rate[d].push_back(turning[d]);
        skew = std::fmax(skew, std::fabs(dot(axis, axis) - 1));
        const Vec3 third = cross(axis, table.axis(number(i), (a + 1) % 3, k));
        skew = std::fmax(skew, length(third - table.axis(number(i), (a + 2) % 3, k)));
      }
      CHECK_NEAR(skew, 0, rounding);
      for (std::size_t d = 0; d < 3; ++d) {
        // Of w x axis both may change.
        check_rate(table["r" + number(i) + number(d) + number(a)], rate[d], h, spin_step + 3 * h * spin * spin);
      }
    }
  }
}

/// Of a pendulum in a pose at some rates of its angles: energies, and how its end moves in the plane.
struct Swing {
  double kinetic = 0, potential = 0;
  double y_rate = 0, z_rate = 0, spin = 0;
};

Swing swing(const Scenario& s, const std::vector<double>& q, const std::vector<double>& qd) {
  Swing end;
  double a = 0, z = 0;
  for (std::size_t i = 0; i < s.planar->links.size(); ++i) {
    const Link& link = s.planar->links[i];
    a += q[i];
    end.spin += qd[i];
    const double c = link.centre_m(), w = end.spin;
    const double y_here = end.y_rate - c * w * std::sin(a), z_here = end.z_rate + c * w * std::cos(a);
    end.kinetic += (link.mass_kg * (y_here * y_here + z_here * z_here) + link.inertia_kgm2() * w * w) / 2;
    end.potential += link.mass_kg * s.gravity * (z + c * std::sin(a));
    end.y_rate -= link.length_m * w * std::sin(a);
    end.z_rate += link.length_m * w * std::cos(a);
    z += link.length_m * std::sin(a);
  }
  return end;
}

/// Of a pendulum in generalized coordinates everything follows from angles and rates.
void angles_make_a_pendulum(const Results& results, const Table& table) {
  const Scenario& s = results.scenario;
  const std::size_t n = s.planar->links.size();
  const auto each = [&](const char* column, std::size_t k) {
    std::vector<double> values;
    for (std::size_t i = 0; i < n; ++i) values.push_back(table[column + number(i)][k]);
    return values;
  };
  const auto now = [&](std::size_t k) { return swing(s, each("q", k), each("qd", k)); };
  CHECK_NEAR(off(table, "kinetic", [&](std::size_t k) { return now(k).kinetic; }), 0, rounding);
  CHECK_NEAR(off(table, "potential", [&](std::size_t k) { return now(k).potential; }), 0, rounding);
  if (n != 2) return;
  // The mass matrix from the energies of unit rates, and J^T J from what they make of the end: both 2 x 2.
  const auto unit = [&](std::size_t k, double one, double other) { return swing(s, each("q", k), {one, other}); };
  const auto condition = [&](std::size_t k) {
    const double a = 2 * unit(k, 1, 0).kinetic, d = 2 * unit(k, 0, 1).kinetic;
    const double b = unit(k, 1, 1).kinetic - (a + d) / 2;
    const double norm = std::fmax(a + std::fabs(b), d + std::fabs(b));  // of the inverse: the same over a d - b^2
    return norm * norm / (a * d - b * b);
  };
  const auto manipulability = [&](std::size_t k) {
    const Swing first = unit(k, 1, 0), second = unit(k, 0, 1);
    const auto product = [](const Swing& u, const Swing& v) {
      return u.y_rate * v.y_rate + u.z_rate * v.z_rate + u.spin * v.spin;
    };
    const double mean = (product(first, first) + product(second, second)) / 2;
    const double apart = std::hypot((product(first, first) - product(second, second)) / 2, product(first, second));
    return (mean - apart) / (mean + apart);
  };
  CHECK_NEAR(off(table, "condition", condition), 0, 1e-11);  // a difference of products that loses two digits
  CHECK_NEAR(off(table, "manipulability", manipulability), 0, rounding);
  CHECK_EQUAL(off(table, "gap", [](std::size_t) { return 0; }), 0.0);
  CHECK_EQUAL(off(table, "out_of_plane", [](std::size_t) { return 0; }), 0.0);
}

Vec3 moments_of(const Scenario& s, const Link& link) {
  const PlanarFrame& frame = s.planar->frame;
  Vec3 moments;
  const Vec3 across_plane = cross(frame.along_body, frame.across_body);
  for (std::size_t a = 0; a < 3; ++a) {
    moments[a] = std::fabs(frame.along_body[a]) * link.inertia_along_kgm2() +
                 std::fabs(frame.across_body[a]) * link.inertia_across_kgm2() +
                 std::fabs(across_plane[a]) * link.inertia_kgm2();
  }
  return moments;
}

/// Newton's law over the step to a row, N: what mass times acceleration, as ODE steps it, lacks of the weight and the
/// other forces on a body.
double missing_force(const Results& results, const Table& table, std::size_t i, double mass, const Vec3& force,
                     std::size_t k) {
  const Vec3 gained = table.vector("v", number(i), k) - table.vector("v", number(i), k - 1);
  const Vec3 all = force + (-mass * results.scenario.gravity) * Vec3{0, 0, 1};
  return length(all + (-mass / results.scenario.step_s) * gained);
}

// Velocities of 10 m/s, good to 1e-15, over 1 ms, of a few kg.
constexpr double newton_N = 1e-9;

/// Of a pendulum of bodies everything follows from the bodies' columns.
void bodies_make_a_pendulum(const Results& results, const Table& table) {
  const Scenario& s = results.scenario;
  const PlanarFrame& frame = s.planar->frame;
  const std::size_t n = s.planar->links.size();
  bodies_move(results, table, n);
  const auto along = [&](std::size_t i, std::size_t k) {
    Vec3 direction{};
    for (std::size_t a = 0; a < 3; ++a) direction = direction + frame.along_body[a] * table.axis(number(i), a, k);
    return direction;
  };
  const auto angle = [&](std::size_t i, std::size_t k) {
    return std::atan2(dot(along(i, k), frame.up), dot(along(i, k), frame.horizontal));
  };
  const auto spin = [&](std::size_t i, std::size_t k) { return dot(table.vector("w", number(i), k), frame.axis()); };
  double worst_angle = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < table.rows(); ++k) {
      const double relative = angle(i, k) - (i == 0 ? 0 : angle(i - 1, k));
      worst_angle =
          std::fmax(worst_angle, std::fabs(std::remainder(table["q" + number(i)][k] - relative, 2 * std::numbers::pi)));
    }
    CHECK_NEAR(off(table, "qd" + number(i), [&](std::size_t k) { return spin(i, k) - (i == 0 ? 0 : spin(i - 1, k)); }),
               0, rounding);
  }
  CHECK_NEAR(worst_angle, 0, rounding);

  const auto sum = [&](const auto& of) {
    return [&table, n, of](std::size_t k) {
      double all = 0;
      for (std::size_t i = 0; i < n; ++i) all += of(i, k);
      return all;
    };
  };
  const auto moving = [&](std::size_t i, std::size_t k) {
    return kinetic(table, i, s.planar->links[i].mass_kg, moments_of(s, s.planar->links[i]), k);
  };
  const auto lifted = [&](std::size_t i, std::size_t k) {
    return s.planar->links[i].mass_kg * s.gravity * (table["z" + number(i)][k] - frame.hinge_m[2]);
  };
  CHECK_NEAR(off(table, "kinetic", sum(moving)), 0, rounding);
  CHECK_NEAR(off(table, "potential", sum(lifted)), 0, rounding);
  const auto gap = [&](std::size_t k) {
    Vec3 anchor = frame.hinge_m;
    double widest = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 centre = table.vector("", number(i), k);
      widest = std::fmax(widest, length((centre + -s.planar->links[i].centre_m() * along(i, k)) - anchor));
      anchor = centre + s.planar->links[i].beyond_centre_m() * along(i, k);
    }
    return widest;
  };
  const auto beside = [&](std::size_t k) {
    double most = 0;
    for (std::size_t i = 0; i < n; ++i) {
      most = std::fmax(most, std::fabs(dot(table.vector("", number(i), k) - frame.hinge_m, frame.axis())));
    }
    return most;
  };
  CHECK_NEAR(off(table, "gap", gap), 0, rounding);
  CHECK_NEAR(off(table, "out_of_plane", beside), 0, rounding);

  if (!results.method->name.starts_with("ode-step")) return;
  double worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 1; k < table.rows(); ++k) {
      if (table["contacts"][k] > 0) continue;
      Vec3 force = table.vector("f", number(i), k);
      if (i + 1 < n) force = force - table.vector("f", number(i + 1), k);
      worst = std::fmax(worst, missing_force(results, table, i, s.planar->links[i].mass_kg, force, k));
    }
  }
  CHECK_NEAR(worst, 0, newton_N);
}

/// Free bodies, bodies on a ground and bodies in a joint.
void bodies_make_their_columns(const Results& results, const Table& table) {
  const Scenario& s = results.scenario;
  const std::size_t n = s.mechanism.bodies.size();
  bodies_move(results, table, n);
  const auto sum = [&](const auto& of) {
    return [&table, n, of](std::size_t k) {
      double all = 0;
      for (std::size_t i = 0; i < n; ++i) all += of(i, k);
      return all;
    };
  };
  const auto moving = [&](std::size_t i, std::size_t k) {
    return kinetic(table, i, s.mechanism.bodies[i].mass_kg, s.mechanism.bodies[i].uniform_moments_kgm2(), k);
  };
  const auto lifted = [&](std::size_t i, std::size_t k) {
    return s.mechanism.bodies[i].mass_kg * s.gravity * table["z" + number(i)][k];
  };
  CHECK_NEAR(off(table, "kinetic", sum(moving)), 0, rounding);
  CHECK_NEAR(off(table, "potential", sum(lifted)), 0, rounding);

  for (std::size_t i = 0; i < n; ++i) {
    const BodyColumns& wanted = results.reference.trace.bodies[i];
    const auto distance = [&](std::size_t k) {
      const Vec3 there{wanted.position[0][k], wanted.position[1][k], wanted.position[2][k]};
      return length(table.vector("", number(i), k) - there);
    };
    CHECK_NEAR(off(table, "error_position" + number(i), distance), 0, rounding);
    // The angle of R R'^T: its skew part has 2 sin of it, its trace 1 + 2 cos. Small ones only to the root of rounding.
    const auto turned = [&](std::size_t k) {
      Vec3 skew{};
      double trace = -1;
      for (std::size_t a = 0; a < 3; ++a) {
        const Vec3 here = table.axis(number(i), a, k);
        const Vec3 there{wanted.rotation[a][k], wanted.rotation[3 + a][k], wanted.rotation[6 + a][k]};
        skew = skew + cross(there, here);
        trace += dot(here, there);
      }
      return std::atan2(length(skew), trace);
    };
    CHECK_NEAR(off(table, "error_turn" + number(i), turned), 0, 1e-7);
  }

  const auto momentum = [&](std::size_t i, std::size_t k) {
    Vec3 all{};
    for (std::size_t a = 0; a < 3; ++a) {
      const Vec3 axis = table.axis(number(i), a, k);
      all = all + (s.mechanism.bodies[i].uniform_moments_kgm2()[a] * dot(table.vector("w", number(i), k), axis)) * axis;
    }
    return all;
  };
  if (s.mechanism.obstacles.empty() && s.mechanism.joints.empty()) {
    const auto drift = [&](std::size_t i, std::size_t k) { return length(momentum(i, k) - momentum(i, 0)); };
    CHECK_NEAR(off(table, "angular_momentum_drift", sum(drift)), 0, rounding);
  }
  if (!s.mechanism.obstacles.empty()) {
    // The lowest of a box's corners, or of a ball.
    const Vec3 up = std::get<HalfSpace>(s.mechanism.obstacles[0].shape).normal;
    const auto depth = [&](std::size_t k) {
      double deepest = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const Shape& shape = s.mechanism.bodies[i].shape;
        const Vec3 size = sides_m(shape);
        const Vec3 centre = table.vector("", number(i), k);
        if (is_sphere(shape)) deepest = std::fmax(deepest, size[0] / 2 - dot(centre, up));
        if (is_sphere(shape)) continue;
        for (int corner = 0; corner < 8; ++corner) {
          Vec3 point = centre;
          for (std::size_t a = 0; a < 3; ++a) {
            point = point + ((corner >> a & 1 ? 0.5 : -0.5) * size[a]) * table.axis(number(i), a, k);
          }
          deepest = std::fmax(deepest, -dot(point, up));
        }
      }
      return deepest;
    };
    CHECK_NEAR(off(table, "penetration", depth), 0, rounding);
  }
  if (!s.mechanism.joints.empty()) {
    // No body turns here: the halves stay where they are beside the centres.
    const auto gap = [&](std::size_t k) {
      const Vec3 moved = table.vector("", "1", k) - table.vector("", "1", 0);
      const Vec3 other = n == 1 ? Vec3{} : (table.vector("", "2", k) - table.vector("", "2", 0));
      return length((moved - other) + s.mechanism.joints[0].opening_m);
    };
    CHECK_NEAR(off(table, "gap", gap), 0, rounding);
    if (!results.method->name.starts_with("ode-")) return;
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 1; k < table.rows(); ++k) {
        worst = std::fmax(
            worst, missing_force(results, table, i, s.mechanism.bodies[i].mass_kg, table.vector("f", number(i), k), k));
      }
    }
    CHECK_NEAR(worst, 0, newton_N);
  }
}

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

// Metrics ---------------------------------------------------------------------------------------------------------

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

// Tables ----------------------------------------------------------------------------------------------------------

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> parts(1);
  for (const char letter : line) {
    if (letter == ',') {
      parts.emplace_back();
    } else {
      parts.back() += letter;
    }
  }
  return parts;
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
      wanted = run["impacts"].size();
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

// Comparison ------------------------------------------------------------------------------------------------------

/// What a comparison says of two folders whose one file differs.
std::string difference(const std::filesystem::path& a, const std::filesystem::path& b) {
  const Comparison comparison = compare_folders(a, b);
  std::string names;
  for (const FileComparison& file : comparison.files) {
    if (file.sameness != Sameness::different) continue;
    for (const Difference& one : file.differences) names += one.metric + " ";
  }
  return names;
}

void visit(const json& part, const std::string& pointer, const std::function<void(const std::string&)>& at) {
  if (!part.is_structured() || part.empty()) return at(pointer);
  for (const auto& item : part.items()) visit(item.value(), pointer + "/" + item.key(), at);
}

/// One value of METHOD.json or one cell of the trace is another: the comparison names it.
void comparison_tells_of_each(const Results& results) {
  std::string folder = (std::filesystem::temp_directory_path() / "odeval-results-test-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return CHECK(false);
  const std::filesystem::path root = folder;
  const std::filesystem::path trace = results.scenario.name + "/m.csv", summary = results.scenario.name + "/m.json";
  for (const char* side : {"a", "b"}) {
    write_whole(root / side / trace, results.csv);
    write_whole(root / side / summary, results.summary);
  }
  CHECK_EQUAL(difference(root / "a", root / "b"), "");

  const json run = json::parse(results.summary);
  std::size_t blind = 0;
  const auto told = [&](const json& other, const std::string& way) {
    write_whole(root / "b" / summary, other.dump());
    return difference(root / "a", root / "b").find(way + " ") != std::string::npos;
  };
  visit(run, "", [&](const std::string& pointer) {
    json other = run;
    json& value = other[json::json_pointer(pointer)];
    const bool real = value.is_number_float();
    const double before = real ? value.get<double>() : 0;
    if (value.is_number()) {
      value = 1.5 * value.get<double>() + 1;
    } else if (value.is_boolean()) {
      value = !value.get<bool>();
    } else {
      value = value.is_null() ? json(1.25) : json("another");
    }
    std::string way = pointer.substr(1);
    std::ranges::replace(way, '/', '.');
    // What made the results is shown and not judged; that the reference is lost follows from its bound.
    const bool judged = !way.starts_with("versions.") && way != "reference" && way != "reference_lost_at";
    if (!judged) ++blind;
    test::report(told(other, way) == judged, __FILE__, __LINE__,
                 way + (judged ? ": a change is not told" : ": is judged, and should only be shown"));
    const bool setting = way.starts_with("settings.");
    if (!real || !judged || (before == 0 && !setting)) return;  // of 0 any uncertainty is more than twice as large
    // By its last bit a setting is another one, and what is measured the same.
    value = std::nextafter(before, infinity);
    test::report(told(other, way) == setting, __FILE__, __LINE__, way + ": by the last bit");
  });
  CHECK_EQUAL(blind, run["versions"].size() + 2);
  write_whole(root / "b" / summary, results.summary);

  const CsvColumns table = parse_csv(results.csv, "trace");
  const std::string header = results.csv.substr(0, results.csv.find('\n') + 1);
  const auto told_of_cell = [&](std::size_t column, double changed) {
    std::string text = header;
    for (std::size_t k = 0; k < table.columns[0].size(); ++k) {
      for (std::size_t c = 0; c < table.header.size(); ++c) {
        text += (c == 0 ? "" : ",") + number_text(c == column && k == 1 ? changed : table.columns[c][k]);
      }
      text += '\n';
    }
    write_whole(root / "b" / trace, text);
    return difference(root / "a", root / "b");
  };
  for (std::size_t column = 0; column < table.header.size(); ++column) {
    const std::string& name = table.header[column];
    const double cell = table.columns[column][1];
    // A millionth: what is measured may differ by a billionth, an angle by what the reference knows of it.
    const std::string names = told_of_cell(column, cell + 1e-6 * std::fmax(1, std::fabs(cell)));
    test::report(names.starts_with(name + " from t = "), __FILE__, __LINE__,
                 name + ": a change is told as '" + names + "'");
    const bool exact = name == "t" || name == "contacts";
    test::report(told_of_cell(column, std::nextafter(cell, infinity)).empty() != exact, __FILE__, __LINE__,
                 name + ": by the last bit");
  }
  std::filesystem::remove_all(root);
}

// -----------------------------------------------------------------------------------------------------------------

Results check_results(const char* name, const std::vector<Override>& settings, const char* method) {
  const Results results = results_of(name, settings, method);
  const int before = test::failures;
  const Table table(results.csv);
  const json run = json::parse(results.summary);
  check_times(results, table);
  energies_add_up(table);
  if (!results.scenario.planar) {
    bodies_make_their_columns(results, table);
  } else {
    for (std::size_t i = 0; i < results.scenario.planar->links.size(); ++i) {
      const Column& rate = table["qd" + number(i)];
      check_rate(table["q" + number(i)], rate, results.scenario.step_s, largest_step(rate));
      const Column& truth = results.reference.trace.q[i];
      CHECK_EQUAL(
          off(table, "error_q" + number(i), [&](std::size_t k) { return table["q" + number(i)][k] - truth[k]; }), 0.0);
    }
    if (table.has("x1")) {
      bodies_make_a_pendulum(results, table);
    } else {
      angles_make_a_pendulum(results, table);
    }
  }
  // No step led to row 0: it shows the force of the first one.
  if (table.has("fx1") && results.method->name.starts_with("ode-"))
    CHECK(table.vector("f", "1", 0) == table.vector("f", "1", 1));
  check_counts(results, table, run);
  check_metrics(results, table, run);
  check_table(results, run);
  if (test::failures > before) std::printf("  of %s, %s\n", name, method);
  return results;
}

}  // namespace

int main() {
  const std::vector<Override> second{{"duration", "1", ""}};
  for (const char* method : {"ode-step-double", "ode-rk4-double", "maximal-rk4", "lagrange-ode45", "lagrange-euler"}) {
    const Results results = check_results("double_pendulum", {{"duration", "2", ""}}, method);
    if (std::string(method) == "ode-step-double") check_time_shift(results);
  }
  check_results("chain", {{"duration", "0.5", ""}, {"n", "5", ""}}, "ode-quickstep-double");
  check_results("chain", {{"duration", "0.5", ""}, {"n", "5", ""}}, "lagrange-rk4");
  check_results("potra_pendulum", second, "ode-step-double");
  check_results("wall_pendulum", second, "lagrange-rk4");
  impacts_are_those_of_the_trace(check_results("wall_pendulum", second, "ode-step-double"));
  check_results("free_box", second, "ode-quickstep-double");
  check_results("free_box", second, "analytic");
  check_results("thin_body", second, "ode-step-double");
  check_results("bouncing_ball", second, "ode-rk4-double");
  impacts_are_those_of_the_trace(check_results("bouncing_ball", second, "ode-step-double"));
  const Results slide = check_results("friction_slide", {}, "ode-step-double");
  CHECK(json::parse(slide.summary)["rest_time"].is_number());  // it stops, and that is measured
  const json slid = json::parse(check_results("friction_slide", {}, "analytic").summary);
  CHECK_NEAR(slid["at_rest_from"].get<double>(), 2 / (0.3 * 9.81), 1e-12);  // v / (mu g)
  // It is slower than 1 mm/s from 1e-3 / (mu g) earlier on, and that shows in the next row.
  CHECK_BETWEEN(slid["at_rest_from"].get<double>() - slid["rest_time"].get<double>(), -1e-3, 1e-3 / (0.3 * 9.81));
  check_time_shift(check_results("spring_joint", second, "ode-step-double"));
  // The law of a rigid joint is ODE's own, its force as well: to 1.5e-7 of 3000 N.
  check_results("open_hinge", {}, "ode-quickstep-double");
  const json hinge = json::parse(check_results("open_hinge", {}, "ode-step-double").summary);
  CHECK_BETWEEN(hinge["max_reaction_error"].get<double>(), 0, 1e-6);

  const Override sparse{"sample", "0.1", ""};
  comparison_tells_of_each(results_of("wall_pendulum", {{"duration", "2", ""}, sparse}, "ode-step-double"));
  comparison_tells_of_each(results_of("bouncing_ball", {{"duration", "2", ""}, sparse}, "ode-step-double"));
  return test::verdict();
}
