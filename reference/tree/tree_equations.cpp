#include "reference/tree/tree_equations.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "odeval/error.hpp"
#include "reference/maximal/box_lcp.hpp"
#include "reference/tree/simbody_tree.hpp"

namespace odeval::reference {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

/// The axes of a list, as columns of the inverse mass matrix: how a unit force along one accelerates each.
Eigen::MatrixXd mobility(SimbodyTree& simbody, const double* y, const std::vector<TreeEquations::Axis>& axes,
                         const std::vector<std::size_t>& which) {
  const auto count = static_cast<Eigen::Index>(which.size());
  Eigen::MatrixXd a(count, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const TreeEquations::Axis& pushed = axes[which[static_cast<std::size_t>(j)]];
    const std::vector<double>& kick = simbody.kick(y, pushed.speed);
    for (Eigen::Index i = 0; i < count; ++i) {
      const TreeEquations::Axis& axis = axes[which[static_cast<std::size_t>(i)]];
      a(i, j) = axis.sign * pushed.sign * kick[axis.speed - simbody.first_speed()];
    }
  }
  return a;
}

/// Of springs, torques and controllers.
double load(const TreeEquations::Axis& axis, double t, const double* y) {
  return axis.joint.steady_load(t, axis.q(y), axis.rate(y)) + (axis.held > 0 ? y[axis.held] : 0);
}

/// The axis at t = 0 of what slides; nothing of what turns.
std::optional<Vec3> way_of(const TreeEquations::Axis& axis) {
  if (const auto* const slider = std::get_if<SliderJoint>(&axis.joint.kind)) return slider->axis;
  if (!axis.motion) return std::nullopt;
  const Driveable motion = driveable_of(axis.joint.kind)[*axis.motion];
  return motion.slides ? std::optional(motion.axis) : std::nullopt;
}

/// A body that a way is fixed in: of a slider both are, of a joint with several motions its first.
std::size_t carrier_of_way(const TreeEquations::Axis& axis, const Branch& branch) {
  return axis.motion ? axis.joint.first : branch.body;
}

}  // namespace

TreeEquations::TreeEquations(const Scenario& scenario)
    : bodies_(scenario.mechanism.bodies.size()),
      joints_(scenario.mechanism.joints),
      planar_(scenario.planar),
      tree_(spanning_tree(scenario.mechanism)),
      simbody_(open_simbody_tree(scenario.mechanism, tree_, scenario.gravity)),
      points_(contact_points(scenario.mechanism).value()),
      loops_(static_cast<std::size_t>(std::ranges::count_if(tree_, &Branch::again))),
      start_(simbody_->start()) {
  for (std::size_t i = 0; i < tree_.size(); ++i) {
    const Branch& branch = tree_[i];
    if (!branch.joint || !joints_[*branch.joint].driven()) continue;
    const Joint& joint = joints_[*branch.joint];
    const double sign = joint.first == branch.body ? 1.0 : -1.0;
    for (const AxisDrive& each : joint.drives) {
      const auto [coordinate, speed] = simbody_->place_of_motion(i, each.motion);
      add_axis({alone(joint, each), i, sign, coordinate, speed, 0, *branch.joint, each.motion, each.number});
    }
    if (!joint.drives.empty()) continue;
    add_axis({joint, i, sign, simbody_->place_of_coordinate(i), simbody_->place_of_speed(i), 0, *branch.joint, {}, 0});
  }
  if (loops_ > 0) {
    const std::shared_ptr<const LoopChart> around = chart(start_);
    if (around->size() == start_.size() - simbody_->start().size()) {
      throw UserError(fmt::format("{}: the joints leave nothing that can move", scenario.name));
    }
    if (!around->find(around->small(start_).data(), start_)) {
      throw MachineError(fmt::format("reference for '{}': its loops can not be closed at t = 0", scenario.name));
    }
  }
  start_ = sampled(0, start_.data());
}

TreeEquations::~TreeEquations() = default;

