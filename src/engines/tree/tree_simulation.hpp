#pragma once
// The loop over a world that takes steps.
#include <memory>
#include <vector>

#include "engines/tree/hanging.hpp"
#include "engines/tree/impacts.hpp"
#include "engines/tree/world.hpp"
#include "odeval/engine.hpp"

namespace odeval::engine_tree {

/// A world that is moved and recorded.
class TreeSimulation final : public Simulation {
 public:
  TreeSimulation(const Scenario& scenario, const SampleGrid& grid, std::unique_ptr<World> world);

  SampleShape shape() const override { return {mechanism_.bodies.size(), mechanism_.joints.size(), 0}; }
  Outcome run(Recorder recorder) override;
  Told told() const override { return world_->told(); }

 private:
  double time_of(long step) const { return static_cast<double>(step) * grid_.step_s; }
  void move(Recorder& recorder, Outcome& outcome);
  void follow();
  double direction(std::size_t link) const;
  void weigh();
  void record(Sample sample) const;
  void record_forces(Sample sample) const;

  Mechanism mechanism_;
  std::shared_ptr<const PlanarView> view_;
  double gravity_;
  SampleGrid grid_;
  std::unique_ptr<World> world_;
  std::vector<std::size_t> closing_;  // joints that close loops
  std::vector<Hanging> tree_;
  Impacts impacts_;
  Touched touched_;              // in the last step
  long step_ = 0;                // of the grid, that have been taken
  std::vector<Placed> bodies_;   // after them
  std::vector<Placed> before_;   // before the last of them
  std::vector<Vec3> carried_;    // by what each body hangs on, N
  std::vector<Vec3> closed_by_;  // what closing joints give their first bodies, N
  std::vector<double> angles_;   // of links in a plane
};

}  // namespace odeval::engine_tree
