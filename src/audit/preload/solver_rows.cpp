#include "audit/preload/solver_rows.hpp"

#include <array>
#include <utility>

namespace odeval::audit {

std::uint32_t rows_of(dJointType type) {
  // In the order of ODE's kinds, from none on.
  constexpr std::array<std::uint32_t, 18> rows{0, 3, 5, 5, 3, 4, 4, 6, 0, 3, 3, 3, 4, 3, 4, 1, 4, 1};
  const auto kind = static_cast<std::size_t>(type);
  return kind < rows.size() ? rows[kind] : 0;
}

std::uint32_t rows_of(const dContact& contact) {
  const bool rough = contact.surface.mu > 0 || ((contact.surface.mode & dContactMu2) != 0 && contact.surface.mu2 > 0);
  return rough ? 3 : 1;
}

void SolverRows::begin(std::size_t bodies) {
  rows_.assign(bodies, 0);
  parent_.resize(bodies);
  for (std::size_t i = 0; i < bodies; ++i) parent_[i] = static_cast<std::uint32_t>(i);
}

std::size_t SolverRows::root(std::size_t body) {
  while (parent_[body] != body) body = parent_[body] = parent_[parent_[body]];
  return body;
}

void SolverRows::add(std::size_t first, std::size_t second, std::uint32_t rows) {
  if (first == not_moving) std::swap(first, second);
  if (first == not_moving) return;
  first = root(first);
  if (second != not_moving && (second = root(second)) != first) {
    parent_[second] = static_cast<std::uint32_t>(first);
    rows += std::exchange(rows_[second], 0);
  }
  rows_[first] += rows;
}

// In ns, fitted to chains of 2 and 10 links, an arm and a box on four contacts by both steppers and 10, 20 and 50
// iterations, which it meets to a fifth. With m rows the factorization takes m^3, what comes before and after it m^2.
void SolverRows::add_to(Head& head) {
  for (const std::uint32_t rows : rows_) {
    const double m = rows;
    head.direct += m * m * (1 + m / 40);
    head.iteration += 10 * m;
    head.besides += 100 + 30 * m;
  }
}

}  // namespace odeval::audit
