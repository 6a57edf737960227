#pragma once
// From a mechanism as it is drawn, where every joint stands at 0, to where its motion starts.
#include "model/description.hpp"
#include "model/mend_start.hpp"

namespace odeval {

/// What drives, stops and loads a joint, or one of its motions, counted from q on: of a Joint or an AxisDrive.
template <class Driven>
void count_from(Driven& driven, double q) {
  if (driven.stop) *driven.stop = {driven.stop->low - q, driven.stop->high - q, driven.stop->restitution};
  for (JointSpring& spring : driven.springs) spring.rest -= q;
  for (Controller& controller : driven.controllers) controller.target.constant -= q;
}

/// Brings the mechanism, whose joints are those of the description in its order, to where it starts; throws BadStart.
///
/// Velocities that the joints do not allow, by not more than `mended_share`, become the nearest that they do. Then each
/// joint moves by its q: the child and all that hangs on it against the parent, motion by motion from the parent to the
/// child. In a loop the q that are said are held, and its other joints close it: Newton's method over their motions,
/// from as it is drawn on in steps of the q. Velocities go along, each joint has its rates, and `qd` is added; in loops
/// these are held and the rest follows, with the least kinetic energy of the change. A body that none of this concerns
/// stays as it is, to the bit.
MendedStart bring_to_start(Mechanism& mechanism, const Description& said);

}  // namespace odeval