void TreeEquations::add_axis(Axis axis) {
  if (axis.joint.sampled()) {
    axis.held = start_.size();
    start_.push_back(0);
  }
  axes_.push_back(std::move(axis));
}

std::string TreeEquations::version() const { return "Simbody " + simbody_->version(); }

bool TreeEquations::forces_are_known() const { return loops_ == 0 || !simbody_->closure(start_.data()).implied; }

std::shared_ptr<const LoopChart> TreeEquations::chart(const State& around) const {
  return std::make_shared<LoopChart>(*simbody_, loops_ > 0, around);
}

void TreeEquations::slope(const LoopChart& chart, double t, const double* small, double* slope,
                          const Grips& grips) const {
  if (chart.trivial()) {
    (*this)(t, small, slope, grips);
    return;
  }
  State state;
  State whole(size(), std::numeric_limits<double>::quiet_NaN());
  if (chart.find(small, state)) (*this)(t, state.data(), whole.data(), grips);
  chart.small(whole.data(), slope);
}

/// Gives Simbody all forces along axes; `held` are those of axes that hold.
void TreeEquations::push(double t, const double* y, const Grips& grips, const std::vector<double>& held) const {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Axis& axis = axes_[i];
    simbody_->push(axis.speed, axis.sign * (load(axis, t, y) + (grips[i].holds ? held[i] : grips[i].force)));
  }
}

std::vector<double> TreeEquations::holding(double t, const double* y, const Grips& grips) const {
  std::vector<double> forces(axes_.size());
  std::vector<std::size_t> holding;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (grips[i].holds) holding.push_back(i);
  }
  if (holding.empty()) return forces;
  push(t, y, grips, forces);
  State slope(simbody_->start().size());
  simbody_->slope(y, slope.data());
  Eigen::VectorXd wanted(static_cast<Eigen::Index>(holding.size()));
  for (std::size_t i = 0; i < holding.size(); ++i) {
    const Axis& axis = axes_[holding[i]];
    wanted[static_cast<Eigen::Index>(i)] = -axis.sign * slope[axis.speed];
  }
  const Eigen::VectorXd found = mobility(*simbody_, y, axes_, holding).llt().solve(wanted);
  for (std::size_t i = 0; i < holding.size(); ++i) forces[holding[i]] = found[static_cast<Eigen::Index>(i)];
  return forces;
}

void TreeEquations::operator()(double t, const double* y, double* dydt, const Grips& grips) const {
  if (!axes_.empty()) push(t, y, grips, holding(t, y, grips));
  simbody_->slope(y, dydt);
  std::fill(dydt + simbody_->start().size(), dydt + size(), 0.0);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (grips[i].holds) dydt[axes_[i].speed] = 0;
  }
}

void TreeEquations::show(const double* y, std::span<BodyState> bodies) const {
  const std::vector<Placed>& placed = simbody_->bodies(y);
  for (const Branch& branch : tree_) {
    if (branch.again) continue;
    const Placed& body = placed[branch.body];
    BodyState& state = bodies[branch.body];
    state = {
        .position = body.position_m, .rotation = body.rotation, .velocity = body.velocity_m_s, .spin = body.spin_rad_s};
    if (!planar_) continue;
    // The hinge's angle on that of the link before: no turn is lost.
    const double turned = body.first_coordinate * dot(planar_->frame.hinge_axis, planar_->frame.axis());
    state.angle = (branch.parent ? bodies[*branch.parent].angle : 0) + planar_->q0[branch.body] + turned;
  }
}

void TreeEquations::forces(double t, const double* y, const Grips& grips, std::span<JointState> joints) const {
  if (!axes_.empty()) push(t, y, grips, holding(t, y, grips));
  std::vector<Vec3> on_body = simbody_->forces(y);
  for (const Axis& axis : axes_) {  // the load of a way is a force, but not one of the joint
    const std::optional<Vec3> way = way_of(axis);
    if (!way || !axis.joint.loaded()) continue;
    const Joint& joint = axis.joint;
    const bool in_world = std::holds_alternative<PlaneJoint>(joint.kind);
    const Vec3 along = in_world ? *way : simbody_->direction(y, carrier_of_way(axis, tree_[axis.branch]), *way);
    on_body[axis.branch] = on_body[axis.branch] - axis.sign * load(axis, t, y) * along;
  }
  for (std::size_t i = 0; i < tree_.size(); ++i) {
    const Branch& branch = tree_[i];
    if (!branch.joint) continue;
    const double sign = joints_[*branch.joint].carried() == branch.body ? 1 : -1;
    joints[*branch.joint].force = sign * on_body[i];
  }
}

