#pragma once
// A mechanism in DART.
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/Joint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/simulation/World.hpp>

#include <optional>
#include <utility>
#include <vector>

#include "engines/tree/hanging.hpp"
#include "engines/tree/joint_loads.hpp"
#include "engines/tree/touching.hpp"
#include "engines/tree/world.hpp"
#include "odeval/scenario.hpp"

namespace odeval::engine_dart {

class DartWorld final : public engine_tree::World {
 public:
  DartWorld(const Scenario& scenario, double step_s);

  long step(double from, double to) override;
  const std::vector<engine_tree::Placed>& bodies() override;
  engine_tree::Touched touched() override;
  std::vector<Vec3> contact_forces() override;
  Told told() const override;

 private:
  dart::dynamics::BodyNode* make(const engine_tree::Hanging& hanging, dart::dynamics::BodyNode* parent,
                                 const dart::dynamics::BodyNode::Properties& body);

  static void press(dart::dynamics::Joint* joint, double force);
  void drive(const Joint& joint, dart::dynamics::Joint& made);
  void meet(const Scenario& scenario);

  engine_tree::Touching touching_;
  dart::simulation::WorldPtr world_;
  dart::dynamics::SkeletonPtr skeleton_;                           // all bodies, however many trees they are
  std::vector<dart::dynamics::BodyNode*> nodes_;                   // by the numbers of bodies
  std::vector<std::pair<dart::dynamics::Joint*, double>> motors_;  // and their speeds
  engine_tree::JointLoads<dart::dynamics::Joint*> loads_;
  std::vector<engine_tree::Placed> bodies_;
};

}  // namespace odeval::engine_dart
