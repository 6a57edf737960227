#pragma once
// How far a tree's motion may be off: errors of steps, carried on by the motion.
#include <Eigen/Core>
#include <vector>

#include "reference/closed_form/body_motion.hpp"
#include "reference/tree/tree_motion.hpp"

namespace odeval::reference {

/// The bound of reference_solution.hpp, U = f I + A / 5, with two ellipsoids of errors, I and A, in the numbers of a
/// tree's small state (loop_chart.hpp); read as an error of bodies, of the worst body's place, attitude and spin, in
/// every direction.
///
/// A change of what motors and stops do carries an error along by what it does to a state beside the true one, and by
/// how much earlier or later it happens to that.
///
/// Jacobians are central differences of the equations. Steps of CVODE are taken together, to strides of as much time as
/// a third-order transition is good for.
class TreeUncertainty {
 public:
  /// `start_error` is by how much a number of the state may be off at t = 0, beyond its rounding.
  TreeUncertainty(const TreeEquations& equations, const Mechanism& mechanism, Tolerances tolerances,
                  double start_error);

  /// Takes in the step that `tight` has just made; moves `loose` along.
  void follow(TreeMotion& tight, TreeMotion& loose);
  /// The same after the last step: what at() is asked for begins before its end.
  void finish(TreeMotion& tight, TreeMotion& loose);

  /// Of a sample between t = 0 and the last step.
  BodyUncertainty at(double t) const;

 private:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;
  struct Stride {
    double end_s;
    BodyUncertainty bound;  // at its end; the larger one of both ends holds within
  };

  void stride(const Vector& y, double end_s, const Grips& grips);
  void compare(const Vector& tight, const Vector& loose);
  void pass(const TreeMotion& tight);
  Matrix slopes(double t, const Vector& y, const Grips& grips) const;
  Matrix slopes_of_bodies(const Vector& y) const;
  double spin_jump(const TreeMotion::Change& change) const;
  Vector step_error(const Vector& y) const;
  BodyUncertainty bound(const Vector& y) const;

  void show(const Vector& y, std::vector<BodyState>& bodies) const;
  std::vector<double> whole(const Vector& y) const;

  const TreeEquations& equations_;
  std::shared_ptr<const LoopChart> chart_;
  const Mechanism& mechanism_;
  Tolerances tolerances_;  // of the tight run
  Matrix independent_;     // I and A, as in error_spread.hpp
  Matrix aligned_;
  Vector start_;       // the small state at the start of the next stride, where there are no slopes yet
  Matrix slopes_;      // at the end of the last stride
  bool fresh_ = true;  // there are none: motors and stops have changed since
  double factor_ = 1;
  double longest_s_ = 0;  // that the next stride may be
  double steps_ = 0;      // since the last stride
  std::vector<Stride> strides_;
  struct Jump {
    double t;
    double unknown_s;   // how much earlier or later it may be
    double spin_rad_s;  // by how much the worst body's spin jumps
  };
  std::vector<Jump> jumps_;
};

}  // namespace odeval::reference