// A motor has all its force either way until its speed is reached; a stop has what it takes to push the joint back.
Grips TreeEquations::grips(double t, const double* y, std::optional<Released> released) const {
  Grips grips(axes_.size());
  std::vector<std::size_t> may_hold;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Axis& axis = axes_[i];
    Grip& grip = grips[i];
    const double rate = axis.rate(y);
    bool holds = false;
    if (const std::optional<Motor>& motor = axis.joint.motor; motor && motor->most > 0) {
      holds = std::fabs(rate - motor->speed) <= at_speed;
      const double push = std::copysign(motor->most, motor->speed - rate);
      grip.least = holds ? -motor->most : push;
      grip.most = holds ? motor->most : push;
    }
    if (const std::optional<Stop>& stop = axis.joint.stop; stop && std::fabs(rate) <= at_speed) {
      const bool low = axis.q(y) - stop->low <= at_end;
      const bool high = stop->high - axis.q(y) <= at_end;
      if (low) grip.most = unbounded;
      if (high) grip.least = -unbounded;
      holds = holds || low || high;
    }
    grip.force = grip.least;  // of one that may not hold; of others until it is known
    if (released && released->axis == i) {
      grip = {.holds = false, .least = 0, .most = 0, .force = released->force};
    } else if (holds) {
      may_hold.push_back(i);
    }
  }
  if (may_hold.empty()) return grips;

  // A lambda = wanted + w: the forces between their bounds that keep all speeds, or let them leave the right way.
  for (const std::size_t i : may_hold) grips[i].force = 0;
  push(t, y, grips, {});
  State slope(simbody_->start().size());
  simbody_->slope(y, slope.data());
  const auto count = static_cast<Eigen::Index>(may_hold.size());
  Eigen::VectorXd wanted(count), least(count), most(count), force(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::size_t k = may_hold[static_cast<std::size_t>(i)];
    wanted[i] = -axes_[k].sign * slope[axes_[k].speed];
    least[i] = grips[k].least;
    most[i] = grips[k].most;
  }
  maximal::BoxLcp().solve(count, mobility(*simbody_, y, axes_, may_hold), wanted, least, most, force);
  for (Eigen::Index i = 0; i < count; ++i) {
    Grip& grip = grips[may_hold[static_cast<std::size_t>(i)]];
    grip.holds = force[i] > least[i] && force[i] < most[i];
    grip.force = grip.holds ? 0 : force[i];
  }
  return grips;
}

// Newton's law of restitution along the axis that strikes, and those that strike at once with it; of the others on
// their stops, those that have to push.
TreeEquations::Strike TreeEquations::strike(const double* y, std::size_t axis) const {
  Strike all;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const std::optional<Stop>& stop = axes_[i].joint.stop;
    if (!stop) continue;
    const double above = axes_[i].q(y) - stop->low;
    const double below = stop->high - axes_[i].q(y);
    const double away = above < below ? 1 : -1;
    const double approach = -away * axes_[i].rate(y);
    if (i != axis && std::fabs(std::fmin(above, below)) > at_end) continue;
    all.axes.push_back(i);
    all.away.push_back(away);
    all.restitution.push_back(approach * stop->restitution > rest_speed ? stop->restitution : 0);
  }
  const auto count = static_cast<Eigen::Index>(all.axes.size());
  const Eigen::VectorXd impulse = impulses(y, all, Eigen::VectorXd::Constant(count, unbounded));
  Strike felt;
  for (std::size_t i = 0; i < all.axes.size(); ++i) {
    if (impulse[static_cast<Eigen::Index>(i)] <= 0 && all.axes[i] != axis) continue;
    felt.axes.push_back(all.axes[i]);
    felt.away.push_back(all.away[i]);
    felt.restitution.push_back(all.restitution[i]);
  }
  return felt;
}

