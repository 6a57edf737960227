#include "render/body_stage.hpp"

#include <algorithm>
#include <cmath>

namespace odeval::render {
namespace {

constexpr double far_m = 1e6;  // beyond, nothing is drawn

Vec3 middle_of(const Pose& pose) {
  Vec3 sum{};
  for (const LinkPose& body : pose) sum = sum + body.centre_m;
  return (1.0 / static_cast<double>(std::max<std::size_t>(pose.size(), 1))) * sum;
}

/// The plane that falls towards +x, seen below a point.
GroundPlane ground_below(const HalfSpace& plane, const Vec3& point) {
  const Vec3& normal = plane.normal;
  const double height = dot(point, normal) - plane.offset_m;
  return {point - height * normal, {normal[2], 0, -normal[0]}, {0, 1, 0}, normal};
}

}  // namespace

BodyStage::BodyStage(const Scenario& scenario, std::span<const Pose> shown)
    : bodies_(scenario.mechanism.bodies),
      joints_(scenario.mechanism),
      frame_(scenario.frame()),
      free_(scenario.mechanism.obstacles.empty()) {
  for (const Joint& joint : scenario.mechanism.joints) {
    if (joint.second) continue;
    pin_ = anchor_m(joint.kind);
    free_ = false;
  }
  Vec3 low{far_m, far_m, far_m};
  Vec3 high{-far_m, -far_m, -far_m};
  if (pin_) {
    low = high = *pin_;
    extent_.push_back(*pin_);
  }
  const auto hold = [&](const Pose& pose) {
    const Vec3 by = shift(pose);
    for (std::size_t i = 0; i < pose.size(); ++i) {
      if (!drawable(pose[i])) continue;
      LinkPose seen = pose[i];
      seen.centre_m = seen.centre_m + by;
      std::ranges::copy(corners_of(seen, half(i)), std::back_inserter(extent_));
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], pose[i].centre_m[k] + by[k] - radius(i));
        high[k] = std::max(high[k], pose[i].centre_m[k] + by[k] + radius(i));
      }
    }
  };
  for (const Pose& pose : shown) hold(pose);
  if (low[0] > high[0]) low = high = {};  // nothing that could be drawn
  if (extent_.empty()) extent_.push_back(low);
  const Vec3 centre = 0.5 * (low + high);
  reach_m_ = std::max(length(high - low) / 2, 1e-3);
  frame_.hinge_m = centre;
  for (const Obstacle& obstacle : scenario.mechanism.obstacles) {
    if (const auto* const plane = std::get_if<HalfSpace>(&obstacle.shape)) ground_ = ground_below(*plane, centre);
  }
}

double BodyStage::radius(std::size_t body) const {
  const Vec3 size = sides_m(bodies_[body].shape);
  return is_sphere(bodies_[body].shape) ? size[0] / 2 : length(size) / 2;
}

// Along the body's z axis, across along x, hinge along y: as in space_frame.
BoxSize BodyStage::half(std::size_t body) const {
  const auto [x, y, z] = sides_m(bodies_[body].shape);
  return {z / 2, x / 2, y / 2};
}

bool BodyStage::drawable(const LinkPose& body) const {
  // Comparisons that are false for what is no number as well.
  const auto is_unit = [](const Vec3& v) { return std::fabs(dot(v, v) - 1) < 0.1; };
  return dot(body.centre_m, body.centre_m) < far_m * far_m && is_unit(body.along) && is_unit(body.across) &&
         is_unit(body.hinge);
}

/// In free flight what is in the middle of the bodies is in the middle of the picture.
Vec3 BodyStage::shift(const Pose& pose) const { return free_ ? -1 * middle_of(pose) : Vec3{}; }

Pose BodyStage::moved(Pose pose, const Vec3& by) const {
  for (LinkPose& body : pose) body.centre_m = body.centre_m + by;
  return pose;
}

bool BodyStage::inside(const Camera& camera, const Pose& pose) const {
  const Pose seen = moved(pose, shift(pose));
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!drawable(pose[i])) return false;
    for (const Vec3& point : corners_of(seen[i], half(i))) {
      const Pixel at = camera.project(point);
      if (at.depth_m <= 0 || at.x < 0 || at.y < 0 || at.x > camera.width() || at.y > camera.height()) return false;
    }
  }
  return true;
}

void BodyStage::add_body(Layer& layer, const Brush& brush, const Pose& pose, std::size_t body, double edge_px) const {
  if (is_sphere(bodies_[body].shape)) {
    brush.sphere(layer, pose[body], radius(body), colour_in_turn(body), edge_px);
  } else {
    brush.box(layer, pose[body], half(body), colour_in_turn(body), edge_px);
  }
}

void BodyStage::add_wires(Layer& layer, const Brush& brush, const Pose& pose, const Colour& colour, double px) const {
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) continue;
    if (is_sphere(bodies_[i].shape)) {
      brush.circles(layer, pose[i], radius(i), colour, px);
    } else {
      brush.wire(layer, pose[i], half(i), colour, px);
    }
  }
}

std::vector<Layer> BodyStage::layers(const Camera& camera, const Pose& pose, const Pose* outline) const {
  const Vec3 towards_lamp = unit(0.55 * frame_.horizontal + 0.75 * frame_.axis() + 1.1 * frame_.up);
  const Brush brush(camera, frame_.up, frame_.hinge_m + lamp_distance * reach_m_ * towards_lamp);
  const double edge_px = edge_width_px(camera);
  const Vec3 by = shift(pose);
  const Pose seen = moved(pose, by);

  std::vector<Layer> layers;
  const bool above = ground_ && dot(camera.eye(), ground_->normal) > 0;  // from below, the ground would hide all
  if (above && dot(ground_->normal, towards_lamp) > 0.1) {
    std::vector<Quad> casters;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!drawable(pose[i])) continue;
      if (is_sphere(bodies_[i].shape)) {
        add_quads(casters, seen[i].centre_m, radius(i));
      } else {
        add_quads(casters, seen[i], half(i));
      }
    }
    add_ground(layers, brush, camera, *ground_, reach_m_);
    add_shadows(layers, casters, {ground_->normal, 0}, {}, towards_lamp);
  }
  Layer& solids = layers.emplace_back();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (drawable(pose[i])) add_body(solids, brush, seen, i, edge_px);
  }
  std::vector<bool> shown(pose.size());
  for (std::size_t i = 0; i < shown.size(); ++i) shown[i] = drawable(pose[i]);
  if (!shown.empty()) joints_.add(solids, brush, seen, shown, reach_m_, edge_px);
  if (outline != nullptr) {
    const Pose second = moved(*outline, by);
    add_outline(layers, edge_px,
                [&](Layer& wires, const Colour& colour, double px) { add_wires(wires, brush, second, colour, px); });
  }
  return layers;
}

}  // namespace odeval::render
