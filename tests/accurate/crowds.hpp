#pragma once
// Worlds in which contacts crowd: what falls in a heap, stands in a stack, or lies on many points.
#include "tests/accurate/worlds.hpp"

namespace odeval::test {

/// Eleven bodies on ball joints, lying in the air, a little turned: trunk, head, pelvis, arms and legs of two parts.
inline void ragdoll(World& world) {
  const Quaterniond turn(Eigen::AngleAxisd(0.3, Vector3d(1, 0.5, 0.2).normalized()));
  const Vector3d up(0, 0, 1);
  const auto part = [&](double mass, const Vector3d& sides, const Vector3d& at) {
    return world.box(mass, sides, turn * at + up, turn);
  };
  const auto join = [&](dBodyID a, dBodyID b, const Vector3d& at) { world.ball(a, b, turn * at + up); };
  const dBodyID trunk = part(20, {0.5, 0.3, 0.2}, {0, 0, 0});
  const dBodyID head = part(4, {0.2, 0.18, 0.2}, {0.4, 0, 0});
  const dBodyID pelvis = part(10, {0.2, 0.3, 0.2}, {-0.4, 0, 0});
  join(trunk, head, {0.275, 0, 0});
  join(trunk, pelvis, {-0.275, 0, 0});
  for (const double side : {-1.0, 1.0}) {
    const dBodyID upper = part(2, {0.1, 0.28, 0.1}, {0.2, 0.32 * side, 0});
    const dBodyID lower = part(1.5, {0.08, 0.28, 0.08}, {0.2, 0.64 * side, 0});
    join(trunk, upper, {0.2, 0.165 * side, 0});
    join(upper, lower, {0.2, 0.48 * side, 0});
    const dBodyID thigh = part(7, {0.4, 0.13, 0.13}, {-0.73, 0.1 * side, 0});
    const dBodyID shank = part(4, {0.4, 0.11, 0.11}, {-1.16, 0.1 * side, 0});
    join(pelvis, thigh, {-0.515, 0.1 * side, 0});
    join(thigh, shank, {-0.945, 0.1 * side, 0});
  }
  dCreatePlane(world.space, 0, 0, 1, 0);
}

inline void stack_of_10(World& world) {
  for (int i = 0; i < 10; ++i) world.box(1, {0.2, 0.2, 0.2}, {0, 0, 0.1 + 0.205 * i});
  dCreatePlane(world.space, 0, 0, 1, 0);
}

/// Fifty balls that fall into a pit.
inline void pile_of_50(World& world) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shift(-0.01, 0.01);
  for (int i = 0; i < 50; ++i) {
    const Vector3d place(0.22 * (i % 3) - 0.22, 0.22 * (i / 3 % 3) - 0.22, 0.15 + 0.25 * (i / 9));
    world.sphere(1, 0.1, place + Vector3d(shift(random), shift(random), 0));
  }
  dCreatePlane(world.space, 0, 0, 1, 0);
  dCreatePlane(world.space, 1, 0, 0.2, -0.5);
  dCreatePlane(world.space, -1, 0, 0.2, -0.5);
  dCreatePlane(world.space, 0, 1, 0.2, -0.5);
  dCreatePlane(world.space, 0, -1, 0.2, -0.5);
}

constexpr double buggy_wheel = 0.18, buggy_turns = 10;  // m, rad/s

/// Four wheels on sprung hinge2 joints, a little above the ground; the rear ones, locked ahead, drive it.
inline void buggy(World& world) {
  const dBodyID chassis = world.box(5, {0.9, 0.5, 0.2}, {0, 0, 0.3});
  for (const double x : {0.35, -0.35}) {
    for (const double y : {0.35, -0.35}) {
      const dBodyID wheel = world.sphere(0.5, buggy_wheel, {x, y, 0.2});
      const dJointID joint = dJointCreateHinge2(world.id, nullptr);
      dJointAttach(joint, chassis, wheel);
      dJointSetHinge2Anchor(joint, x, y, 0.2);
      const dReal steering[] = {0, 0, 1, 0}, axle[] = {0, 1, 0, 0};
      dJointSetHinge2Axes(joint, steering, axle);
      dJointSetHinge2Param(joint, dParamSuspensionERP, 0.4);
      dJointSetHinge2Param(joint, dParamSuspensionCFM, 0.02);
      if (x > 0) {
        dJointSetHinge2Param(joint, dParamFMax, 5);
        dJointSetHinge2Param(joint, dParamLoStop, -0.5);
        dJointSetHinge2Param(joint, dParamHiStop, 0.5);
      } else {
        dJointSetHinge2Param(joint, dParamLoStop, 0);
        dJointSetHinge2Param(joint, dParamHiStop, 0);
        dJointSetHinge2Param(joint, dParamVel2, -buggy_turns);
        dJointSetHinge2Param(joint, dParamFMax2, 2);
      }
    }
  }
  dCreatePlane(world.space, 0, 0, 1, 0);
}

}  // namespace odeval::test
