#include "measure/body_trace.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "measure/body_columns.hpp"

namespace odeval {
namespace {

Vec3 vec(const double* p) { return {p[0], p[1], p[2]}; }

/// Angular momentum about the centre, in the world, and the energy of the rotation.
struct Turning {
  Vec3 momentum{};
  double energy = 0;
};

Turning turning(const Vec3& moments, const BodyState& body) {
  Turning turning;
  const Vec3 spin = vec(body.spin);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vec3 direction{body.rotation[axis], body.rotation[3 + axis], body.rotation[6 + axis]};
    const double rate = dot(spin, direction);
    turning.energy += moments[axis] * rate * rate / 2;
    for (std::size_t k = 0; k < 3; ++k) turning.momentum[k] += moments[axis] * rate * direction[k];
  }
  return turning;
}

/// How far a body reaches into the ground; < 0: above it.
double overlap(const Body& what, const BodyState& body, const Vec3& normal) {
  double reach = what.size_m[0] / 2;
  if (what.shape == Shape::box) {
    reach = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Vec3 direction{body.rotation[axis], body.rotation[3 + axis], body.rotation[6 + axis]};
      reach += what.size_m[axis] / 2 * std::fabs(dot(direction, normal));
    }
  }
  return reach - dot(normal, vec(body.position));
}

double distance(const Vec3& a, const Vec3& b) {
  const Vec3 between{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return std::sqrt(dot(between, between));
}

template <std::size_t N>
double squared_difference(const std::array<Column, N>& a, const std::array<Column, N>& b, std::size_t row) {
  double sum = 0;
  for (std::size_t i = 0; i < N; ++i) sum += (a[i][row] - b[i][row]) * (a[i][row] - b[i][row]);
  return sum;
}

}  // namespace

Trace body_trace(const Scenario& scenario, const SampleGrid& grid, const Rows& rows) {
  const std::size_t count = scenario.bodies.size();
  const bool torque_free = !scenario.ground;
  Trace trace;
  resize_bodies(trace, count, rows.count());
  for (Column* column : {&trace.t, &trace.kinetic, &trace.potential, &trace.contacts}) column->resize(rows.count());
  (torque_free ? trace.angular_momentum_drift : trace.penetration).resize(rows.count());
  trace.long_axis_spin.assign(count, Column(rows.count()));

  std::vector<Vec3> start(count);
  for (std::size_t k = 0; k < rows.count(); ++k) {
    trace.t[k] = grid.time(static_cast<long>(k));
    for (std::size_t i = 0; i < count; ++i) {
      const Body& what = scenario.bodies[i];
      BodyState body;
      std::memcpy(&body, rows.row(k) + i * body_numbers, sizeof body);
      const Vec3 velocity = vec(body.velocity);
      const Turning turned = turning(what.inertia_kgm2(), body);
      trace.kinetic[k] += what.mass_kg * dot(velocity, velocity) / 2 + turned.energy;
      trace.potential[k] += what.mass_kg * scenario.gravity * body.position[2];
      if (k == 0) start[i] = turned.momentum;
      if (torque_free) trace.angular_momentum_drift[k] += distance(turned.momentum, start[i]);
      trace.long_axis_spin[i][k] = spin_along(body, what.long_axis());
      if (!torque_free) {
        trace.penetration[k] = std::fmax(trace.penetration[k], overlap(what, body, scenario.ground->normal()));
      }
      store_body(trace.bodies[i], k, body);
    }
    trace.contacts[k] = rows.row(k)[count * body_numbers];
  }
  return trace;
}

// Two attitudes an angle a apart differ by |R - R'|_F = sqrt(8) sin(a / 2).
void compare_bodies(Trace& trace, const Reference& reference) {
  const std::size_t count = trace.bodies.size();
  trace.error_position.assign(count, Column(trace.rows()));
  trace.error_turn.assign(count, Column(trace.rows()));
  for (std::size_t i = 0; i < count; ++i) {
    const BodyColumns& body = trace.bodies[i];
    const BodyColumns& wanted = reference.trace.bodies[i];
    for (std::size_t k = 0; k < trace.rows(); ++k) {
      trace.error_position[i][k] = std::sqrt(squared_difference(body.position, wanted.position, k));
      const double sine = std::sqrt(squared_difference(body.rotation, wanted.rotation, k) / 8);
      trace.error_turn[i][k] = 2 * std::asin(std::fmin(sine, 1.0));
    }
  }
}

}  // namespace odeval
