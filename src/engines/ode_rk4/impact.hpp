#pragma once
// What contacts do to velocities and poses: complementarity, solved for the whole mechanism.
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "engines/ode_rk4/accurate_step.hpp"
#include "engines/ode_rk4/friction.hpp"
#include "engines/ode_rk4/motion.hpp"

namespace odeval::engine_rk4 {

/// A point where body a meets body b. World frame.
struct Contact {
  std::size_t a, b;  // one of them may be world_body
  Vector3d point;    // m
  Vector3d normal;   // unit; moving a along it takes the bodies apart
  double depth;      // m
  double restitution;
  std::pair<const void*, const void*> geoms;  // in the order of their addresses; of a stop, its joint and itself
  bool turns = false;  // a stop of a hinge, what rolls or spins: the normal is an axis, the depth an angle
  bool idle = false;   // of an impact's rows: says nothing
  double friction = 0, rho = 0, rhoN = 0;  // of Bounce
  // N s and N m s, of it the last time it was held: where to begin
  Vector3d push = Vector3d::Zero(), turn = Vector3d::Zero();
  bool is_stop = false;
  // What it pushed on average while it was held last, N and N m; its arms on a and b, from their centres to the point,
  // and how they changed, m/s; how its normal turned, rad/s.
  Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero(), spin = Vector3d::Zero();
  std::array<Vector3d, 2> arms{Vector3d::Zero(), Vector3d::Zero()}, drifts = arms;
  bool placed = false;               // the arms are known
  bool steady = false;               // all of these are
  Vector3d came = Vector3d::Zero();  // m/s, a against b, at its point when the way here began, if it is steady
  bool followed = false;             // it rested when the way here began
  // N s and N m s: what of that acted on the way here.
  Vector3d felt = Vector3d::Zero(), felt_turn = Vector3d::Zero();
  bool missed = false;  // it is where it should be, but collision detection has not found it there

  bool rubs() const { return friction > 0 || rho > 0 || rhoN > 0; }
};

inline bool same_geoms(const Contact& one, const Contact& other) { return one.geoms == other.geoms; }

// What rests lies this deep, m: a thousand times deeper than contacts are rounded, so that it is found in every step.
constexpr double rest_depth = 1e-9;

/// Normal speed of a against b at a contact found at `state`, m/s; negative: they approach.
double normal_speed(const Contact& contact, const State& state);
/// The same, for velocities of another time.
double normal_speed(const Contact& contact, const State& found_at, const State& velocities);

/// Velocity of a against b at a contact's point, m/s.
Vector3d relative_velocity(const Contact& contact, const State& found_at, const State& velocities);
/// The same along the contact's plane.
Vector3d slip(const Contact& contact, const State& found_at, const State& velocities);

/// What slid and came to stick.
struct Sticks {
  double share = 1;  // about how much of the time in which the impulses acted had passed; 1: nothing did
  double slip = 0;   // m/s, before
};

/// What impulses at the contacts of one pose do: that of the motion's last projection.
class Impact {
 public:
  /// `work`: what friction may take yet (friction_work). `motors`: those that act in `stop`, besides.
  Impact(Motion& motion, std::span<const Contact> contacts, const State& state, double& work,
         std::vector<LateMotor> motors = {});

