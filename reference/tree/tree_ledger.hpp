#pragma once
// The works of a tree of bodies along its motion: of motors, stops, loads, struts, suspensions and contacts.
#include <optional>
#include <vector>

#include "odeval/ways.hpp"
#include "odeval/work.hpp"
#include "reference/tree/tree_motion.hpp"

namespace odeval::reference {

/// The joints that strike their stops there.
std::vector<StopStrike> strikes_at(const TreeEquations& equations, const TreeMotion::Change& change);

/// What springs do is the energy that they hold less; what stops and contacts do is what the bodies' energy jumps by.
/// All else is integrated over the motion's own polynomials, piece by piece, by Gauss's rule of order 16.
class TreeLedger {
 public:
  /// Both must outlive it.
  TreeLedger(const TreeEquations& equations, const Mechanism& mechanism);
  TreeLedger(const TreeLedger&) = delete;
  TreeLedger& operator=(const TreeLedger&) = delete;

  /// On to a time of the motion's last piece.
  void follow(TreeMotion& motion, double until);
  /// Over what happens at its end.
  void pass(const TreeMotion::Change& change);

  /// Until a state of now, and what acts along joints there.
  void record(double t, const double* y, const Grips& grips, const Sample& sample);
  /// Of joints on their stops until now.
  const std::vector<StopStrike>& strikes() const { return strikes_; }
  /// How long the motors were at their limits, of a run of so many seconds.
  std::vector<MotorUse> motors(double duration_s) const;

 private:
  using State = TreeEquations::State;
  struct Use {
    double time_s = 0;
    std::optional<double> first_s;
  };

  std::vector<double> drives(double t, const double* y, const Grips& grips) const;
  bool at_limit(std::size_t axis, const State& y, const Grip& grip) const;
  Works power(double t, const State& y, const Grips& grips);
  double elastic(const double* y);
  double kinetic(const State& y);

  const TreeEquations& equations_;
  const Mechanism& mechanism_;
  bool struts_;  // whether struts or suspensions damp
  std::vector<BodyState> bodies_;
  WayReader ways_;
  double elastic_at_start_;
  double t_ = 0;  // until which the works are
  Works works_{};
  std::vector<Use> uses_;  // of axes
  std::vector<StopStrike> strikes_;
};

}  // namespace odeval::reference
