#pragma once
// Between ODE's bodies and a state: reading, showing, and putting back to the last bit.
#include <vector>

#include "engines/ode_rk4/motion.hpp"

namespace odeval::engine_rk4 {

/// Throws AccurateStepError for numbers that are not finite.
void read_state(const Mechanism& mechanism, State& state);
/// What has been added to the bodies, and gravity. Throws AccurateStepError for numbers that are not finite.
void read_forces(dWorldID world, const Mechanism& mechanism, std::vector<Wrench>& forces);

void show_poses(const Mechanism& mechanism, const State& state);
void show_twists(const Mechanism& mechanism, const State& state);

bool finite(const State& state);

/// What bodies have besides a state, when it was made: forces, and the rotation matrices to the last bit.
class Saved {
 public:
  void save(const Mechanism& mechanism);
  /// Puts them back, and the state that was read then.
  void restore(const State& state) const;
  /// Forces and torques alone.
  void restore_forces() const;

 private:
  struct Exact {
    dBodyID id;
    dReal rotation[12], force[3], torque[3];
  };
  std::vector<Exact> bodies_;
};

}  // namespace odeval::engine_rk4
