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

/// A kind of true motion, and what it asks of a mechanism.
struct MotionRow {
  bool (*supports)(const Mechanism&);
  std::unique_ptr<BodyMotion> (*make)(const Scenario&);
};

bool uniform(const Body& body) { return !body.inertia_kgm2; }

bool bodies_alone(const Mechanism& mechanism) {
  return !mechanism.bodies.empty() && std::ranges::all_of(mechanism.bodies, uniform) && mechanism.joints.empty() &&
         mechanism.contacts.empty();
}

/// One or two bodies on one joint, which nothing drives or stops.
bool one_joint(const Mechanism& mechanism) {
  if (mechanism.joints.size() != 1 || !mechanism.contacts.empty()) return false;
  const Joint& joint = mechanism.joints.front();
  return joint.first == 0 && joint.carried() + 1 == mechanism.bodies.size() && !joint.motor && !joint.stop;
}

/// The one contact of bodies with a plane; nothing where there is more to touch, or joints hold them.
const Contact* contact_with_plane(const Mechanism& mechanism) {
  if (!mechanism.joints.empty() || mechanism.obstacles.size() != 1 || mechanism.contacts.size() != 1) return nullptr;
  return std::holds_alternative<HalfSpace>(mechanism.obstacles[0].shape) ? &mechanism.contacts[0] : nullptr;
}
bool rubbing(const Mechanism& mechanism) {
  const Contact* const contact = contact_with_plane(mechanism);
  return contact != nullptr && contact->friction;
}
bool bouncing(const Mechanism& mechanism) {
  const Contact* const contact = contact_with_plane(mechanism);
  return contact != nullptr && !contact->friction;
}

/// The one table of true motions; the first that supports a mechanism is its own.
constexpr std::array motions{
    MotionRow{one_joint, make_sprung_joint},
    MotionRow{rubbing, make_sliding_box},
    MotionRow{bouncing, make_bouncing_balls},
    MotionRow{bodies_alone, make_free_bodies},
};

auto find_motion(const Mechanism& mechanism) {
  return std::ranges::find_if(motions, [&](const MotionRow& motion) { return motion.supports(mechanism); });
}

}  // namespace

bool has_body_motion(const Scenario& scenario) { return find_motion(scenario.mechanism) != motions.end(); }

std::unique_ptr<BodyMotion> make_body_motion(const Scenario& scenario) {
  const auto* const row = find_motion(scenario.mechanism);
  if (row == motions.end()) {
    throw UserError(scenario.name + ": no closed form is known for these bodies, joints and contacts together");
  }
  return row->make(scenario);
}

}  // namespace odeval::reference
