#pragma once
// The problems that a scenario file can name.
#include <array>

#include "odeval/problem.hpp"

namespace odeval {

/// The one table of problems; everything that names a problem reads it.
inline constexpr std::array problems{
    Problem{"single_pendulum", "one link on one hinge; closed form in elliptic functions", 1, false, hanging_frame},
    Problem{"double_pendulum", "two links on two hinges; chaotic", 2, false, hanging_frame},
    Problem{"wall_pendulum", "one link that swings against a wall; closed form between impacts", 1, true, lying_frame},
    Problem{"chain", "n links on n hinges", 0, false, hanging_frame},
    Problem{"potra_pendulum", "two balls on rods that both swing against a wall", 2, true, potra_frame},
    Problem{"free_box", "bodies that nothing touches; closed form in elliptic functions", 0, false, body_frame,
            Family::bodies},
    Problem{"thin_body", "bodies that nothing touches, as thin as wanted; closed form in elliptic functions", 0, false,
            body_frame, Family::bodies},
    Problem{"bouncing_ball", "balls that fall on the ground, and rest at last; closed form", 0, false, body_frame,
            Family::bodies, true},
    Problem{"friction_slide", "a box that slides on the ground until friction holds it; closed form", 0, false,
            body_frame, Family::bodies, true, true},
    Problem{"spring_joint", "bodies pulled out of a joint; closed form of a damped spring", 0, false, body_frame,
            Family::bodies, false, false, true},
};

}  // namespace odeval
