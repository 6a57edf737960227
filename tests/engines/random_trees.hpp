#pragma once
// Trees of bodies for engines in joint coordinates: every kind of joint, bodies with tensors of their own, loads.
#include <cmath>
#include <string>

#include "odeval/scenario.hpp"
#include "tests/random_joints.hpp"

namespace odeval::test {

/// A tensor that a body could have: moments of a box along turned axes, which the products of inertia show.
inline std::array<double, 9> any_tensor(Random& draw, double mass_kg) {
  const double moment = mass_kg * draw.within(0.02, 0.05);
  const Vec3 along = draw.direction();
  std::array<double, 9> tensor{};
  // I = m (1.2 - 0.7 n n'): moments 1.2, 1.2 and 0.5 of m, and a little apart.
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) tensor[3 * i + j] = -0.7 * moment * along[i] * along[j];
    tensor[4 * i] += moment * (1.2 + 0.05 * static_cast<double>(i));
  }
  return tensor;
}

/// Every other one hangs on the world, the others fly. The first body of a joint is the one that carries or the one
/// that hangs. `loads`: springs, torques and controllers on hinges and sliders.
inline Scenario random_tree(unsigned seed, bool loads) {
  Random draw(seed);
  Scenario scenario;
  scenario.name = "tree" + std::to_string(seed);
  scenario.duration_s = 0.5;
  std::vector<Body>& bodies = scenario.mechanism.bodies;
  const std::size_t count = 3 + seed % 4;
  for (std::size_t i = 0; i < count; ++i) {
    Body body{.shape = Box{{draw.within(0.1, 0.6), draw.within(0.1, 0.6), draw.within(0.1, 0.6)}},
              .mass_kg = draw.within(0.3, 3),
              .position_m = draw.vector(1.5),
              .attitude = draw.vector(2)};
    if (i % 2 == 1) body.inertia_kgm2 = any_tensor(draw, body.mass_kg);
    const bool on_world = i == 0 && seed % 2 == 1;
    if (i == 0 && !on_world) {
      body.velocity_m_s = draw.vector(1);
      body.spin_rad_s = draw.vector(2);
      bodies.push_back(body);
      continue;
    }
    const std::size_t parent = on_world ? 0 : draw.below(i);
    // Fixed to the world nothing would move.
    const JointKind kind = any_kind(draw, (on_world ? seed / 2 % 4 : seed + i) % 5, body.position_m + draw.vector(0.4));
    const bool parent_first = !on_world && draw.below(2) == 0;
    Joint joint{.kind = kind, .first = parent_first ? parent : i, .second = {}};
    if (!on_world) joint.second = parent_first ? i : parent;
    if (loads && freedom_of(kind).ways.size() + freedom_of(kind).turns.size() == 1) {
      joint.springs = {{draw.within(0, 4), draw.within(0, 0.1), draw.within(-0.5, 0.5)}};
      joint.torques = {{.constant = draw.within(-1, 1),
                        .amplitude = draw.within(-1, 1),
                        .frequency_Hz = draw.within(0.5, 3),
                        .phase_rad = draw.within(-3, 3)}};
      joint.controllers = {
          {.kp = draw.within(0, 2), .kd = draw.within(0, 0.05), .target = {.constant = draw.within(-1, 1)}}};
    }
    const Vec3 anchor = anchor_m(kind);
    if (!on_world) {
      body.spin_rad_s = bodies[parent].spin_rad_s;
      body.velocity_m_s =
          bodies[parent].velocity_m_s + cross(bodies[parent].spin_rad_s, anchor - bodies[parent].position_m);
    }
    const Freedom free = freedom_of(kind);
    for (const Vec3& way : free.ways) body.velocity_m_s = body.velocity_m_s + draw.within(-0.5, 0.5) * way;
    for (const Vec3& turn : free.turns) body.spin_rad_s = body.spin_rad_s + draw.within(-2, 2) * turn;
    body.velocity_m_s = body.velocity_m_s + cross(body.spin_rad_s, body.position_m - anchor);
    bodies.push_back(body);
    scenario.mechanism.joints.push_back(joint);
  }
  return scenario;
}

}  // namespace odeval::test
