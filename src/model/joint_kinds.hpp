#pragma once
// The kinds of joint that a scenario file can name.
#include <array>
#include <string_view>

#include "model/description.hpp"

namespace odeval {

/// A kind's word in files, whether it has an axis, and what it is made of.
struct JointWord {
  std::string_view word;
  bool axis;
  JointKind (*make)(const JointTable&);
};

/// The one table of them.
inline constexpr std::array joint_words{
    JointWord{"ball", false, [](const JointTable& table) { return JointKind(BallJoint{table.anchor_m}); }},
    JointWord{"hinge", true,
              [](const JointTable& table) {
                return JointKind(HingeJoint{table.anchor_m, table.axis});
              }},
};

}  // namespace odeval
