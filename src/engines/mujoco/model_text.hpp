#pragma once
// A mechanism in MuJoCo's language.
#include <string>
#include <vector>

#include "engines/tree/hanging.hpp"

namespace odeval::engine_mujoco {

/// The <mujoco> element. Bodies are called b0, b1 and so on, the motions of a body's joint by the body's name and d0,
/// d1.
std::string model_text(const Mechanism& mechanism, const std::vector<engine_tree::Hanging>& tree);

/// b3, of body 3.
std::string name_of(std::size_t body);

}  // namespace odeval::engine_mujoco
