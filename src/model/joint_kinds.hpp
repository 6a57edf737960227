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
  int axes;     // how many it has; the last two of several at right angles
  bool sprung;  // whether [joint] may name it
  bool driven;  // whether motors, stops and loads may act on it
  JointKind (*make)(const JointTable&);
  Carries parent = Carries::anything;
  bool suspended = false;  // whether it has a suspension
  int motors = 0;          // of one that is not `driven`: how many tables motor, motor2, motor3 it may have
};

/// The one table of them.
inline constexpr std::array joint_words{
    JointWord{"ball", 0, true, false, [](const JointTable& table) { return JointKind(BallJoint{table.anchor_m}); }},
    JointWord{"hinge", 1, true, true,
              [](const JointTable& table) {
                return JointKind(HingeJoint{table.anchor_m, table.axis});
              }},
    JointWord{"slider", 1, false, true,
              [](const JointTable& table) {
                return JointKind(SliderJoint{table.anchor_m, table.axis});
              }},
    JointWord{"universal", 2, false, false,
              [](const JointTable& table) {
                // `axis` is fixed in the parent, `axis2` in the child; which of them is the joint's first:
                // put_bodies.cpp.
                return table.parent == world_name ? JointKind(UniversalJoint{table.anchor_m, table.axis2, table.axis})
                                                  : JointKind(UniversalJoint{table.anchor_m, table.axis, table.axis2});
              },
              Carries::anything, false, 2},
    JointWord{"fixed", 0, false, false, [](const JointTable& table) { return JointKind(FixedJoint{table.anchor_m}); }},
    JointWord{"piston", 1, false, false,
              [](const JointTable& table) {
                return JointKind(PistonJoint{table.anchor_m, table.axis});
              },
              Carries::anything, false, 2},
    JointWord{"pr", 2, false, false,
              [](const JointTable& table) {
                return JointKind(SlidingHingeJoint{table.anchor_m, table.axis, table.axis2});
              },
              Carries::anything, false, 2},
    JointWord{"pu", 3, false, false,
              [](const JointTable& table) {
                const bool on_world = table.parent == world_name;  // as of a universal joint
                return JointKind(SlidingUniversalJoint{table.anchor_m, table.axis, on_world ? table.axis3 : table.axis2,
                                                       on_world ? table.axis2 : table.axis3});
              },
              Carries::anything, false, 3},
    JointWord{"hinge2", 2, false, false,
              [](const JointTable& table) {
                return JointKind(
                    Hinge2Joint{table.anchor_m, table.axis, table.axis2, table.suspension[0], table.suspension[1]});
              },
              Carries::a_body, true, 2},
    JointWord{"plane2d", 0, false, false, [](const JointTable& table) { return JointKind(PlaneJoint{table.anchor_m}); },
              Carries::the_world},
};

}  // namespace odeval
