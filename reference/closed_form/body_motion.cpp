#include "reference/closed_form/body_motion.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <variant>

#include "odeval/error.hpp"
#include "reference/closed_form/balls.hpp"
#include "reference/closed_form/free_bodies.hpp"
#include "reference/closed_form/sliding_box.hpp"
#include "reference/closed_form/sprung_joint.hpp"

namespace odeval::reference {
namespace {

/// A kind of true motion, and what it asks of a mechanism.
struct MotionRow {
  bool (*supports)(const Scenario&);
  std::unique_ptr<BodyMotion> (*make)(const Scenario&);
};

bool bodies_alone(const Scenario& scenario) {
  const Mechanism& mechanism = scenario.mechanism;
  return !mechanism.bodies.empty() && mechanism.joints.empty() && mechanism.contacts.empty();
}

/// One or two bodies on one joint.
bool one_joint(const Scenario& scenario) {
  const Mechanism& mechanism = scenario.mechanism;
  if (mechanism.joints.size() != 1 || !mechanism.contacts.empty()) return false;
  const Joint& joint = mechanism.joints.front();
  return joint.first == 0 && joint.carried() + 1 == mechanism.bodies.size() && has_sprung_motion(scenario);
}

/// A plane, and the one contact of every body with it; nothing where there is more to touch, or joints hold bodies.
struct Ground {
  const HalfSpace* plane;
  const Contact* contact;
};
std::optional<Ground> only_ground(const Mechanism& mechanism) {
  if (!mechanism.joints.empty() || mechanism.obstacles.size() != 1 || mechanism.contacts.size() != 1) return {};
  const Obstacle& obstacle = mechanism.obstacles.front();
  const Contact& contact = mechanism.contacts.front();
  const auto touches = [&](const Body& body) { return contact.is_between(body.name, obstacle.name); };
  const auto* const plane = std::get_if<HalfSpace>(&obstacle.shape);
  if (plane == nullptr || !std::ranges::all_of(mechanism.bodies, touches)) return {};
  return Ground{plane, &contact};
}
/// Down a plane that falls along x.
bool rubbing(const Scenario& scenario) {
  const auto ground = only_ground(scenario.mechanism);
  return ground && ground->contact->friction && ground->plane->normal[1] == 0;
}
bool bouncing(const Scenario& scenario) {
  const auto ground = only_ground(scenario.mechanism);
  return ground && !ground->contact->friction;
}

/// The one table of true motions; the first that supports a mechanism is its own.
constexpr std::array motions{
    MotionRow{one_joint, make_sprung_joint},
    MotionRow{rubbing, make_sliding_box},
    MotionRow{bouncing, make_bouncing_balls},
    MotionRow{bodies_alone, make_free_bodies},
};

auto find_motion(const Scenario& scenario) {
  const bool known = !scenario.planar && (features_of(scenario) - known_of_bodies).empty();
  return std::ranges::find_if(motions, [&](const MotionRow& row) { return known && row.supports(scenario); });
}

}  // namespace

bool has_body_motion(const Scenario& scenario) { return find_motion(scenario) != motions.end(); }

std::unique_ptr<BodyMotion> make_body_motion(const Scenario& scenario) {
  const auto* const row = find_motion(scenario);
  if (row == motions.end()) {
    throw UserError(scenario.name + ": no closed form is known for these bodies, joints and contacts together");
  }
  return row->make(scenario);
}

}  // namespace odeval::reference
