#pragma once
// The one door through which every way of moving a scenario is used.
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "odeval/scenario.hpp"

namespace odeval {

/// What the numbers of one recorded row mean.
enum class Coordinates {
  generalized,  // q1..qn, qd1..qdn
  cartesian,    // for each link a BodyState, then the number of contacts
};

/// One link in Cartesian coordinates, world frame, in the order the trace's columns have.
struct BodyState {
  double position[3];     // centre of mass, m
  double rotation[9];     // body to world, by rows
  double velocity[3];     // of the centre of mass, m/s
  double spin[3];         // rad/s
  double joint_force[3];  // of this link's joint on it, N; an engine's is that of the step that led to the row (row 0:
                          // the first step's)
  double angle;           // absolute, of the link's direction, followed from step to step so that no turn is lost, rad
};
inline constexpr std::size_t body_numbers = sizeof(BodyState) / sizeof(double);

/// Raw samples, row after row, in memory allocated and touched before the run starts.
class Rows {
 public:
  Rows(std::size_t width, std::size_t capacity) : width_(width), values_(width * capacity) {}

  /// The next row to fill. The caller never asks for more rows than the capacity.
  double* append() { return values_.data() + width_ * count_++; }
  double* row(std::size_t k) { return values_.data() + width_ * k; }
  const double* row(std::size_t k) const { return values_.data() + width_ * k; }
  std::size_t width() const { return width_; }
  std::size_t count() const { return count_; }

 private:
  std::size_t width_;
  std::size_t count_ = 0;
  std::vector<double> values_;
};

/// One touch of the wall. `depth` is how far the engine let the bodies overlap (0 where the method locates the touch).
/// Where either of two balls may touch, `link` says which (1 or 2), q1 is link 1's angle all the same, and the rates
/// are the ball's velocity away from the wall, m/s.
struct Impact {
  double t = 0;
  double q1 = 0;
  double qd_before = 0;
  double qd_after = 0;
  double depth = 0;
  std::optional<int> link = {};
};

/// How a run went.
struct Outcome {
  long steps = 0;                         // accepted steps
  long evaluations = 0;                   // of the equations of motion; 0 for an engine that does not say
  bool diverged = false;                  // a value left the finite numbers, or the engine gave up
  std::string reason;                     // why, when diverged
  long messages = 0;                      // warnings of the engine
  double at_rest_from = -1;               // s, when a cascade of impacts came to rest on the wall; < 0: never
  std::optional<double> self_difference;  // rad, largest difference between a method's own runs at two step sizes
  std::vector<Impact> impacts;
};

/// A scenario loaded into a method, at t = 0 and ready to move. Set-up is the constructor's work.
class Simulation {
 public:
  virtual ~Simulation() = default;

  /// Moves from t = 0 to the end of the grid, once. With `rows` it also records a row per sample
  /// (t = 0 included); without, it does nothing but step, which is what `bench` times.
  /// A run that blows up ends early with the rows so far and `diverged` set.
  virtual Outcome run(Rows* rows) = 0;
};

/// Throws UserError when the scenario asks for what the method cannot do.
using MakeSimulation = std::unique_ptr<Simulation> (*)(const Scenario&, const SampleGrid&);

}  // namespace odeval
