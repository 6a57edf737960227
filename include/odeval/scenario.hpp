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
#include "odeval/softness.hpp"

namespace odeval {

/// Which velocities ODE starts with: those of t = 0, or those of half a step before, to which its stored velocities
/// belong (claim O1).
enum class Start { as_given, half_step };

/// Along what the two forces of a contact's friction act: ODE's own choice, or the way the contact slides and across.
enum class FrictionAxes { plane_space, sliding };

/// How ODE turns a body by its spin in a step: along the tangent, its own choice, or by the whole angle.
enum class Turning { infinitesimal, finite };

/// ODE's own settings. Every one is set explicitly in each world, so no default of a build shows through.
struct OdeSettings {
  double erp = 0.2;                                                     // of joints and contacts alike: the world's
  double cfm = 1e-5;                                                    // likewise
  std::optional<Spring> spring;                                         // in the place of erp and cfm
  int iterations = 20;                                                  // of QuickStep, each over all rows
  double sor_w = 1.3;                                                   // of QuickStep: over-relaxation, 0 to 2
  std::optional<double> bounce;                                         // absent: the restitution of wall or ground
  double bounce_vel = 0;                                                // m/s: slower contacts do not bounce
  double max_correcting_vel = std::numeric_limits<double>::infinity();  // m/s, that mends an overlap
  double surface_layer = 0;                                             // m of overlap that is left alone
  FrictionAxes friction_axes = FrictionAxes::plane_space;
  Start start = Start::as_given;
  std::uint32_t seed = 0;  // of QuickStep's order of rows
  bool gyroscopic = true;  // the torque -w x (I w) of a tumbling body
  Turning rotation = Turning::infinitesimal;

  /// What ODE is given at this step.
  Softness softness(double step_s) const { return spring ? softness_of(*spring, step_s) : Softness{erp, cfm}; }
};

/// Bullet's own settings, where joints are constraints between bodies, and where things touch or stop.
struct BulletSettings {
  int iterations = 10;  // of its sequential impulses, each over all joints and contacts
  double erp = 0.2;     // 0 to 1, the part of a joint's or a contact's error that a step takes back
};

/// MuJoCo's own settings, where things touch or stop or joints close loops.
struct MujocoSettings {
  double time_constant_s = 0.02;  // within which a contact, a stop or a loop takes an error back (solref)
  bool elliptic = false;          // friction within a cone, else a pyramid
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
  std::string method;              // name
  std::string metric;              // name of a quantity
  double until_s = 0;              // its last sample
  std::optional<double> at_most;   // in the quantity's unit
  std::optional<double> at_least;  // likewise; one of the two is there
};

/// Which touches are told as impacts, and in which coordinate: the view for those.
struct ImpactView {
  std::size_t body = 0;                   // number
  Vec3 normal{};                          // unit, away from what is struck
  bool as_angle = false;                  // the coordinate is q1 of the planar view, not the height along the normal
  bool as_rate = false;                   // rates are those of the body's angle, not of its way along the normal
  std::optional<double> touches_at = {};  // m along the normal, where the body's centre stands as it begins to touch,
                                          // which gives the depth; absent: the depth is that of the deepest contact
  std::optional<int> link = {};           // told with the impact
};

/// What a file says of the mechanism, completed: a key ("links.0.mass") and its value. Summaries show it.
using SettingValue = std::variant<double, std::int64_t, std::string, std::vector<double>>;
using Definition = std::vector<std::pair<std::string, SettingValue>>;

/// A mechanism in a start, for how long, by whom and how well.
///
/// With a planar view the mechanism is what the generator made of that view: whoever changes one makes both anew
/// (model/generate.hpp), or there is no reference. Without one, bodies, joints and contacts may be changed as they are.
struct Scenario {
  std::string name;                          // stem of the file; names the result folder
  std::string file;                          // where it was read, for messages
  std::string summary;                       // what is simulated, in a line
  Mechanism mechanism;                       // what an engine is given
  std::shared_ptr<const PlanarView> planar;  // null: no joint coordinates
  bool named = false;                        // whether tables call its bodies and joints by name, and not by number
  std::vector<ImpactView> impact_views;      // one for each thing that has impacts of its own
  Definition definition;                     // what the file said of the mechanism
  double duration_s = 0;                     // simulated time
  double step_s = 1e-3;                      // of methods with a fixed step; else the spacing of rows
  std::optional<double> sample_s;            // absent: a row every step
  double gravity = 9.81;                     // m/s², along -z
  OdeSettings ode;                           // of ODE, and of whoever steps as it does
  BulletSettings bullet;                     // of Bullet's constraints
  MujocoSettings mujoco;                     // of MuJoCo's
  MaximalSettings maximal;                   // of the methods with Lagrange multipliers
  std::optional<double> rtol;                // absent: each adaptive method's own default
  std::optional<double> atol;
  std::vector<std::string> methods;   // what runs without --method
  std::vector<Tolerance> tolerances;  // what `check` enforces

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
