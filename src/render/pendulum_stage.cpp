#include "render/pendulum_stage.hpp"

#include <algorithm>
#include <numbers>

#include "render/joint_marks.hpp"
#include "render/scenery.hpp"

namespace odeval::render {
namespace {

constexpr Colour wall_colour{214, 208, 198};
}  // namespace

PendulumStage::PendulumStage(const Scenario& scenario, std::span<const Pose> shown)
    : frame_(scenario.planar->frame), links_(scenario.planar->links) {
  double lengths = 0;
  double widest = 0;
  for (const Link& link : links_) {
    lengths += link.length_m;
    widest = std::max(widest, link.width_m);
  }
  reach_m_ = lengths + widest / 2;
  ground_m_ = dot(frame_.hinge_m, frame_.up) - reach_m_ - lengths / 40;
  if (scenario.planar->wall) wall_ = wall_of(*scenario.planar);
  extent_ = shown.empty() ? reachable() : around(shown);
}

PendulumStage::Block PendulumStage::wall_of(const PlanarView& view) const {
  const double hinge_height = dot(frame_.hinge_m, frame_.up);
  const double top = hinge_height + reach_m_ / 2;
  const double thickness = 0.3 * reach_m_;
  const double depth = std::max(0.8 * reach_m_, 2 * links_.front().depth_m);
  const double middle = view.wall->face_m - thickness / 2 - dot(frame_.hinge_m, frame_.horizontal);
  const Vec3 centre = frame_.hinge_m + middle * frame_.horizontal + ((top + ground_m_) / 2 - hinge_height) * frame_.up;
  return {{centre, frame_.up, frame_.horizontal, frame_.axis()}, {(top - ground_m_) / 2, thickness / 2, depth / 2}};
}

std::vector<Vec3> PendulumStage::reachable() const {
  double depth = 0;
  for (const Link& link : links_) depth = std::max(depth, link.depth_m);
  std::vector<Vec3> points;
  const double face = wall_ ? dot(wall_->pose.centre_m, frame_.horizontal) + wall_->half.across : 0;
  for (int k = 0; k < 48; ++k) {
    const double angle = 2 * std::numbers::pi * k / 48;
    for (const double side : {-0.5, 0.5}) {
      Vec3 point = frame_.hinge_m + reach_m_ * (std::cos(angle) * frame_.horizontal + std::sin(angle) * frame_.up) +
                   side * depth * frame_.axis();
      if (wall_) point = point + std::max(0.0, face - dot(point, frame_.horizontal)) * frame_.horizontal;
      points.push_back(point);
    }
  }
  if (wall_) std::ranges::copy(corners_of(wall_->pose, wall_->half), std::back_inserter(points));
  return points;
}

/// The poses, the first hinge, and as much of a wall as stands beside them. What has flown off is not followed.
std::vector<Vec3> PendulumStage::around(std::span<const Pose> shown) const {
  std::vector<Vec3> points{frame_.hinge_m};
  for (const Pose& pose : shown) {
    for (std::size_t i = 0; i < pose.size(); ++i) {
      if (!drawable(pose[i]) || distance(pose[i].centre_m, frame_.hinge_m) > 1.1 * reach_m_) continue;
      const Block link = block(pose, i);
      std::ranges::copy(corners_of(link.pose, link.half), std::back_inserter(points));
    }
  }
  if (!wall_) return points;
  const auto height = [&](const Vec3& point) { return dot(point, frame_.up); };
  const auto [low, high] = std::ranges::minmax(points, {}, height);
  const double behind_face = dot(wall_->pose.centre_m, frame_.horizontal) + wall_->half.across / 2;
  for (Vec3 point : {low, high}) {
    point = point + (behind_face - dot(point, frame_.horizontal)) * frame_.horizontal;
    points.push_back(point);
  }
  return points;
}

bool PendulumStage::drawable(const LinkPose& link) const {
  // Comparisons that are false for what is no number as well.
  const auto is_unit = [](const Vec3& v) { return std::fabs(dot(v, v) - 1) < 0.1; };
  const Vec3 away = link.centre_m - frame_.hinge_m;
  return dot(away, away) < 1e6 * reach_m_ * reach_m_ && is_unit(link.along) && is_unit(link.across) &&
         is_unit(link.hinge);
}

bool PendulumStage::inside(const Camera& camera, const Pose& pose) const {
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) return false;
    const Block link = block(pose, i);
    for (const Vec3& point : corners_of(link.pose, link.half)) {
      const Pixel at = camera.project(point);
      if (at.depth_m <= 0 || at.x < 0 || at.y < 0 || at.x > camera.width() || at.y > camera.height()) return false;
    }
  }
  return true;
}

// Links next to each other are drawn a little less deep in turn: faces in the same plane would fight for pixels.
PendulumStage::Block PendulumStage::block(const Pose& pose, std::size_t link) const {
  const Link& size = links_[link];
  if (size.shape == LinkShape::sphere) return {pose[link], {size.width_m / 2, size.width_m / 2, size.width_m / 2}};
  const double depth = size.depth_m * (link % 2 == 0 ? 1 : 0.97);
  return {pose[link], {size.length_m / 2, size.width_m / 2, depth / 2}};
}

// What holds a ball, from its hinge to its centre: thin, but never too thin to see.
PendulumStage::Block PendulumStage::rod(const Pose& pose, std::size_t link) const {
  LinkPose middle = pose[link];
  const double half = links_[link].length_m / 2;
  middle.centre_m = middle.centre_m - half * middle.along;
  const double thin = std::max(0.1 * links_[link].width_m, 0.003 * reach_m_);
  return {middle, {half, thin, thin}};
}

