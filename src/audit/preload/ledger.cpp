#include "audit/preload/ledger.hpp"

#include <algorithm>
#include <cmath>

#include "audit/preload/axes.hpp"
#include "audit/preload/softness.hpp"

namespace odeval::audit {
namespace {

double dot(const dReal* a, const dReal* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const dReal* a) { return std::sqrt(dot(a, a)); }

/// One that ODE is asked to tell of, where the program does not ask itself.
void ask(dJointID joint, dJointFeedback& own) {
  if (dJointGetFeedback(joint) != nullptr) return;
  own = {};
  dJointSetFeedback(joint, &own);
}

void ask_no_more(dJointID joint, const dJointFeedback& own) {
  if (dJointGetFeedback(joint) == &own) dJointSetFeedback(joint, nullptr);
}

/// Kinetic, of the body with this velocity and spin.
double energy_at(const Body& body, const dReal* velocity, const dReal* spin) {
  dMass mass;
  dBodyGetMass(body.id, &mass);
  dVector3 in_body;
  dVector3 momentum;
  dMultiply1_331(in_body, dBodyGetRotation(body.id), spin);
  dMultiply0_331(momentum, mass.I, in_body);
  return 0.5 * (mass.mass * dot(velocity, velocity) + dot(in_body, momentum));
}

void keep_velocities(Body& body) {
  std::copy_n(dBodyGetLinearVel(body.id), 3, body.velocity.begin());
  std::copy_n(dBodyGetAngularVel(body.id), 3, body.spin.begin());
  std::copy_n(dBodyGetForce(body.id), 3, body.force.begin());
  std::copy_n(dBodyGetTorque(body.id), 3, body.torque.begin());
  body.moves = dBodyIsKinematic(body.id) == 0;
  body.told = false;
}

/// Which stop ODE will find the joint at: 1, the low one, 2 or none, 0.
int stop_of(dJointID joint, const Drive& drive) {
  const Axis& row = *drive.row;
  const bool is_none = row.place == nullptr || (row.linear ? drive.low == -dInfinity && drive.high == dInfinity
                                                           : drive.low < -M_PI && drive.high > M_PI);
  if (is_none || drive.low > drive.high) return 0;
  // ODE tells of a hinge from the world to a body the angle the other way, and stops it by the angle as it is.
  const bool other_way = row.type == dJointTypeHinge && dJointGetBody(joint, 0) == nullptr;
  const dReal place = other_way ? -row.place(joint) : row.place(joint);
  return place <= drive.low ? 1 : place >= drive.high ? 2 : 0;
}

/// Of a motor at a stop ODE makes no row: it adds all of its force to those of the bodies, or the part that the fudge
/// factor leaves of it where it goes away from the stop.
dReal push_of(int stop, const Drive& drive, dReal velocity, dReal fudge) {
  if (stop == 0 || drive.low == drive.high) return 0;
  const bool up = velocity > 0 || (velocity == 0 && stop == 2);
  const bool leaves = (stop == 1 && velocity > 0) || (stop == 2 && velocity < 0);
  return (up ? drive.most : -drive.most) * (leaves ? fudge : 1);
}

/// Of a universal from the world to a body ODE tells the axes and angles the other way round, but not the parameters.
int group_of(const Joint& joint, const Axis& row) {
  const bool other_way = row.type == dJointTypeUniversal && dJointGetBody(joint.id, 0) == nullptr;
  return (other_way ? 1 - row.group : row.group) * dParamGroup;
}

/// Where the joint's motors and stops act in the step: with it they turn.
void keep_drives(Joint& joint) {
  joint.drives.clear();
  for (const Axis& row : joint.axes) {
    const auto parameter = [&](int which) { return row.parameter(joint.id, group_of(joint, row) + which); };
    Drive drive{&row, parameter(dParamFMax), parameter(dParamLoStop), parameter(dParamHiStop)};
    if (!(drive.most > 0) && drive.low == -dInfinity && drive.high == dInfinity) continue;
    dBodyID first = dJointGetBody(joint.id, 0);
    dBodyID second = dJointGetBody(joint.id, 1);
    if (first == nullptr) std::swap(first, second);
    if (first == nullptr) continue;
    row.axis(joint.id, drive.axis.data());
    dVector3 arm{};
    if (!row.linear) {
      row.anchor(joint.id, arm);
      for (int i = 0; i < 3; ++i) arm[i] -= dBodyGetPosition(first)[i];
    } else if (second != nullptr) {
      for (int i = 0; i < 3; ++i) arm[i] = (dBodyGetPosition(second)[i] - dBodyGetPosition(first)[i]) / 2;
    }
    // Of a force f at the arm, the torque about the axis is (arm x f) axis = f (axis x arm).
    const dReal* a = row.linear ? arm : drive.axis.data();
    const dReal* b = row.linear ? drive.axis.data() : arm;
    dCalcVectorCross3(drive.lever.data(), a, b);
    const int stop = stop_of(joint.id, drive);
    drive.at_stop = stop != 0;
    drive.push = push_of(stop, drive, parameter(dParamVel), parameter(dParamFudgeFactor));
    joint.drives.push_back(drive);
  }
}

/// Work of the added forces, and the mean velocities; what damping took.
void take_body(World& world, Body& body, dReal h) {
  if (!body.moves) return;
  const dReal* velocity = dBodyGetLinearVel(body.id);
  const dReal* spin = dBodyGetAngularVel(body.id);
  if (body.told) {
    world.work.damping +=
        energy_at(body, velocity, spin) - energy_at(body, body.velocity_left.data(), body.spin_left.data());
    velocity = body.velocity_found.data();
    spin = body.spin_found.data();
  }
  for (std::size_t i = 0; i < 3; ++i) {
    body.velocity[i] = (body.velocity[i] + velocity[i]) / 2;
    body.spin[i] = (body.spin[i] + spin[i]) / 2;
  }
  world.work.added += h * (dot(body.force.data(), body.velocity.data()) + dot(body.torque.data(), body.spin.data()));
}

double work_on(const Body* body, const dReal* force, const dReal* torque, dReal h) {
  if (body == nullptr || !body->moves) return 0;
  return h * (dot(force, body->velocity.data()) + dot(torque, body->spin.data()));
}

}  // namespace

/// Of its bodies, in the order in which ODE tells of them: the first is never the world.
struct Ledger::Acting {
  const dJointFeedback* forces;
  dBodyID id;  // of the first
  const Body* first;
  const Body* second;

