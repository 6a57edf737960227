#pragma once
// Across a pose at which loops may branch off.
//
// There the constraints' Jacobian loses rank: what holds near it is known to eps / distance, accelerations to eps /
// distance^3, and a solver that keeps a tolerance takes ever smaller steps to it. The motion itself goes on smoothly.
// So one long step goes across, by Gauss-Legendre collocation: its order is twice the number of its nodes, of which
// there is an even number, so that they stand clear of the pose in the middle.
#include <memory>
#include <optional>
#include <vector>

#include "reference/closed_form/body_motion.hpp"
#include "reference/tree/tree_equations.hpp"

namespace odeval::reference {

/// States over a time, as the polynomial through some of them.
class Way {
 public:
  using State = TreeEquations::State;

  void add(double t, State state);
  double begin() const { return times_.front(); }
  double end() const { return times_.back(); }
  double time(std::size_t i) const { return times_[i]; }
  const State& state(std::size_t i) const { return states_[i]; }
  const State& last() const { return states_.back(); }
  State at(double t) const;

 private:
  std::vector<double> times_;
  std::vector<State> states_;
};

/// What is integrated: nothing holds or drives a joint.
struct Across {
  const TreeEquations& equations;
  std::shared_ptr<const LoopChart> chart;
  Grips grips;
  double begin_s;
  double end_s;  // the pose lies about half way
};

struct Passage {
  Way way;
  BodyUncertainty unsure{};        // between both ends
  std::vector<double> unsure_end;  // numbers of a small state
};

/// From a state, to as far beyond the pose as that lies before it. Two collocations, of which one has two nodes less:
/// their difference is what the passage states. Nothing where they differ by more than `most_unsure`, or loops do not
/// stay closed between the nodes: the motion does not go on smoothly.
std::optional<Passage> pass(Across across, const TreeEquations::State& from);
/// From another state near it. Nothing likewise.
std::optional<Way> pass_near(const Across& across, const TreeEquations::State& from, const Way& way);

/// m, rad, m/s or rad/s
inline constexpr double most_unsure = 1e-9;

}  // namespace odeval::reference
