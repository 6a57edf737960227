#pragma once
// The kinds of joint that a scenario file can name.
#include <array>
#include <string_view>

#include "model/description.hpp"

namespace odeval {

/// What a joint's parent is called that is no body.
inline constexpr std::string_view world_name = "world";

/// What may carry a joint's child.
enum class Carries { anything, a_body, the_world };

/// A kind's word in files, what it needs there, and what it is made of.
struct JointWord {
  std::string_view word;
  int axes;             // how many it has; the last two of several at right angles
  bool sprung;          // whether [joint] may name it
  std::size_t motions;  // how many of its motions motors and loads may act on
  std::size_t stopped;  // of the first how many of these ODE has stops
  JointKind (*make)(const JointTable&);
  Carries parent = Carries::anything;
  bool suspended = false;  // whether it has a suspension
  /// Its motions in the order of lists, where it has several.
  std::string_view order = {};
};

/// The one table of them.
inline constexpr std::array joint_words{
    JointWord{"ball", 0, true, 0, 0, [](const JointTable& table) { return JointKind(BallJoint{table.anchor_m}); }},
    JointWord{"hinge", 1, true, 1, 1,
              [](const JointTable& table) {
                return JointKind(HingeJoint{table.anchor_m, table.axis});
              }},
    JointWord{"slider", 1, false, 1, 1,
              [](const JointTable& table) {
                return JointKind(SliderJoint{table.anchor_m, table.axis});
              }},
    JointWord{"universal", 2, false, 2, 2,
              [](const JointTable& table) {
                // `axis` is fixed in the parent, `axis2` in the child; which of them is the joint's first:
                // put_bodies.cpp.
                return table.parent == world_name ? JointKind(UniversalJoint{table.anchor_m, table.axis2, table.axis})
                                                  : JointKind(UniversalJoint{table.anchor_m, table.axis, table.axis2});
              },
              Carries::anything, false, "axis, axis2"},
    JointWord{"fixed", 0, false, 0, 0, [](const JointTable& table) { return JointKind(FixedJoint{table.anchor_m}); }},
    JointWord{"piston", 1, false, 2, 2,
              [](const JointTable& table) {
                return JointKind(PistonJoint{table.anchor_m, table.axis});
              },
              Carries::anything, false, "the way, the turn"},
    JointWord{"pr", 2, false, 2, 2,
              [](const JointTable& table) {
                return JointKind(SlidingHingeJoint{table.anchor_m, table.axis, table.axis2});
              },
              Carries::anything, false, "axis, axis2"},
    JointWord{"pu", 3, false, 3, 3,
              [](const JointTable& table) {
                const bool on_world = table.parent == world_name;  // as of a universal joint
                return JointKind(SlidingUniversalJoint{table.anchor_m, table.axis, on_world ? table.axis3 : table.axis2,
                                                       on_world ? table.axis2 : table.axis3});
              },
              Carries::anything, false, "axis, axis2, axis3"},
    JointWord{"hinge2", 2, false, 2, 1,
              [](const JointTable& table) {
                return JointKind(
                    Hinge2Joint{table.anchor_m, table.axis, table.axis2, table.suspension[0], table.suspension[1]});
              },
              Carries::a_body, true, "axis, axis2"},
    JointWord{"plane2d", 0, false, 3, 0, [](const JointTable& table) { return JointKind(PlaneJoint{table.anchor_m}); },
              Carries::the_world, false, "x, y, the turn"},
};

}  // namespace odeval
