#pragma once
// Recorded bodies into columns of a trace.
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "odeval/mechanism.hpp"
#include "odeval/motion.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Room for so many rows of so many bodies.
inline void resize_bodies(Trace& trace, std::size_t bodies, std::size_t rows) {
  const auto size = [rows](auto& columns) {
    for (Column& column : columns) column.resize(rows);
  };
  trace.bodies.resize(bodies);
  for (BodyColumns& body : trace.bodies) {
    size(body.position);
    size(body.rotation);
    size(body.velocity);
    size(body.spin);
    size(body.joint_force);
  }
}

/// One sample of a body into its columns; `joint_force` is that of the joint that tables show beside it.
inline void store_body(BodyColumns& columns, std::size_t row, const BodyState& body, const Vec3& joint_force) {
  const auto store = [row]<std::size_t N>(std::array<Column, N>& to, const std::array<double, N>& values) {
    for (std::size_t i = 0; i < N; ++i) to[i][row] = values[i];
  };
  store(columns.position, body.position);
  store(columns.rotation, body.rotation);
  store(columns.velocity, body.velocity);
  store(columns.spin, body.spin);
  store(columns.joint_force, joint_force);
}

/// The force that tables show beside each body: of its carrier, zero without one.
class ForcesOfBodies {
 public:
  explicit ForcesOfBodies(const Mechanism& mechanism) {
    for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) carriers_.push_back(carrier_of(mechanism, i));
  }

  Vec3 operator()(std::size_t body, std::span<const JointState> joints) const {
    return force_beside(carriers_[body], joints);
  }

 private:
  std::vector<std::optional<Carrier>> carriers_;
};

/// Spin about one of the body's own axes, rad/s.
inline double spin_along(const BodyState& body, std::size_t axis) {
  return dot(body.spin, axis_of(body.rotation, axis));
}

}  // namespace odeval
