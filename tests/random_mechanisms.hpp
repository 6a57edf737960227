#pragma once
// Random trees and loops of bodies: every kind of joint, bodies with tensors of their own, loads.
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <vector>

#include "odeval/scenario.hpp"
#include "reference/closed_form/rotation.hpp"
#include "tests/random_joints.hpp"

namespace odeval::test {

/// The same body told along other axes of its own: its tensor is then no diagonal one.
inline Body in_axes(const Body& body, const Rotation& axes) {
  const Vec3 moments = body.uniform_moments_kgm2();
  Body other = body;
  std::array<double, 9>& tensor = other.inertia_kgm2.emplace();
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      tensor[3 * i + j] = 0;
      for (std::size_t k = 0; k < 3; ++k) tensor[3 * i + j] += axes[3 * i + k] * moments[k] * axes[3 * j + k];
    }
  }
  return other;
}

/// The child moves as the joint lets it, against its parent.
inline void set_speed(Random& random, Body& child, const Body* parent, const JointKind& kind) {
  const Vec3 anchor = anchor_m(kind);
  if (parent != nullptr) {
    child.spin_rad_s = parent->spin_rad_s;
    child.velocity_m_s = parent->velocity_m_s + cross(parent->spin_rad_s, anchor - parent->position_m);
  }
  const Freedom free = freedom_of(kind);
  for (const Vec3& way : free.ways) child.velocity_m_s = child.velocity_m_s + random.within(-0.5, 0.5) * way;
  for (const Vec3& turn : free.turns) child.spin_rad_s = child.spin_rad_s + random.within(-2, 2) * turn;
  child.velocity_m_s = child.velocity_m_s + cross(child.spin_rad_s, child.position_m - anchor);
}

/// The first so many kinds of any_kind.
inline constexpr std::size_t simple_kinds = 5;
inline constexpr std::size_t kinds_that_converge =
    7;                                       // in ODE: tests/oracle/sliding_joints_test.cpp tells why the others do not
inline constexpr std::size_t all_kinds = 9;  // but for plane2d, which holds to the world alone

/// A tree of bodies on joints of the first so many kinds, boxes with tensors of their own among them; every other one
/// hangs on the world, the others fly.
inline Scenario grown(unsigned seed, std::size_t count, std::size_t kinds = simple_kinds) {
  Random random(seed);
  Scenario scenario;
  scenario.name = "tree" + std::to_string(seed);
  scenario.duration_s = 0.5;
  scenario.ode.cfm = 1e-10;
  std::vector<Body>& bodies = scenario.mechanism.bodies;
  for (std::size_t i = 0; i < count; ++i) {
    Body body{.shape = Box{{random.within(0.1, 0.6), random.within(0.1, 0.6), random.within(0.1, 0.6)}},
              .mass_kg = random.within(0.3, 3),
              .position_m = random.vector(1.5),
              .attitude = random.vector(2)};
    if (i % 2 == 1) body = in_axes(body, reference::rotation_of(random.vector(1)));
    const bool hangs_on_world = i == 0 && seed % 2 == 1;
    if (i == 0 && !hangs_on_world) {
      body.velocity_m_s = random.vector(1);
      body.spin_rad_s = random.vector(2);
    } else {
      const std::size_t parent = hangs_on_world ? 0 : random.below(i);
      // Fixed to the world nothing would move; the kinds come in turn, so that few trees have them all.
      const std::size_t kind =
          hangs_on_world ? (seed % 4 + (seed % 3 == 0 && kinds > simple_kinds ? 4 : 0)) % kinds : (seed + i) % kinds;
      Joint joint{.kind = any_kind(random, kind, body.position_m + random.vector(0.4)), .first = i, .second = {}};
      if (!hangs_on_world) joint.second = parent;
      if (!hangs_on_world && random.below(2) == 0) joint = {.kind = joint.kind, .first = parent, .second = i};
      set_speed(random, body, hangs_on_world ? nullptr : &bodies[parent], joint.kind);
      scenario.mechanism.joints.push_back(joint);
    }
    bodies.push_back(body);
  }
  return scenario;
}

inline Scenario grown(unsigned seed) { return grown(seed, 3 + seed % 4); }

/// A spring, a torque and a controller of the sizes that such bodies feel, on a Joint or an AxisDrive.
template <class Loaded>
void load_one(Random& random, Loaded& one) {
  const auto signal = [&] {
    return Signal{.constant = random.within(-1, 1),
                  .amplitude = random.within(-1, 1),
                  .frequency_Hz = random.within(0.5, 3),
                  .phase_rad = random.within(-3, 3)};
  };
  one.springs = {{random.within(0, 4), random.within(0, 0.1), random.within(-0.5, 0.5)}};
  one.torques = {signal()};
  one.controllers = {{.kp = random.within(0, 2), .kd = random.within(0, 0.05), .target = signal()}};
}

/// They act on every hinge and slider.
inline void load(Scenario& scenario, unsigned seed) {
  Random random(seed + 1000);
  for (Joint& joint : scenario.mechanism.joints) {
    if (!std::holds_alternative<HingeJoint>(joint.kind) && !std::holds_alternative<SliderJoint>(joint.kind)) continue;
    load_one(random, joint);
  }
}

/// They act on every motion of joints with several.
inline std::size_t load_motions(Scenario& scenario, unsigned seed) {
  Random random(seed + 3000);
  std::size_t loaded = 0;
  for (Joint& joint : scenario.mechanism.joints) {
    const std::size_t motions = driveable_of(joint.kind).size();
    for (std::size_t k = 0; k < motions; ++k) {
      load_one(random, joint.drives.emplace_back(AxisDrive{.motion = k, .number = k + 1}));
      ++loaded;
    }
  }
  return loaded;
}