void PendulumStage::add_hinges(Layer& layer, const Brush& brush, const Pose& pose, double edge_px) const {
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) continue;
    const double thinnest = i == 0 ? links_[0].width_m : std::min(links_[i].width_m, links_[i - 1].width_m);
    const double deepest = i == 0 ? links_[0].depth_m : std::max(links_[i].depth_m, links_[i - 1].depth_m);
    // Never too small to see, nor so large that the hinges of a long chain hide its links.
    const double radius = std::max(0.32 * thinnest, std::min(0.004 * reach_m_, 0.1 * links_[i].length_m)) /
                          (links_[i].shape == LinkShape::sphere ? 2 : 1);
    const Vec3 near = pose[i].centre_m - links_[i].centre_m() * pose[i].along;
    const Vec3 at = i == 0 ? frame_.hinge_m : near;
    // The first hinge holds on to the world; the others stand out so far that no edge is lifted over them.
    const double out = i == 0 ? 1.6 * radius : radius;
    const double half = 0.5 * deepest + out;
    brush.cylinder(layer, at, pose[i].hinge, radius, half, joint_colour, edge_px);
    add_centre_line(layer, brush, at, pose[i].hinge, {-half, half}, radius, edge_px);
  }
}

/// What throws shadows: the links, and what holds the balls.
std::vector<Quad> PendulumStage::casters_of(const Pose& pose) const {
  std::vector<Quad> casters;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) continue;
    const Block link = block(pose, i);
    if (links_[i].shape == LinkShape::sphere) {
      const Block held_by = rod(pose, i);
      add_quads(casters, held_by.pose, held_by.half);
      add_quads(casters, link.pose.centre_m, link.half.along);
    } else {
      add_quads(casters, link.pose, link.half);
    }
  }
  return casters;
}

void PendulumStage::add_floor(std::vector<Layer>& layers, const Brush& brush, const Camera& camera,
                              std::vector<Quad> casters, const Vec3& towards_lamp) const {
  if (dot(camera.eye(), frame_.up) <= ground_m_) return;  // from below, the ground would hide all
  const Vec3 middle = frame_.hinge_m + (ground_m_ - dot(frame_.hinge_m, frame_.up)) * frame_.up;
  add_ground(layers, brush, camera, {middle, frame_.horizontal, frame_.axis(), frame_.up}, reach_m_);
  if (wall_) add_quads(casters, wall_->pose, wall_->half);
  add_shadows(layers, casters, {frame_.up, ground_m_}, {}, towards_lamp);
}

void PendulumStage::add_wall(std::vector<Layer>& layers, const Brush& brush, const Camera& camera,
                             const std::vector<Quad>& casters, const Vec3& towards_lamp) const {
  Layer& wall = layers.emplace_back();
  brush.box(wall, wall_->pose, wall_->half, wall_colour, edge_width_px(camera));
  const double face = dot(wall_->pose.centre_m, frame_.horizontal) + wall_->half.across;
  if (dot(camera.eye(), frame_.horizontal) <= face) return;
  const double side = dot(wall_->pose.centre_m, frame_.axis());
  const double top = dot(wall_->pose.centre_m, frame_.up) + wall_->half.along;
  add_shadows(layers, casters, {frame_.horizontal, face},
              {{frame_.axis(), side - wall_->half.hinge},
               {-1 * frame_.axis(), -side - wall_->half.hinge},
               {frame_.up, ground_m_},
               {-1 * frame_.up, -top}},
              towards_lamp);
}

void PendulumStage::add_links(Layer& links, const Brush& brush, const Pose& pose, double edge_px) const {
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) continue;
    const Block link = block(pose, i);
    if (links_[i].shape == LinkShape::sphere) {
      const Block held_by = rod(pose, i);
      brush.box(links, held_by.pose, held_by.half, colour_in_turn(i), 0);
      brush.sphere(links, link.pose, link.half.along, colour_in_turn(i), edge_px);
    } else {
      brush.box(links, link.pose, link.half, colour_in_turn(i), edge_px);
    }
  }
}

void PendulumStage::add_wires(Layer& wires, const Brush& brush, const Pose& pose, const Colour& colour,
                              double px) const {
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) continue;
    const Block link = block(pose, i);
    if (links_[i].shape == LinkShape::sphere) {
      const Block held_by = rod(pose, i);
      brush.wire(wires, held_by.pose, held_by.half, colour, px);
      brush.circles(wires, link.pose, link.half.along, colour, px);
    } else {
      brush.wire(wires, link.pose, link.half, colour, px);
    }
  }
}

std::vector<Layer> PendulumStage::layers(const Camera& camera, const Pose& pose, const Pose* outline) const {
  const Vec3 towards_lamp = unit(0.55 * frame_.horizontal + 0.75 * frame_.axis() + 1.1 * frame_.up);
  const Brush brush(camera, frame_.up, frame_.hinge_m + lamp_distance * reach_m_ * towards_lamp);
  const double edge_px = edge_width_px(camera);
  const std::vector<Quad> casters = casters_of(pose);

  std::vector<Layer> layers;
  add_floor(layers, brush, camera, casters, towards_lamp);
  if (wall_) add_wall(layers, brush, camera, casters, towards_lamp);
  Layer& links = layers.emplace_back();
  add_links(links, brush, pose, edge_px);
  add_hinges(links, brush, pose, edge_px);
  if (outline != nullptr) {
    add_outline(layers, edge_px,
                [&](Layer& wires, const Colour& colour, double px) { add_wires(wires, brush, *outline, colour, px); });
  }
  return layers;
}

}  // namespace odeval::render
