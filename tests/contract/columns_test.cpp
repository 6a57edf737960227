// The columns of a trace, in every family of scenarios, against the same numbers got another way: from one another and
// from the laws they obey.
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "tests/results.hpp"

namespace {

using namespace odeval;
using namespace odeval::test;

constexpr double infinity = std::numeric_limits<double>::infinity();

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

void check_columns(const Results& results) {
  const Table table(results.csv);
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
}

}  // namespace

int main() {
  check_all(check_columns);
  return verdict();
}
