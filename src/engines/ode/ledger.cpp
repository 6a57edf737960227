#include "engines/ode/ledger.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engines/ode/joint_axis.hpp"

namespace odeval::engine_ode {
namespace {

double place_of(dJointID joint, const JointKind& kind, std::optional<std::size_t> motion) {
  if (motion) return way_of(joint, kind, *motion);
  return std::holds_alternative<HingeJoint>(kind) ? dJointGetHingeAngle(joint) : dJointGetSliderPosition(joint);
}

}  // namespace

Ledger::Ledger(const Scenario& scenario, Scene& scene)
    : mechanism_(scenario.mechanism),
      scene_(scene),
      step_s_(scenario.step_s),
      // A force at its limit went through a product and a quotient with the step, in ODE's own precision.
      tolerance_(16 * std::numeric_limits<dReal>::epsilon()),
      before_(mechanism_.bodies.size()),
      after_(before_.size()),
      mean_(before_.size()) {
  for (std::size_t i = 0; i < mechanism_.bodies.size(); ++i) numbers_[body(i).position] = i;
  for (std::size_t j = 0; j < mechanism_.joints.size(); ++j) {
    const Joint& joint = mechanism_.joints[j];
    for (const AxisDrive& each : joint.drives) {
      driven_.push_back(
          {j, alone(joint, each), !driveable_of(joint.kind)[each.motion].slides, each.motion, each.number});
    }
    if (joint.drives.empty() && joint.driven()) {
      driven_.push_back({j, joint, std::holds_alternative<HingeJoint>(joint.kind)});
    }
    if (std::holds_alternative<Hinge2Joint>(joint.kind)) suspensions_.push_back({j, {}});
  }
}

Ledger::Twist Ledger::twist(std::size_t i) const { return {vector(body(i).velocity), vector(body(i).spin)}; }

Vec3 Ledger::arm(std::size_t i, const Vec3& point) const { return point - vector(body(i).position); }

/// A unit force along a line at a point of either body.
Ledger::Row Ledger::pair(std::size_t first, std::optional<std::size_t> second, const std::array<Vec3, 2>& at,
                         const Vec3& along) const {
  Row row{first, second, along, cross(arm(first, at[0]), along), {}};
  if (second) row.turn_second = Vec3{} - cross(arm(*second, at[1]), along);
  return row;
}

// Of a slider between two bodies ODE lets the force act half-way between their centres.
Ledger::Row Ledger::axis_of(const Driven& joint) const {
  const Joint& what = joint.what;
  const dJointID made = scene_.joint(joint.number);
  if (joint.motion) {
    const auto [axis, at] = odeval::engine_ode::axis_of(made, what.kind, *joint.motion);
    if (joint.turns) return {what.first, what.second, {}, axis, Vec3{} - axis};
    return pair(what.first, what.second, {at, at}, axis);
  }
  if (joint.turns) {
    const Vec3 axis = told_by(made, dJointGetHingeAxis);
    return {what.first, what.second, {}, axis, Vec3{} - axis};
  }
  const Vec3 axis = told_by(made, dJointGetSliderAxis);
  const Vec3 centre = vector(body(what.first).position);
  if (!what.second) return pair(what.first, {}, {centre, centre}, axis);
  const Vec3 half_way = 0.5 * (centre + vector(body(*what.second).position));
  return pair(what.first, what.second, {half_way, half_way}, axis);
}

double Ledger::rate(const Row& row, const std::vector<Twist>& twists) const {
  const Twist& first = twists[row.first];
  double rate = dot(row.along, first.velocity) + dot(row.turn_first, first.spin);
  if (!row.second) return rate;
  const Twist& second = twists[*row.second];
  return rate - dot(row.along, second.velocity) + dot(row.turn_second, second.spin);
}

// ODE lets a stop act by the pose before the step (joint.cpp: testRotationalLimit).
void Ledger::see_stop(Driven& joint) {
  const auto& stop = joint.what.stop;
  if (!stop) return;
  const bool was_free = !joint.at_low && !joint.at_high;
  const double place = place_of(scene_.joint(joint.number), joint.what.kind, joint.motion);
  joint.at_low = place <= real(stop->low);
  joint.at_high = !joint.at_low && place >= real(stop->high);
  const double now = rate(joint.row, before_);
  const bool strikes = (joint.at_low && now < 0) || (joint.at_high && now > 0);
  if (was_free && strikes)
    strikes_.push_back({t_, joint.number, joint.in_file, joint.at_low, now, std::numeric_limits<double>::quiet_NaN()});
}

void Ledger::before_step(double t) {
  t_ = t;
  for (std::size_t i = 0; i < before_.size(); ++i) before_[i] = twist(i);
  std::size_t next = 0;
  for (Driven& joint : driven_) {
    joint.row = axis_of(joint);
    if (joint.turns) {
      const dJointID made = scene_.joint(joint.number);
      const Vec3 anchor = joint.motion ? odeval::engine_ode::axis_of(made, joint.what.kind, *joint.motion).at
                                       : told_by(made, dJointGetHingeAnchor);
      joint.lever = arm(joint.what.first, anchor);
    }
    if (joint.what.loaded()) joint.loads = scene_.loads().by_kind(next++, t);
    see_stop(joint);
  }
  struts_.clear();
  scene_.loads().each_strut([&](std::size_t number, const std::array<Vec3, 2>& at, const Vec3& along, double pull) {
    const Strut& strut = mechanism_.struts[number];
    struts_.push_back({pair(strut.first, strut.second, at, along), pull});
  });
  for (auto& [number, row] : suspensions_) {
    const Joint& joint = mechanism_.joints[number];
    const dJointID made = scene_.joint(number);
    row = pair(joint.first, joint.second, {told_by(made, dJointGetHinge2Anchor), told_by(made, dJointGetHinge2Anchor2)},
               told_by(made, dJointGetHinge2Axis1));
  }
}

/// What a joint gives along the axis of a motion: its rows that hold have nothing there.
double Ledger::feedback_along(const Driven& joint) const {
  const dJointFeedback& told = scene_.feedback(joint.number);
  const Vec3 force = vector(told.f1);
  if (!joint.turns) return dot(joint.row.along, force);
  return dot(joint.row.turn_first, vector(told.t1) - cross(joint.lever, force));
}

// A motor that presses on while its stop acts does so beside ODE's equations, with all it has (joint.cpp: addLimot).
void Ledger::drive(Driven& joint) {
  const Joint& what = joint.what;
  const std::optional<Motor>& motor = what.motor;
  const double mean = step_s_ * rate(joint.row, mean_);
  const double told = feedback_along(joint);
  const bool stopped = joint.at_low || joint.at_high;
  const bool driven = motor && motor->most > 0 && !(stopped && what.stop->low == what.stop->high);
  joint.total = told;
  // Axes that cross stand square but for ODE's error: of what acts about one a little is told about the other.
  double push = stopped || (joint.motion && !motor) ? 0 : told;
  if (stopped) {
    of(works_, Work::stops) += told * mean;
    const bool forwards = driven && (motor->speed > 0 || (motor->speed == 0 && joint.at_high));
    if (driven) push = forwards ? motor->most : -motor->most;
    joint.total += push;
  }
  of(works_, Work::motors) += push * mean;
  if (driven && std::fabs(push) >= motor->most * (1 - tolerance_)) {
    ++joint.at_limit;
    if (!joint.first_s) joint.first_s = t_;
  }
  for (std::size_t kind = 0; kind < works_.size(); ++kind) {
    joint.total += joint.loads[kind];
    if (kind != static_cast<std::size_t>(Work::springs)) works_[kind] += joint.loads[kind] * mean;
  }
  for (auto strike = strikes_.rbegin(); strike != strikes_.rend() && strike->t == t_; ++strike) {
    if (strike->joint == joint.number && strike->motion == joint.in_file) strike->rate_after = rate(joint.row, after_);
  }
}

/// A suspension is a spring by the pose after the step and a damper (ODE's manual, equations 3.6 and 3.7).
void Ledger::suspend(std::size_t number, double mean_of_step, double told) {
  const auto& wheel = std::get<Hinge2Joint>(mechanism_.joints[number].kind);
  const dJointID made = scene_.joint(number);
  const double way = dot(told_by(made, dJointGetHinge2Axis1),
                         told_by(made, dJointGetHinge2Anchor2) - told_by(made, dJointGetHinge2Anchor));
  of(works_, Work::dampers) += (told - wheel.stiffness * way) * mean_of_step;
}

void Ledger::touch() {
  for (const Touch& touch : scene_.touches()) {
    const dJointFeedback& told = touch.feedback;
    const auto work = [&](dBodyID touched, const dReal* force, const dReal* torque) {
      if (touched == nullptr) return;
      const Twist& mean = mean_[numbers_.at(dBodyGetPosition(touched))];
      of(works_, Work::contacts) += step_s_ * (dot(vector(force), mean.velocity) + dot(vector(torque), mean.spin));
    };
    work(touch.first, told.f1, told.t1);
    work(touch.second, told.f2, told.t2);
  }
}

void Ledger::after_step() {
  for (std::size_t i = 0; i < before_.size(); ++i) {
    after_[i] = twist(i);
    mean_[i] = {0.5 * (before_[i].velocity + after_[i].velocity), 0.5 * (before_[i].spin + after_[i].spin)};
  }
  for (Driven& joint : driven_) drive(joint);
  for (const Damper& strut : struts_) of(works_, Work::dampers) += strut.force * step_s_ * rate(strut.row, mean_);
  for (const auto& [number, row] : suspensions_) {
    suspend(number, step_s_ * rate(row, mean_), dot(row.along, vector(scene_.feedback(number).f1)));
  }
  touch();
  ++steps_;
}

double Ledger::elastic_energy(std::span<const BodyState> bodies) {
  double energy = ways_->elastic_energy(bodies);
  std::size_t next = 0;
  for (const Driven& joint : driven_) {
    if (joint.what.loaded()) energy += odeval::elastic_energy(joint.what, scene_.loads().way_of(next++));
  }
  return energy;
}

void Ledger::record(Sample sample) {
  if (!ways_) {
    scene_.keep_touches();
    ways_.emplace(mechanism_, sample.bodies);
    elastic_at_start_ = elastic_energy(sample.bodies);
  }
  of(works_, Work::springs) = elastic_at_start_ - elastic_energy(sample.bodies);
  std::copy(works_.begin(), works_.end(), sample.works.begin());
  record_loads(sample);
}

void Ledger::record_loads(Sample sample) const {
  for (const Driven& joint : driven_) sample.joints[joint.number].load = joint.total;
}

void Ledger::tell(Outcome& outcome) const {
  outcome.strikes = strikes_;
  for (const Driven& joint : driven_) {
    if (!joint.what.motor || steps_ == 0) continue;
    const double share = static_cast<double>(joint.at_limit) / static_cast<double>(steps_);
    outcome.motors.push_back({joint.number, share, joint.first_s, joint.in_file});
  }
}

}  // namespace odeval::engine_ode
