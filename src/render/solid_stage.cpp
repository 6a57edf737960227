#include "render/solid_stage.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace odeval::render {
namespace {

constexpr double far_m = 1e6;  // beyond, nothing is drawn
constexpr double largest_standing =
    4;  // half a diagonal of what stands in the world, in reaches: the camera is farther
constexpr Colour standing{176, 180, 187};  // what no body carries

bool drawable(const LinkPose& body) {
  // Comparisons that are false for what is no number as well.
  const auto is_unit = [](const Vec3& v) { return std::fabs(dot(v, v) - 1) < 0.1; };
  return dot(body.centre_m, body.centre_m) < far_m * far_m && is_unit(body.along) && is_unit(body.across) &&
         is_unit(body.hinge);
}

Vec3 turned(const LinkPose& body, const Vec3& v) { return v[0] * body.across + v[1] * body.hinge + v[2] * body.along; }

LinkPose in_world(const Solid& solid, const Pose& pose) {
  if (!solid.body) return solid.place;
  const LinkPose& body = pose[*solid.body];
  return {body.centre_m + turned(body, solid.place.centre_m), turned(body, solid.place.along),
          turned(body, solid.place.across), turned(body, solid.place.hinge)};
}

/// Half the sides of the box around it.
BoxSize half(const Solid& solid) {
  const auto& [x, y, z] = solid.size_m;
  switch (solid.kind) {
    case Solid::Kind::box:
      return {z / 2, x / 2, y / 2};
    case Solid::Kind::sphere:
      return {x, x, x};
    case Solid::Kind::capsule:
      return {y / 2 + x, x, x};
    case Solid::Kind::cylinder:
      break;
  }
  return {y / 2, x, x};
}

double radius(const Solid& solid) {
  const BoxSize box = half(solid);
  if (solid.kind == Solid::Kind::sphere) return box.along;
  return std::hypot(box.along, box.across, box.hinge);
}

LinkPose moved(LinkPose place, double along) {
  place.centre_m = place.centre_m + along * place.along;
  return place;
}

void add(Layer& layer, const Brush& brush, const Solid& solid, const LinkPose& place, const Colour& colour, double px) {
  const double r = solid.size_m[0];
  const double length = solid.size_m[1];
  switch (solid.kind) {
    case Solid::Kind::box:
      return brush.box(layer, place, half(solid), colour, px);
    case Solid::Kind::sphere:
      return brush.sphere(layer, place, r, colour, px);
    case Solid::Kind::capsule:
      for (const double end : {-0.5, 0.5}) brush.sphere(layer, moved(place, end * length), r, colour, 0);
      break;
    case Solid::Kind::cylinder:
      break;
  }
  brush.cylinder(layer, place.centre_m, place.along, r, length / 2, colour, px);
}

/// Its edges alone: of what is round, its rims and four lines between them.
void add_wires(Layer& layer, const Brush& brush, const Solid& solid, const LinkPose& place, const Colour& colour,
               double px) {
  const double r = solid.size_m[0];
  if (solid.kind == Solid::Kind::box) return brush.wire(layer, place, half(solid), colour, px);
  if (solid.kind == Solid::Kind::sphere) return brush.circles(layer, place, r, colour, px);
  constexpr int pieces = 48;
  const auto rim = [&](double end, int k) {
    const double angle = 2 * std::numbers::pi * k / pieces;
    return place.centre_m + end * solid.size_m[1] * place.along +
           r * (std::cos(angle) * place.across + std::sin(angle) * place.hinge);
  };
  for (const double end : {-0.5, 0.5}) {
    for (int k = 0; k < pieces; ++k) brush.line(layer, rim(end, k), rim(end, k + 1), px, colour, colour);
    if (solid.kind == Solid::Kind::capsule) {
      brush.circles(layer, moved(place, end * solid.size_m[1]), r, colour, px);
    }
  }
  for (int k = 0; k < pieces; k += pieces / 4) brush.line(layer, rim(-0.5, k), rim(0.5, k), px, colour, colour);
}

void add_casters(std::vector<Quad>& casters, const Solid& solid, const LinkPose& place) {
  if (solid.kind == Solid::Kind::sphere) return add_quads(casters, place.centre_m, solid.size_m[0]);
  add_quads(casters, place, half(solid));
}

/// At right angles to a unit vector.
Vec3 across(const Vec3& v) {
  const Vec3 least = std::fabs(v[0]) <= std::fabs(v[1]) || std::fabs(v[0]) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return unit(least - dot(least, v) * v);
}

/// The level direction in which the bodies' corners are spread most.
Vec3 widest(const std::vector<Solid>& solids, const Vec3& up, std::span<const Pose> shown) {
  const Vec3 u = across(up);
  const Vec3 v = cross(up, u);
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (const Pose& pose : shown) {
    for (const Solid& solid : solids) {
      if (!solid.body || !drawable(pose[*solid.body])) continue;
      for (const Vec3& corner : corners_of(in_world(solid, pose), half(solid))) {
        const double a = dot(corner, u);
        const double b = dot(corner, v);
        n += 1;
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
        yy += b * b;
      }
    }
  }
  if (n == 0) return u;
  const double angle = 0.5 * std::atan2(2 * (xy - x * y / n), xx - x * x / n - (yy - y * y / n));
  return std::cos(angle) * u + std::sin(angle) * v;
}

}  // namespace

