#pragma once
// A mechanism in MuJoCo.
#include <mujoco/mujoco.h>

#include <memory>
#include <string>
#include <vector>

#include "engines/tree/hanging.hpp"
#include "engines/tree/joint_loads.hpp"
#include "engines/tree/world.hpp"
#include "odeval/scenario.hpp"

namespace odeval::engine_mujoco {

class MujocoWorld final : public engine_tree::World {
 public:
  /// `integrator` is one of mjtIntegrator.
  MujocoWorld(const Scenario& scenario, double step_s, int integrator);
  ~MujocoWorld() override;
  MujocoWorld(const MujocoWorld&) = delete;
  MujocoWorld& operator=(const MujocoWorld&) = delete;

  long step(double from, double to) override;
  const std::vector<engine_tree::Placed>& bodies() override;
  engine_tree::Touched touched() override { return touched_; }
  std::vector<Vec3> contact_forces() override;
  std::vector<Vec3> closing_forces() override;
  Told told() const override;

 private:
  struct Free {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };
  /// Where the one coordinate of a hinge or a slider stands.
  struct Coordinate {
    int position;  // in mjData::qpos
    int speed;     // in mjData::qvel
  };

  void start();
  void look_for_loads();
  /// What MuJoCo calls in every stage of a step, which has its contacts: puts the loads on.
  static void in_stage(const mjModel* model, mjData* data);
  void look_for_contacts();
  double way(const Coordinate& at) const { return data_->qpos[at.position]; }
  double rate(const Coordinate& at) const { return data_->qvel[at.speed]; }

  Mechanism mechanism_;
  std::vector<std::size_t> closing_;  // joints that close loops
  std::vector<engine_tree::Hanging> tree_;
  double time_constant_s_;  // of constraints
  bool too_stiff_ = false;  // it is less than two steps, and there are some
  std::unique_ptr<mjModel, Free> model_;
  std::unique_ptr<mjData, Free> data_;
  std::vector<int> number_;  // MuJoCo's of each body
  engine_tree::JointLoads<Coordinate> loads_;
  double from_s_ = 0;             // where the step began,
  mjtNum from_by_clock_ = 0;      // and by MuJoCo's own clock, which adds steps up
  engine_tree::Touched touched_;  // in any stage of the last step
  std::vector<engine_tree::Placed> bodies_;
};

}  // namespace odeval::engine_mujoco
