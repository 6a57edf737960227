#include "reference/maximal/newton_euler.hpp"

#include <cmath>
#include <cstring>

#include "reference/closed_form/rotation.hpp"
#include "reference/cvode_solver.hpp"
#include "reference/planar/cvode.hpp"

namespace odeval::reference {
namespace {

/// One body's part of the state.
struct FreeState {
  Vec3 position;
  Vec3 velocity;
  std::array<double, 4> attitude;  // unit quaternion, body to world, scalar first
  Vec3 spin;                       // body frame
};
constexpr std::size_t state_numbers = sizeof(FreeState) / sizeof(double);
static_assert(sizeof(FreeState) == 13 * sizeof(double));

FreeState start_of(const Body& body) {
  const Vec3 turn = rotation_vector(body.attitude);
  const double angle = length(turn);
  const double part = angle == 0 ? 0.5 : std::sin(angle / 2) / angle;
  const auto [x, y, z] = turn;
  return {body.position_m,
          body.velocity_m_s,
          {std::cos(angle / 2), part * x, part * y, part * z},
          turned_back(rotation_of(turn), body.spin_rad_s)};
}

// x' = v,  v' = -g,  q' = q (0, w) / 2,  I w' = I w x w
FreeState slope_of(const FreeState& y, const Vec3& moments, double gravity) {
  const auto [a, b, c, d] = y.attitude;
  const auto [w1, w2, w3] = y.spin;
  return {y.velocity,
          {0, 0, -gravity},
          {(-b * w1 - c * w2 - d * w3) / 2, (a * w1 + c * w3 - d * w2) / 2, (a * w2 + d * w1 - b * w3) / 2,
           (a * w3 + b * w2 - c * w1) / 2},
          {(moments[1] - moments[2]) / moments[0] * w2 * w3, (moments[2] - moments[0]) / moments[1] * w3 * w1,
           (moments[0] - moments[1]) / moments[2] * w1 * w2}};
}

/// CVODE keeps the quaternion's length to its tolerance only.
Rotation rotation_of(const std::array<double, 4>& quaternion) {
  const auto [a, b, c, d] = quaternion;
  const double twice = 2 / (a * a + b * b + c * c + d * d);
  return {1 - twice * (c * c + d * d), twice * (b * c - a * d),     twice * (b * d + a * c),
          twice * (b * c + a * d),     1 - twice * (b * b + d * d), twice * (c * d - a * b),
          twice * (b * d - a * c),     twice * (c * d + a * b),     1 - twice * (b * b + c * c)};
}

BodyState shown(const FreeState& y) {
  const Rotation attitude = rotation_of(y.attitude);
  return {.position = y.position, .rotation = attitude, .velocity = y.velocity, .spin = turned(attitude, y.spin)};
}

class FreeCvode final : public Simulation {
 public:
  FreeCvode(const Scenario& scenario, const SampleGrid& grid)
      : grid_(grid),
        count_(scenario.mechanism.bodies.size()),
        state_(count_ * state_numbers),
        solver_(
            count_ * state_numbers,
            [this](double, const double* y, double* slope) {
              for (std::size_t i = 0; i < count_; ++i) {
                FreeState body;
                std::memcpy(&body, y + i * state_numbers, sizeof body);
                const FreeState change = slope_of(body, moments_[i], gravity_);
                std::memcpy(slope + i * state_numbers, &change, sizeof change);
              }
            },
            {scenario.rtol.value_or(tight_tolerances.rtol), scenario.atol.value_or(tight_tolerances.atol), true},
            scenario.name, scenario.duration_s),
        gravity_(scenario.gravity) {
    for (std::size_t i = 0; i < count_; ++i) {
      moments_.push_back(scenario.mechanism.bodies[i].uniform_moments_kgm2());
      const FreeState start = start_of(scenario.mechanism.bodies[i]);
      std::memcpy(state_.data() + i * state_numbers, &start, sizeof start);
    }
    solver_.start(0, state_.data());
  }

  SampleShape shape() const override { return {.bodies = count_}; }

  Outcome run(Recorder recorder) override {
    record(recorder);
    for (long row = 1; row < grid_.rows; ++row) {
      while (solver_.end() < grid_.time(row)) solver_.step();
      if (!recorder) continue;
      solver_.interpolate(grid_.time(row), state_.data());
      record(recorder);
    }
    Outcome outcome;
    outcome.steps = solver_.steps();
    outcome.evaluations = solver_.evaluations();
    return outcome;
  }

 private:
  void record(Recorder recorder) const {
    if (!recorder) return;
    const Sample sample = recorder.next();
    for (std::size_t i = 0; i < count_; ++i) {
      FreeState body;
      std::memcpy(&body, state_.data() + i * state_numbers, sizeof body);
      sample.bodies[i] = shown(body);
    }
  }

  SampleGrid grid_;
  std::size_t count_;
  std::vector<double> state_;  // as recorded
  std::vector<Vec3> moments_;
  CvodeSolver solver_;
  double gravity_;
};

}  // namespace

std::unique_ptr<Simulation> make_free_cvode(const Scenario& scenario, const SampleGrid& grid) {
  return std::make_unique<FreeCvode>(scenario, grid);
}

}  // namespace odeval::reference
