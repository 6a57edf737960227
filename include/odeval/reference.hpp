#pragma once
// What every motion is compared with, and who knows it.
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "odeval/motion.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// The reference motion at the times of a trace, and how far it may itself be off.
struct Reference {
  Trace trace;                  // in joint coordinates where the scenario has them, or else of bodies
  Column uncertainty_q;         // rad, bound on the largest angle error at each sample; empty without angles
  Column uncertainty_position;  // m, bound on the error of any body's centre at each sample; empty without bodies
  Column uncertainty_turn;      // rad, likewise of any body's attitude
  Column uncertainty_spin;      // rad/s, likewise of any body's spin
  std::vector<std::array<Column, 3>> joint_force;  // n, N, world frame: of its joint on each link or body
  std::vector<Impact> impacts;
  std::vector<double> impact_uncertainty_s;  // one per impact
  std::vector<StopStrike> strikes;           // of joints on their stops, in the order of time
  double at_rest_from = -1;                  // s, as in Outcome
  std::string origin;  // who says so: solver and tolerances, or the closed form, for tables and summaries
};

/// A way to know the true motion: a row of the table in reference/providers.cpp, and nothing else chooses one.
///
/// Shapes   the grid's K rows: every column of the trace and of the uncertainties has K entries, or none
/// Units    SI and radians, world frame; bounds are absolute, in the unit of what they bound
/// Errors   solve throws UserError when the start has no solution of this kind (it names the key), MachineError when a
///          solver gives up; both name the scenario
struct ReferenceProvider {
  std::string_view method;            // whose mathematics it is, as --method says it: that one is not compared
  bool (*supports)(const Scenario&);  // by what the scenario is made of, not by how it starts
  Reference (*solve)(const Scenario&, const SampleGrid&);
  bool to_confirm = false;  // by a second formulation, whoever asks for the reference
};

}  // namespace odeval
