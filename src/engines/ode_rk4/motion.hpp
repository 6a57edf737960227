#pragma once
// Newton-Euler with Lagrange multipliers, a Runge-Kutta formula, and the projection onto the joints.
//
//   M u' = f + J' lambda,  J u' + bias = 0   =>   (J M^-1 J') lambda = -(J M^-1 f + bias)
//
// The system is solved by blocks (block_ldl.hpp) or, where joints make trees, along them (tree.hpp), which is faster
// and gives the same to rounding. One step: the stages; then positions move by -M^-1 J' A^-1 C and velocities by -M^-1
// J' A^-1 J u, A = J M^-1 J' at the end of the step: the nearest state, weighted by mass, that keeps the joints (to the
// second order in what is corrected, which is itself of the order of the step's error).
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engines/ode_rk4/block_ldl.hpp"
#include "engines/ode_rk4/mechanism.hpp"
#include "engines/ode_rk4/runge_kutta.hpp"
#include "engines/ode_rk4/tree.hpp"

namespace odeval::engine_rk4 {

struct Wrench {
  Vector3d force;
  Vector3d torque;

  Wrench& operator+=(const Wrench& other) {
    force += other.force;
    torque += other.torque;
    return *this;
  }
};

/// dq/dt at an angular velocity in the world.
Eigen::Vector4d turn_rate(const Vector3d& w, const Eigen::Vector4d& q);
/// A turn by a rotation vector in the world, exact in its angle.
void turn_by(const Vector3d& angle, Eigen::Vector4d& q);

/// What a contact that rests is taken to do to its bodies, and the other way to the second: along what moves and turns
/// with it.
struct Push {
  std::size_t a, b;  // one of them may be world_body
  std::size_t with;  // of them: the point moves with its centre, and away from it
  Vector3d arm, force, torque;
  Vector3d drift, spin;  // m/s and rad/s: of the arm, and of the others

  Vector3d point_after(double time, const State& state) const {
    const Vector3d point = arm + time * drift;
    return with == world_body ? point : Vector3d(state[with].pose.position + point);
  }
  Vector3d force_after(double time) const { return force + time * spin.cross(force); }
  Vector3d torque_after(double time) const { return torque + time * spin.cross(torque); }
};

/// On every body, gravity included. `renew`, if any, is asked for them at the time and the state of each stage.
struct Forces {
  std::vector<Wrench> now;
  std::function<void(double t, const State& state, std::vector<Wrench>& now)> renew;
  double start = 0;          // t of the state that a step starts from
  std::vector<Push> pushes;  // that act besides
  double since = 0;          // t at which they are as they stand there

  /// With pushes, at a state, `t` into the step.
  const std::vector<Wrench>& all(double t, const State& state);
  /// The same, of forces renewed.
  const std::vector<Wrench>& at(double t, const State& state) {
    if (renew) renew(t, state, now);
    return all(t, state);
  }

 private:
  std::vector<Wrench> sum_;
};

/// The joint that is farthest apart.
struct JointError {
  double size = 0;  // m or rad
  std::size_t joint = 0;
};

struct JointErrors {
  JointError before;
  JointError after;
};

/// What a motor that acts with contacts can still give at the end of a time.
struct LateMotor {
  std::size_t joint, motor;
  double least, most;  // N s or N m s; 0 is one of those between
  double before;       // what it gave last
  double within;       // N s or N m s: what it gave on the way
};

class Motion {
 public:
  /// `order` of the Runge-Kutta formula: 4 or 8. Not `along_trees`: all by blocks.
  explicit Motion(Mechanism mechanism, int order = 4, bool along_trees = true);

  const Mechanism& mechanism() const { return mechanism_; }

  /// A state moved by h, joints kept; `driven`: the state that `drive` was last called for. Errors: of the state that
  /// it started from, and of the one it came to.
  JointErrors step(const State& from, Forces& forces, double h, State& to, bool driven = false);

  /// For a step of h: reads velocities and limits of the motors anew, who is asleep, and what springs and damping
  /// are at that step.
  void prepare(double h);
  /// Throws AccurateStepError for springs that are stiffer than the step can follow, from this state on. Looks when the
  /// step has changed and then now and again, since poses change slowly beside what explodes.
  void check_springs(const State& state);
  bool has_motors() const { return !motors_.empty(); }
  /// Decides which motors hold and which push from this state on, `t` into the step. `broken` ones hold no more. Late
  /// ones hold a velocity that they have; to come to it is left to the end.
  void drive(const State& state, Forces& forces, double t, std::span<const std::size_t> broken);
  /// Motors of bodies that contacts act on at the end of a step are late. Within it those that do not hold push with
  /// what is expected of them.
  void put_off(const std::vector<char>& bodies);
  /// Of late motors: what each `gave` last, but of those that move bodies that are `off`, and where nothing is given,
  /// 0.
  void expect(std::span<const double> gave, const std::vector<char>& off);
  /// What each late one gave on average in a time h that has just ended, N or N m; 0 of the others.
  std::vector<double> gave(double h) const;
  /// Those, after a motion of a time h: their limits times h, less what they have given in it.
  std::vector<LateMotor> late(double h) const;
  /// That one of them gives.
  void note(const LateMotor& late, double impulse) {
    mechanism_.joints[late.joint].motors[late.motor].at_end = impulse;
  }
  const Motor& motor(const LateMotor& late) const { return mechanism_.joints[late.joint].motors[late.motor]; }
  /// At the pose of the last `project` or `displace`.
  MotorLine line(const LateMotor& late, const State& state) const {
    return line_of(mechanism_.joints[late.joint], motor(late), state, turns_);
  }
  /// After a step: can all motors go on as they are until contacts decide? Each of them is late, and needed no more
  /// than its limit at the last stage.
  bool can_wait() const;
  /// How far each motor is beyond what it does, at a state that a step came to: it holds with more than its limit, or
  /// has passed its velocity while it pushes. Positive: it has to change; as shares of its limit and its velocity.
  void beyond(const State& state, Forces& forces, double t, std::vector<double>& shares);
  bool holds(std::size_t motor) const { return motors_[motor].of(mechanism_).drive == Drive::holds; }
  /// Makes it push as it held.
  void let_slip(std::size_t motor);

