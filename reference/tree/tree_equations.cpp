#include "reference/tree/tree_equations.hpp"

#include "reference/tree/simbody_tree.hpp"

namespace odeval::reference {

TreeEquations::TreeEquations(const Scenario& scenario)
    : joints_(scenario.mechanism.joints),
      planar_(scenario.planar),
      tree_(spanning_tree(scenario.mechanism).value()),
      simbody_(std::make_unique<SimbodyTree>(scenario.mechanism, tree_, scenario.gravity)) {}

TreeEquations::~TreeEquations() = default;

const std::vector<double>& TreeEquations::start() const { return simbody_->start(); }

void TreeEquations::operator()(const double* y, double* dydt) const { simbody_->slope(y, dydt); }

void TreeEquations::show(const double* y, std::span<BodyState> bodies) const {
  const std::vector<Placed>& placed = simbody_->bodies(y);
  for (const Branch& branch : tree_) {
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

void TreeEquations::forces(const double* y, std::span<JointState> joints) const {
  const std::vector<Vec3>& on_body = simbody_->forces(y);
  for (const Branch& branch : tree_) {
    if (!branch.joint) continue;
    const double sign = joints_[*branch.joint].carried() == branch.body ? 1 : -1;
    joints[*branch.joint].force = sign * on_body[branch.body];
  }
}

}  // namespace odeval::reference
