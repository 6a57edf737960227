#pragma once
// The one door through which every way of moving a scenario is used, and what each way can do.
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "odeval/motion.hpp"
#include "odeval/scenario.hpp"
#include "odeval/told.hpp"

namespace odeval {

/// A scenario loaded into an engine, at t = 0 and ready to move. Set-up is the constructor's work.
class Simulation {
 public:
  virtual ~Simulation() = default;

  /// What a sample of its motion holds.
  virtual SampleShape shape() const = 0;

  /// Moves from t = 0 to the end of the grid, once. A recorder that records gets a sample a row (t = 0 included);
  /// without one, it does nothing but step, which is what `bench` times.
  /// A run that blows up ends early with the samples so far and `diverged` set. Throws MachineError when the machine
  /// fails (no memory for a step), never for what the motion does.
  virtual Outcome run(Recorder recorder) = 0;

  /// What the engine was told that no setting of the scenario says, for summaries.
  virtual Told told() const { return {}; }
};

/// Throws UserError when the scenario asks for what the engine cannot do, MachineError when the engine refuses it.
using MakeSimulation = std::unique_ptr<Simulation> (*)(const Scenario&, const SampleGrid&);

/// What a scenario may ask of an engine beyond one link that swings freely.
enum class Feature : std::uint8_t {
  space,              // bodies that are no links in a plane
  several_links,      // two or more
  many_links,         // three or more
  wall,               // links that strike something
  wall_of_several,    // more than one of them
  ground,             // contacts of bodies in space
  friction,           // of any contact, by a coefficient
  constant_friction,  // by a force, whatever the normal force is
  joints_in_space,    // joints of bodies that are no links in a plane
  open_joints,        // joints that start open
  motors,
  stops,
  bouncing_stops,   // that give a part of the speed back
  loads,            // springs, torques and controllers of joints
  inertia,          // a tensor of its own, not that of a uniform solid
  loops,            // joints that close some
  rare_joints,      // ODE's kinds that other engines do not have
  struts,           // springs between points of bodies
  rare_shapes,      // contacts of shapes that other engines are not given
  axis_drives,      // motors, stops and loads of joints with several motions
  cross_stops,      // stops of turns of kinds that cross two axes, universal and pu
  plane_motors,     // of plane2d
  soft_contacts,    // with an ERP and a CFM of their own
  sprung_contacts,  // with a spring and a damper of their own
};

/// The features in words ("friction"), in the order of the enumeration.
std::span<const std::string_view> feature_names();

/// A set of features: a bit each.
class Features {
 public:
  /// None.
  constexpr Features() = default;
  constexpr Features(std::initializer_list<Feature> features) {
    for (const Feature feature : features) bits_ |= bit(feature);
  }
  /// Whether it is in the set.
  constexpr bool has(Feature feature) const { return (bits_ & bit(feature)) != 0; }
  /// Whether nothing is.
  constexpr bool empty() const { return bits_ == 0; }
  /// Puts it into the set.
  constexpr void add(Feature feature) { bits_ |= bit(feature); }
  /// Those of a that b lacks.
  friend constexpr Features operator-(Features a, Features b) {
    a.bits_ &= ~b.bits_;
    return a;
  }
  /// Those of a and those of b.
  friend constexpr Features operator|(Features a, Features b) {
    a.bits_ |= b.bits_;
    return a;
  }

 private:
  /// A place for each feature: fewer than 32 of them.
  static constexpr std::uint32_t bit(Feature feature) { return 1U << static_cast<unsigned>(feature); }
  std::uint32_t bits_ = 0;
};

/// What a scenario asks of whoever moves it: read off its mechanism and its views, not off its name.
Features features_of(const Scenario& scenario);

/// "friction, stops": in the order of the enumeration. Empty of an empty set.
std::string listed(Features features);

/// A key that an engine reads, and where it makes a difference.
struct EngineSetting {
  std::string_view key;              // "ode.erp"
  bool (*matters)(const Scenario&);  // whether the engine finds in the scenario what the setting acts on
  std::string_view acts_on;          // that, in words: "joints or contacts"
};

/// The matrix that a formulation inverts or factors.
enum class SystemMatrix {
  none,            // none, or not known
  mass_matrix,     // M(q), n x n, in the report's relative coordinates (D.2)
  hinge_rows,      // J M^-1 J^T of all five rows a hinge, 5n x 5n
  hinge_rows_cfm,  // the same + CFM / h on the diagonal: ODE
  planar_joints,   // J M^-1 J^T of joints in the plane, 2n x 2n, no CFM
};

/// One way of moving a scenario: a row of a table, and nothing else says what it is.
struct Engine {
  std::string_view name;                         // as --method says it
  std::string_view formulation;                  // in words, for tables
  std::string_view advanced_by;                  // likewise: what takes a step
  int order = 0;                                 // of convergence in the step; 0: no fixed step
  double rtol = 0;                               // its own tolerances, which --rtol and --atol replace; 0: it has none
  double atol = 0;                               // likewise, rad and rad/s
  Features can;                                  // of what a scenario may ask
  MakeSimulation make = nullptr;                 // null: left out of this build
  std::span<const EngineSetting> settings = {};  // what it reads and the motion does not
  SystemMatrix inverts = SystemMatrix::none;     // in each pose, for the columns of conditioning
  std::string_view why_missing = {};             // why `make` is null, and what would bring it
  bool tells = false;                            // whether its simulations have more to tell than settings
};

}  // namespace odeval
