#include <fmt/format.h>

#include <cmath>

#include "model/draft.hpp"
#include "model/generate.hpp"

namespace odeval {

namespace {

/// The rotation vector of one turn and then another, by the product of their quaternions.
Vec3 turn_after(const Vec3& first, const Vec3& then) {
  const auto half = [](const Vec3& v) {
    const double angle = std::sqrt(dot(v, v));
    const double part = angle == 0 ? 0.5 : std::sin(angle / 2) / angle;
    return std::pair{std::cos(angle / 2), Vec3{part * v[0], part * v[1], part * v[2]}};
  };
  const auto [a, u] = half(then);
  const auto [b, v] = half(first);
  const Vec3 turning = cross(u, v);
  Vec3 w{};
  for (std::size_t k = 0; k < 3; ++k) w[k] = a * v[k] + b * u[k] + turning[k];
  const double sine = std::sqrt(dot(w, w));
  const double angle = 2 * std::atan2(sine, a * b - dot(u, v));
  const double part = sine == 0 ? 0 : angle / sine;
  return {part * w[0], part * w[1], part * w[2]};
}

/// What stands in the file along the ground (downhill, across, away) into the world.
void lay_on_ground(Description& said) {
  const Vec3 normal = sloping(said.ground->slope_rad).normal;
  const Vec3 downhill{normal[2], 0, -normal[0]};
  const auto into_world = [&](const Vec3& v) {
    return Vec3{v[0] * downhill[0] + v[2] * normal[0], v[1], v[0] * downhill[2] + v[2] * normal[2]};
  };
  for (BodyTable& body : said.bodies) {
    body.position_m = into_world(body.position_m);
    body.velocity_m_s = into_world(body.velocity_m_s);
    body.spin_rad_s = into_world(body.spin_rad_s);
    body.turn_rad = turn_after(body.turn_rad, {0, said.ground->slope_rad, 0});
  }
}

/// What `aspect` says goes into the sides, which are held to the least size again.
void make_thin(Draft& draft) {
  constexpr double least_m = 1e-4;
  for (std::size_t i = 0; i < draft.said.bodies.size(); ++i) {
    BodyTable& body = draft.said.bodies[i];
    for (const std::size_t side : {0, 1}) {
      body.size_m[side] /= body.aspect;
      if (body.size_m[side] >= least_m) continue;
      draft.fail(fmt::format("bodies.{}.aspect", i), fmt::format("{}", body.aspect),
                 fmt::format("makes a side {:.6g} m thin; it must leave at least {} m", body.size_m[side], least_m));
    }
  }
}

void check_bodies(const Draft& draft) {
  for (const char* key : {"n", "links", "q0", "qd0", "maximal"}) draft.refuse(key);
  if (draft.said.bodies.empty()) {
    draft.fail("bodies", "0 tables",
               fmt::format("must be tables [[bodies]], at least one, for {}", draft.said.problem->name));
  }
  constexpr std::size_t most = 1024;  // as links of a chain
  if (draft.said.bodies.size() > most) {
    draft.fail("bodies", fmt::format("{} tables", draft.said.bodies.size()),
               fmt::format("must be at most {} tables [[bodies]]", most));
  }
  for (std::size_t i = 0; i < draft.said.bodies.size(); ++i) {
    const auto& [x, y, z] = draft.said.bodies[i].size_m;
    if (draft.said.bodies[i].sphere && (x != y || x != z)) {
      draft.fail(fmt::format("bodies.{}.size", i), fmt::format("[{}, {}, {}]", x, y, z),
                 "must be the diameter, three times, for a sphere");
    }
  }
}

void check_joint(const Draft& draft) {
  if (draft.said.bodies.size() > 2) {
    draft.fail("bodies", fmt::format("{} tables", draft.said.bodies.size()),
               fmt::format("must be one table [[bodies]] or two for {}", draft.said.problem->name));
  }
  if (dot(draft.said.joint->axis, draft.said.joint->axis) == 0) {
    draft.fail("joint.axis", "[0, 0, 0]", "must have a direction");
  }
}

void pull_out_of_joint(Description& said) {
  Vec3& axis = said.joint->axis;
  const double length = std::sqrt(dot(axis, axis));
  for (std::size_t k = 0; k < 3; ++k) {
    axis[k] /= length;
    said.bodies.front().position_m[k] += said.joint->displacement_m[k];
  }
}

}  // namespace

void settle_bodies(Draft& draft) {
  make_thin(draft);
  check_bodies(draft);
}

void place_bodies(Draft& draft) {
  if (draft.said.problem->joints) {
    settle_joints(draft);
    settle_contacts(draft);
  }
  if (draft.said.joint) check_joint(draft);
  if (draft.said.ground) lay_on_ground(draft.said);
  if (draft.said.joint) pull_out_of_joint(draft.said);
}

}  // namespace odeval