SolidStage::SolidStage(std::vector<Solid> solids, const std::vector<Ground>& grounds, const Vec3& up,
                       std::span<const Pose> shown, JointMarks joints)
    : solids_(std::move(solids)), joints_(std::move(joints)) {
  frame_.up = up;
  frame_.horizontal = widest(solids_, up, shown);
  Vec3 low{far_m, far_m, far_m};
  Vec3 high{-far_m, -far_m, -far_m};
  for (const Pose& pose : shown) {
    for (const Solid& solid : solids_) {
      if (!solid.body || !drawable(pose[*solid.body])) continue;
      for (const Vec3& corner : corners_of(in_world(solid, pose), half(solid))) {
        for (std::size_t k = 0; k < 3; ++k) {
          low[k] = std::min(low[k], corner[k]);
          high[k] = std::max(high[k], corner[k]);
        }
      }
    }
  }
  if (low[0] > high[0]) low = high = {};  // nothing that could be drawn
  frame_.hinge_m = 0.5 * (low + high);
  reach_m_ = std::max(length(high - low) / 2, 1e-3);
  std::erase_if(solids_, [this](const Solid& one) { return !one.body && radius(one) > largest_standing * reach_m_; });
  for (const auto& [normal, offset] : grounds) {
    if (dot(normal, up) < 0.5) continue;  // walls
    const Vec3 u = across(normal);
    ground_ = {frame_.hinge_m - (dot(frame_.hinge_m, normal) - offset) * normal, u, cross(normal, u), normal};
  }
}

std::vector<Vec3> SolidStage::extent() const {
  std::vector<Vec3> points;
  for (int k = 0; k < 48; ++k) {
    const double angle = 2 * std::numbers::pi * k / 48;
    for (const Vec3& side : {frame_.up, frame_.axis()}) {
      points.push_back(frame_.hinge_m + reach_m_ * (std::cos(angle) * frame_.horizontal + std::sin(angle) * side));
    }
  }
  return points;
}

bool SolidStage::seen(const Solid& solid, const Pose& pose) const { return !solid.body || drawable(pose[*solid.body]); }

bool SolidStage::inside(const Camera& camera, const Pose& pose) const {
  for (const Solid& solid : solids_) {
    if (!solid.body) continue;
    if (!seen(solid, pose)) return false;
    for (const Vec3& point : corners_of(in_world(solid, pose), half(solid))) {
      const Pixel at = camera.project(point);
      if (at.depth_m <= 0 || at.x < 0 || at.y < 0 || at.x > camera.width() || at.y > camera.height()) return false;
    }
  }
  return true;
}

std::vector<Layer> SolidStage::layers(const Camera& camera, const Pose& pose, const Pose* outline) const {
  const Vec3 towards_lamp = unit(0.55 * frame_.horizontal + 0.75 * frame_.axis() + 1.1 * frame_.up);
  const Brush brush(camera, frame_.up, frame_.hinge_m + lamp_distance * reach_m_ * towards_lamp);
  const double edge_px = edge_width_px(camera);
  std::vector<Layer> layers;
  // From below, the ground would hide all.
  if (ground_ && dot(camera.eye() - ground_->middle, ground_->normal) > 0 && dot(ground_->normal, towards_lamp) > 0.1) {
    std::vector<Quad> casters;
    for (const Solid& solid : solids_) {
      if (seen(solid, pose)) add_casters(casters, solid, in_world(solid, pose));
    }
    add_ground(layers, brush, camera, *ground_, reach_m_);
    add_shadows(layers, casters, {ground_->normal, dot(ground_->middle, ground_->normal)}, {}, towards_lamp);
  }
  Layer& drawn = layers.emplace_back();
  for (const Solid& solid : solids_) {
    if (!seen(solid, pose)) continue;
    add(drawn, brush, solid, in_world(solid, pose), solid.body ? colour_in_turn(*solid.body) : standing, edge_px);
  }
  std::vector<bool> shown(pose.size());
  for (std::size_t i = 0; i < shown.size(); ++i) shown[i] = drawable(pose[i]);
  if (!shown.empty()) joints_.add(drawn, brush, pose, shown, reach_m_, edge_px);
  if (outline != nullptr) {
    add_outline(layers, edge_px, [&](Layer& wires, const Colour& colour, double px) {
      for (const Solid& solid : solids_) {
        if (solid.body && seen(solid, *outline)) add_wires(wires, brush, solid, in_world(solid, *outline), colour, px);
      }
    });
  }
  return layers;
}

}  // namespace odeval::render
