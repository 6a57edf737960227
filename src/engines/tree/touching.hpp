#pragma once
// What touches what, for engines that ask of two things by their numbers.
#include <optional>
#include <vector>

#include "odeval/mechanism.hpp"

namespace odeval::engine_tree {

/// Numbers are those of bodies, and those of obstacles after them.
class Touching {
 public:
  explicit Touching(const Mechanism& mechanism);

  /// Nothing touches anything.
  bool empty() const { return of_pair_.empty(); }
  /// Null: they pass through each other.
  const Contact* between(std::size_t first, std::size_t second) const;
  /// Bodies and obstacles.
  std::size_t count() const { return count_; }

 private:
  std::size_t count_;
  std::vector<Contact> contacts_;
  std::vector<const Contact*> of_pair_;
};

/// Damping over critical damping by which what is thrown against a spring and damper that push and never pull leaves
/// them at a part of its speed: a restitution as engines have it whose contacts are springs. For a restitution of 0,
/// which no damping gives, 1: that leaves 0.135 of the speed.
double damping_ratio(double restitution);

}  // namespace odeval::engine_tree
