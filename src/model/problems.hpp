#pragma once
// The problems that a scenario file can name: each says which tables the file has and how they lie in the world.
#include <array>
#include <string_view>

#include "odeval/planar_view.hpp"

namespace odeval {

struct Problem {
  std::string_view name;
  std::string_view summary;
  bool planar;  // links on hinges in a plane (q0, qd0, [[links]]), or bodies in space ([[bodies]])
  int links;    // 0: as many as the scenario says
  PlanarFrame frame;
  bool wall = false;      // [wall]: links strike it
  bool ground = false;    // [ground]: bodies lie on it
  bool friction = false;  // of a ground: whether it holds what slides on it
  bool joint = false;     // [joint]: holds the first body
  bool joints = false;    // [[joints]]: hold bodies with names on one another and on the world
};

/// Report C.2: boxes hang along -z of their own frame and turn about x.
inline constexpr PlanarFrame hanging_frame{
    {0, 0, 2.1}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1.57079632679489661923};
/// Report C.5: the box lies along +x of its own frame and turns about y.
inline constexpr PlanarFrame lying_frame{{1, 0, 3}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0};
/// Potra et al. (IJNME 66, 2006): the same plane about (0, 0, 2).
inline constexpr PlanarFrame potra_frame{{0, 0, 2}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0};

/// The one table of problems; everything that names a problem reads it.
inline constexpr std::array problems{
    Problem{"single_pendulum", "one link on one hinge; closed form in elliptic functions", true, 1, hanging_frame},
    Problem{"double_pendulum", "two links on two hinges; chaotic", true, 2, hanging_frame},
    Problem{.name = "wall_pendulum",
            .summary = "one link that swings against a wall; closed form between impacts",
            .planar = true,
            .links = 1,
            .frame = lying_frame,
            .wall = true},
    Problem{"chain", "n links on n hinges", true, 0, hanging_frame},
    Problem{.name = "potra_pendulum",
            .summary = "two balls on rods that both swing against a wall",
            .planar = true,
            .links = 2,
            .frame = potra_frame,
            .wall = true},
    Problem{"free_box", "bodies that nothing touches; closed form in elliptic functions", false, 0, space_frame},
    Problem{"thin_body", "bodies that nothing touches, as thin as wanted; closed form in elliptic functions", false, 0,
            space_frame},
    Problem{.name = "bouncing_ball",
            .summary = "balls that fall on the ground, and rest at last; closed form",
            .planar = false,
            .links = 0,
            .frame = space_frame,
            .ground = true},
    Problem{.name = "friction_slide",
            .summary = "a box that slides on the ground until friction holds it; closed form",
            .planar = false,
            .links = 0,
            .frame = space_frame,
            .ground = true,
            .friction = true},
    Problem{.name = "spring_joint",
            .summary = "bodies pulled out of a joint; closed form of a damped spring",
            .planar = false,
            .links = 0,
            .frame = space_frame,
            .joint = true},
    Problem{
        .name = "mechanism",
        .summary = "bodies on joints of any kind, in trees and loops; beside a reference in generalized coordinates",
        .planar = false,
        .links = 0,
        .frame = space_frame,
        .joints = true},
};

}  // namespace odeval
