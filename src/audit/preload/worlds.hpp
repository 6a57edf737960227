#pragma once
// The worlds of the program, their bodies and joints, as they come and go: ODE lists none of them.
#include <ode/ode.h>

#include <array>
#include <cstdint>
#include <list>
#include <span>
#include <vector>

#include "audit/preload/axes.hpp"

namespace odeval::audit {

using Triple = std::array<dReal, 4>;  // as ODE's vectors, the last unused

/// One of a kind that ODE has changed for the length of a step, and what it was.
struct Changed {
  int parameter;
  dReal before;
};

struct PartSample;

struct Body {
  dBodyID id;
  std::uint32_t number;  // in order of creation, of all worlds
  bool drawn = false;    // its geoms are told of
  bool moves = true;     // it is not kinematic
  Triple velocity{};     // before the step; then the mean over it, as of the next
  Triple spin{};
  Triple force{};  // what the program has added for the step
  Triple torque{};
  std::array<dReal, 2> damping{};  // linear, angular, and the steps until it is disabled, while they are changed
  int steps_to_rest = -1;          // -1: they are not
  bool told = false;        // of in the step, when ODE had moved it, as is what is damped or has a callback; then:
  Triple velocity_found{};  // of the equations
  Triple spin_found{};
  Triple velocity_left{};  // by the callback, before it is damped
  Triple spin_left{};

  void keep_found();
  void keep_left();
};

/// An axis of a joint with a motor or stops, as it was before the step.
struct Drive {
  const Axis* row;
  dReal most;  // of the motor's force
  dReal low;   // stops
  dReal high;
  Triple axis{};
  Triple lever{};  // of a hinge, what the torque of a force about it is the product with; of a slider, of a spin with
  bool at_stop = false;
  dReal push = 0;  // there: of the motor, on the first body
};

struct Joint {
  dJointID id;
  std::uint32_t number;  // in order of creation, of all worlds
  dJointType type;
  dJointGroupID group;                  // 0: none
  bool seen = false;                    // by `gap`
  Triple offset{};                      // then: of the bodies, in the frame of the first
  dJointFeedback feedback{};            // sum over the parts of a step
  std::vector<Changed> changed{};       // parameters, while they are
  std::span<const Axis> axes{};         // of its motors and stops
  std::vector<Drive> drives{};          // of those, the ones that it has
  PartSample* part = nullptr;           // of the ledger
  std::array<std::size_t, 2> places{};  // of its bodies in the world's, if they still are there
};

/// A contact that is there, for the ledger.
struct Touch {
  dJointID id;
  dJointGroupID group;
  dContact contact;
  dJointFeedback feedback;  // set when ODE is asked for it

  Touch(dJointID its_id, dJointGroupID its_group, const dContact& its) : id(its_id), group(its_group), contact(its) {}
};

/// A contact that is there, for what the program is told of its forces.
struct Made {
  dJointID id;
  dJointGroupID group;
};

class Softened;

struct World {
  dWorldID id;
  std::uint32_t number;
  std::uint64_t steps = 0;
  double t = 0;
  std::vector<Body> bodies{};
  std::vector<Joint> joints{};   // no contacts
  std::vector<Touch> touches{};  // while they are followed
  std::vector<Made> made{};      // contacts, while they are followed
  std::uint32_t contacts = 0;    // made since the last step; with a ledger, then those that act on a body in it
  dReal depth = 0;               // the largest of them
  struct {
    double added = 0;
    double motors = 0;
    double stops = 0;
    double joints = 0;
    double contacts = 0;
    double damping = 0;
    double program = 0;
  } work{};                            // since the start, J
  double energy = 0;                   // when it was last sampled, J
  const Softened* softened = nullptr;  // while it is

  /// Null: it is no body, or another world's; `hint` is where it stood among the bodies.
  Body* find(dBodyID body, std::size_t& hint);
  void keep_forces();
  void put_forces_back();
};

/// Joints that the program empties together.
struct Group {
  dJointGroupID id;
  long fresh = 0;  // contacts made since the last step, where what made them can be called again
  long other = 0;  // joints
};

class Worlds {
 public:
  World& of(dWorldID id);  // which is followed from now on, if it was not
  void forget(dWorldID id);

  void add(dWorldID world, dBodyID body);
  void forget(dBodyID body);

  void add(dWorldID world, dJointID joint, dJointType type, dJointGroupID group);
  void follow_touches() { follows_touches_ = true; }
  void follow_made() { follows_made_ = true; }
  void add_contact(dWorldID world, dJointID joint, const dContact& contact, dJointGroupID group, bool renewable);
  void forget(dJointID joint);
  const Joint* find(dJointID joint) const;  // null where it is not followed
  void empty(dJointGroupID group);
  void forget(dJointGroupID group);

  /// Empties the groups of contacts that can be made anew. False, and nothing is done, when there are others.
  bool empty_contacts();
  /// A step was taken: no contact is fresh any more.
  void age();

  std::size_t size() const { return worlds_.size(); }

 private:
  Group& of(dJointGroupID id);
  void forget_contacts(dJointGroupID group);

  std::list<World> worlds_;  // which stay where they are
  std::vector<Group> groups_;
  std::uint32_t worlds_made_ = 0;
  std::uint32_t bodies_made_ = 0;
  std::uint32_t joints_made_ = 0;
  bool follows_touches_ = false;
  bool follows_made_ = false;
  bool loose_ = false;  // contacts were made since the last step that are in no group
};

}  // namespace odeval::audit
