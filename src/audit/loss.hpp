#pragma once
// Since when a body moves otherwise than it would at a step of 0.
#include <algorithm>
#include <cmath>
#include <optional>

namespace odeval::audit {

/// Of its place, or of its attitude: lost is what is off by more than a tenth of how far it has itself gone, or turned,
/// until then.
///
/// What begins to move, or is hit, may do so up to a step late, and is off by as much of its way as that, however good
/// the step: so an error counts that is still more than a tenth of the way 15 steps later, by when a motion of constant
/// speed has outgrown one of a step and the uncertainty of a quarter of it.
class Loss {
 public:
  /// What is off by `least` is not lost, and what is off by more than `most` is.
  Loss(double least, double most) : least_(least), most_(most) {}

  /// At each step: the largest error and the farthest way until then, which only grow.
  void add(double t_s, double error, double way) {
    if (counts_) return;
    const double may_be_off = std::min(std::max(way / 10, least_), most_);
    if (since_s_ && error_ <= may_be_off) since_s_.reset();
    if (since_s_) {
      counts_ = ++steps_ >= 15;
    } else if (error > may_be_off) {
      since_s_ = t_s;
      error_ = error;
      steps_ = 0;
    }
  }
  /// The first error that is too large and stays so to the end of what was added, or for long enough.
  std::optional<double> since_s() const { return since_s_; }

 private:
  double least_;
  double most_;
  std::optional<double> since_s_;
  double error_ = 0;  // then
  int steps_ = 0;     // since then
  bool counts_ = false;
};

}  // namespace odeval::audit
