#pragma once
// What the engines in joint coordinates have in common, and the two bodies of Bullet that a hinge holds: a mechanism
// that takes steps.
#include <memory>
#include <stdexcept>
#include <vector>

#include "odeval/mechanism.hpp"
#include "odeval/told.hpp"

namespace odeval::engine_tree {

/// Where a body is and how it moves, in the world.
struct Placed {
  Vec3 position_m{};  // of the centre of mass
  Rotation rotation{};
  Vec3 velocity_m_s{};  // likewise
  Vec3 spin_rad_s{};
};

/// The motion can not go on: it left the finite numbers, or the engine gave up.
struct Lost : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What touched in the step that led here.
struct Touched {
  long contacts = 0;  // points
  double depth = 0;   // m, of the deepest of them
};

/// An engine's world with a mechanism in it.
class World {
 public:
  virtual ~World() = default;

  /// Moves it from one time to another, s; the engine's own steps that it took, one where the step is fixed.
  /// Throws Lost.
  virtual long step(double from, double to) = 0;
  /// Whether it chooses its own steps: then between two times any number of others may be left out.
  virtual bool chooses_steps() const { return false; }
  /// By the numbers of bodies; stays until the next call.
  virtual const std::vector<Placed>& bodies() = 0;
  /// Nothing where no two things may.
  virtual Touched touched() { return {}; }
  /// What contacts gave each body in the last step, N, by the numbers of bodies; empty where no two things may touch.
  virtual std::vector<Vec3> contact_forces() { return {}; }
  /// N, on the first body of each joint that closes a loop (hang), in the last step.
  virtual std::vector<Vec3> closing_forces() { return {}; }
  /// What the engine was told, as it says it.
  virtual Told told() const = 0;
};

/// Throws Lost unless a sum of squares of speeds is finite with room for energies.
inline void require_finite(double sum) {
  if (!(sum < 1e290)) throw Lost("a velocity or its square left the finite numbers");
}

}  // namespace odeval::engine_tree
