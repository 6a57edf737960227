#pragma once
// Small ODE worlds for the tests of the accurate step.
#include <ode/ode.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace odeval::test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

inline Vector3d vec(const dReal* v) { return {v[0], v[1], v[2]}; }

/// Owns a world and a space; makes bodies and joints in it.
class World {
 public:
  explicit World(const Vector3d& gravity = {0, 0, -9.81}) : gravity_(gravity) {
    static const int once = dInitODE2(0);
    static_cast<void>(once);
    id = dWorldCreate();
    space = dHashSpaceCreate(nullptr);
    dWorldSetGravity(id, gravity[0], gravity[1], gravity[2]);
  }
  ~World() {
    dSpaceDestroy(space);
    dWorldDestroy(id);
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// A uniform box with a geom.
  dBodyID box(double mass, const Vector3d& sides, const Vector3d& at,
              const Quaterniond& turn = Quaterniond::Identity()) {
    const dBodyID body = dBodyCreate(id);
    dMass m;
    dMassSetBoxTotal(&m, mass, sides[0], sides[1], sides[2]);
    dBodySetMass(body, &m);
    place(body, at, turn);
    const dGeomID geom = dCreateBox(space, sides[0], sides[1], sides[2]);
    dGeomSetBody(geom, body);
    bodies.push_back(body);
    return body;
  }
  dBodyID sphere(double mass, double radius, const Vector3d& at) {
    const dBodyID body = dBodyCreate(id);
    dMass m;
    dMassSetSphereTotal(&m, mass, radius);
    dBodySetMass(body, &m);
    place(body, at, Quaterniond::Identity());
    const dGeomID geom = dCreateSphere(space, radius);
    dGeomSetBody(geom, body);
    bodies.push_back(body);
    return body;
  }
  static void place(dBodyID body, const Vector3d& at, const Quaterniond& turn) {
    const dQuaternion q = {turn.w(), turn.x(), turn.y(), turn.z()};
    dBodySetPosition(body, at[0], at[1], at[2]);
    dBodySetQuaternion(body, q);
  }
  static void move(dBodyID body, const Vector3d& velocity, const Vector3d& spin) {
    dBodySetLinearVel(body, velocity[0], velocity[1], velocity[2]);
    dBodySetAngularVel(body, spin[0], spin[1], spin[2]);
  }

  dJointID hinge(dBodyID a, dBodyID b, const Vector3d& at, const Vector3d& axis) {
    const dJointID joint = dJointCreateHinge(id, nullptr);
    dJointAttach(joint, a, b);
    dJointSetHingeAnchor(joint, at[0], at[1], at[2]);
    dJointSetHingeAxis(joint, axis[0], axis[1], axis[2]);
    return joint;
  }
  dJointID ball(dBodyID a, dBodyID b, const Vector3d& at) {
    const dJointID joint = dJointCreateBall(id, nullptr);
    dJointAttach(joint, a, b);
    dJointSetBallAnchor(joint, at[0], at[1], at[2]);
    return joint;
  }
  dJointID slider(dBodyID a, dBodyID b, const Vector3d& axis) {
    const dJointID joint = dJointCreateSlider(id, nullptr);
    dJointAttach(joint, a, b);
    dJointSetSliderAxis(joint, axis[0], axis[1], axis[2]);
    return joint;
  }
  dJointID universal(dBodyID a, dBodyID b, const Vector3d& at, const Vector3d& axis1, const Vector3d& axis2) {
    const dJointID joint = dJointCreateUniversal(id, nullptr);
    dJointAttach(joint, a, b);
    dJointSetUniversalAnchor(joint, at[0], at[1], at[2]);
    dJointSetUniversalAxis1(joint, axis1[0], axis1[1], axis1[2]);
    dJointSetUniversalAxis2(joint, axis2[0], axis2[1], axis2[2]);
    return joint;
  }
  dJointID fixed(dBodyID a, dBodyID b) {
    const dJointID joint = dJointCreateFixed(id, nullptr);
    dJointAttach(joint, a, b);
    dJointSetFixed(joint);
    return joint;
  }

  static Quaterniond turn(dBodyID body) {
    const dReal* q = dBodyGetQuaternion(body);
    return {q[0], q[1], q[2], q[3]};
  }
  static Eigen::Matrix3d inertia(dBodyID body) {
    dMass m;
    dBodyGetMass(body, &m);
    Eigen::Matrix3d i;
    for (Eigen::Index r = 0; r < 3; ++r) {
      for (Eigen::Index c = 0; c < 3; ++c) i(r, c) = m.I[4 * r + c];
    }
    const Eigen::Matrix3d rotation = turn(body).normalized().toRotationMatrix();
    return rotation * i * rotation.transpose();
  }
  static double mass(dBodyID body) {
    dMass m;
    dBodyGetMass(body, &m);
    return m.mass;
  }

  double energy() const {
    double sum = 0;
    for (const dBodyID body : bodies) {
      const Vector3d v = vec(dBodyGetLinearVel(body));
      const Vector3d w = vec(dBodyGetAngularVel(body));
      sum +=
          mass(body) * (v.squaredNorm() / 2 - gravity_.dot(vec(dBodyGetPosition(body)))) + w.dot(inertia(body) * w) / 2;
    }
    return sum;
  }
  Vector3d momentum() const {
    Vector3d sum = Vector3d::Zero();
    for (const dBodyID body : bodies) sum += mass(body) * vec(dBodyGetLinearVel(body));
    return sum;
  }
  /// About the origin.
  Vector3d angular_momentum() const {
    Vector3d sum = Vector3d::Zero();
    for (const dBodyID body : bodies) {
      const Vector3d p = mass(body) * vec(dBodyGetLinearVel(body));
      sum += vec(dBodyGetPosition(body)).cross(p) + inertia(body) * vec(dBodyGetAngularVel(body));
    }
    return sum;
  }
  /// Positions, quaternions, velocities, spins: every bit of every body.
  std::vector<double> state() const {
    std::vector<double> all;
    for (const dBodyID body : bodies) {
      all.insert(all.end(), dBodyGetPosition(body), dBodyGetPosition(body) + 3);
      all.insert(all.end(), dBodyGetQuaternion(body), dBodyGetQuaternion(body) + 4);
      all.insert(all.end(), dBodyGetRotation(body), dBodyGetRotation(body) + 12);
      all.insert(all.end(), dBodyGetLinearVel(body), dBodyGetLinearVel(body) + 3);
      all.insert(all.end(), dBodyGetAngularVel(body), dBodyGetAngularVel(body) + 3);
    }
    return all;
  }

  dWorldID id;
  dSpaceID space;
  std::vector<dBodyID> bodies;

 private:
  Vector3d gravity_;
};

/// Largest overlap of any two geoms, by ODE.
inline double overlap(const World& world) {
  double deepest = 0;
  dSpaceCollide(world.space, &deepest, [](void* data, dGeomID one, dGeomID other) {
    const dBodyID a = dGeomGetBody(one), b = dGeomGetBody(other);
    if (a != nullptr && b != nullptr && dAreConnected(a, b) != 0) return;
    dContactGeom found[16];
    const int count = dCollide(one, other, 16, found, sizeof(dContactGeom));
    double& most = *static_cast<double*>(data);
    for (int i = 0; i < count; ++i) most = std::max(most, found[i].depth);
  });
  return deepest;
}

/// Steps of h for a duration in s: the most that the energy rises by in one of them, J.
template <class Step>
double most_risen(const World& world, Step& step, double h, double duration) {
  double last = world.energy(), rise = 0;
  for (double t = 0; t < duration; t += h) {
    step(h);
    rise = std::max(rise, world.energy() - last);
    last = world.energy();
  }
  return rise;
}

/// Slope of log error over log step between two runs.
inline double order(double coarse_error, double fine_error, double ratio) {
  return std::log(coarse_error / fine_error) / std::log(ratio);
}

}  // namespace odeval::test
