#pragma once
// What contacts do to velocities and poses: complementarity, solved for the whole mechanism.
#include <span>
#include <utility>
#include <vector>

#include "engines/ode_rk4/accurate_step.hpp"
#include "engines/ode_rk4/motion.hpp"

namespace odeval::engine_rk4 {

/// A point where body a meets body b. World frame.
struct Contact {
  std::size_t a, b;  // one of them may be world_body
  Vector3d point;    // m
  Vector3d normal;   // unit; moving a along it takes the bodies apart
  double depth;      // m
  double restitution;
  std::pair<const void*, const void*> geoms;  // in the order of their addresses; of a stop, its joint and itself
  bool turns = false;                         // a stop of a hinge: the normal is an axis, the depth an angle
};

/// Normal speed of a against b at a contact found at `state`, m/s; negative: they approach.
double normal_speed(const Contact& contact, const State& state);
/// The same, for velocities of another time.
double normal_speed(const Contact& contact, const State& found_at, const State& velocities);

/// What impulses at the contacts of one pose do: that of the motion's last projection.
class Impact {
 public:
  Impact(Motion& motion, std::span<const Contact> contacts, const State& state);

  /// After it no contact closes, impulses have only pushed, and kinetic energy is at most what it was, by the laws of
  /// restitution.hpp. All bodies feel the impulses through the joints.
  void strike(State& state, ImpactOrder order, double rest_speed) const;
  /// Without restitution.
  void stop(State& state) const;

  /// Moves the bodies apart, mass-weighted and with joints kept, until no contact is deeper than `depth`, to the first
  /// order in the way, and by what is given besides. Ends what the Impact can be used for. Returns the joint error that
  /// is left.
  JointError push_out(double depth, State& state, std::span<const Twist> besides = {}) const;

 private:
  double free_response(const Contact& contact) const;
  Eigen::VectorXd speeds(const State& state) const;
  void strike_by(const Eigen::VectorXd& impulses, State& state) const;
  void respond(const Eigen::VectorXd& sizes) const;  // into change_

  Motion& motion_;
  std::span<const Contact> contacts_;
  Eigen::MatrixXd response_;    // speeds of the contacts, for a unit impulse at each
  std::vector<Vector3d> arms_;  // of each contact on its two bodies
  mutable std::vector<Wrench> impulses_;
  mutable std::vector<Twist> change_;
};

}  // namespace odeval::engine_rk4
