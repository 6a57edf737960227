#pragma once
// A mechanism in MuJoCo's language.
#include <string>
#include <vector>

#include "engines/tree/hanging.hpp"

namespace odeval::engine_mujoco {

/// The <mujoco> element. Bodies are called b0, b1 and so on, the motions of a body's joint by the body's name and d0,
/// d1. `closing`: the joints that close loops, for which equations follow in that order (equations_of). The time
/// constant, s, is that of contacts, stops and loops.
/// Throws UserError for a loop that MuJoCo has no equations for.
std::string model_text(const Mechanism& mechanism, const std::vector<engine_tree::Hanging>& tree,
                       const std::vector<std::size_t>& closing, double time_constant_s);

/// How many elements of <equality> a joint makes that closes a loop.
int equations_of(const JointKind& kind);

/// b3, of body 3.
std::string name_of(std::size_t body);

}  // namespace odeval::engine_mujoco
