#include "audit/preload/worlds.hpp"

#include <algorithm>

#include "audit/preload/own.hpp"

namespace odeval::audit {

void Body::keep_found() {
  told = true;
  std::copy_n(dBodyGetLinearVel(id), 3, velocity_found.begin());
  std::copy_n(dBodyGetAngularVel(id), 3, spin_found.begin());
}

void Body::keep_left() {
  std::copy_n(dBodyGetLinearVel(id), 3, velocity_left.begin());
  std::copy_n(dBodyGetAngularVel(id), 3, spin_left.begin());
}

Body* World::find(dBodyID body, std::size_t& hint) {
  if (body == nullptr) return nullptr;
  if (hint < bodies.size() && bodies[hint].id == body) return &bodies[hint];
  const auto found = std::ranges::find(bodies, body, &Body::id);
  if (found == bodies.end()) return nullptr;
  hint = static_cast<std::size_t>(found - bodies.begin());
  return &*found;
}

void World::keep_forces() {
  for (Body& body : bodies) {
    std::copy_n(dBodyGetForce(body.id), 3, body.force.begin());
    std::copy_n(dBodyGetTorque(body.id), 3, body.torque.begin());
  }
}

void World::put_forces_back() {
  for (Body& body : bodies) {
    dBodySetForce(body.id, body.force[0], body.force[1], body.force[2]);
    dBodySetTorque(body.id, body.torque[0], body.torque[1], body.torque[2]);
  }
}

World& Worlds::of(dWorldID id) {
  const auto found = std::find_if(worlds_.begin(), worlds_.end(), [id](const World& world) { return world.id == id; });
  if (found != worlds_.end()) return *found;
  worlds_.push_back({.id = id, .number = worlds_made_++});
  return worlds_.back();
}

void Worlds::forget(dWorldID id) {
  std::erase_if(worlds_, [id](const World& world) { return world.id == id; });
}

void Worlds::add(dWorldID world, dBodyID body) { of(world).bodies.push_back({.id = body, .number = bodies_made_++}); }

void Worlds::forget(dBodyID body) {
  std::erase_if(of(dBodyGetWorld(body)).bodies, [body](const Body& one) { return one.id == body; });
}

void Worlds::add(dWorldID world, dJointID joint, dJointType type, dJointGroupID group) {
  of(world).joints.push_back(
      {.id = joint, .number = joints_made_++, .type = type, .group = group, .axes = axes_of(type)});
  if (group != nullptr) ++of(group).other;
}

void Worlds::add_contact(dWorldID world, dJointID joint, const dContact& contact, dJointGroupID group, bool renewable) {
  World& its = of(world);
  if (follows_touches_) its.touches.emplace_back(joint, group, contact);
  if (follows_made_) its.made.push_back({joint, group});
  ++its.contacts;
  its.depth = std::max(its.depth, contact.geom.depth);
  if (group == nullptr) {
    loose_ = true;
  } else if (renewable) {
    ++of(group).fresh;
  } else {
    ++of(group).other;
  }
}

void Worlds::forget(dJointID joint) {
  const Joint* its = find(joint);
  if (its != nullptr && its->group != nullptr) return;  // ODE leaves it to its group
  for (World& world : worlds_) {
    if (std::erase_if(world.joints, [joint](const Joint& one) { return one.id == joint; }) > 0) return;
    const auto is_its = [joint](const auto& one) { return one.id == joint && one.group == nullptr; };
    if (std::erase_if(world.touches, is_its) + std::erase_if(world.made, is_its) > 0) return;
  }
}

const Joint* Worlds::find(dJointID joint) const {
  for (const World& world : worlds_) {
    const auto found =
        std::find_if(world.joints.begin(), world.joints.end(), [joint](const Joint& one) { return one.id == joint; });
    if (found != world.joints.end()) return &*found;
  }
  return nullptr;
}

void Worlds::empty(dJointGroupID group) {
  of(group) = {.id = group};
  for (World& world : worlds_) {
    std::erase_if(world.joints, [group](const Joint& one) { return one.group == group; });
  }
  forget_contacts(group);
}

void Worlds::forget_contacts(dJointGroupID group) {
  for (World& world : worlds_) {
    const auto is_its = [group](const auto& one) { return one.group == group; };
    std::erase_if(world.touches, is_its);
    std::erase_if(world.made, is_its);
  }
}

void Worlds::forget(dJointGroupID group) {
  empty(group);
  std::erase_if(groups_, [group](const Group& one) { return one.id == group; });
}

bool Worlds::empty_contacts() {
  const auto mixed = [](const Group& group) { return group.fresh > 0 && group.other > 0; };
  if (loose_ || std::any_of(groups_.begin(), groups_.end(), mixed)) return false;
  for (Group& group : groups_) {
    if (group.fresh == 0) continue;
    ODEVAL_OWN(dJointGroupEmpty)(group.id);
    forget_contacts(group.id);
    group.fresh = 0;
  }
  return true;
}

void Worlds::age() {
  for (Group& group : groups_) {
    group.other += group.fresh;
    group.fresh = 0;
  }
  loose_ = false;
}

Group& Worlds::of(dJointGroupID id) {
  const auto found = std::find_if(groups_.begin(), groups_.end(), [id](const Group& group) { return group.id == id; });
  if (found != groups_.end()) return *found;
  groups_.push_back({.id = id});
  return groups_.back();
}

}  // namespace odeval::audit
