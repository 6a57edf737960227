#include <algorithm>
#include <cmath>
#include <string>

#include "model/generate.hpp"

namespace odeval {
namespace {

/// Side lengths of the link's box along its body axes.
Vec3 box_sides(const Link& link, const PlanarFrame& frame) {
  Vec3 sides;
  for (std::size_t k = 0; k < 3; ++k) {
    sides[k] = std::fabs(frame.along_body[k]) * link.length_m + std::fabs(frame.across_body[k]) * link.width_m +
               std::fabs(frame.hinge_axis[k]) * link.depth_m;
  }
  return sides;
}

Shape shape_of(const Link& link, const PlanarFrame& frame) {
  if (link.shape == LinkShape::sphere) return Sphere{link.width_m};
  return Box{box_sides(link, frame)};
}

void add_links(Mechanism& mechanism, const PlanarView& view) {
  const PlanarFrame& frame = view.frame;
  const Vec3 axis = frame.axis();
  Vec3 near = frame.hinge_m;
  Vec3 near_velocity{};
  double angle = 0;
  double rate = 0;
  for (std::size_t i = 0; i < view.links.size(); ++i) {
    const Link& link = view.links[i];
    angle += view.q0[i];
    rate += view.qd0[i];
    const Vec3 along = std::cos(angle) * frame.horizontal + std::sin(angle) * frame.up;
    const Vec3 across = cross(axis, along);  // a point at distance s along the link moves with rate * s * across
    mechanism.bodies.push_back({.shape = shape_of(link, frame),
                                .mass_kg = link.mass_kg,
                                .position_m = near + link.centre_m() * along,
                                .attitude = AxisAngle{axis, angle + frame.rest_turn_rad},
                                .velocity_m_s = near_velocity + rate * link.centre_m() * across,
                                .spin_rad_s = rate * axis,
                                .name = "link" + std::to_string(i + 1)});
    Joint hinge{.kind = HingeJoint{near, frame.hinge_axis}, .first = i, .second = {}};
    if (i > 0) {
      hinge.first = i - 1;
      hinge.second = i;
    }
    mechanism.joints.push_back(hinge);
    near = near + link.length_m * along;
    near_velocity = near_velocity + rate * link.length_m * across;
  }
}

// The report's wall is a box of 1.8 x 2.0 x 5.5 m whose middle is the origin: face at x = 0.9, top at z = 2.75, below
// the hinge at z = 3. The scenario's wall is the plane of that face, so the box keeps its thickness and grows in height
// (and depth) beyond the link's reach: no link swings over it, and none that the report's wall would stop goes free.
// C.5 hangs its link on a further body that a fixed joint holds inside the wall, in contact with it in every step; the
// world itself is what that body stands for.
FixedBox box_of(const Wall& wall, const PlanarView& view) {
  const Link& link = view.links.front();
  const double reach = std::hypot(link.length_m, link.width_m / 2);
  const double thickness = 1.8;
  const double depth = std::max(2.0, 2 * link.depth_m);
  const double height = std::max(5.5, 2 * (view.frame.hinge_m[2] + reach + 1));
  return {{wall.face_m - thickness / 2, 0, 0}, {thickness, depth, height}};
}

// Of one link its angle, of several each ball's way to the wall.
std::vector<ImpactView> impacts_on(const Wall& wall, const PlanarView& view) {
  const Vec3 away{1, 0, 0};
  if (view.links.size() == 1) return {{.normal = away, .as_angle = true, .as_rate = true}};
  std::vector<ImpactView> views;
  for (std::size_t i = 0; i < view.links.size(); ++i) {
    views.push_back({.body = i,
                     .normal = away,
                     .as_angle = true,
                     .touches_at = wall.face_m + view.links[i].width_m / 2,
                     .link = static_cast<int>(i) + 1});
  }
  return views;
}

}  // namespace

void put_planar(Scenario& scenario, PlanarView view) {
  scenario.mechanism = {};
  scenario.impact_views.clear();
  add_links(scenario.mechanism, view);
  if (view.wall) {
    scenario.mechanism.obstacles.push_back({box_of(*view.wall, view), "wall"});
    scenario.mechanism.contacts.push_back({.restitution = view.wall->restitution});
    scenario.impact_views = impacts_on(*view.wall, view);
  }
  scenario.planar = std::make_shared<const PlanarView>(std::move(view));
}

}  // namespace odeval
