#include "measure/body_trace.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "measure/body_columns.hpp"
#include "measure/greater.hpp"
#include "measure/unwrap.hpp"
#include "odeval/ways.hpp"

namespace odeval {
namespace {

/// Angular momentum about the centre, in the world, and the energy of the rotation.
struct Turning {
  Vec3 momentum{};
  double energy = 0;
};

Turning turning(const std::array<double, 9>& inertia, const BodyState& body) {
  const Vec3 spin{spin_along(body, 0), spin_along(body, 1), spin_along(body, 2)};
  const Vec3 momentum = turned(inertia, spin);
  return {turned(body.rotation, momentum), dot(spin, momentum) / 2};
}

/// The same of a body whose own axes are principal ones.
Turning turning(const Vec3& moments, const BodyState& body) {
  Turning turning;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vec3 direction = axis_of(body.rotation, axis);
    const double rate = dot(body.spin, direction);
    turning.energy += moments[axis] * rate * rate / 2;
    for (std::size_t k = 0; k < 3; ++k) turning.momentum[k] += moments[axis] * rate * direction[k];
  }
  return turning;
}

Turning turning(const Body& what, const BodyState& body) {
  return what.inertia_kgm2 ? turning(*what.inertia_kgm2, body) : turning(what.uniform_moments_kgm2(), body);
}

/// How far a shape reaches from its centre along a direction.
struct Reach {
  const Rotation& rotation;
  const Vec3& normal;

  double operator()(const Sphere& ball) const { return ball.diameter_m / 2; }
  double operator()(const Box& box) const {
    double reach = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      reach += box.sides_m[axis] / 2 * std::fabs(dot(axis_of(rotation, axis), normal));
    }
    return reach;
  }
  double operator()(const Cylinder& bar) const {
    const double along = std::fabs(dot(axis_of(rotation, 2), normal));
    return bar.length_m / 2 * along + bar.diameter_m / 2 * std::sqrt(std::fmax(0, 1 - along * along));
  }
  double operator()(const Capsule& bar) const {
    const double along = std::fabs(dot(axis_of(rotation, 2), normal));
    return bar.diameter_m / 2 + (bar.length_m - bar.diameter_m) / 2 * along;
  }
};

/// A shape of a body and a plane that contacts let it touch.
struct Footing {
  std::size_t body = 0;  // number
  Part part;
  HalfSpace plane;

  /// How deep the shape is in what lies below the plane.
  double overlap(const BodyState& state) const {
    const Frame place = Frame{state.position, state.rotation} * part.place;
    return std::visit(Reach{place.rotation, plane.normal}, part.shape) -
           (dot(plane.normal, place.position_m) - plane.offset_m);
  }
};

std::vector<Footing> footings_of(const Mechanism& mechanism) {
  std::vector<Footing> all;
  for (const Obstacle& obstacle : mechanism.obstacles) {
    const auto* const plane = std::get_if<HalfSpace>(&obstacle.shape);
    if (plane == nullptr) continue;
    for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
      const Body& body = mechanism.bodies[i];
      for (const Part& part : body.parts()) {
        const auto lets = [&](const Contact& contact) {
          return contact.is_between(body.touches_as(part), obstacle.name);
        };
        if (std::ranges::any_of(mechanism.contacts, lets)) all.push_back({i, part, *plane});
      }
    }
  }
  return all;
}

template <std::size_t N>
double squared_difference(const std::array<Column, N>& a, const std::array<Column, N>& b, std::size_t row) {
  double sum = 0;
  for (std::size_t i = 0; i < N; ++i) sum += (a[i][row] - b[i][row]) * (a[i][row] - b[i][row]);
  return sum;
}

/// How far a joint is open, by what lies between its halves and how its first body is turned against t = 0.
struct Gap {
  const Vec3& between;
  const Rotation& now;
  const Rotation& start;

  double operator()(const SliderJoint& slider) const { return across(slider.axis); }
  double operator()(const PistonJoint& piston) const { return across(piston.axis); }
  double operator()(const SlidingHingeJoint& joint) const { return across(joint.axis1); }
  double operator()(const SlidingUniversalJoint& joint) const { return across(joint.way); }
  double operator()(const Hinge2Joint& wheel) const { return across(wheel.axis1); }
  double operator()(const PlaneJoint&) const { return std::fabs(between[2]); }
  double operator()(const BallJoint&) const { return length(between); }
  double operator()(const HingeJoint&) const { return length(between); }
  double operator()(const UniversalJoint&) const { return length(between); }
  double operator()(const FixedJoint&) const { return length(between); }

 private:
  /// Of what lies between, beside an axis that the first body has at t = 0.
  double across(const Vec3& axis_at_start) const {
    const Rotation back{start[0], start[3], start[6], start[1], start[4], start[7], start[2], start[5], start[8]};
    const Vec3 axis = turned(now, turned(back, axis_at_start));
    return length(between - dot(between, axis) * axis);
  }
};

