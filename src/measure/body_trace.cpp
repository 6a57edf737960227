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

Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// The joint's halves: one on the first body; the other on the second, or in the world.
class JointHalves {
 public:
  explicit JointHalves(const Scenario& scenario) : scenario_(scenario) {}

  /// At t = 0, when the first body's half stands away from the anchor by the displacement.
  void start(std::size_t body, const BodyState& state) {
    if (body > 1) return;
    const Vec3 anchor = scenario_.joint->anchor_m;
    const Vec3 away = minus(anchor, scenario_.bodies[body].position_m);
    const Vec3& shift = scenario_.joint->displacement_m;
    const Vec3 arm = body == 0 ? Vec3{away[0] + shift[0], away[1] + shift[1], away[2] + shift[2]} : away;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      arms_[body][axis] = dot(arm, {state.rotation[axis], state.rotation[3 + axis], state.rotation[6 + axis]});
    }
    halves_[1] = anchor;
  }

  void move(std::size_t body, const BodyState& state) {
    if (body > 1) return;
    for (std::size_t k = 0; k < 3; ++k) {
      halves_[body][k] = state.position[k] + dot(vec(state.rotation + 3 * k), arms_[body]);
    }
  }

  double gap() const { return distance(halves_[0], halves_[1]); }

 private:
  const Scenario& scenario_;
  std::array<Vec3, 2> arms_{};  // body frame
  std::array<Vec3, 2> halves_{};
};

}  // namespace

Trace body_trace(const Scenario& scenario, const SampleGrid& grid, const Rows& rows) {
  const std::size_t count = scenario.bodies.size();
  const bool torque_free = !scenario.ground && !scenario.joint;
  Trace trace;
  resize_bodies(trace, count, rows.count());
  for (Column* column : {&trace.t, &trace.kinetic, &trace.potential, &trace.contacts}) column->resize(rows.count());
  if (torque_free) trace.angular_momentum_drift.resize(rows.count());
  if (scenario.ground) trace.penetration.resize(rows.count());
  if (scenario.joint) trace.gap.resize(rows.count());
  trace.long_axis_spin.assign(count, Column(rows.count()));

  JointHalves halves(scenario);
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
      if (scenario.ground) {
        trace.penetration[k] = std::fmax(trace.penetration[k], overlap(what, body, scenario.ground->normal()));
      }
      store_body(trace.bodies[i], k, body);
      if (!scenario.joint) continue;
      if (k == 0) halves.start(i, body);
      halves.move(i, body);
    }
    if (scenario.joint) trace.gap[k] = halves.gap();
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
