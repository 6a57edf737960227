#pragma once
// Explicit Runge-Kutta formulas: stages at t + at h from the start plus h times `from` of each stage before, and their
// sum by weights.
#include <span>

namespace odeval::engine_rk4 {

struct RungeKutta {
  struct Part {
    std::size_t stage;
    double share;
  };
  struct Stage {
    double at;
    std::span<const Part> from;
  };
  std::span<const Stage> stages;
  std::span<const Part> weights;
};

constexpr std::size_t most_stages = 12;  // of those below

/// Order 4: the classical formula, four stages. Order 8: that of Dormand and Prince with twelve.
const RungeKutta& runge_kutta(int order);

}  // namespace odeval::engine_rk4
