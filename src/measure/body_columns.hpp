#pragma once
// Recorded bodies into columns of a trace.
#include <array>
#include <cstddef>

#include "odeval/method.hpp"
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

inline void store_body(BodyColumns& columns, std::size_t row, const BodyState& body) {
  const auto store = [row]<std::size_t N>(std::array<Column, N>& to, const double(&values)[N]) {
    for (std::size_t i = 0; i < N; ++i) to[i][row] = values[i];
  };
  store(columns.position, body.position);
  store(columns.rotation, body.rotation);
  store(columns.velocity, body.velocity);
  store(columns.spin, body.spin);
  store(columns.joint_force, body.joint_force);
}

}  // namespace odeval
