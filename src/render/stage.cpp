#include "render/stage.hpp"

#include <algorithm>

#include "render/body_stage.hpp"
#include "render/pendulum_stage.hpp"
#include "render/solid_stage.hpp"

namespace odeval::render {
namespace {

/// Whether a body is more than a box or a ball.
bool has_more(const Body& body) { return is_bar(body.shape) || !body.several.empty(); }

struct SolidOf {
  Solid operator()(const Box& box) const { return {Solid::Kind::box, box.sides_m, {}}; }
  Solid operator()(const Sphere& ball) const { return {Solid::Kind::sphere, {ball.diameter_m / 2}, {}}; }
  Solid operator()(const Cylinder& bar) const {
    return {Solid::Kind::cylinder, {bar.diameter_m / 2, bar.length_m}, {}};
  }
  Solid operator()(const Capsule& bar) const {
    return {Solid::Kind::capsule, {bar.diameter_m / 2, bar.length_m - bar.diameter_m}, {}};
  }
};

std::unique_ptr<Stage> make_solid_stage(const Mechanism& mechanism, std::span<const Pose> shown) {
  std::vector<Solid> solids;
  for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
    for (const Part& part : mechanism.bodies[i].parts()) {
      const auto& [at, turn] = part.place;
      Solid solid = std::visit(SolidOf{}, part.shape);
      solid.place = {at, axis_of(turn, 2), axis_of(turn, 0), axis_of(turn, 1)};
      solid.body = i;
      solids.push_back(solid);
    }
  }
  std::vector<Ground> grounds;
  for (const Obstacle& obstacle : mechanism.obstacles) {
    if (const auto* const plane = std::get_if<HalfSpace>(&obstacle.shape)) {
      grounds.push_back({plane->normal, plane->offset_m});
    }
  }
  return std::make_unique<SolidStage>(std::move(solids), grounds, Vec3{0, 0, 1}, shown, JointMarks(mechanism));
}

}  // namespace

std::unique_ptr<Stage> make_stage(const Scenario& scenario, std::span<const Pose> shown) {
  if (std::ranges::any_of(scenario.mechanism.bodies, has_more)) return make_solid_stage(scenario.mechanism, shown);
  if (!scenario.planar) return std::make_unique<BodyStage>(scenario, shown);
  return std::make_unique<PendulumStage>(scenario, shown);
}

}  // namespace odeval::render
