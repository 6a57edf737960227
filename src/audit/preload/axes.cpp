#include "audit/preload/axes.hpp"

#include <algorithm>
#include <array>

namespace odeval::audit {
namespace {

// In order of types. Of hinge2, ODE tells no second angle.
constexpr std::array axes{
    Axis{dJointTypeHinge, false, dJointGetHingeAxis, dJointGetHingeAnchor, dJointGetHingeAngle, dJointGetHingeParam, 0},
    Axis{dJointTypeSlider, true, dJointGetSliderAxis, nullptr, dJointGetSliderPosition, dJointGetSliderParam, 0},
    Axis{dJointTypeUniversal, false, dJointGetUniversalAxis1, dJointGetUniversalAnchor, dJointGetUniversalAngle1,
         dJointGetUniversalParam, 0},
    Axis{dJointTypeUniversal, false, dJointGetUniversalAxis2, dJointGetUniversalAnchor, dJointGetUniversalAngle2,
         dJointGetUniversalParam, 1},
    Axis{dJointTypeHinge2, false, dJointGetHinge2Axis1, dJointGetHinge2Anchor, dJointGetHinge2Angle1,
         dJointGetHinge2Param, 0},
    Axis{dJointTypeHinge2, false, dJointGetHinge2Axis2, dJointGetHinge2Anchor, nullptr, dJointGetHinge2Param, 1},
};

}  // namespace

std::span<const Axis> axes_of(dJointType type) {
  const auto [first, last] = std::ranges::equal_range(axes, type, {}, &Axis::type);
  return {first, last};
}

}  // namespace odeval::audit
