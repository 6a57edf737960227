#pragma once
// When a run keeps a budget, and when a step does so for more than by luck: one rule for `recommend` and the page.
#include <array>
#include <cmath>
#include <cstddef>

namespace odeval::catalogue {

/// What was measured, with what the reference may be off by on top. A run that is not to be believed measures infinity.
inline bool keeps(double value, double uncertainty, double at_most) {
  return std::fabs(value) + uncertainty <= at_most;
}

/// Beside a step, those that no user would tell from it, in percent of it: where in a step an impact falls is chance,
/// and so is what rounding leaves, or a motion that is nearly lost. An impact at t passes through a whole step as the
/// step changes by h/t of itself, so that they stand unevenly: with steps 0.25 % apart a wall's impact after 400 steps
/// falls at one place in all of them, which then keep 0.01 rad where a step 0.8 % away leaves 0.013 (ODE
/// 0.16.2). The farthest first: where an error grows with the step they fail first.
inline constexpr std::array nearby_percents{3.0,  -3.0,  1.93, -1.13, 0.71, -2.31, 0.29, -0.17,  // where nothing hits
                                            2.57, -2.69, 2.23, -1.89, 1.61, -1.43, 1.37, -0.83,
                                            1.03, -0.53, 0.53, -0.31, 2.81, -2.03, 0.11, -0.07};
inline constexpr std::size_t enough_without_impacts = 8;
inline constexpr double farthest_percent = nearby_percents.front();

constexpr double moved(double step_s, double percent) { return step_s * (1 + percent / 100); }

/// A run at a step nearby.
struct Near {
  bool keeps;
  bool impacts;  // something hit something in it
};

/// Whether all steps near one keep what it keeps. `run(step_s)` gives a Near.
template <class Run>
bool kept_nearby(double step_s, const Run& run) {
  bool impacts = false;
  for (std::size_t i = 0; i < nearby_percents.size() && (impacts || i < enough_without_impacts); ++i) {
    const Near near = run(moved(step_s, nearby_percents[i]));
    if (!near.keeps) return false;
    impacts = impacts || near.impacts;
  }
  return true;
}

}  // namespace odeval::catalogue
