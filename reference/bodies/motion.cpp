#include "reference/bodies/motion.hpp"

#include <algorithm>
#include <array>

#include "odeval/error.hpp"
#include "reference/bodies/balls.hpp"
#include "reference/bodies/free_bodies.hpp"
#include "reference/bodies/sliding_box.hpp"
#include "reference/bodies/sprung_joint.hpp"

namespace odeval::reference {
namespace {

/// A kind of true motion, and what it asks of a scenario.
struct MotionRow {
  bool (*supports)(const Scenario&);
  std::unique_ptr<BodyMotion> (*make)(const Scenario&);
};

bool joined(const Scenario& scenario) { return scenario.joint.has_value(); }
bool rubbing(const Scenario& scenario) { return scenario.ground && scenario.problem->friction; }
bool on_ground(const Scenario& scenario) { return scenario.ground.has_value(); }
bool free_flight(const Scenario& scenario) { return !scenario.bodies.empty(); }

/// The one table of true motions; the first that supports a scenario is its own.
constexpr std::array motions{
    MotionRow{joined, make_sprung_joint},
    MotionRow{rubbing, make_sliding_box},
    MotionRow{on_ground, make_bouncing_balls},
    MotionRow{free_flight, make_free_bodies},
};

}  // namespace

std::unique_ptr<BodyMotion> make_body_motion(const Scenario& scenario) {
  const auto row = std::ranges::find_if(motions, [&](const MotionRow& motion) { return motion.supports(scenario); });
  if (row == motions.end()) throw UserError(scenario.name + ": no closed form is known for a scenario without bodies");
  return row->make(scenario);
}

}  // namespace odeval::reference
