#include "render/stage.hpp"

#include "render/body_stage.hpp"
#include "render/pendulum_stage.hpp"

namespace odeval::render {

std::unique_ptr<Stage> make_stage(const Scenario& scenario, std::span<const Pose> shown) {
  if (!scenario.planar) return std::make_unique<BodyStage>(scenario, shown);
  return std::make_unique<PendulumStage>(scenario, shown);
}

}  // namespace odeval::render
