#pragma once
// Joints of every kind as Simbody's mobilizers. C++17, as simbody_tree.hpp.
#include <Simbody.h>

#include <cstddef>
#include <vector>

#include "odeval/mechanism.hpp"

namespace odeval::reference {

/// Bodies that hang one on the other, and how the one before each is turned at t = 0.
struct Chain {
  std::vector<SimTK::MobilizedBody> bodies;
  std::vector<SimTK::Rotation> turned;
};

/// What a joint hangs its body on.
struct HungOn {
  SimTK::MobilizedBody& parent;
  SimTK::Transform parent_place;  // at t = 0
  bool body_is_first;             // of the joint
};

/// Hangs a body that stands in a place at t = 0. A suspension's spring and damper become loads.
Chain hang(const HungOn& carrier, const SimTK::Body::Rigid& body, const SimTK::Transform& place, const JointKind& kind,
           SimTK::GeneralForceSubsystem& loads);

/// Which of a chain's bodies has a motion of its joint that may be driven, and as which of its own.
struct Mobility {
  std::size_t body;
  int number;
};
/// Of a motion by its number in driveable_of.
Mobility mobility_of(const JointKind& kind, std::size_t motion, bool body_is_first);

}  // namespace odeval::reference
