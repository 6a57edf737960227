#include "reference/tree/tree_ledger.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace odeval::reference {
namespace {

/// Gauss's nodes and weights on -1..1, of eight: the positive ones (Abramowitz and Stegun, table 25.4).
constexpr std::array<std::array<double, 2>, 4> gauss{{{0.1834346424956498049, 0.3626837833783619830},
                                                      {0.5255324099163289858, 0.3137066458778872873},
                                                      {0.7966664774136267396, 0.2223810344533744706},
                                                      {0.9602898564975362317, 0.1012285362903762592}}};

std::vector<BodyState> bodies_at(const TreeEquations& equations, const Mechanism& mechanism, const double* y) {
  std::vector<BodyState> bodies(mechanism.bodies.size());
  equations.show(y, bodies);
  return bodies;
}

bool damps(const Mechanism& mechanism) {
  const auto wheel = [](const Joint& joint) {
    const auto* const hinge2 = std::get_if<Hinge2Joint>(&joint.kind);
    return hinge2 != nullptr && hinge2->damping > 0;
  };
  return std::ranges::any_of(mechanism.struts, [](const Strut& strut) { return strut.damping_Ns_m > 0; }) ||
         std::ranges::any_of(mechanism.joints, wheel);
}

/// Turns by its moments, or its tensor.
double turning_energy(const Body& what, const BodyState& body) {
  Vec3 spin{};
  for (std::size_t k = 0; k < 3; ++k) spin[k] = dot(body.spin, axis_of(body.rotation, k));
  if (what.inertia_kgm2) return dot(spin, turned(*what.inertia_kgm2, spin)) / 2;
  const Vec3 moments = what.uniform_moments_kgm2();
  return (moments[0] * spin[0] * spin[0] + moments[1] * spin[1] * spin[1] + moments[2] * spin[2] * spin[2]) / 2;
}

}  // namespace

std::vector<StopStrike> strikes_at(const TreeEquations& equations, const TreeMotion::Change& change) {
  std::vector<StopStrike> strikes;
  for (const TreeEquations::Axis& axis : equations.axes()) {
    if (!axis.joint.stop) continue;
    const double before = axis.rate(change.before.data());
    const double after = axis.rate(change.after.data());
    const double q = axis.q(change.after.data());
    const bool low = q - axis.joint.stop->low <= TreeEquations::at_end && before < 0;
    const bool high = axis.joint.stop->high - q <= TreeEquations::at_end && before > 0;
    if ((low || high) && before != after) strikes.push_back({change.t, axis.number, axis.in_file, low, before, after});
  }
  return strikes;
}

TreeLedger::TreeLedger(const TreeEquations& equations, const Mechanism& mechanism)
    : equations_(equations),
      mechanism_(mechanism),
      struts_(damps(mechanism)),
      bodies_(bodies_at(equations, mechanism, equations.start().data())),
      ways_(mechanism, bodies_),
      elastic_at_start_(elastic(equations.start().data())),
      uses_(equations.axes().size()) {}

double TreeLedger::elastic(const double* y) {
  equations_.show(y, bodies_);
  double energy = ways_.elastic_energy(bodies_);
  for (const TreeEquations::Axis& axis : equations_.axes()) energy += elastic_energy(axis.joint, axis.q(y));
  return energy;
}

double TreeLedger::kinetic(const State& y) {
  equations_.show(y.data(), bodies_);
  double energy = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& what = mechanism_.bodies[i];
    energy += what.mass_kg * dot(bodies_[i].velocity, bodies_[i].velocity) / 2 + turning_energy(what, bodies_[i]);
  }
  return energy;
}

/// Of motors and stops, along their axes.
std::vector<double> TreeLedger::drives(double t, const double* y, const Grips& grips) const {
  std::vector<double> forces(grips.size());
  const bool any = std::ranges::any_of(grips, &Grip::holds);
  if (any) forces = equations_.holding(t, y, grips);
  for (std::size_t i = 0; i < grips.size(); ++i) {
    if (!grips[i].holds) forces[i] = grips[i].force;
  }
  return forces;
}

