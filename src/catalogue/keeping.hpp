#pragma once
// When a run keeps a budget, and when a step does so for more than by luck: one rule for `recommend` and the page.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace odeval::catalogue {

/// What was measured, with what the reference may be off by on top. A run that is not to be believed measures infinity.
inline bool keeps(double value, double uncertainty, double at_most) {
  return std::fabs(value) + uncertainty <= at_most;
}

/// Beside a step, those that no user would tell from it, in percent of it: where in a step an impact falls is chance,
/// and so is what rounding leaves, or a motion that is nearly lost. An impact at t passes through a whole step as the
/// step changes by h/t of itself, so that they stand by chance as well: with steps 0.25 % apart a wall's impact after
/// 400 steps falls at one place in all of them, which then keep 0.01 rad where a step 0.8 % away leaves 0.013 (ODE
/// 0.16.2). So they are a sample: where 60 of 60 keep a budget, fewer than 5 % of all such steps break it, at 95 %
/// (0.95^60 = 0.046). The farthest first: where an error grows with the step they fail first.
inline constexpr auto nearby_percents = [] {
  constexpr std::array where_nothing_hits{3.0, -3.0, 1.93, -1.13, 0.71, -2.31, 0.29, -0.17};
  std::array<double, 60> percents{};
  std::uint32_t chance = 1;
  for (std::size_t i = 0; i < percents.size(); ++i) {
    chance = chance * 1664525U + 1013904223U;  // Knuth and Lewis: the same numbers everywhere
    const double share = chance / 4294967296.0;
    percents[i] = i < where_nothing_hits.size() ? where_nothing_hits[i] : 3 * (2 * share - 1);
  }
  return percents;
}();
inline constexpr std::size_t enough_without_impacts = 8;

/// Of the budget, which steps nearby have to keep where something hits something: the rest is for those that are not
/// tried, since the worst of 60 is not the worst of all. Near a wall's answer whose 60 left up to 0.00975 of 0.01 rad,
/// 2 of 300 others left more, 0.01034 at most; where the 60 leave a twentieth, none of 300 does, for 2 % more steps of
/// the run, and leaving a tenth takes 54 % more (ODE 0.16.2).
inline constexpr double share_where_it_hits = 0.95;

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
