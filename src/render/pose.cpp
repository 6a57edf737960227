#include "render/pose.hpp"

namespace odeval::render {
namespace {

Pose from_bodies(const PlanarFrame& frame, const Trace& trace, std::size_t row) {
  Pose pose;
  for (const BodyColumns& body : trace.bodies) {
    const auto turned = [&](const Vec3& v) {
      Vec3 world{};
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) world[i] += body.rotation[3 * i + j][row] * v[j];
      }
      return world;
    };
    pose.push_back({{body.position[0][row], body.position[1][row], body.position[2][row]},
                    turned(frame.along_body),
                    turned(frame.across_body),
                    turned(frame.hinge_axis)});  // links turn about it, so it is the same in body and world frame
  }
  return pose;
}

Pose from_angles(const Scenario& scenario, const Trace& trace, std::size_t row) {
  const PlanarFrame& frame = scenario.planar->frame;
  Pose pose;
  Vec3 near = frame.hinge_m;
  double angle = 0;
  for (std::size_t i = 0; i < scenario.planar->links.size(); ++i) {
    angle += trace.q[i][row];
    const Vec3 along = std::cos(angle) * frame.horizontal + std::sin(angle) * frame.up;
    const Link& link = scenario.planar->links[i];
    pose.push_back({near + link.centre_m() * along, along, cross(frame.axis(), along), frame.hinge_axis});
    near = near + link.length_m * along;
  }
  return pose;
}

}  // namespace

Pose pose_at(const Scenario& scenario, const Trace& trace, std::size_t row) {
  return trace.bodies.empty() ? from_angles(scenario, trace, row) : from_bodies(scenario.frame(), trace, row);
}

}  // namespace odeval::render