/// What all joints hold, by rows, of velocity and spin of each body in turn.
inline Eigen::MatrixXd held_by_joints(const Mechanism& mechanism) {
  const std::vector<Body>& bodies = mechanism.bodies;
  const auto size = static_cast<Eigen::Index>(6 * bodies.size());
  std::vector<Eigen::VectorXd> held;
  const auto hold = [&](const Joint& joint, const Vec3& way, const Vec3& turn) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
    const auto add = [&](std::size_t body, double sign) {
      const Vec3 lever = cross(anchor_m(joint.kind) - bodies[body].position_m, way);
      for (std::size_t k = 0; k < 3; ++k) {
        row[static_cast<Eigen::Index>(6 * body + k)] += sign * way[k];
        row[static_cast<Eigen::Index>(6 * body + 3 + k)] += sign * (lever[k] + turn[k]);
      }
    };
    add(joint.first, 1);
    if (joint.second) add(*joint.second, -1);
    held.push_back(row);
  };
  for (const Joint& joint : mechanism.joints) {
    const Freedom free = freedom_of(joint.kind);
    for (const Vec3& direction : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      const auto minus = [&](const std::vector<Vec3>& directions) {
        Vec3 left = direction;
        for (const Vec3& along : directions) left = left - dot(left, along) * along;
        return left;
      };
      hold(joint, minus(free.ways), {});
      hold(joint, {}, minus(free.turns));
    }
  }
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(held.size()), size);
  for (std::size_t i = 0; i < held.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = held[i];
  return rows;
}

inline Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factored(const Eigen::MatrixXd& rows) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors;
  factors.setThreshold(1e-9);
  factors.compute(rows);
  return factors;
}

/// Velocities as near as may be to those that bodies have that all joints allow.
inline void fit_start(Mechanism& mechanism) {
  std::vector<Body>& bodies = mechanism.bodies;
  const Eigen::MatrixXd rows = held_by_joints(mechanism);
  const Eigen::Index size = rows.cols();
  Eigen::VectorXd speeds(size);
  const auto of = [](Body& body, std::size_t k) -> double& {
    return k < 3 ? body.velocity_m_s[k] : body.spin_rad_s[k - 3];
  };
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    speeds[i] = of(bodies[k / 6], k % 6);
  }
  speeds -= factored(rows).solve(rows * speeds);
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    of(bodies[k / 6], k % 6) = speeds[i];
  }
}

/// As above, where kind 4, which would hold all, is the plane.
inline void lay_in_plane(Scenario& scenario) {
  for (Joint& joint : scenario.mechanism.joints) {
    if (joint.second || !std::holds_alternative<FixedJoint>(joint.kind)) continue;
    Body& body = scenario.mechanism.bodies[joint.first];
    const double height = body.position_m[2];
    for (Body& all : scenario.mechanism.bodies) all.position_m[2] -= height;
    for (Joint& all : scenario.mechanism.joints) {
      std::visit([&](auto& kind) { kind.anchor_m[2] -= height; }, all.kind);
    }
    joint.kind = PlaneJoint{body.position_m};
    body.velocity_m_s = {0.3, -0.2, 0};
    body.spin_rad_s = {0, 0, 1};
  }
  fit_start(scenario.mechanism);
}

/// Joints that close loops, as many as leave two freedoms, where none holds what others hold already: what such a loop
/// holds twice is at odds by the error of its joints. And at every third a hinge beside one that is there, which says
/// the same again, whatever the error. False: none was found.
inline bool close_loops(Scenario& scenario, unsigned seed, std::size_t kinds) {
  Random random(seed + 3000);
  Mechanism& mechanism = scenario.mechanism;
  const auto left = [&] {
    return 6 * static_cast<Eigen::Index>(mechanism.bodies.size()) - factored(held_by_joints(mechanism)).rank();
  };
  std::size_t closed = 0;
  for (int tries = 0; tries < 200 && closed < 1 + seed % 2; ++tries) {
    const std::size_t first = random.below(mechanism.bodies.size());
    const std::size_t second = random.below(mechanism.bodies.size());
    if (first == second) continue;
    const Vec3 between = 0.5 * (mechanism.bodies[first].position_m + mechanism.bodies[second].position_m);
    const JointKind kind = any_kind(random, random.below(kinds), between + random.vector(0.2));
    const Freedom free = freedom_of(kind);
    const auto holds = 6 - static_cast<Eigen::Index>(free.ways.size() + free.turns.size());
    const Eigen::Index before = left();
    mechanism.joints.push_back({.kind = kind, .first = first, .second = second});
    if (before - holds >= 2 && left() == before - holds) {
      ++closed;
    } else {
      mechanism.joints.pop_back();
    }
  }
  const auto hinge = std::ranges::find_if(
      mechanism.joints, [](const Joint& joint) { return std::holds_alternative<HingeJoint>(joint.kind); });
  if (seed % 3 == 0 && hinge != mechanism.joints.end()) {
    Joint beside = *hinge;
    auto& kind = std::get<HingeJoint>(beside.kind);
    kind.anchor_m = kind.anchor_m + 0.3 * kind.axis;
    mechanism.joints.push_back(beside);
  }
  fit_start(mechanism);
  return closed > 0;
}

}  // namespace odeval::test
