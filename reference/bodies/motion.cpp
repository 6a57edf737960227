#include "reference/bodies/motion.hpp"

#include <algorithm>
#include <array>

#include "odeval/error.hpp"
#include "reference/bodies/bouncing_ball.hpp"
#include "reference/bodies/free_bodies.hpp"
#include "reference/bodies/sliding_box.hpp"
#include "reference/bodies/spring_joint.hpp"

namespace odeval::reference {
namespace {

struct MotionRow {
  std::string_view problem;
  std::unique_ptr<BodyMotion> (*make)(const Scenario&);
};

/// The one table of true motions, a row a problem of the family.
constexpr std::array motions{
    MotionRow{"free_box", make_free_bodies},         MotionRow{"thin_body", make_free_bodies},
    MotionRow{"bouncing_ball", make_bouncing_balls}, MotionRow{"friction_slide", make_sliding_box},
    MotionRow{"spring_joint", make_spring_joint},
};

}  // namespace

std::unique_ptr<BodyMotion> make_body_motion(const Scenario& scenario) {
  const auto row = std::ranges::find(motions, scenario.problem->name, &MotionRow::problem);
  if (row == motions.end()) {
    throw UserError(scenario.name + ": no closed form is known for " + std::string(scenario.problem->name));
  }
  return row->make(scenario);
}

}  // namespace odeval::reference
