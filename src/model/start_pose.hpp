#pragma once
// From a mechanism as it is drawn, where every joint stands at 0, to where its motion starts.
#include "model/description.hpp"
#include "odeval/mechanism.hpp"

namespace odeval {

/// Whether a joint says where it starts, or how fast.
bool moves_at_start(const Description& said);

/// The first joint that connects what hangs together without it; nothing where there is none.
std::optional<std::size_t> closes_a_loop(const Description& said);

/// Moves the mechanism, whose joints are those of the description in its order and hang together as a tree, by the q of
/// each: the child and all that hangs on it against the parent, in the order of the joint's motions from the parent to
/// the child. What moves takes the velocities that the file gives it along, each joint its rates, and `qd` is added to
/// these. What hangs on no moving joint stays as it is, to the bit.
void move_to_start(Mechanism& mechanism, const Description& said);

}  // namespace odeval
