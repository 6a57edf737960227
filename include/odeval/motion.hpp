#pragma once
// What moves, sample by sample: written by a stepping loop, read by whoever measures.
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "odeval/mechanism.hpp"
#include "odeval/work.hpp"

namespace odeval {

/// A body in the world frame.
struct BodyState {
  Vec3 position{};                   // centre of mass, m
  std::array<double, 9> rotation{};  // body to world, by rows
  Vec3 velocity{};                   // of the centre of mass, m/s
  Vec3 spin{};                       // rad/s
  double angle = 0;  // of a link in a plane: absolute, followed from step to step so that no turn is lost, rad; else 0
};

/// A joint in the world frame.
struct JointState {
  Vec3 force{};  // on the body that the joint carries (Joint::carried), N; an engine's is that of the step that led to
                 // the sample (of the first sample: the first step's)
  double load = 0;  // of a motion that has works, along a hinge or a slider, as the joint counts: what motor, stop,
                    // springs, torques and controllers give together, N m or N; likewise of that step
};

/// The force that tables show beside a body, N: of its carrier on it, zero without one. A zero has no sign.
inline Vec3 force_beside(const std::optional<Carrier>& carrier, std::span<const JointState> joints) {
  if (!carrier) return {};
  const Vec3& force = joints[carrier->joint].force;
  return carrier->sign > 0 ? force : Vec3{} - force;
}

/// How much one sample holds. Bodies and joints, or joint coordinates: what a method does not have is 0.
struct SampleShape {
  std::size_t bodies = 0;       // in the order of Mechanism::bodies
  std::size_t joints = 0;       // in the order of Mechanism::joints
  std::size_t coordinates = 0;  // in the order of PlanarView::links
  std::size_t works = 0;        // in the order of Work: all of them, or none where nobody keeps the books
};

/// One sample of a motion; the spans are as long as the motion's shape says.
template <class Body, class Joint, class Number>
struct BasicSample {
  std::span<Body> bodies;   // world frame
  std::span<Joint> joints;  // world frame
  std::span<Number> q;      // rad, relative as in PlanarView::q0
  std::span<Number> qd;     // rad/s
  std::span<Number> works;  // J, since t = 0
  Number& contacts;         // contact joints in the step that led here
};
/// To write.
using Sample = BasicSample<BodyState, JointState, double>;
/// To read.
using ConstSample = BasicSample<const BodyState, const JointState, const double>;

/// Samples in the order of time, in memory that is allocated and touched before the run starts.
///
/// Times are not here: sample k stands at SampleGrid::time(k). A run that ends early leaves fewer samples than the grid
/// has rows.
class Motion {
 public:
  /// Room for `capacity` samples, all zero.
  Motion(const SampleShape& shape, std::size_t capacity)
      : shape_(shape),
        bodies_(shape.bodies * capacity),
        joints_(shape.joints * capacity),
        coordinates_(2 * shape.coordinates * capacity),
        works_(shape.works * capacity),
        contacts_(capacity) {}

  /// What each sample holds.
  const SampleShape& shape() const { return shape_; }
  /// Samples so far.
  std::size_t size() const { return size_; }

  /// Sample k < size(); its spans stay valid as long as the motion.
  Sample operator[](std::size_t k) { return sample<Sample>(*this, k); }
  ConstSample operator[](std::size_t k) const { return sample<ConstSample>(*this, k); }

  /// The next sample to fill, all zero. The caller never asks for more than the capacity.
  Sample append() { return (*this)[size_++]; }

 private:
  /// The parts of sample k, of a motion to read or to write.
  template <class S, class Self>
  static S sample(Self& self, std::size_t k) {
    const SampleShape& shape = self.shape_;
    auto* const q = self.coordinates_.data() + 2 * shape.coordinates * k;
    return {{self.bodies_.data() + shape.bodies * k, shape.bodies},
            {self.joints_.data() + shape.joints * k, shape.joints},
            {q, shape.coordinates},
            {q + shape.coordinates, shape.coordinates},
            {self.works_.data() + shape.works * k, shape.works},
            self.contacts_[k]};
  }

  SampleShape shape_;
  std::size_t size_ = 0;             // samples so far
  std::vector<BodyState> bodies_;    // of each sample one after the other
  std::vector<JointState> joints_;   // likewise
  std::vector<double> coordinates_;  // q, then qd, of each sample
  std::vector<double> works_;        // of each sample
  std::vector<double> contacts_;     // one a sample
};

/// What a stepping loop calls: nothing is allocated, and nothing happens where nobody records.
class Recorder {
 public:
  /// Records nothing: what `bench` times.
  Recorder() = default;
  /// Fills the motion, which must outlive it.
  explicit Recorder(Motion& motion) : motion_(&motion) {}

  /// Whether anybody records.
  explicit operator bool() const { return motion_ != nullptr; }

  /// The next sample to fill. Only where something is recorded.
  Sample next() { return motion_->append(); }
  /// A sample that is there already.
  Sample at(std::size_t k) { return (*motion_)[k]; }

 private:
  Motion* motion_ = nullptr;  // null: records nothing
};

/// One touch. `depth` is how far the engine let the bodies overlap (0 where the method locates the touch). What
/// q1 and the rates are, the scenario's impact view says: an angle and its rate, or a height and a speed.
struct Impact {
  double t = 0;                  // s, of the step in which it began, or of the touch itself
  double q1 = 0;                 // rad, or m above a ground
  double qd_before = 0;          // rad/s, or m/s away from what is struck
  double qd_after = 0;           // likewise
  double depth = 0;              // m
  std::optional<int> link = {};  // which of several links, from 1
};

/// How a run went.
struct Outcome {
  long steps = 0;                         // accepted steps
  long evaluations = 0;                   // of the equations of motion; 0 for an engine that does not say
  bool diverged = false;                  // a value left the finite numbers, or the engine gave up
  std::string reason;                     // why, when diverged
  long messages = 0;                      // of ODE: complaints that it prints and goes on after
  std::string first_message;              // the text of the first of them
  double at_rest_from = -1;               // s, when a cascade of impacts came to rest; < 0: never
  std::optional<double> self_difference;  // rad, largest difference between a method's own runs at two step sizes
  std::vector<Impact> impacts;            // in the order of time
  std::vector<StopStrike> strikes;        // of joints on their stops, likewise; of a motion that has works
  std::vector<MotorUse> motors;           // of all joints that have one, likewise
};

}  // namespace odeval