/// Along the ways that leave the ends: between 0 and the most, or whatever gives the speeds where there is no bound.
Eigen::VectorXd TreeEquations::impulses(const double* y, const Strike& strike,
                                        const std::optional<Eigen::VectorXd>& most) const {
  const auto count = static_cast<Eigen::Index>(strike.axes.size());
  Eigen::MatrixXd a = mobility(*simbody_, y, axes_, strike.axes);
  Eigen::VectorXd wanted(count), impulse(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    wanted[i] = -(1 + strike.restitution[k]) * strike.away[k] * axes_[strike.axes[k]].rate(y);
    for (Eigen::Index j = 0; j < count; ++j) a(i, j) *= strike.away[k] * strike.away[static_cast<std::size_t>(j)];
  }
  if (!most) return a.llt().solve(wanted);
  maximal::BoxLcp().solve(count, a, wanted, Eigen::VectorXd::Zero(count), *most, impulse);
  return impulse;
}

TreeEquations::State TreeEquations::struck(const double* y, const Strike& strike) const {
  State after(y, y + size());
  const Eigen::VectorXd impulse = impulses(y, strike, {});
  for (std::size_t i = 0; i < strike.axes.size(); ++i) {
    const Axis& axis = axes_[strike.axes[i]];
    after[axis.way] = axis.sign * (strike.away[i] > 0 ? axis.joint.stop->low : axis.joint.stop->high);
    const std::vector<double>& kick = simbody_->kick(y, axis.speed);
    const double along = axis.sign * strike.away[i] * impulse[static_cast<Eigen::Index>(i)];
    for (std::size_t j = 0; j < kick.size(); ++j) after[simbody_->first_speed() + j] += along * kick[j];
  }
  return after;
}

std::vector<Meeting> TreeEquations::meetings(const double* y) const {
  const std::vector<Placed>& bodies = simbody_->bodies(y);
  std::vector<Meeting> all;
  for (const ContactPoint& point : points_) all.push_back(meeting(point, bodies));
  return all;
}

Meeting TreeEquations::meeting_at(const double* y, std::size_t point) const {
  return meeting(points_[point], simbody_->bodies(y));
}

/// A unit impulse at each of some points: what it adds to the speeds, and to how fast each point parts.
struct TreeEquations::Impacts {
  std::vector<std::vector<double>> gained;
  Eigen::MatrixXd parting;
  Eigen::VectorXd rate;  // before
};

TreeEquations::Impacts TreeEquations::impacts(const double* y, const std::vector<std::size_t>& points) const {
  const auto count = static_cast<Eigen::Index>(points.size());
  Impacts all{{}, Eigen::MatrixXd(count, count), Eigen::VectorXd(count)};
  std::vector<std::vector<double>> along;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Meeting now = meeting_at(y, points[i]);
    const ContactPoint& point = points_[points[i]];
    SimbodyTree::Impulse impulse = simbody_->impulse(y, point.body, point.other, now.point_m, now.normal);
    all.rate[static_cast<Eigen::Index>(i)] = now.rate_m_s;
    along.push_back(std::move(impulse.along));
    all.gained.push_back(std::move(impulse.gained));
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      const std::vector<double>& way = along[static_cast<std::size_t>(i)];
      all.parting(i, j) =
          std::inner_product(way.begin(), way.end(), all.gained[static_cast<std::size_t>(j)].begin(), 0.0);
    }
  }
  return all;
}

