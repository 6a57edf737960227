// Energy from velocities of the middles of the steps, on motions that are known exactly.
#include "measure/centred_energy.hpp"

#include "tests/check.hpp"
#include "tests/scenarios.hpp"

using namespace odeval;

namespace {

constexpr double step_s = 1e-3;
constexpr double g = 9.81;

/// A body that falls along -z and spins up about the plane's axis, its velocities half a step older than its positions.
Trace falling(const Scenario& scenario, double spin_up) {
  const Vec3 axis = scenario.planar->frame.axis();
  const Link& link = scenario.planar->links.front();
  Trace trace;
  trace.bodies.resize(1);
  BodyColumns& body = trace.bodies.front();
  for (int k = 0; k <= 100; ++k) {
    const double t = k * step_s;
    const double stored = k == 0 ? -step_s / 2 : t - step_s / 2;
    trace.t.push_back(t);
    trace.potential.push_back(-link.mass_kg * g * g * t * t / 2);
    const double v = -g * stored;
    const double w = spin_up * stored;
    trace.kinetic.push_back((link.mass_kg * v * v + link.inertia_kgm2() * w * w) / 2);
    for (std::size_t d = 0; d < 3; ++d) {
      body.velocity[d].push_back(d == 2 ? v : 0);
      body.spin[d].push_back(axis[d] * w);
    }
  }
  return trace;
}

// Without spin the fall keeps its energy. The stored velocities of t - h/2 lose m g^2 (t h - h^2/4) / 2 of it.
void check_fall() {
  const Scenario scenario = test::report_scenario("single_pendulum", 1.0, step_s);
  const Trace trace = falling(scenario, 0);
  const Column drift = centred_energy_drift(scenario, trace);
  CHECK_EQUAL(drift.size(), trace.rows() - 1);
  const double start = g * g * step_s * step_s / 8;  // the energy that the stored velocity of row 0 has
  for (std::size_t k = 0; k < drift.size(); ++k) CHECK_NEAR(drift[k], -start, 1e-15);
  CHECK_NEAR(trace.kinetic[90] + trace.potential[90], -g * g * (0.09 * step_s - step_s * step_s / 4) / 2, 1e-15);
}

void check_spin() {
  const Scenario scenario = test::report_scenario("single_pendulum", 1.0, step_s);
  const double spin_up = 7;
  const Column kinetic = centred_kinetic(scenario, falling(scenario, spin_up));
  const double inertia = (1.0 + 0.1 * 0.1) / 12;  // of the report's link about its centre, kg m²
  const double t = 0.05;
  CHECK_NEAR(kinetic[50], (g * g * t * t + inertia * spin_up * spin_up * t * t) / 2, 1e-15);
}

}  // namespace

int main() {
  check_fall();
  check_spin();
  return test::verdict();
}
