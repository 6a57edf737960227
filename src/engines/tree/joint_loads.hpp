#pragma once
// Springs, torques and controllers of joints, which an engine is given as forces along its own coordinates.
#include <algorithm>
#include <vector>

#include "odeval/mechanism.hpp"

namespace odeval::engine_tree {

/// The loaded joints of a mechanism. Coordinate is what an engine calls a joint's way by; its way and rate count as the
/// joint's, from t = 0 (Degree::axis).
template <class Coordinate>
class JointLoads {
 public:
  /// Nothing where nothing acts on it.
  void add(const Joint& joint, const Coordinate& coordinate) {
    if (joint.loaded()) loads_.push_back({joint, coordinate});
  }
  bool empty() const { return loads_.empty(); }
  /// Whether a controller looks at one of them once a step.
  bool sampled() const {
    return std::any_of(loads_.begin(), loads_.end(), [](const Load& load) { return load.joint.sampled(); });
  }

  /// At the beginning of a step: what controllers that look once a step see, they hold until the next call.
  /// `way` and `rate` tell those of a coordinate.
  template <class Way, class Rate>
  void sample(double t, const Way& way, const Rate& rate) {
    for (Load& load : loads_) {
      if (load.joint.sampled()) load.held = load.joint.sampled_load(t, way(load.at), rate(load.at));
    }
  }
  /// All loads at a time, N m or N; `push` takes a coordinate and a force along it.
  template <class Way, class Rate, class Push>
  void apply(double t, const Way& way, const Rate& rate, const Push& push) const {
    for (const Load& load : loads_) {
      push(load.at, load.held + load.joint.steady_load(t, way(load.at), rate(load.at)));
    }
  }

 private:
  struct Load {
    Joint joint;
    Coordinate at;
    double held = 0;
  };
  std::vector<Load> loads_;
};

}  // namespace odeval::engine_tree