// A joint that is held by its stop stands still, so all that is done by what holds is a motor's.
Works TreeLedger::power(double t, const State& y, const Grips& grips) {
  Works power{};
  const std::vector<double> driven = drives(t, y.data(), grips);
  for (std::size_t i = 0; i < driven.size(); ++i) {
    const TreeEquations::Axis& axis = equations_.axes()[i];
    const double rate = axis.rate(y.data());
    const double held = axis.held > 0 ? y[axis.held] : 0;
    const Works loads = loads_by_kind(axis.joint, t, axis.q(y.data()), rate, held);
    for (std::size_t kind = 0; kind < power.size(); ++kind) power[kind] += loads[kind] * rate;
    of(power, Work::motors) += driven[i] * rate;
  }
  if (struts_) {
    equations_.show(y.data(), bodies_);
    of(power, Work::dampers) += ways_.damping_power(bodies_);
  }
  return power;
}

/// Of one that presses a joint on its stop as well.
bool TreeLedger::at_limit(std::size_t i, const State& y, const Grip& grip) const {
  const TreeEquations::Axis& axis = equations_.axes()[i];
  if (!axis.joint.motor) return false;
  return !grip.holds || std::fabs(axis.rate(y.data()) - axis.joint.motor->speed) > TreeEquations::at_speed;
}

void TreeLedger::follow(TreeMotion& motion, double until) {
  const double half = (until - t_) / 2;
  const bool works = struts_ || !equations_.axes().empty();
  if (works && half > 0) {
    for (const auto& [node, weight] : gauss) {
      for (const double side : {-node, node}) {
        const double t = t_ + half * (1 + side);
        const Works now = power(t, motion.at(t), motion.grips());
        for (std::size_t kind = 0; kind < now.size(); ++kind) works_[kind] += half * weight * now[kind];
      }
    }
    const State& y = motion.at(until);
    for (std::size_t i = 0; i < uses_.size(); ++i) {
      if (!at_limit(i, y, motion.grips()[i])) continue;
      uses_[i].time_s += 2 * half;
      if (!uses_[i].first_s) uses_[i].first_s = t_;
    }
  }
  t_ = until;
}

// Springs and weights do nothing in no time. What a motor's locating leaves of a speed is the motor's.
void TreeLedger::pass(const TreeMotion::Change& change) {
  if (change.passage) return;  // in a time of its own, which is followed as any other
  const double gained = kinetic(change.after) - kinetic(change.before);
  const std::vector<StopStrike> strikes = strikes_at(equations_, change);
  strikes_.insert(strikes_.end(), strikes.begin(), strikes.end());
  const Work kind = !strikes.empty() ? Work::stops : mechanism_.contacts.empty() ? Work::motors : Work::contacts;
  of(works_, kind) += gained;
}

void TreeLedger::record(double t, const double* y, const Grips& grips, const Sample& sample) {
  Works now = works_;
  of(now, Work::springs) = elastic_at_start_ - elastic(y);
  std::copy(now.begin(), now.end(), sample.works.begin());
  const std::vector<double> driven = drives(t, y, grips);
  for (std::size_t i = 0; i < driven.size(); ++i) {
    const TreeEquations::Axis& axis = equations_.axes()[i];
    const double held = axis.held > 0 ? y[axis.held] : 0;
    sample.joints[axis.number].load = driven[i] + axis.joint.steady_load(t, axis.q(y), axis.rate(y)) + held;
  }
}

std::vector<MotorUse> TreeLedger::motors(double duration_s) const {
  std::vector<MotorUse> motors;
  for (std::size_t i = 0; i < uses_.size(); ++i) {
    const TreeEquations::Axis& axis = equations_.axes()[i];
    if (axis.joint.motor) motors.push_back({axis.number, uses_[i].time_s / duration_s, uses_[i].first_s, axis.in_file});
  }
  return motors;
}

}  // namespace odeval::reference