/// A joint's halves: one on the first body; the other on the second, or in the world.
class JointHalves {
 public:
  /// As the bodies stand at t = 0, when the first body's half stands away from the anchor by the opening.
  JointHalves(const Joint& joint, const std::vector<Body>& starts, std::span<const BodyState> bodies)
      : joint_(joint), anchor_(anchor_m(joint.kind)), start_(bodies[joint.first].rotation) {
    arms_[0] = in_body(anchor_ - starts[joint.first].position_m + joint.opening_m, bodies[joint.first]);
    if (joint.second) arms_[1] = in_body(anchor_ - starts[*joint.second].position_m, bodies[*joint.second]);
  }

  double gap(std::span<const BodyState> bodies) const {
    const Vec3 other = joint_.second ? half(1, bodies[*joint_.second]) : anchor_;
    const BodyState& first = bodies[joint_.first];
    return std::visit(Gap{half(0, first) - other, first.rotation, start_}, joint_.kind);
  }

 private:
  static Vec3 in_body(const Vec3& arm, const BodyState& body) {
    return {dot(arm, axis_of(body.rotation, 0)), dot(arm, axis_of(body.rotation, 1)),
            dot(arm, axis_of(body.rotation, 2))};
  }
  Vec3 half(std::size_t which, const BodyState& body) const {
    return body.position + turned(body.rotation, arms_[which]);
  }

  Joint joint_;
  Vec3 anchor_;
  std::array<Vec3, 2> arms_{};  // body frame
  Rotation start_;              // of the first body
};

/// Fills the columns of a trace, one sample after the other.
class BodyReader {
 public:
  BodyReader(const Scenario& scenario, Trace& trace, std::size_t rows, std::size_t works)
      : scenario_(scenario),
        mechanism_(scenario.mechanism),
        trace_(trace),
        force_of_(scenario.mechanism),
        footings_(footings_of(scenario.mechanism)),
        torque_free_(scenario.mechanism.contacts.empty() && scenario.mechanism.joints.empty()),
        start_(mechanism_.bodies.size()) {
    resize_bodies(trace, mechanism_.bodies.size(), rows);
    for (Column* column : {&trace.t, &trace.kinetic, &trace.potential, &trace.contacts}) column->resize(rows);
    if (torque_free_) trace.angular_momentum_drift.resize(rows);
    if (!footings_.empty()) trace.penetration.resize(rows);
    if (!mechanism_.joints.empty()) trace.gap.resize(rows);
    trace.long_axis_spin.assign(mechanism_.bodies.size(), Column(rows));
    trace.works.assign(works, Column(rows));
  }

  void read(std::size_t k, const ConstSample& sample) {
    for (std::size_t i = 0; i < mechanism_.bodies.size(); ++i) read_body(k, i, sample);
    for (const Footing& footing : footings_) {
      trace_.penetration[k] = greater(trace_.penetration[k], footing.overlap(sample.bodies[footing.body]));
    }
    if (!mechanism_.joints.empty()) trace_.gap[k] = largest_gap(sample.bodies);
    for (std::size_t i = 0; i < trace_.works.size(); ++i) trace_.works[i][k] = sample.works[i];
    trace_.contacts[k] = sample.contacts;
  }

 private:
  void read_body(std::size_t k, std::size_t i, const ConstSample& sample) {
    const Body& what = mechanism_.bodies[i];
    const BodyState& body = sample.bodies[i];
    const Turning turned = turning(what, body);
    trace_.kinetic[k] += what.mass_kg * dot(body.velocity, body.velocity) / 2 + turned.energy;
    trace_.potential[k] += what.mass_kg * scenario_.gravity * body.position[2];
    if (k == 0) start_[i] = turned.momentum;
    if (torque_free_) trace_.angular_momentum_drift[k] += distance(turned.momentum, start_[i]);
    trace_.long_axis_spin[i][k] = spin_along(body, what.long_axis());
    store_body(trace_.bodies[i], k, body, force_of_(i, sample.joints));
  }

  double largest_gap(std::span<const BodyState> bodies) {
    if (halves_.empty()) {
      for (const Joint& joint : mechanism_.joints) halves_.emplace_back(joint, mechanism_.bodies, bodies);
    }
    double largest = 0;
    for (const JointHalves& halves : halves_) largest = greater(halves.gap(bodies), largest);
    return largest;
  }

  const Scenario& scenario_;
  const Mechanism& mechanism_;
  Trace& trace_;
  ForcesOfBodies force_of_;
  std::vector<Footing> footings_;
  bool torque_free_;
  std::vector<Vec3> start_;  // angular momenta
  std::vector<JointHalves> halves_;
};

