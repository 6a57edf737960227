#pragma once
// The works of a mechanism in ODE, step by step: of motors, stops, loads, struts, suspensions and contacts.
#include <ode/ode.h>

#include <array>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engines/ode/scene.hpp"
#include "odeval/motion.hpp"
#include "odeval/ways.hpp"
#include "odeval/work.hpp"

namespace odeval::engine_ode {

/// A force of ODE is constant over a step, and does the work of its impulse on the mean of the velocities before and
/// after: by just that the step's kinetic energy changes. Springs are told by the energy they hold. What the books then
/// leave is of the steps: weights and springs that count by the pose before, joints that are pulled together, turning.
class Ledger {
 public:
  /// The scene must outlive it.
  Ledger(const Scenario& scenario, Scene& scene);
  Ledger(const Ledger&) = delete;  // who reads ways points to the mechanism
  Ledger& operator=(const Ledger&) = delete;

  /// When loads are sampled and contacts made.
  void before_step(double t);
  void after_step();

  /// Works until now, and what acted along joints in the last step.
  void record(Sample sample);
  void record_loads(Sample sample) const;
  void tell(Outcome& outcome) const;

 private:
  /// A pair of forces along a line or about one: a unit of it, on the first body; the second has the opposite force.
  struct Row {
    std::size_t first = 0;
    std::optional<std::size_t> second = {};  // absent: the world
    Vec3 along{};
    Vec3 turn_first{};
    Vec3 turn_second{};
  };
  struct Twist {
    Vec3 velocity{};
    Vec3 spin{};
  };
  struct Driven {
    std::size_t number;  // of the joint
    Joint what;          // of one of several motions the joint with that alone
    bool turns;
    std::optional<std::size_t> motion = {};  // of several
    std::size_t in_file = 0;                 // its number there
    Row row{};                               // in the step
    Vec3 lever{};                            // of what turns, from the first body's centre to the anchor, likewise
    Works loads{};                           // likewise
    double total = 0;                        // along the joint, likewise
    bool at_low = false;                     // its stop acts in the step
    bool at_high = false;                    // likewise
    long at_limit = 0;                       // steps in which the motor gave all it has
    std::optional<double> first_s = {};
  };
  struct Damper {
    Row row;
    double force;  // in the step
  };

  const BodyView& body(std::size_t i) const { return scene_.bodies()[i]; }
  Twist twist(std::size_t i) const;
  Vec3 arm(std::size_t i, const Vec3& point) const;
  Row pair(std::size_t first, std::optional<std::size_t> second, const std::array<Vec3, 2>& at,
           const Vec3& along) const;
  Row axis_of(const Driven& joint) const;
  double rate(const Row& row, const std::vector<Twist>& twists) const;
  double feedback_along(const Driven& joint) const;
  void see_stop(Driven& joint);
  void drive(Driven& joint);
  void suspend(std::size_t number, double mean_of_step, double told);
  void touch();
  double elastic_energy(std::span<const BodyState> bodies);

  const Mechanism mechanism_;
  Scene& scene_;
  double step_s_;
  double tolerance_;  // within which a motor's force is its limit, of it
  double t_ = 0;      // of the step
  long steps_ = 0;
  Works works_{};
  std::vector<Twist> before_;
  std::vector<Twist> after_;
  std::vector<Twist> mean_;  // of both
  std::vector<Driven> driven_;
  std::vector<Damper> struts_;
  std::vector<std::pair<std::size_t, Row>> suspensions_;   // by the numbers of their joints
  std::unordered_map<const dReal*, std::size_t> numbers_;  // of bodies, by where they are kept
  std::vector<StopStrike> strikes_;
  std::optional<WayReader> ways_;
  double elastic_at_start_ = 0;
};

}  // namespace odeval::engine_ode
