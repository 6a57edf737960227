#include "reference/tree/contact_points.hpp"

#include <algorithm>

namespace odeval::reference {
namespace {

const Contact* contact_between(const Mechanism& mechanism, const std::string& a, const std::string& b) {
  const auto found =
      std::ranges::find_if(mechanism.contacts, [&](const Contact& contact) { return contact.is_between(a, b); });
  return found == mechanism.contacts.end() ? nullptr : &*found;
}

bool may_touch(const Mechanism& mechanism, const Body& first, const Body& second) {
  const std::vector<Part> ones = first.parts();
  const std::vector<Part> others = second.parts();
  return std::ranges::any_of(ones, [&](const Part& one) {
    return std::ranges::any_of(others, [&](const Part& other) {
      return contact_between(mechanism, first.touches_as(one), second.touches_as(other)) != nullptr;
    });
  });
}

bool connected(const Mechanism& mechanism, std::size_t a, std::size_t b) {
  return std::ranges::any_of(mechanism.joints, [&](const Joint& joint) {
    return (joint.first == a && joint.second == b) || (joint.first == b && joint.second == a);
  });
}

/// Adds the points of a shape that may come to be its lowest ones; false where these are not so many.
struct AddPoints {
  std::vector<ContactPoint>& points;
  ContactPoint point;
  const Frame& place;

  bool operator()(const Box& box) {
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        for (const double z : {-0.5, 0.5}) add({x * box.sides_m[0], y * box.sides_m[1], z * box.sides_m[2]});
      }
    }
    return true;
  }
  bool operator()(const Sphere& ball) {
    point.radius_m = ball.diameter_m / 2;
    add({});
    return true;
  }
  bool operator()(const Capsule& bar) {
    point.radius_m = bar.diameter_m / 2;
    for (const double end : {-0.5, 0.5}) add({0, 0, end * (bar.length_m - bar.diameter_m)});
    return true;
  }
  bool operator()(const Cylinder&) { return false; }  // a rim

 private:
  void add(const Vec3& corner_m) {
    point.corner_m = place.position_m + turned(place.rotation, corner_m);
    points.push_back(point);
  }
};

double radius_of(const Shape& shape) {
  const auto* const ball = std::get_if<Sphere>(&shape);
  return ball == nullptr ? 0 : ball->diameter_m / 2;
}

/// False where they may touch in a way that is not followed.
bool add_plane(std::vector<ContactPoint>& points, const Mechanism& mechanism, std::size_t i, const Obstacle& obstacle) {
  const Body& body = mechanism.bodies[i];
  const auto* const plane = std::get_if<HalfSpace>(&obstacle.shape);
  return std::ranges::all_of(body.parts(), [&](const Part& part) {
    const Contact* const contact = contact_between(mechanism, body.touches_as(part), obstacle.name);
    if (contact == nullptr) return true;
    if (plane == nullptr) return false;
    const ContactPoint point{.body = i, .plane = *plane, .other = {}, .restitution = contact->restitution};
    return std::visit(AddPoints{points, point, part.place}, part.shape);
  });
}

/// Likewise.
bool add_pair(std::vector<ContactPoint>& points, const Mechanism& mechanism, std::size_t i, std::size_t j) {
  const Body& first = mechanism.bodies[i];
  const Body& second = mechanism.bodies[j];
  if (!may_touch(mechanism, first, second) || connected(mechanism, i, j)) return true;
  // Of several shapes a body's own is the box around them.
  if (!is_sphere(first.shape) || !is_sphere(second.shape)) return false;
  const Contact* const contact = contact_between(mechanism, first.name, second.name);
  points.push_back({.body = i,
                    .radius_m = radius_of(first.shape),
                    .other = j,
                    .other_radius_m = radius_of(second.shape),
                    .restitution = contact->restitution});
  return true;
}

}  // namespace

Meeting meeting(const ContactPoint& point, const std::vector<Placed>& bodies) {
  const Placed& body = bodies[point.body];
  const Vec3 arm = turned(body.rotation, point.corner_m);
  const Vec3 place = body.position_m + arm;
  const auto velocity = [](const Placed& of, const Vec3& at) {
    return of.velocity_m_s + cross(of.spin_rad_s, at - of.position_m);
  };
  Meeting now;
  if (!point.other) {
    now.normal = point.plane.normal;
    now.apart_m = dot(now.normal, place) - point.plane.offset_m - point.radius_m;
    now.point_m = place - point.radius_m * now.normal;
    now.rate_m_s = dot(now.normal, velocity(body, now.point_m));
    return now;
  }
  const Placed& other = bodies[*point.other];
  const Vec3 between = place - other.position_m;
  // A step may look beyond the contact, where centres may meet: then any direction will do.
  now.normal = length(between) > 0 ? unit(between) : Vec3{0, 0, 1};
  now.apart_m = length(between) - point.radius_m - point.other_radius_m;
  now.point_m = other.position_m + point.other_radius_m * now.normal;
  now.rate_m_s = dot(now.normal, velocity(body, now.point_m) - velocity(other, now.point_m));
  return now;
}

std::optional<std::vector<ContactPoint>> contact_points(const Mechanism& mechanism) {
  std::vector<ContactPoint> points;
  if (mechanism.contacts.empty()) return points;
  const auto no_impact = [](const Contact& contact) { return contact.friction || contact.spring; };
  if (std::ranges::any_of(mechanism.contacts, no_impact)) return std::nullopt;
  for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
    for (const Obstacle& obstacle : mechanism.obstacles) {
      if (!add_plane(points, mechanism, i, obstacle)) return std::nullopt;
    }
    for (std::size_t j = i + 1; j < mechanism.bodies.size(); ++j) {
      if (!add_pair(points, mechanism, i, j)) return std::nullopt;
    }
  }
  return points;
}

}  // namespace odeval::reference
