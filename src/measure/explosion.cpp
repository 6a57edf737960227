#include "measure/explosion.hpp"

#include <algorithm>
#include <cmath>

namespace odeval {
namespace {

constexpr double most_times = 100;  // the energy that can be there

Vec3 at(const std::array<Column, 3>& columns, std::size_t row) {
  return {columns[0][row], columns[1][row], columns[2][row]};
}

/// Of a body's own frame, at a row.
Vec3 spin_in_body(const BodyColumns& body, std::size_t row) {
  Vec3 spin{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < 3; ++k) spin[axis] += body.rotation[3 * k + axis][row] * body.spin[k][row];
  }
  return spin;
}

double kinetic_energy(const Mechanism& mechanism, const std::vector<BodyColumns>& bodies, std::size_t row) {
  double energy = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& what = mechanism.bodies[i];
    const Vec3 velocity = at(bodies[i].velocity, row);
    const Vec3 spin = spin_in_body(bodies[i], row);
    const Vec3 moments = what.uniform_moments_kgm2();
    const Vec3 momentum = what.inertia_kgm2 ? turned(*what.inertia_kgm2, spin)
                                            : Vec3{moments[0] * spin[0], moments[1] * spin[1], moments[2] * spin[2]};
    energy += (what.mass_kg * dot(velocity, velocity) + dot(spin, momentum)) / 2;
  }
  return energy;
}

bool outruns(const Mechanism& mechanism, const std::vector<BodyColumns>& bodies, std::size_t row, double step_s) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double side = std::ranges::max(sides_m(mechanism.bodies[i].shape));
    if (!(length(at(bodies[i].velocity, row)) * step_s <= side)) return true;
    if (!(length(at(bodies[i].spin, row)) * step_s <= 1)) return true;
  }
  return false;
}

}  // namespace

std::optional<std::size_t> explosion(const Scenario& scenario, const SampleGrid& grid, const Trace& trace,
                                     const Reference& reference) {
  const Mechanism& mechanism = scenario.mechanism;
  const Trace& wanted = reference.trace;
  if (wanted.bodies.empty() || trace.bodies.size() != wanted.bodies.size()) return std::nullopt;
  double most = 0;
  for (std::size_t k = 0; k < wanted.rows(); ++k) {
    most = std::fmax(most, kinetic_energy(mechanism, wanted.bodies, k));
  }
  const double fallen_m_s = scenario.gravity * grid.time(grid.rows - 1);
  for (const Body& body : mechanism.bodies) most += body.mass_kg * fallen_m_s * fallen_m_s / 2;
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    if (outruns(mechanism, trace.bodies, k, grid.step_s) &&
        !(kinetic_energy(mechanism, trace.bodies, k) <= most_times * most)) {
      return k;
    }
  }
  return std::nullopt;
}

}  // namespace odeval
