// The functions of ODE that a program calls, in the place of ODE's own. Each does what ODE's does, by calling it.
#include "audit/preload/own.hpp"
#include "audit/preload/session.hpp"

using odeval::audit::Session;
using odeval::audit::Worlds;

namespace {

template <class... What>
void follow(void (Worlds::*change)(What...), What... what) {
  Session::get().follow([&](Session& session) { (session.worlds().*change)(what...); });
}

dJointID followed(dWorldID world, dJointID joint, dJointType type, dJointGroupID group) {
  follow<dWorldID, dJointID, dJointType, dJointGroupID>(&Worlds::add, world, joint, type, group);
  return joint;
}

void forget_geom(dGeomID geom) {
  Session::get().follow([geom](Session& session) { session.collisions().forget(geom); });
}

}  // namespace

#define ODEVAL_JOINT(kind)                                                                         \
  dJointID ODEVAL_BEFORE(dJointCreate##kind)(dWorldID world, dJointGroupID group) {                \
    Session::get().set_what_is_tried(world);                                                       \
    return followed(world, ODEVAL_OWN(dJointCreate##kind)(world, group), dJointType##kind, group); \
  }

#pragma GCC visibility push(default)
extern "C" {

ODEVAL_JOINT(Ball)
ODEVAL_JOINT(Hinge)
ODEVAL_JOINT(Slider)
ODEVAL_JOINT(Hinge2)
ODEVAL_JOINT(PR)
ODEVAL_JOINT(PU)
ODEVAL_JOINT(Piston)
ODEVAL_JOINT(Universal)
ODEVAL_JOINT(Fixed)
ODEVAL_JOINT(Null)
ODEVAL_JOINT(AMotor)
ODEVAL_JOINT(LMotor)
ODEVAL_JOINT(Plane2D)
ODEVAL_JOINT(DBall)
ODEVAL_JOINT(DHinge)
ODEVAL_JOINT(Transmission)

dJointID ODEVAL_BEFORE(dJointCreateContact)(dWorldID world, dJointGroupID group, const dContact* contact) {
  Session& session = Session::get();
  if (!session.follows()) return ODEVAL_OWN(dJointCreateContact)(world, group, contact);
  dContact place;
  const dContact& part = session.softened(world, *contact, place);
  dJointID joint = ODEVAL_OWN(dJointCreateContact)(world, group, &part);
  session.follow([&](Session& its) { its.worlds().add_contact(world, joint, part, group, its.in_callback()); });
  return joint;
}

void ODEVAL_BEFORE(dJointDestroy)(dJointID joint) {
  if (joint != nullptr) follow<dJointID>(&Worlds::forget, joint);
  ODEVAL_OWN(dJointDestroy)(joint);
}

void ODEVAL_BEFORE(dJointGroupEmpty)(dJointGroupID group) {
  follow<dJointGroupID>(&Worlds::empty, group);
  ODEVAL_OWN(dJointGroupEmpty)(group);
}

void ODEVAL_BEFORE(dJointGroupDestroy)(dJointGroupID group) {
  follow<dJointGroupID>(&Worlds::forget, group);
  ODEVAL_OWN(dJointGroupDestroy)(group);
}

dBodyID ODEVAL_BEFORE(dBodyCreate)(dWorldID world) {
  dBodyID body = ODEVAL_OWN(dBodyCreate)(world);
  Session::get().give_samples(body);
  Session::get().moved_callbacks().forget(body);  // of one that was there before, and went with its world
  follow<dWorldID, dBodyID>(&Worlds::add, world, body);
  return body;
}

void ODEVAL_BEFORE(dBodyDestroy)(dBodyID body) {
  if (body != nullptr) follow<dBodyID>(&Worlds::forget, body);
  Session::get().moved_callbacks().forget(body);
  ODEVAL_OWN(dBodyDestroy)(body);
}

// ODE's is this library's, which calls the program's once a step of the program.
void ODEVAL_BEFORE(dBodySetMovedCallback)(dBodyID body, void (*callback)(dBodyID)) {
  Session& session = Session::get();
  if (!session.follows()) return ODEVAL_OWN(dBodySetMovedCallback)(body, callback);
  session.moved_callbacks().set(body, callback);
  ODEVAL_OWN(dBodySetMovedCallback)(body, callback == nullptr ? nullptr : odeval::audit::take_moved);
}

void ODEVAL_BEFORE(dWorldDestroy)(dWorldID world) {
  ODEVAL_OWN(dWorldDestroy)(world);
  follow<dWorldID>(&Worlds::forget, world);
}

int ODEVAL_BEFORE(dWorldStep)(dWorldID world, dReal h) {
  return Session::get().step(world, h, ODEVAL_OWN(dWorldStep), false, __builtin_frame_address(0));
}

int ODEVAL_BEFORE(dWorldQuickStep)(dWorldID world, dReal h) {
  return Session::get().step(world, h, ODEVAL_OWN(dWorldQuickStep), true, __builtin_frame_address(0));
}

void ODEVAL_BEFORE(dWorldSetStepThreadingImplementation)(dWorldID world, const dThreadingFunctionsInfo* functions,
                                                         dThreadingImplementationID threading) {
  if (functions != nullptr) Session::get().remark(odeval::audit::pool_of_threads);
  ODEVAL_OWN(dWorldSetStepThreadingImplementation)(world, functions, threading);
}

void ODEVAL_BEFORE(dSpaceCollide)(dSpaceID space, void* data, dNearCallback* callback) {
  Session::get().collide(reinterpret_cast<dGeomID>(space), nullptr, data, callback, [&] {
    ODEVAL_OWN(dSpaceCollide)(space, data, callback);
  });
}

void ODEVAL_BEFORE(dSpaceCollide2)(dGeomID first, dGeomID second, void* data, dNearCallback* callback) {
  Session::get().collide(first, second, data, callback, [&] {
    ODEVAL_OWN(dSpaceCollide2)(first, second, data, callback);
  });
}

void ODEVAL_BEFORE(dGeomDestroy)(dGeomID geom) {
  forget_geom(geom);
  ODEVAL_OWN(dGeomDestroy)(geom);
}

void ODEVAL_BEFORE(dSpaceDestroy)(dSpaceID space) {
  forget_geom(reinterpret_cast<dGeomID>(space));
  ODEVAL_OWN(dSpaceDestroy)(space);
}

// Samples of a velocity that is averaged before a body comes to rest are one a step: as many more as there are parts.
void ODEVAL_BEFORE(dBodySetAutoDisableAverageSamplesCount)(dBodyID body, unsigned count) {
  ODEVAL_OWN(dBodySetAutoDisableAverageSamplesCount)(body, Session::get().samples(count));
}

int ODEVAL_BEFORE(dBodyGetAutoDisableAverageSamplesCount)(dBodyID body) {
  return Session::get().program_samples(ODEVAL_OWN(dBodyGetAutoDisableAverageSamplesCount)(body));
}

void ODEVAL_BEFORE(dBodySetAutoDisableDefaults)(dBodyID body) {
  ODEVAL_OWN(dBodySetAutoDisableDefaults)(body);
  Session::get().give_samples(body);
}

// Of odeval_name.h.
void odeval_audit_name_body(dBodyID body, const char* name) {
  if (body == nullptr || name == nullptr) return;
  Session::get().follow([=](Session& session) { session.name(body, name); });
}

void odeval_audit_name_joint(dJointID joint, const char* name) {
  if (joint == nullptr || name == nullptr) return;
  Session::get().follow([=](Session& session) { session.name(joint, name); });
}

// The handlers that the program reads and writes are its own; ODE has this library's.
void ODEVAL_BEFORE(dSetMessageHandler)(dMessageFunction* handler) {
  Session& session = Session::get();
  if (!session.follows()) return ODEVAL_OWN(dSetMessageHandler)(handler);
  session.program_message = handler;
}

void ODEVAL_BEFORE(dSetDebugHandler)(dMessageFunction* handler) {
  Session& session = Session::get();
  if (!session.follows()) return ODEVAL_OWN(dSetDebugHandler)(handler);
  session.program_debug = handler;
}

dMessageFunction* ODEVAL_BEFORE(dGetMessageHandler)() {
  Session& session = Session::get();
  return session.follows() ? session.program_message : ODEVAL_OWN(dGetMessageHandler)();
}

dMessageFunction* ODEVAL_BEFORE(dGetDebugHandler)() {
  Session& session = Session::get();
  return session.follows() ? session.program_debug : ODEVAL_OWN(dGetDebugHandler)();
}

}  // extern "C"
#pragma GCC visibility pop
