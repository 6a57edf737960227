#pragma once
// What is simulated and with which settings: one TOML file, checked, with the command line on top.
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "odeval/problem.hpp"

namespace odeval {

enum class Shape { box, sphere };

/// A link of mass between its hinge and the next one, `length` away.
///
/// box   uniform; `width` lies in the plane of swing, `depth` along the hinge
/// ball  a uniform sphere of diameter `width` about the next hinge, on a massless rod; `depth` is its `width`
struct Link {
  double mass_kg = 0;
  double length_m = 0;
  double width_m = 0;
  double depth_m = 0;
  Shape shape = Shape::box;

  /// Distance of the centre of mass from the near hinge, m.
  double centre_m() const { return shape == Shape::box ? length_m / 2 : length_m; }
  /// Of the far hinge from the centre of mass, m.
  double beyond_centre_m() const { return length_m - centre_m(); }

  // Moments of inertia about the centre, kg m².
  /// For rotation in the plane (report, D.1).
  double inertia_kgm2() const { return moment_kgm2(length_m, width_m); }
  /// About the link's own direction.
  double inertia_along_kgm2() const { return moment_kgm2(width_m, depth_m); }
  /// About the direction across it in the plane.
  double inertia_across_kgm2() const { return moment_kgm2(length_m, depth_m); }

 private:
  /// a and b: the sides of a box across the axis.
  double moment_kgm2(double a, double b) const {
    return shape == Shape::box ? mass_kg * (a * a + b * b) / 12.0 : mass_kg * width_m * width_m / 10.0;
  }
};

/// A uniform rigid body. World frame; its own axes are the world's, turned by `turn`.
struct Body {
  Shape shape = Shape::box;
  double mass_kg = 0;
  Vec3 size_m{};        // sides along its own axes; of a sphere the diameter, three times
  Vec3 position_m{};    // of its centre
  Vec3 turn_rad{};      // rotation vector
  Vec3 velocity_m_s{};  // of its centre
  Vec3 spin_rad_s{};
  double aspect = 1;  // already in size_m: by how much the sides x and y were divided

  /// Moments of inertia about its own axes through the centre, kg m².
  Vec3 inertia_kgm2() const {
    const auto [x, y, z] = size_m;
    if (shape == Shape::sphere) return {mass_kg * x * x / 10, mass_kg * y * y / 10, mass_kg * z * z / 10};
    return {mass_kg * (y * y + z * z) / 12, mass_kg * (z * z + x * x) / 12, mass_kg * (x * x + y * y) / 12};
  }

  /// Number of its own axis along the longest side; of equally long ones the last.
  std::size_t long_axis() const {
    const auto [x, y, z] = size_m;
    return z >= x && z >= y ? 2 : y >= x ? 1 : 0;
  }
};

/// What bounds the force of friction on a body.
enum class FrictionModel {
  pyramid,   // a coefficient times the normal force (ODE's dContactApprox1)
  constant,  // a force, whatever the normal force is
};

/// A plane through the origin that falls towards +x, and that nothing passes.
struct Ground {
  double slope_rad = 0;
  double restitution = 0;
  double friction = 0;  // a coefficient; in the constant-force model newtons, of a whole body
  FrictionModel friction_model = FrictionModel::pyramid;

