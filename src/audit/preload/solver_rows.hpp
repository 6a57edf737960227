#pragma once
// What ODE's solvers have to do in a step, counted.
#include <ode/ode.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "audit/preload/record_format.hpp"

namespace odeval::audit {

constexpr std::size_t not_moving = std::numeric_limits<std::size_t>::max();

/// Rows that a joint of this kind adds to the equations, its motors and stops not counted.
std::uint32_t rows_of(dJointType type);
std::uint32_t rows_of(const dContact& contact);

/// Rows of each island, bodies that are joined, in a step.
class SolverRows {
 public:
  void begin(std::size_t bodies);
  /// Between the first and the second body of the world, either of which may be not_moving.
  void add(std::size_t first, std::size_t second, std::uint32_t rows);
  void add_to(Head& head);

 private:
  std::size_t root(std::size_t body);

  std::vector<std::uint32_t> parent_;
  std::vector<std::uint32_t> rows_;  // of each body's island where it is the root
};

}  // namespace odeval::audit