  Acting(World& world, dJointID joint, std::array<std::size_t, 2>& hints)
      : forces(dJointGetFeedback(joint)), id(dJointGetBody(joint, 0)) {
    dBodyID other = dJointGetBody(joint, 1);
    if (id == nullptr) std::swap(id, other);
    first = world.find(id, hints[0]);
    second = world.find(other, hints[1]);
  }
  double work(dReal h) const {
    return work_on(first, forces->f1, forces->t1, h) + work_on(second, forces->f2, forces->t2, h);
  }
  /// Where they stand among the world's bodies.
  std::array<std::size_t, 2> moving(const World& world) const {
    const auto place = [&](const Body* body) {
      return body == nullptr || !body->moves ? not_moving : static_cast<std::size_t>(body - world.bodies.data());
    };
    return {place(first), place(second)};
  }
  std::array<std::uint32_t, 2> numbers() const {
    return {first != nullptr ? first->number + 1 : 0, second != nullptr ? second->number + 1 : 0};
  }

  /// What acts on the first body along the axis, and how fast it goes there from the second, in the mean.
  double force_along(const Drive& drive) const {
    const dReal* axis = drive.axis.data();
    return drive.row->linear ? dot(forces->f1, axis) : dot(forces->t1, axis) - dot(forces->f1, drive.lever.data());
  }
  double rate_along(const Drive& drive) const { return rate_of(first, drive, 1) + rate_of(second, drive, -1); }
  /// The same of the bodies whose energy counts.
  double moving_rate_along(const Drive& drive) const {
    return (first != nullptr && first->moves ? rate_of(first, drive, 1) : 0) +
           (second != nullptr && second->moves ? rate_of(second, drive, -1) : 0);
  }
  static double rate_of(const Body* body, const Drive& drive, double side) {
    if (body == nullptr) return 0;
    const dReal* axis = drive.axis.data();
    if (!drive.row->linear) return side * dot(body->spin.data(), axis);
    return side * dot(body->velocity.data(), axis) + dot(body->spin.data(), drive.lever.data());
  }
};

Ledger::Step::Step(Ledger& ledger, World& world) : ledger_(ledger), world_(world) {
  for (Body& body : world_.bodies) keep_velocities(body);
  for (Joint& joint : world_.joints) {
    ask(joint.id, joint.feedback);
    keep_drives(joint);
  }
  for (Touch& touch : world_.touches) ask(touch.id, touch.feedback);
}

Ledger::Step::~Step() {
  for (const Joint& joint : world_.joints) ask_no_more(joint.id, joint.feedback);
  for (const Touch& touch : world_.touches) ask_no_more(touch.id, touch.feedback);
}

void Ledger::Step::taken(dReal h) {
  ledger_.rows_.begin(world_.bodies.size());
  world_.contacts = 0;  // of those made, some may be of two geoms that have no body
  world_.depth = 0;
  for (Body& body : world_.bodies) take_body(world_, body, h);
  for (Joint& joint : world_.joints) ledger_.take(world_, joint, h);
  for (Touch& touch : world_.touches) ledger_.take(world_, touch, h);
  ledger_.sum_up_pairs();
}

PartSample* Ledger::part_of(Joint& joint) {
  if (joint.part != nullptr) return joint.part;
  joint.part = parts_.add();
  if (joint.part == nullptr) {
    overflowed_ = true;
    return nullptr;
  }
  joint.part->type = static_cast<std::uint32_t>(joint.type);
  joint.part->number = joint.number;
  return joint.part;
}

Ledger::Pair& Ledger::pair_of(std::uint32_t first, std::uint32_t second) {
  const auto [low, high] = std::minmax(first, second);
  const std::uint64_t key = std::uint64_t{low} << 32 | high;
  if (last_pair_ != nullptr && last_key_ == key) return *last_pair_;  // contacts of two bodies come together
  const auto [found, is_new] = pairs_.try_emplace(key);
  Pair& pair = found->second;
  last_key_ = key;
  last_pair_ = &pair;  // a map's values stay where they are
  if (!is_new) return pair;
  pair.part = parts_.add();
  if (pair.part == nullptr) {
    overflowed_ = true;
    return pair;
  }
  pair.part->type = static_cast<std::uint32_t>(dJointTypeContact);
  pair.part->bodies[0] = high;  // so that the world comes second
  pair.part->bodies[1] = low;
  return pair;
}

void Ledger::take(World& world, Joint& joint, dReal h) {
  const Acting acting(world, joint.id, joint.places);
  if (acting.id == nullptr) return;
  PartSample* const part = part_of(joint);
  double work = acting.work(h);
  std::uint32_t rows = rows_of(joint.type);
  double by_motors = joint.type == dJointTypeAMotor || joint.type == dJointTypeLMotor ? work : 0;
  double by_stops = 0;
  bool at_limit = false;
  bool at_stop = false;
  for (const Drive& drive : joint.drives) {
    if (drive.most > 0) ++rows;
    const double force = acting.force_along(drive);
    // At a stop the row is the stop's, and what the motor adds is beside it.
    (drive.at_stop ? by_stops : by_motors) += h * force * acting.rate_along(drive);
    by_motors += h * drive.push * acting.rate_along(drive);
    work += h * drive.push * acting.moving_rate_along(drive);  // of which ODE's feedback does not tell
    constexpr double rounding = 1e-6;                          // of sums of forces with lever arms
    const double of_motor = drive.at_stop ? drive.push : force;
    at_limit = at_limit || (drive.most > 0 && std::fabs(of_motor) >= drive.most * (1 - rounding));
    at_stop = at_stop || drive.at_stop;
  }
  const auto [first, second] = acting.moving(world);
  rows_.add(first, second, rows);
  world.work.motors += by_motors;
  world.work.stops += by_stops;
  world.work.joints += work - by_motors - by_stops;
  if (part == nullptr) return;
  std::ranges::copy(acting.numbers(), part->bodies);
  ++part->steps;
  if (at_limit) ++part->steps_at_limit;
  if (at_stop) ++part->steps_at_stop;
  part->work += work;
  part->motor_work += by_motors;
  part->stop_work += by_stops;
  part->force = std::max({part->force, length(acting.forces->f1), length(acting.forces->f2)});
  part->torque = std::max({part->torque, length(acting.forces->t1), length(acting.forces->t2)});
}

namespace {

/// Of a contact, along its two axes, each: friction, and what it may be at most where that is a limit.
template <class Take>
void each_axis(const dContact& contact, const dReal* force, double normal, const Take& take) {
  const dSurfaceParameters& surface = contact.surface;
  const dReal* n = contact.geom.normal;
  std::array<dVector3, 2> axes{};
  if ((surface.mode & dContactFDir1) != 0) {
    std::copy_n(contact.fdir1, 3, axes[0]);
    dCalcVectorCross3(axes[1], n, axes[0]);
  } else {
    dPlaneSpace(n, axes[0], axes[1]);
  }
  const std::array mus{surface.mu, (surface.mode & dContactMu2) != 0 ? surface.mu2 : surface.mu};
  const std::array pyramids{dContactApprox1_1, dContactApprox1_2};
  for (std::size_t i = 0; i < 2; ++i) {
    const double most = (surface.mode & pyramids[i]) != 0 ? mus[i] * normal : mus[i];
    if (most > 0 && mus[i] < dInfinity) take(i, std::fabs(dot(force, axes[i])), most);
  }
}

}  // namespace

namespace {

/// s, in which a contact stops masses that approach: that of its damper or, where it has hardly one, of its spring.
double stopping_time(const Touch& touch, Softness its, dReal h) {
  double inverse_mass = 0;
  for (const int side : {0, 1}) {
    dBodyID body = dJointGetBody(touch.id, side);
    if (body == nullptr || dBodyIsKinematic(body) != 0) continue;
    dMass mass;
    dBodyGetMass(body, &mass);
    inverse_mass += 1 / mass.mass;
  }
  const double by_damper = its.cfm / (inverse_mass * (1 - its.erp));
  const double by_spring = std::sqrt(h * its.cfm / (inverse_mass * its.erp));
  return std::min(by_damper, by_spring);
}

}  // namespace

void Ledger::take(World& world, Touch& touch, dReal h) {
  std::array<std::size_t, 2> hints{};
  const Acting acting(world, touch.id, hints);
  if (acting.id == nullptr) return;
  ++world.contacts;
  world.depth = std::max(world.depth, touch.contact.geom.depth);
  const auto [first, second] = acting.moving(world);
  rows_.add(first, second, rows_of(touch.contact));
  const double work = acting.work(h);
  world.work.contacts += work;
  const auto numbers = acting.numbers();
  Pair& pair = pair_of(numbers[0], numbers[1]);
  if (pair.part == nullptr) return;
  if (!pair.touches) {  // one of its contacts is enough: they have what the two are made of
    touching_.push_back(&pair);
    stopping_s_ = std::min(stopping_s_, stopping_time(touch, softness_of(touch.contact.surface, world.id), h));
  }
  pair.touches = true;
  PartSample& part = *pair.part;
  const double normal = std::fabs(dot(acting.forces->f1, touch.contact.geom.normal));
  each_axis(touch.contact, acting.forces->f1, normal, [&](std::size_t axis, double friction, double most) {
    pair.friction[axis] += friction;
    pair.most[axis] += most;
  });
  part.work += work;
  part.force = std::max(part.force, normal);
  if (touch.contact.geom.depth > part.largest_m) {
    part.largest_m = touch.contact.geom.depth;
    part.largest_t = world.t;
  }
}

void Ledger::sum_up_pairs() {
  for (Pair* pair : touching_) {
    PartSample& part = *pair->part;
    ++part.steps;
    double share = -1;
    for (std::size_t i = 0; i < 2; ++i) {
      if (pair->most[i] > 0) share = std::max(share, pair->friction[i] / pair->most[i]);
    }
    // Its limits are those of normal forces that ODE has found without friction, of which only the sum stays.
    constexpr double all = 0.99;
    if (share >= 0) ++part.steps_rough;
    if (share >= all) ++part.steps_sliding;
    part.friction_share = std::max(part.friction_share, share);
    pair->friction = pair->most = {};
    pair->touches = false;
  }
  touching_.clear();
}

namespace {

std::uint32_t kind_of(dGeomID geom) {
  switch (dGeomGetClass(geom)) {
    case dBoxClass:
      return ShapeSample::box;
    case dSphereClass:
      return ShapeSample::sphere;
    case dCapsuleClass:
      return ShapeSample::capsule;
    case dCylinderClass:
      return ShapeSample::cylinder;
    case dPlaneClass:
      return ShapeSample::plane;
    default:
      return ShapeSample::bounds;
  }
}

/// Of its size, in what way it is told for its kind.
void measure(dGeomID geom, ShapeSample& shape) {
  dVector4 plane{};
  dReal bounds[6]{};
  switch (shape.kind) {
    case ShapeSample::box:
      return dGeomBoxGetLengths(geom, shape.size);
    case ShapeSample::sphere:
      shape.size[0] = dGeomSphereGetRadius(geom);
      return;
    case ShapeSample::capsule:
      return dGeomCapsuleGetParams(geom, &shape.size[0], &shape.size[1]);
    case ShapeSample::cylinder:
      return dGeomCylinderGetParams(geom, &shape.size[0], &shape.size[1]);
    case ShapeSample::plane:
      dGeomPlaneGetParams(geom, plane);
      std::copy_n(plane, 3, shape.size);
      shape.position[0] = plane[3];
      return;
    default:
      dGeomGetAABB(geom, bounds);
      for (int i = 0; i < 3; ++i) {
        shape.size[i] = bounds[2 * i + 1] - bounds[2 * i];
        shape.position[i] = (bounds[2 * i + 1] + bounds[2 * i]) / 2;
      }
  }
}

/// From the world's frame into the body's.
void put_into_frame(dBodyID body, ShapeSample& shape) {
  dVector3 away{};
  for (int i = 0; i < 3; ++i) away[i] = shape.position[i] - dBodyGetPosition(body)[i];
  dVector3 in_body{};
  dMultiply1_331(in_body, dBodyGetRotation(body), away);
  std::copy_n(in_body, 3, shape.position);
  dQuaternion turned{};
  dQMultiply1(turned, dBodyGetQuaternion(body), shape.quaternion);
  std::copy_n(turned, 4, shape.quaternion);
}

}  // namespace

void Ledger::draw(dGeomID geom, std::uint32_t body) {
  if (dGeomIsSpace(geom) != 0) return;
  ShapeSample shape{};
  shape.kind = kind_of(geom);
  shape.body = body;
  shape.quaternion[0] = 1;
  if (shape.kind != ShapeSample::plane && shape.kind != ShapeSample::bounds) {
    std::copy_n(dGeomGetPosition(geom), 3, shape.position);
    dGeomGetQuaternion(geom, shape.quaternion);
  }
  measure(geom, shape);
  if (dBodyID its = dGeomGetBody(geom)) put_into_frame(its, shape);
  if (ShapeSample* place = shapes_.add()) {
    *place = shape;
  } else {
    overflowed_ = true;
  }
}

void Ledger::draw(World& world) {
  for (Body& body : world.bodies) {
    if (body.drawn) continue;
    body.drawn = true;
    for (dGeomID geom = dBodyGetFirstGeom(body.id); geom != nullptr; geom = dBodyGetNextGeom(geom)) {
      draw(geom, body.number + 1);
    }
  }
}

void Ledger::draw_space(dSpaceID space) {
  const int count = dSpaceGetNumGeoms(space);
  for (int i = 0; i < count; ++i) {
    dGeomID geom = dSpaceGetGeom(space, i);
    if (dGeomIsSpace(geom) != 0) {
      draw_space(reinterpret_cast<dSpaceID>(geom));
    } else if (dGeomGetBody(geom) == nullptr) {
      draw(geom, 0);
    }
  }
}

}  // namespace odeval::audit
