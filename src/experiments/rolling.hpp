#pragma once
// SimBenchmark's rolling scene: a box that a force pulls over the ground, with balls on it. It slides, they roll.
#include <string>

#include "odeval/engine.hpp"
#include "odeval/scenario.hpp"

namespace odeval::experiments::rolling {

inline constexpr double gravity = 9.81, box_kg = 10, ball_kg = 1, force_N = 150, of_ground = 0.4, of_balls = 0.8;
inline constexpr double duration_s = 4, step_s = 1e-3;
inline constexpr int balls = 25;

/// What a force is led by: a mechanism has forces along joints, so three sliders, each on the next, leave the box every
/// way and keep it level. What they weigh is pushed as well, by the force that it needs, so that the box moves as
/// without them.
struct Lead {
  double slider_kg = 1;
  double above_m = 0;  // the box's centre
};
/// Hardly any mass, on a lever: what iterations do not hold.
inline constexpr Lead light{0.1, 5};

/// Iterations of those who have such. Without feedback of errors, as theirs.
Scenario scene(double direction_deg, int iterations, const Lead& lead = {});

/// Mean over time of the squared errors of the velocities of the box and a ball, m²/s², beside Coulomb's law; infinite
/// where the run blew up.
double error(const Engine& method, double direction_deg, int iterations, const Lead& lead = {});

/// QuickStep's errors along y, m²/s².
struct QuickStep {
  double led = 0;         // with the iterations of the table
  double with_few = 0;    // with ODE's own
  double light_lead = 0;  // as the table, with light sliders
};
/// What its iterations have to do with the error, by these.
std::string about(const QuickStep& errors, int iterations, int few);

}  // namespace odeval::experiments::rolling
