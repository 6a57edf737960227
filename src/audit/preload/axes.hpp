#pragma once
// Axes of joints along which motors and stops act.
#include <ode/ode.h>

#include <span>

namespace odeval::audit {

struct Axis {
  dJointType type;
  bool linear;  // else it turns
  void (*axis)(dJointID, dVector3);
  void (*anchor)(dJointID, dVector3);  // null: linear
  dReal (*place)(dJointID);            // null: it has no stop
  dReal (*parameter)(dJointID, int);
  int group;  // of parameters
};

/// Of a kind of joint; none of kinds whose motors are not told from what else they do.
std::span<const Axis> axes_of(dJointType type);

}  // namespace odeval::audit
