#pragma once
// What is simulated and with which settings: a mechanism, its start, how long. Files are read by src/model.
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "odeval/mechanism.hpp"
#include "odeval/planar_view.hpp"

namespace odeval {

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

/// Which touches are told as impacts, and in which coordinate: the view for those.
struct ImpactView {
  std::size_t body = 0;
  Vec3 normal{};                     // unit, away from what is struck
  bool as_angle = false;             // the coordinate is q1 of the planar view, not the height along the normal
  bool as_rate = false;              // rates are those of the body's angle, not of its way along the normal
  std::optional<double> touches_at = {};  // m along the normal, where the body's centre stands as it begins to touch, which
                                     // gives the depth; absent: the depth is that of the deepest contact
  std::optional<int> link = {};      // told with the impact
};

/// What a file says of the mechanism, completed: a key ("links.0.mass") and its value. Summaries show it.
using SettingValue = std::variant<double, std::int64_t, std::string, std::vector<double>>;
using Definition = std::vector<std::pair<std::string, SettingValue>>;

struct Scenario {
  std::string name;     // stem of the file; names the result folder
  std::string file;     // where it was read, for messages
  std::string summary;  // what is simulated, in a line
  Mechanism mechanism;
  std::shared_ptr<const PlanarView> planar;  // null: no joint coordinates
  std::vector<ImpactView> impact_views;      // one for each thing that has impacts of its own
  Definition definition;
  double duration_s = 0;
  double step_s = 1e-3;
  std::optional<double> sample_s;  // absent: a row every step
  double gravity = 9.81;           // m/s², along -z
  OdeSettings ode;
  MaximalSettings maximal;
  std::optional<double> rtol;  // absent: each adaptive method's own default
  std::optional<double> atol;
  std::vector<std::string> methods;
  std::vector<Tolerance> tolerances;

  /// Of whatever touches first; 0 where nothing does.
  double restitution() const { return mechanism.contacts.empty() ? 0 : mechanism.contacts.front().restitution; }
  /// Where a camera stands, and what is up.
  const PlanarFrame& frame() const { return planar ? planar->frame : space_frame; }
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
