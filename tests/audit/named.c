/* Names given by a program in C, for faulty.cpp. */
#include "audit/odeval_name.h"

void name_in_c(dBodyID body, dJointID joint);

void name_in_c(dBodyID body, dJointID joint) {
  odeval_name(body, "the ball in C");
  odeval_name(joint, "the joint in C");
}
