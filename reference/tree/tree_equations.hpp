#pragma once
// Equations of motion of a tree of bodies in generalized coordinates: Simbody's, which take time in proportion to the
// number of bodies. Where joints close loops, the accelerations that these allow.
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "odeval/motion.hpp"
#include "odeval/scenario.hpp"
#include "reference/tree/contact_points.hpp"
#include "reference/tree/loop_chart.hpp"
#include "reference/tree/spanning_tree.hpp"

namespace odeval::reference {

/// What a driven joint's motor and stop do for a while. Their force counts as a motor counts (mechanism.hpp).
struct Grip {
  bool holds = false;  // the joint keeps its speed, by whatever force that takes between the next two
  double least = 0;    // N m or N
  double most = 0;
  double force = 0;  // while it does not hold

  bool operator==(const Grip&) const = default;
};
/// Of all driven joints, in the order of TreeEquations::axes.
using Grips = std::vector<Grip>;

/// The state is what Simbody calls Q and U, one after the other: angles of hinges and universal joints (rad, 0 at t =
/// 0, without jumps), ways of sliders (m), quaternions of balls and of free bodies (whose length says nothing), places
/// of free bodies (m); then the speeds that belong to them. After these the loads that controllers hold which look once
/// a step.
class TreeEquations {
 public:
  using State = std::vector<double>;

  /// A joint that something drives, stops or loads; or one of several motions of a joint, with what does so there.
  struct Axis {
    Joint joint;
    std::size_t branch;                 // number in the tree
    double sign;                        // of its way against the coordinate in the state
    std::size_t way;                    // places in a state
    std::size_t speed;                  // likewise
    std::size_t held;                   // likewise, of the held load where there is one
    std::size_t number;                 // of the joint
    std::optional<std::size_t> motion;  // of several (driveable_of)
    std::size_t in_file;                // its number in files; 0 of a joint with one

    double q(const double* y) const { return sign * y[way]; }
    double rate(const double* y) const { return sign * y[speed]; }
  };

  /// The mechanism's joints are closed. Of its start the velocities that they allow.
  explicit TreeEquations(const Scenario& scenario);
  ~TreeEquations();

  /// "Simbody 3.7": whose equations they are.
  std::string version() const;
  /// Numbers in a state.
  std::size_t size() const { return start_.size(); }
  /// The state at t = 0.
  const State& start() const { return start_; }
  const std::vector<Axis>& axes() const { return axes_; }
  std::size_t bodies() const { return bodies_; }
  /// How many loops the joints close.
  std::size_t loops() const { return loops_; }
  /// Whether every joint's force is known: not where loops hold something twice.
  bool forces_are_known() const;

  /// Small states around a state.
  std::shared_ptr<const LoopChart> chart(const State& around) const;
  /// Likewise their slopes: of no number where loops can not be closed.
  void slope(const LoopChart& chart, double t, const double* small, double* slope, const Grips& grips) const;

  /// dy/dt
  void operator()(double t, const double* y, double* dydt, const Grips& grips) const;

  /// The bodies in the world. Of links in a plane with their angles.
  void show(const double* y, std::span<BodyState> bodies) const;
  /// The force of each joint on the body that it carries.
  void forces(double t, const double* y, const Grips& grips, std::span<JointState> joints) const;

  /// Motors and stops by what holds at a state: speeds that are reached, ends that are touched at no speed. `released`
  /// is an axis that does not hold whatever its speed, at a force.
  struct Released {
    std::size_t axis;
    double force;
  };
  Grips grips(double t, const double* y, std::optional<Released> released = {}) const;
  /// The forces by which those that hold do so, 0 of others.
  std::vector<double> holding(double t, const double* y, const Grips& grips) const;
  /// Axes that strike an end of their way or are pressed to it at a moment.
  struct Strike {
    std::vector<std::size_t> axes;
    std::vector<double> away;         // of each: the sign of the way that leaves the end
    std::vector<double> restitution;  // of each: its speed after over its speed before
  };
  /// Of an axis that strikes at a state, with those others that lie on their ends and feel it.
  Strike strike(const double* y, std::size_t axis) const;
  /// The state after it.
  State struck(const double* y, const Strike& strike) const;
  /// Where bodies may meet, and how these places stand at a state.
  const std::vector<ContactPoint>& points() const { return points_; }
  std::vector<Meeting> meetings(const double* y) const;
  Meeting meeting_at(const double* y, std::size_t point) const;
  /// Points at which bodies strike each other at a moment.
  struct Hit {
    std::vector<std::size_t> points;
    std::vector<double> restitution;  // of each: the speed after over the speed before
  };
  /// Of a point that meets at a state, with those others that meet there as well and feel it.
  Hit hit(const double* y, std::size_t point) const;
  /// The state after it.
  State rebounded(const double* y, const Hit& hit) const;
  /// The bodies at t = 0, with the speeds that weights, gyroscopic torques and what acts along joints alone would have
  /// given after dt, s.
  const std::vector<Placed>& pushed(double dt) const;
  /// The state with what controllers see now.
  State sampled(double t, const double* y) const;
  /// Whether any does.
  bool samples() const;
  /// Of all axes the one that springs, dampers and controllers move the fastest in a state, and how stiff they are for
  /// a step: h^2 k / m or h d / m, the larger, where m is what the axis has to move. Above 4, or 2, no explicit step of
  /// that length is stable. No axis where nothing of the kind acts.
  struct Stiffness {
    std::optional<std::size_t> axis = {};
    double of_step = 0;
  };
  Stiffness stiffest(const double* y, double step_s) const;

  /// m or rad, and m/s or rad/s, within which a joint is at its stop or at its motor's speed: what locating leaves.
  static constexpr double at_end = 1e-12;
  static constexpr double at_speed = 1e-12;
  /// A joint that would leave its stop slower than this stays there: it would rise by less than its way's rounding.
  static constexpr double rest_speed = 1e-7;

 private:
  void add_axis(Axis axis);
  struct Impacts;
  Impacts impacts(const double* y, const std::vector<std::size_t>& points) const;
  Eigen::VectorXd impulses(const double* y, const Strike& strike, const std::optional<Eigen::VectorXd>& most) const;
  void push(double t, const double* y, const Grips& grips, const std::vector<double>& held) const;

  std::size_t bodies_;
  std::vector<Joint> joints_;
  std::shared_ptr<const PlanarView> planar_;
  std::vector<Branch> tree_;
  std::unique_ptr<SimbodyTree> simbody_;
  std::vector<Axis> axes_;
  std::vector<ContactPoint> points_;
  std::size_t loops_ = 0;
  State start_;
};

}  // namespace odeval::reference
