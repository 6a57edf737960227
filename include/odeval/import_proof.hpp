#pragma once
// Whether what an engine holds of a robot is the robot of the file.
#include <optional>
#include <string>

namespace odeval {

/// Mass matrix and bias forces of ODE's world, taken back from its bodies and joints, beside those of others at random
/// states: largest differences. Of the mass matrix against the geometric mean of its two diagonal elements, of a bias
/// force against the largest, each against the root of its diagonal element. Stops, motors, springs and what else acts
/// along joints is no part of them, so that a robot with stops is proved as well, at states beyond its stops too.
struct ImportProof {
  int states = 0;
  std::optional<double> simbody = {};  // absent: this build is without
  std::optional<double> kdl = {};      // absent: KDL does not know such a robot
  std::string worst = {};              // name of the body whose coordinate has the largest of all
  std::string without = {};            // what is absent and why

  static constexpr double allowed = 1e-10;
  bool holds() const { return simbody.value_or(0) <= allowed && kdl.value_or(0) <= allowed && (simbody || kdl); }
};

}  // namespace odeval
