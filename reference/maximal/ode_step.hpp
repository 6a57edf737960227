#pragma once
// One dWorldStep of ODE 0.16.2, rebuilt from its mathematics: rigid bodies, hinges, frictionless contacts.
//
// With h the step, J the rows of all constraints and M^-1 = diag(1/m, I_w^-1) with the inertia I_w of the pose at the
// start of the step, forces f hold gravity and the gyroscopic torque, and
//
//   (J M^-1 J^T + CFM/h) lambda = c/h - J (v/h + M^-1 f),   lambda >= 0 for contacts
//   v += h M^-1 (f + J^T lambda),   x += h v,   q += h/2 (0, w) q, normalised
//
// c is the velocity a row asks for: ERP/h times the joint's error, or what a bounce gives back. Velocities come first,
// with J of the old pose, and positions follow with the new ones: semi-implicit Euler.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <span>
#include <vector>

#include "reference/maximal/box_lcp.hpp"

namespace odeval::reference::maximal {

/// A rigid body, world frame where nothing else is said.
struct Body {
  double mass = 1;                                                  // kg
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();            // about the centre, body frame, kg m²
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               // centre of mass, m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  // body to world
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();           // the same; set_orientation keeps both together
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();               // m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();                   // rad/s

  void set_orientation(const Eigen::Quaterniond& unit);
};

/// A uniform box, sides along the body's axes.
Body box(double mass, const Eigen::Vector3d& sides);
Body ball(double mass, double radius);

inline constexpr int world = -1;

/// Two bodies that turn about a common axis.
struct Hinge {
  int body0;
  int body1;                // or `world`
  Eigen::Vector3d anchor0;  // body frame of body 0
  Eigen::Vector3d axis0;    // unit, likewise
  Eigen::Vector3d anchor1;  // body frame of body 1, or world frame
  Eigen::Vector3d axis1;
};

/// Bodies that overlap, without friction. It acts in one step.
struct Contact {
  int body0;
  int body1;                 // or `world`
  Eigen::Vector3d position;  // world frame
  Eigen::Vector3d normal;    // unit, into body 0
  double depth;              // m, >= 0
};

/// How the torque -w x (I w) of a tumbling body enters. ODE's is the linearly implicit one; the others are for
/// comparison: explicit as in a textbook, or left out.
enum class Gyroscopic { implicit_linear, explicit_torque, none };

struct OdeStepSettings {
  double erp = 0.2;
  double cfm = 1e-5;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();                    // m/s²
  double bounce = 0;                                                    // restitution of contacts
  double bounce_vel = 0;                                                // m/s: slower contacts do not bounce
  double max_correcting_vel = std::numeric_limits<double>::infinity();  // m/s
  double surface_layer = 0;                                             // m
  Gyroscopic gyroscopic = Gyroscopic::implicit_linear;
};

class OdeStep {
 public:
  explicit OdeStep(const OdeStepSettings& settings) : settings_(settings) {}

  /// The body's number.
  int add_body(const Body& body);

  /// Joins two bodies, or one to the world, at their present pose. Anchor and axis in the world frame; the axis is
  /// unit. Returns the hinge's number. A second hinge in the place of another is allowed: CFM makes it solvable.
  int add_hinge(int body0, int body1, const Eigen::Vector3d& anchor, const Eigen::Vector3d& axis);

  Body& body(int number) { return bodies_[static_cast<std::size_t>(number)].now; }
  const Body& body(int number) const { return bodies_[static_cast<std::size_t>(number)].now; }

  /// Moves all bodies by one step of h. Allocates only when there are more contacts than ever before.
  void step(double h, std::span<const Contact> contacts = {});

  /// Force of the hinge on its body 0 in the last step, N. On body 1 it is the opposite.
  Eigen::Vector3d hinge_force(int hinge) const { return force_.segment<3>(rows_of_hinge * hinge); }

  /// Steps whose contacts could not be solved to the last bit.
  long unsolved() const { return unsolved_; }

  /// J M^-1 J^T + CFM/h of the last step.
  auto system_matrix() const { return system_.topLeftCorner(rows_, rows_); }

 private:
  static constexpr Eigen::Index rows_of_hinge = 5;
  using Row6 = Eigen::Matrix<double, 1, 6>;  // of the Jacobian of one body: linear, angular

  struct Moving {
    Body now;
    Eigen::Matrix3d inverse_inertia;        // body frame
    Eigen::Matrix3d inverse_inertia_world;  // of the pose at the start of the step
    Eigen::Vector3d force;
    Eigen::Vector3d torque;
  };

  struct Row {
    int body0;
    int body1;
    Row6 j0;
    Row6 j1;
    Row6 j0_over_mass;  // J M^-1
    Row6 j1_over_mass;
    double velocity;  // c
  };

  void gather_forces(double h);
  void add_gyroscopic_torque(Moving& body, double h) const;
  void set_hinge_rows(const Hinge& hinge, Row* rows, double erp_over_h) const;
  void set_contact_row(const Contact& contact, Row& row, double erp_over_h) const;
  void set_system(double h);
  void move(double h);

  const Moving* moving(int number) const {
    return number == world ? nullptr : &bodies_[static_cast<std::size_t>(number)];
  }
  double velocity_along(const Row& row) const;

  OdeStepSettings settings_;
  std::vector<Moving> bodies_;
  std::vector<Hinge> hinges_;
  std::vector<Row> row_;
  Eigen::Index rows_ = 0;
  Eigen::MatrixXd system_;
  Eigen::VectorXd right_, least_, greatest_, force_;
  BoxLcp lcp_;
  long unsolved_ = 0;
};

/// ODE's two unit vectors across a unit vector n.
void plane_space(const Eigen::Vector3d& n, Eigen::Vector3d& p, Eigen::Vector3d& q);

}  // namespace odeval::reference::maximal