  /// Unit, away from what is solid.
  Vec3 normal() const { return {std::sin(slope_rad), 0, std::cos(slope_rad)}; }
  Vec3 downhill() const { return {std::cos(slope_rad), 0, -std::sin(slope_rad)}; }
};

/// A flat wall that fills x <= face (world frame).
struct Wall {
  double face_m = 0;
  double restitution = 1;
};

/// What holds the first body: to the world where it is alone, to the second body where there are two.
struct Joint {
  enum class Kind { ball, hinge };
  Kind kind = Kind::ball;
  Vec3 anchor_m{};        // where its halves meet when it is closed, world frame
  Vec3 axis{0, 1, 0};     // of a hinge, unit
  Vec3 displacement_m{};  // from there to the first body's half at t = 0
};

enum class Start { as_given, half_step };

/// Along what the two forces of a contact's friction act: ODE's own choice, or the way the contact slides and across.
enum class FrictionAxes { plane_space, sliding };
/// How ODE holds a joint together: the part of an error that a step takes back, and how far a force opens it.
struct Softness {
  double erp = 0;
  double cfm = 0;
};

/// The same as a spring and a damper.
struct Spring {
  double kp_N_m = 0;
  double kd_Ns_m = 0;
};

/// Report, eqs. 3.6 and 3.7. The same spring is another softness at another step.
constexpr Softness softness_of(const Spring& spring, double step_s) {
  const double stiffness = step_s * spring.kp_N_m + spring.kd_Ns_m;
  return {step_s * spring.kp_N_m / stiffness, 1 / stiffness};
}

/// The other way round. Without CFM a joint is stiffer than any spring: infinite or not a number.
constexpr Spring spring_of(const Softness& softness, double step_s) {
  return {softness.erp / (step_s * softness.cfm), (1 - softness.erp) / softness.cfm};
}

/// ODE's own settings. Every one is set explicitly in each world, so no default of a build shows through.
struct OdeSettings {
  double erp = 0.2;
  double cfm = 1e-5;
  std::optional<Spring> spring;  // in the place of erp and cfm
  int iterations = 20;
  double sor_w = 1.3;
  std::optional<double> bounce;  // absent: the restitution of wall or ground
  double bounce_vel = 0;
  double max_correcting_vel = std::numeric_limits<double>::infinity();
  double surface_layer = 0;
  FrictionAxes friction_axes = FrictionAxes::plane_space;
  Start start = Start::as_given;
  std::uint32_t seed = 0;
  bool gyroscopic = true;  // the torque -w x (I w) of a tumbling body

  /// What ODE is given at this step.
  Softness softness(double step_s) const { return spring ? softness_of(*spring, step_s) : Softness{erp, cfm}; }
};

/// Feedback of joint errors in the methods with Lagrange multipliers: C'' = -ks C - kd C' (report, 5.36).
///
/// By default an error dies away as fast as it can without overshoot (kd^2 = 4 ks), with a time constant of 2/kd = 50
/// ms: short beside a swing of the report's links, and long beside a step of 1 ms, so that explicit Euler, which is
/// stable up to h = 4/kd, has room and the feedback costs Runge-Kutta little of its accuracy.
struct MaximalSettings {
  double ks = 400;  // 1/s²
  double kd = 40;   // 1/s
};

/// A promise about one metric of one method, enforced by `odeval check`.
struct Tolerance {
  std::string method;
  std::string metric;
  double until_s = 0;
  std::optional<double> at_most;
  std::optional<double> at_least;
};

struct Scenario {
  std::string name;  // stem of the file; names the result folder
  std::string file;  // where it was read, for messages
  const Problem* problem = nullptr;
  double duration_s = 0;
  double step_s = 1e-3;
  std::optional<double> sample_s;  // absent: a row every step
  double gravity = 9.81;           // m/s², along -z
  std::optional<int> n;            // links of a chain; absent: as many as are listed
  std::vector<double> q0;          // rad; q1 from the horizontal, the others relative to the link before
  std::vector<double> qd0;         // rad/s
  std::vector<Link> links;
  std::optional<Wall> wall;
  std::vector<Body> bodies;
  std::optional<Ground> ground;
  std::optional<Joint> joint;
  OdeSettings ode;
  MaximalSettings maximal;
  std::optional<double> rtol;  // absent: each adaptive method's own default
  std::optional<double> atol;
  std::vector<std::string> methods;
  std::vector<Tolerance> tolerances;

  Family family() const { return problem->family; }
  /// Of whatever the bodies strike; 0 where there is nothing.
  double restitution() const { return wall ? wall->restitution : ground ? ground->restitution : 0; }
};

/// The rows of a trace: row k stands at time(k) = k * stride * step, computed by multiplication.
/// The last row is the first at or after the duration, up to rounding.
struct SampleGrid {
  double step_s = 0;
  long stride = 1;  // steps between rows
  long rows = 1;    // including t = 0

  long steps() const { return (rows - 1) * stride; }
  double time(long row) const { return static_cast<double>(row * stride) * step_s; }
};

/// Throws UserError when the spacing of rows is no whole number of steps.
SampleGrid sample_grid(const Scenario& scenario);

}  // namespace odeval
