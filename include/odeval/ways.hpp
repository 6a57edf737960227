#pragma once
// Where joints and struts of one way stand, and how fast they go, read off the bodies.
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "odeval/mechanism.hpp"
#include "odeval/motion.hpp"

namespace odeval {

/// A way and its rate.
struct Way {
  double q = 0;     // rad or m
  double rate = 0;  // per second
};

/// Whether a joint leaves one motion: a hinge or a slider.
bool has_one_way(const JointKind& kind);

/// What files call a kind: "hinge".
std::string_view word_of(const JointKind& kind);

/// Files count a child against its parent, which is the joint's second body unless that is the world: -1 where it is.
inline double sign_in_files(const Joint& joint) { return joint.second ? -1 : 1; }

/// Reads ways off bodies that are given in the order of the mechanism's.
class WayReader {
 public:
  /// By where the bodies stand at t = 0. The mechanism must outlive it.
  WayReader(const Mechanism& mechanism, std::span<const BodyState> start);

  /// Of a hinge or a slider, as the joint counts: the first body against the second, from t = 0. Of a hinge within half
  /// a turn.
  Way joint(std::size_t number, std::span<const BodyState> bodies) const;
  /// Of a hinge2: how far its wheel has gone along its first axis from where the suspension is relaxed.
  Way suspension(std::size_t number, std::span<const BodyState> bodies) const;
  /// Of a strut: its length.
  Way strut(std::size_t number, std::span<const BodyState> bodies) const;

  /// The energy in all struts and suspensions, J.
  double elastic_energy(std::span<const BodyState> bodies) const;
  /// What their dampers take a second, W, not above 0.
  double damping_power(std::span<const BodyState> bodies) const;

 private:
  /// Points and an axis that are fixed in two bodies, or in one and the world.
  struct Pair {
    std::size_t first;
    std::optional<std::size_t> second;
    std::array<Vec3, 2> ends{};    // in the bodies' own axes
    std::array<Vec3, 2> axes{};    // likewise; of the world as they are
    std::array<Vec3, 2> across{};  // at right angles to it, likewise
    double start = 0;              // of a slider at t = 0, m
  };
  Pair pair(std::size_t first, std::optional<std::size_t> second, const std::array<Vec3, 2>& ends, const Vec3& axis,
            std::span<const BodyState> start) const;

  const Mechanism& mechanism_;
  std::vector<Pair> joints_;
  std::vector<Pair> struts_;
};

}  // namespace odeval
