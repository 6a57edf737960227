#include "engines/ode_rk4/islands.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace odeval::engine_rk4 {

std::vector<std::vector<std::size_t>> Islands::afloat() {
  std::vector<std::vector<std::size_t>> all(up_.size());
  std::vector<char> held(up_.size(), 0);
  for (std::size_t i = 0; i < up_.size(); ++i) {
    all[top(i)].push_back(i);
    if (held_[i] != 0 || !moves(i)) held[top(i)] = 1;
  }
  for (std::size_t i = 0; i < up_.size(); ++i) {
    if (held[i] != 0) all[i].clear();
  }
  std::erase_if(all, [](const std::vector<std::size_t>& bodies) { return bodies.size() < 2; });
  return all;
}

RigidMotion shared_motion(const Mechanism& mechanism, const State& state, std::span<const std::size_t> bodies) {
  double mass = 0;
  Vector3d centre = Vector3d::Zero(), momentum = centre, angular = centre;
  for (const std::size_t i : bodies) {
    const double inverse_mass = mechanism.bodies[i].inverse_mass;
    mass += 1 / inverse_mass;
    centre += state[i].pose.position / inverse_mass;
    momentum += state[i].twist.linear / inverse_mass;
  }
  centre /= mass;
  Matrix3d inertia = Matrix3d::Zero();
  for (const std::size_t i : bodies) {
    const Body& body = mechanism.bodies[i];
    const auto& [pose, twist] = state[i];
    const Vector3d arm = pose.position - centre;
    const Matrix3d turn = Quaterniond(pose.turn[0], pose.turn[1], pose.turn[2], pose.turn[3]).toRotationMatrix();
    const Matrix3d own = turn * body.inertia * turn.transpose();
    inertia += own + (arm.squaredNorm() * Matrix3d::Identity() - arm * arm.transpose()) / body.inverse_mass;
    angular += own * twist.angular + arm.cross(twist.linear) / body.inverse_mass;
  }
  return {centre, momentum / mass, inertia.ldlt().solve(angular)};
}

}  // namespace odeval::engine_rk4
