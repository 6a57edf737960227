#pragma once
// What a scenario file says, in its own words, before a generator makes a mechanism of it.
#include <optional>
#include <vector>

#include "model/problems.hpp"
#include "odeval/scenario.hpp"

namespace odeval {

/// One table [[bodies]].
struct BodyTable {
  bool sphere = false;
  double mass_kg = 0;
  Vec3 size_m{};        // sides along its own axes; of a sphere the diameter, three times
  Vec3 position_m{};    // of its centre
  Vec3 turn_rad{};      // rotation vector
  Vec3 velocity_m_s{};  // of its centre
  Vec3 spin_rad_s{};
  double aspect = 1;  // by how much the sides x and y are divided
};

/// [ground]: a plane through the origin that falls towards +x.
struct GroundTable {
  double slope_rad = 0;
  double restitution = 0;
  double friction = 0;  // a coefficient, or newtons of a whole body
  FrictionModel friction_model = FrictionModel::pyramid;
};

struct JointWord;  // model/joint_kinds.hpp

/// [joint]: what holds the first body, to the world where it is alone, to the second where there are two.
struct JointTable {
  const JointWord* kind = nullptr;
  Vec3 anchor_m{};        // where its halves meet when it is closed
  Vec3 axis{0, 1, 0};     // of a kind that has one
  Vec3 displacement_m{};  // from there to the first body's half at t = 0
};

struct Description {
  const Problem* problem = nullptr;
  std::optional<int> n;  // links of a chain; absent: as many as are listed
  std::vector<double> q0;
  std::vector<double> qd0;
  std::vector<Link> links;
  std::optional<Wall> wall;
  std::vector<BodyTable> bodies;
  std::optional<GroundTable> ground;
  std::optional<JointTable> joint;
};

}  // namespace odeval