// Of points that meet at once those that the ones before them do not bind already: two corners that strike together
// where the body can but turn about one axis are one. Then, of these, those that have to push.
TreeEquations::Hit TreeEquations::hit(const double* y, std::size_t point) const {
  std::vector<std::size_t> meet{point};
  const std::vector<Meeting> now = meetings(y);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (i != point && now[i].apart_m <= at_end && now[i].rate_m_s < 0) meet.push_back(i);
  }
  const Impacts all = impacts(y, meet);
  Hit bound;
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < meet.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    std::vector<Eigen::Index> with = kept;
    with.push_back(k);
    constexpr double dependent = 1e-9;  // of its own mobility, what is left of it where the others hold
    const Eigen::MatrixXd a = all.parting(with, with);
    const auto factors = a.ldlt();
    if (!kept.empty() && !(factors.vectorD().minCoeff() > dependent * a.diagonal().maxCoeff())) continue;
    kept = std::move(with);
    bound.points.push_back(meet[i]);
    const double approach = -all.rate[k];
    const double restitution = points_[meet[i]].restitution;
    bound.restitution.push_back(approach * restitution > rest_speed ? restitution : 0);
  }
  const auto count = static_cast<Eigen::Index>(kept.size());
  Eigen::VectorXd wanted(count), impulse(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    wanted[i] = -(1 + bound.restitution[static_cast<std::size_t>(i)]) * all.rate[kept[static_cast<std::size_t>(i)]];
  }
  maximal::BoxLcp().solve(count, all.parting(kept, kept), wanted, Eigen::VectorXd::Zero(count),
                          Eigen::VectorXd::Constant(count, unbounded), impulse);
  Hit felt;
  for (std::size_t i = 0; i < bound.points.size(); ++i) {
    if (impulse[static_cast<Eigen::Index>(i)] <= 0 && bound.points[i] != point) continue;
    felt.points.push_back(bound.points[i]);
    felt.restitution.push_back(bound.restitution[i]);
  }
  return felt;
}

TreeEquations::State TreeEquations::rebounded(const double* y, const Hit& hit) const {
  State after(y, y + size());
  const Impacts all = impacts(y, hit.points);
  Eigen::VectorXd wanted(all.rate.size());
  for (Eigen::Index i = 0; i < wanted.size(); ++i) {
    wanted[i] = -(1 + hit.restitution[static_cast<std::size_t>(i)]) * all.rate[i];
  }
  const Eigen::VectorXd impulse = all.parting.llt().solve(wanted);
  for (std::size_t i = 0; i < hit.points.size(); ++i) {
    const std::vector<double>& gained = all.gained[i];
    for (std::size_t j = 0; j < gained.size(); ++j) {
      after[simbody_->first_speed() + j] += impulse[static_cast<Eigen::Index>(i)] * gained[j];
    }
  }
  return after;
}

const std::vector<Placed>& TreeEquations::pushed(double dt) const {
  const Grips start = grips(0, start_.data());
  if (!axes_.empty()) push(0, start_.data(), start, holding(0, start_.data(), start));
  return simbody_->pushed(dt);
}

TreeEquations::State TreeEquations::sampled(double t, const double* y) const {
  State after(y, y + size());
  for (const Axis& axis : axes_) {
    if (axis.held > 0) after[axis.held] = axis.joint.sampled_load(t, axis.q(y), axis.rate(y));
  }
  return after;
}

TreeEquations::Stiffness TreeEquations::stiffest(const double* y, double step_s) const {
  Stiffness most;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Joint& joint = axes_[i].joint;
    double stiffness = 0;
    double damping = 0;
    for (const JointSpring& spring : joint.springs) {
      stiffness += spring.stiffness;
      damping += spring.damping;
    }
    for (const Controller& controller : joint.controllers) {
      stiffness += controller.kp;
      damping += controller.kd;
    }
    const double freed = mobility(*simbody_, y, axes_, {i})(0, 0);
    const double of_step = step_s * freed * std::fmax(step_s * stiffness, damping);
    if (of_step > most.of_step) most = {i, of_step};
  }
  return most;
}

bool TreeEquations::samples() const {
  return std::ranges::any_of(axes_, [](const Axis& axis) { return axis.held > 0; });
}

}  // namespace odeval::reference
