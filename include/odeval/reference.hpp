#pragma once
// What every trace is compared with.
#include <array>
#include <string>
#include <vector>

#include "odeval/motion.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// The reference motion at the times of a trace, and how far it may itself be off.
struct Reference {
  Trace trace;                  // of pendulums in generalized coordinates, of bodies in Cartesian ones
  Column uncertainty_q;         // rad, bound on the largest angle error at each sample; empty without angles
  Column uncertainty_position;  // m, bound on the error of any body's centre at each sample; empty without bodies
  Column uncertainty_turn;      // rad, likewise of any body's attitude
  Column uncertainty_spin;      // rad/s, likewise of any body's spin
  std::vector<std::array<Column, 3>> joint_force;  // n, N, world frame: joint i on link i
  std::vector<Impact> impacts;
  std::vector<double> impact_uncertainty_s;  // one per impact
  double at_rest_from = -1;
  std::string described;  // solver and tolerances, for tables and summaries
};

}  // namespace odeval