/// The change of the energy that no work accounts for.
void close_books(Trace& trace) {
  if (trace.works.empty()) return;
  trace.unaccounted.resize(trace.rows());
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    double left = trace.kinetic[k] + trace.potential[k] - (trace.kinetic[0] + trace.potential[0]);
    for (const Column& work : trace.works) left -= work[k];
    trace.unaccounted[k] = left;
  }
}

/// What drives joints along their ways, of those that have one.
void add_loads(Trace& trace, const Mechanism& mechanism, const Motion& motion) {
  if (motion.shape().works == 0) return;
  for (std::size_t j = 0; j < trace.joints.size(); ++j) {
    if (trace.joints[j].q.empty()) continue;
    const double sign = sign_in_files(mechanism.joints[j]);
    for (std::size_t k = 0; k < trace.rows(); ++k) {
      trace.joints[j].load.push_back(sign * motion[k].joints[j].load + 0.0);  // a zero has no sign
    }
  }
}

BodyState state_of(const BodyColumns& body, std::size_t row) {
  BodyState state;
  for (std::size_t d = 0; d < 3; ++d) {
    state.position[d] = body.position[d][row];
    state.velocity[d] = body.velocity[d][row];
    state.spin[d] = body.spin[d][row];
  }
  for (std::size_t d = 0; d < 9; ++d) state.rotation[d] = body.rotation[d][row];
  return state;
}

/// Of each joint with one motion: where it stands at t = 0, from as the file draws it.
std::vector<double> starts_in_file(const Scenario& scenario) {
  const auto closed = std::ranges::find(scenario.definition, "closed_at_start.q", &Definition::value_type::first);
  if (closed != scenario.definition.end()) return std::get<std::vector<double>>(closed->second);
  std::vector<double> starts(scenario.mechanism.joints.size());
  for (std::size_t j = 0; j < starts.size(); ++j) {
    const std::string key = "joints." + std::to_string(j) + ".q";
    const auto said = std::ranges::find(scenario.definition, key, &Definition::value_type::first);
    if (said == scenario.definition.end()) continue;
    if (const double* const q = std::get_if<double>(&said->second)) starts[j] = *q;
  }
  return starts;
}

/// The next of a joint's rows. An angle goes on from the one before, and from there by the mean of both rates.
void append_way(JointColumns& columns, const Column& t, Way way, bool turns) {
  if (turns && !columns.q.empty()) {
    const std::size_t k = columns.q.size();
    way.q = unwrap(way.q, columns.q.back() + (t[k] - t[k - 1]) * (columns.qd.back() + way.rate) / 2);
  }
  columns.q.push_back(way.q);
  columns.qd.push_back(way.rate);
}

}  // namespace

void add_joint_columns(const Scenario& scenario, Trace& trace) {
  if (!scenario.named || trace.rows() == 0) return;
  const Mechanism& mechanism = scenario.mechanism;
  for (const Body& body : mechanism.bodies) trace.body_names.push_back(body.name);
  for (const Joint& joint : mechanism.joints) trace.joint_names.push_back(joint.name);
  trace.joints.assign(mechanism.joints.size(), {});
  std::vector<BodyState> bodies(trace.bodies.size());
  std::optional<WayReader> ways;
  std::vector<JointHalves> halves;
  const std::vector<double> starts = starts_in_file(scenario);
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i] = state_of(trace.bodies[i], k);
    if (!ways) {
      ways.emplace(mechanism, bodies);
      for (const Joint& joint : mechanism.joints) halves.emplace_back(joint, mechanism.bodies, bodies);
    }
    for (std::size_t j = 0; j < trace.joints.size(); ++j) {
      const Joint& joint = mechanism.joints[j];
      trace.joints[j].gap.push_back(halves[j].gap(bodies));
      if (!has_one_way(joint.kind)) continue;
      const Way way = ways->joint(j, bodies);
      const double sign = sign_in_files(joint);
      append_way(trace.joints[j], trace.t, {sign * way.q + starts[j] + 0.0, sign * way.rate + 0.0},
                 std::holds_alternative<HingeJoint>(joint.kind));
    }
  }
}

Trace body_trace(const Scenario& scenario, const SampleGrid& grid, const Motion& motion) {
  Trace trace;
  BodyReader reader(scenario, trace, motion.size(), motion.shape().works);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    trace.t[k] = grid.time(static_cast<long>(k));
    reader.read(k, motion[k]);
  }
  close_books(trace);
  add_joint_columns(scenario, trace);
  add_loads(trace, scenario.mechanism, motion);
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
  if (reference.trace.joints.size() != trace.joints.size()) return;
  for (std::size_t j = 0; j < trace.joints.size(); ++j) {
    JointColumns& columns = trace.joints[j];
    columns.error_q.resize(columns.q.size());
    for (std::size_t k = 0; k < columns.q.size(); ++k) {
      columns.error_q[k] = columns.q[k] - reference.trace.joints[j].q[k];
    }
  }
}

}  // namespace odeval
