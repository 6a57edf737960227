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

/// What bodies were when it was made: poses, velocities and forces.
class Saved {
 public:
  void save(const Mechanism& mechanism);
  void restore() const;
  /// Forces and torques alone.
  void restore_forces() const;

 private:
  struct Exact {
    dBodyID id;
    dReal position[3], quaternion[4], rotation[12], velocity[3], spin[3], force[3], torque[3];
  };
  std::vector<Exact> bodies_;
};

}  // namespace odeval::engine_rk4
