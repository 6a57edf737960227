#include "reference/planar/projected_step.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace odeval::reference {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class ProjectedStep final : public Simulation {
 public:
  ProjectedStep(const Scenario& scenario, const SampleGrid& grid)
      : grid_(grid),
        gravity_(scenario.gravity),
        angle_(static_cast<Index>(scenario.planar->links.size())),
        rate_(angle_.size()),
        lever_(MatrixXd::Zero(angle_.size(), angle_.size())),
        mass_(angle_.size()),
        inertia_(angle_.size()) {
    const PlanarView& view = *scenario.planar;
    double angle = 0;
    double rate = 0;
    for (Index i = 0; i < angle_.size(); ++i) {
      const Link& link = view.links[static_cast<std::size_t>(i)];
      angle_[i] = angle += view.q0[static_cast<std::size_t>(i)];
      rate_[i] = rate += view.qd0[static_cast<std::size_t>(i)];
      mass_[i] = link.mass_kg;
      inertia_[i] = link.inertia_kgm2();
      lever_(i, i) = link.length_m / 2;
      for (Index b = i + 1; b < angle_.size(); ++b) lever_(b, i) = link.length_m;
    }
    old_angle_ = angle_;
  }

  SampleShape shape() const override { return {.coordinates = static_cast<std::size_t>(angle_.size())}; }

  Outcome run(Recorder recorder) override {
    Outcome outcome;
    record(recorder);
    for (long row = 1; row < grid_.rows; ++row) {
      for (long k = 0; k < grid_.stride; ++k) {
        step(grid_.step_s);
        ++outcome.steps;
        if (angle_.allFinite() && rate_.allFinite()) continue;
        outcome.diverged = true;
        outcome.reason = "an angle or a rate left the finite numbers";
        return outcome;
      }
      record(recorder);
    }
    outcome.evaluations = outcome.steps;
    return outcome;
  }

 private:
  /// J(a)^T M J(b): body k's centre moves with lever(k, i) times the rate of link i, across it.
  MatrixXd mass_between(const VectorXd& a, const VectorXd& b) const {
    MatrixXd between = lever_.transpose() * mass_.asDiagonal() * lever_;
    for (Index i = 0; i < a.size(); ++i) {
      for (Index j = 0; j < a.size(); ++j) between(i, j) *= std::cos(a[i] - b[j]);
    }
    between.diagonal() += inertia_;
    return between;
  }

  void step(double h) {
    const VectorXd weight =
        (-gravity_ * (lever_.transpose() * mass_)).cwiseProduct(VectorXd(angle_.array().cos().matrix()));
    const VectorXd momentum = mass_between(angle_, old_angle_) * rate_ + h * weight;
    rate_ = mass_between(angle_, angle_).llt().solve(momentum);
    old_angle_ = angle_;
    angle_ += h * rate_;
  }

  void record(Recorder recorder) const {
    if (!recorder) return;
    const Sample sample = recorder.next();
    for (Index i = 0; i < angle_.size(); ++i) {
      const auto joint = static_cast<std::size_t>(i);
      sample.q[joint] = angle_[i] - (i > 0 ? angle_[i - 1] : 0);
      sample.qd[joint] = rate_[i] - (i > 0 ? rate_[i - 1] : 0);
    }
  }

  SampleGrid grid_;
  double gravity_;
  VectorXd angle_;      // absolute, of each link
  VectorXd old_angle_;  // of the pose that the rates belong to
  VectorXd rate_;
  MatrixXd lever_;  // of body k about the hinge of link i, m
  VectorXd mass_, inertia_;
};

}  // namespace

std::unique_ptr<Simulation> make_projected_step(const Scenario& scenario, const SampleGrid& grid) {
  return std::make_unique<ProjectedStep>(scenario, grid);
}

}  // namespace odeval::reference