  /// Moves poses onto the joints, then velocities, with motors released. Errors: as found, and what could not be
  /// mended.
  JointErrors project(State& state);

  /// Makes what is below ready at a state that keeps the joints, such as a step has come to: motors released.
  void stand(const State& state);

  /// The change of all velocities that impulses (N s, N m s) on bodies make, joints kept, at the pose of the last
  /// `project` or `displace`.
  void respond(const std::vector<Wrench>& impulses, std::vector<Twist>& change);

  /// Is it one of a joint's bodies? The world is not.
  bool jointed(std::size_t body) const { return body != world_body && jointed_[body] != 0; }
  /// The change of a body's velocity that an impulse makes without joints.
  Twist free_change(std::size_t body, const Wrench& impulse) const {
    return {mechanism_.bodies[body].inverse_mass * impulse.force, inverse_inertias_[body] * impulse.torque};
  }

  /// Moves poses by displacements (m, rad), then projects. Returns the joint error that could not be mended.
  JointError displace(const std::vector<Twist>& by, State& state);

  /// Does a joint's equation repeat what others say? Such ones are left out.
  bool redundant() const { return matrix_.left_out() > 0; }

  /// Of a joint with a feedback structure, or that stands for a contact, on its first and on its second body: N, and N
  /// m about the body's centre. The last stage of a step tells it, and those below.
  const Wrench& force_on_a(std::size_t joint) const { return joint_forces_[joint].on_a; }
  const Wrench& force_on_b(std::size_t joint) const { return joint_forces_[joint].on_b; }
  /// At a state, `t` into the step.
  void find_forces(const State& state, Forces& forces, double t);
  /// Impulses of the last `respond`, with which joints answer contacts, stood for forces over a time.
  void add_forces(double time);
  /// What a joint's stop does. `id` of the joint.
  void add_force(const void* id, const Wrench& on_a, const Wrench& on_b);

 private:
  /// Of the Runge-Kutta formula.
  struct Stage {
    State state;
    std::vector<Eigen::Vector4d> turn_rates;
    std::vector<Twist> accelerations;
  };
  struct MotorPlace {
    std::size_t joint, motor;
    Motor& of(Mechanism& mechanism) const { return mechanism.joints[joint].motors[motor]; }
    const Motor& of(const Mechanism& mechanism) const { return mechanism.joints[joint].motors[motor]; }
  };

  struct JointForce {
    Wrench on_a, on_b;
  };

  void combine(const State& from, std::span<const RungeKutta::Part> parts, double h, State& sum) const;
  static bool tells(const Joint& joint) { return joint.id == nullptr || dJointGetFeedback(joint.id) != nullptr; }
  JointForce reaction(std::size_t joint) const;
  void tell_forces(const State& state);
  void turn(const State& state);  // rotation matrices, inertias
  void look(const State& state);  // those, and rows; or the tree
  JointError largest_error();     // of the rows
  void factor();                  // the matrix of the rows
  void add_product(std::size_t i, std::size_t j, std::size_t body, Matrix6& block) const;
  void wake();
  void accelerate(const State& state, const std::vector<Wrench>& forces, std::vector<Twist>& accelerations);
  void push_along(const Joint& joint, const MotorLine& line, bool slides, double force,
                  std::vector<Twist>& accelerations);
  JointErrors finish(State& state, const JointError& found);
  void project_velocities(State& state);
  void release();
  void feel(const State& state, Forces& forces, double t);
  double too_fast(const MotorPlace& place, const State& state) const;
  double motor_force(const MotorPlace& place) const;
  bool moves(const MotorPlace& place, const std::vector<char>& bodies) const {
    const Joint& joint = mechanism_.joints[place.joint];
    return bodies[joint.a] != 0 || (joint.b != world_body && bodies[joint.b] != 0);
  }
  double time_to_speed(const MotorPlace& place, const State& state) const;
  void correct(State& state);                   // poses, once, by the errors of the rows
  void solve_onto(std::vector<Twist>& twists);  // twists -= M^-1 J' A^-1 (J twists + right-hand side in lambda_)

  Mechanism mechanism_;
  const RungeKutta* formula_;
  std::optional<Tree> tree_;
  BlockLdl matrix_;
  std::vector<char> jointed_;
  std::vector<MotorPlace> motors_;
  double step_ = 0;                  // s, of the user's
  std::vector<std::size_t> sprung_;  // joints
  int steps_unchecked_ = 0;          // since their springs were
  std::vector<std::size_t> damped_;  // bodies
  std::vector<Matrix3d> turns_;
  std::vector<Matrix3d> inverse_inertias_;  // world frame
  std::vector<JointRows> rows_;
  std::vector<std::array<Matrix6, 2>> weighted_;  // J M^-1 of a joint's two bodies
  std::vector<Vector6> lambda_;
  std::vector<Twist> acceleration_;
  std::vector<Twist> driven_acceleration_;  // of the state that `drive` was last called for
  JointError driven_error_;
  std::vector<Twist> correction_;
  std::vector<Stage> stages_;
  std::vector<JointForce> joint_forces_;
};

}  // namespace odeval::engine_rk4
