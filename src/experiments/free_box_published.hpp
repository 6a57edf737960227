#pragma once
// What was published of the "boxes" benchmark of Gazebo, and whose numbers here it comes to.
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace odeval::experiments::free_box_published {

/// Largest errors until 10 s, those of angular momentum and energy relative to what they were at the start.
struct Errors {
  double distance_m = 0;
  double momentum = 0;
  double energy = 0;
  std::optional<double> turned_rad = {};
};

/// An engine of Gazebo 6 in 2015, and the method that is it here.
struct Engine {
  std::string_view name;
  std::string_view method;
};
std::span<const Engine> engines();

/// Null: there is none. `tumbles`: the harder of the benchmark's two cases.
const Errors* of(std::string_view method, bool tumbles, double step_s);

/// Errors measured here of the tumbling box, by method and step, s. Steps that nothing was published of are those of
/// runs at a part of a step that something was.
using Measured = std::map<std::pair<std::string, double>, Errors>;

/// Largest relative difference of the tumbling box's published numbers from those of a method here, over the published
/// steps, each multiplied by `part`, at which it was measured. Nothing where there is none.
std::optional<double> difference(const Engine& engine, std::string_view method, double part, const Measured& measured);

/// Below this one motion is the other: the benchmark took one step more than ours, of 10 000 at 1 ms and of 100 000 at
/// 0.1 ms, which is up to 6e-4 of an error.
inline constexpr double same = 2e-3;

/// A sentence an engine: its numbers are those of its method here, or of another method or half the step, or nobody's.
std::string about(const Measured& measured);

}  // namespace odeval::experiments::free_box_published
