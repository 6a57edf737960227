#pragma once
// The kinds of joint that a scenario file can name.
#include <array>
#include <string_view>

#include "model/description.hpp"

namespace odeval {

/// What a joint's parent is called that is no body.
inline constexpr std::string_view world_name = "world";

/// A kind's word in files, what it needs there, and what it is made of.
struct JointWord {
  std::string_view word;
  int axes;     // how many it has
  bool sprung;  // whether [joint] may name it
  JointKind (*make)(const JointTable&);
};

/// The one table of them.
inline constexpr std::array joint_words{
    JointWord{"ball", 0, true, [](const JointTable& table) { return JointKind(BallJoint{table.anchor_m}); }},
    JointWord{"hinge", 1, true,
              [](const JointTable& table) {
                return JointKind(HingeJoint{table.anchor_m, table.axis});
              }},
    JointWord{"slider", 1, false,
              [](const JointTable& table) {
                return JointKind(SliderJoint{table.anchor_m, table.axis});
              }},
    JointWord{"universal", 2, false,
              [](const JointTable& table) {
                // `axis` is fixed in the parent, `axis2` in the child; which of them is the joint's first:
                // put_bodies.cpp.
                return table.parent == world_name ? JointKind(UniversalJoint{table.anchor_m, table.axis2, table.axis})
                                                  : JointKind(UniversalJoint{table.anchor_m, table.axis, table.axis2});
              }},
    JointWord{"fixed", 0, false, [](const JointTable& table) { return JointKind(FixedJoint{table.anchor_m}); }},
};

}  // namespace odeval
