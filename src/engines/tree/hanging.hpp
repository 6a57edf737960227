#pragma once
// A mechanism as engines in joint coordinates take it: bodies that hang on one another, each by what its joint leaves.
//
// C++17, as all that stands in this folder but the simulation: Simbody's headers are no C++20. The reference has a tree
// of its own, so that a mistake in one is seen beside the other.
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "odeval/mechanism.hpp"

namespace odeval::engine_tree {

/// w, x, y, z of a turn.
using Quaternion = std::array<double, 4>;

/// Where a body stands at t = 0.
struct Place {
  Vec3 position_m{};  // of the centre of mass
  Quaternion turn{1, 0, 0, 0};
  Rotation rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // the same

  /// A direction of the world in the body.
  Vec3 in_body(const Vec3& direction) const;
  /// A point of the world, from the centre of mass, in the body.
  Vec3 from_centre(const Vec3& point_m) const { return in_body(point_m - position_m); }
};

/// One turn about an axis or one way along it.
struct Degree {
  bool turns = true;
  Vec3 axis{};  // unit, world at t = 0; so that the body's turn or way against what it hangs on counts as the joint's
  double rate = 0;  // at t = 0, rad/s or m/s
};

/// A body, and what it hangs on.
struct Hanging {
  std::size_t body = 0;               // number
  std::optional<std::size_t> joint;   // number; absent: the body is free
  std::optional<std::size_t> parent;  // number of the body that carries it; absent: the world
  Place place;
  Place parent_place;
  Vec3 anchor_m{};              // of the joint
  bool ball = false;            // the joint leaves every turn about the anchor
  std::vector<Degree> degrees;  // else what it leaves, one after the other from the parent outwards
  Vec3 spin_rad_s{};            // against the parent at t = 0
};

/// All bodies, each after the one that carries it. `closing` gets the numbers of joints that close loops, which no body
/// hangs on; without it, MachineError is thrown where there are any.
std::vector<Hanging> hang(const Mechanism& mechanism, std::vector<std::size_t>* closing = nullptr);

/// About the centre of mass along the body's own axes, by rows.
std::array<double, 9> inertia_of(const Body& body);

}  // namespace odeval::engine_tree