  /// After it no contact closes, impulses have only pushed, friction is in its cone, and kinetic energy is at most what
  /// it was. What bounces does so by the laws of restitution.hpp as without friction; then friction takes what it can
  /// in the cones of these impulses, and what it makes to close is stopped. Where nothing bounces all is held at once.
  /// Returns impulses. All bodies feel the impulses through the joints.
  Eigen::VectorXd strike(State& state, ImpactOrder order, double rest_speed) const;
  /// Without restitution: impulses, friction in its cone, and of motors, what contacts did on the way here included.
  /// Returns them.
  Eigen::VectorXd stop(State& state) const;
  /// What contacts did on the way here.
  Eigen::VectorXd felt() const;
  bool has_motors() const { return !motors_.empty(); }
  /// Of motors, J, by impulses of `stop` that acted evenly from one state to another, besides what they did on the way
  /// to where it was `free` of those: what they gave there goes on over what these make of the way.
  double work(const Eigen::VectorXd& impulses, const State& before, const State& free, const State& after) const;
  /// Of bodies that move of themselves, J, by impulses at contacts: a belt drives what rubs on it.
  double work_of_driven(const Eigen::VectorXd& impulses, const State& state) const;
  /// Takes off motors' limits what they gave.
  void spend(const Eigen::VectorXd& impulses, std::vector<LateMotor>& motors) const;
  /// What motors gave, as contacts whose first geom is the joint's id, with what they push; notes it for the next time.
  std::vector<Contact> note_motors(const Eigen::VectorXd& impulses) const;
  /// Joints answer to impulses (Motion::add_forces).
  void answer(const Eigen::VectorXd& impulses) const { respond(impulses); }
  /// Of motion that impulses alone would make of rest, J.
  double energy_of(const Eigen::VectorXd& impulses) const { return impulses.dot(response_ * impulses) / 2; }
  /// Of a contact's speed, by its own normal impulse alone.
  double own_change(const Eigen::VectorXd& impulses, std::size_t number) const {
    const auto i = static_cast<Eigen::Index>(number);
    return response_(i, i) * std::fabs(impulses[i]);
  }
  /// Writes to a contact what impulses it got.
  void note(const Eigen::VectorXd& impulses, std::size_t number, Contact& contact) const;
  /// What `stop`, of forces over a time h, brought to stick first, from the velocities that it had before and that
  /// sliding on would have led to if normal impulses stayed.
  Sticks sticks_at(const Eigen::VectorXd& impulses, const State& before, const State& state, double h) const;

  /// The way that friction, motors and what bounces make by impulses that act evenly over a time h; contacts get that
  /// much shallower. `all`: that all impulses make.
  std::vector<Twist> evenly(const Eigen::VectorXd& impulses, double h, std::vector<Contact>& contacts,
                            bool all = false) const;
  /// The way that takes the bodies apart, mass-weighted and with joints kept, until no contact is deeper than `depth`,
  /// to the first order, with what is given besides. What pushes and yet would be apart then is moved down to it.
  /// `guess`: positive where the way is likely to push; else where contacts did. Empty: there is nowhere to go.
  std::vector<Twist> way_out(double depth, std::span<const Twist> besides = {}, const Eigen::VectorXd& impulses = {},
                             const Eigen::VectorXd& guess = {}) const;

 private:
  double free_response(const Contact& contact) const;
  Eigen::VectorXd speeds(const State& state) const;
  void keep_momenta(const State& state) const;
  void strike_by(const Eigen::VectorXd& impulses, State& state) const;
  void add_rubbing(std::size_t contact, double coefficient, const Vector3d& one, const Vector3d& other, bool turns);
  void find_response(std::size_t bodies);
  void respond(const Eigen::VectorXd& sizes) const;  // into change_

  Eigen::VectorXd pushed_before() const;
  Eigen::VectorXd hold(const Eigen::VectorXd& speeds, const Rubbing& rubbing) const;
  Eigen::VectorXd rubbed(const Eigen::VectorXd& speeds, Eigen::VectorXd impulses, const Rubbing& rubbing) const;
  Eigen::Index normals() const { return static_cast<Eigen::Index>(contacts_.size()); }
  Eigen::Index motor_row(std::size_t k) const {
    return normals() + rubbing_.motors_at() + static_cast<Eigen::Index>(k);
  }

  Motion& motion_;
  std::span<const Contact> contacts_;
  double& work_;
  std::vector<LateMotor> motors_;
  // The contacts, then two more for each that rubs, along its plane, or rolls, about axes in its plane, or spins: about
  // its normal, and one that says nothing. Motors are last.
  std::vector<Contact> rows_;
  Rubbing rubbing_;
  Eigen::MatrixXd response_;    // speeds of the rows, for a unit impulse at each
  std::vector<Vector3d> arms_;  // of each row on its two bodies
  mutable std::vector<Wrench> impulses_;
  mutable std::vector<Twist> change_;
};

}  // namespace odeval::engine_rk4
