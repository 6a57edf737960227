#pragma once
// Velocities that joints do not allow, brought to the nearest that they do.
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "odeval/mechanism.hpp"

namespace odeval {

/// A start that the joints do not allow, and the table of [[joints]] that is to blame.
struct BadStart : std::runtime_error {
  BadStart(std::size_t number, std::string key, const std::string& rule)
      : std::runtime_error(rule), joint(number), key_at_fault(std::move(key)) {}

  std::size_t joint;
  std::string key_at_fault;  // empty: the whole table
};

/// What was changed of a start so that all joints allow it.
struct MendedStart {
  double speed_m_s = 0;        // by how much a body's velocity was changed at most
  double spin_rad_s = 0;       // and its spin
  std::string body = {};       // whose change has most kinetic energy; empty: none was changed
  double turned_rad = 0;       // how far a joint of a loop without a q has turned at most to close it
  double moved_m = 0;          // and how far one has gone along its way
  std::string joint = {};      // which has turned or gone farthest; empty: no loop was to be closed
  std::vector<double> q = {};  // where all joints with one motion then stand, counted as in files; empty: likewise
};

/// How far velocities may be from what the joints allow and are mended: so much of the fastest. Numbers with three
/// digits are off by up to half a per cent of their own, a speed of two of them by a whole one; a wrong sign or a
/// velocity that was forgotten is off by all of it.
inline constexpr double mended_share = 0.01;
/// Of how many bodies at most: the equations are dense, and those of so many take seconds.
inline constexpr std::size_t most_mended = 256;

/// A rate that a joint shall have: of its second body, or of its first where the second is the world, against the
/// other.
struct HeldRate {
  std::size_t joint = 0;
  bool slides = false;
  Vec3 axis{};  // unit, in the world
  Vec3 at_m{};  // of a way: the point of the bodies whose velocities it is of
  double rate = 0;
};

/// What it is.
double rate_of(const Mechanism& mechanism, const HeldRate& of);

/// By how much velocities were changed.
struct ChangedVelocities {
  double speed_m_s = 0;   // largest change of a body's velocity
  double spin_rad_s = 0;  // and of a spin
  std::size_t body = 0;   // whose change has most kinetic energy
};

/// Changes velocities and spins of the bodies to those that all joints allow, with these rates: of all such the ones
/// whose change has the least kinetic energy (the mass-weighted least squares, so that a light body gives way to a
/// heavy one; momentum changes by what the joints could have pushed alone).
ChangedVelocities mend_velocities(Mechanism& mechanism, std::span<const HeldRate> held = {});

/// Velocities that the joints do not allow, by not more than `mended_share`, become the nearest that they do, and it is
/// told. Throws BadStart for what fits less.
void mend_drawn_velocities(Mechanism& mechanism, MendedStart& mended);

}  // namespace odeval
