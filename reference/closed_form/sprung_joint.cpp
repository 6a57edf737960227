#include "reference/closed_form/sprung_joint.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "odeval/error.hpp"
#include "reference/closed_form/damped_oscillator.hpp"
#include "reference/closed_form/rotation.hpp"

namespace odeval::reference {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Whether ODE's law for a joint that is pulled open is known: a spring between two points, however they are turned.
struct HoldsAPoint {
  bool operator()(const BallJoint&) const { return true; }
  bool operator()(const HingeJoint&) const { return true; }
  bool operator()(const SliderJoint&) const { return false; }
  bool operator()(const UniversalJoint&) const { return false; }
  bool operator()(const FixedJoint&) const { return false; }
  bool operator()(const PistonJoint&) const { return false; }
  bool operator()(const SlidingHingeJoint&) const { return false; }
  bool operator()(const SlidingUniversalJoint&) const { return false; }
  bool operator()(const Hinge2Joint&) const { return false; }
  bool operator()(const PlaneJoint&) const { return false; }
};

/// What in a start gives it another motion.
struct Fault {
  std::size_t body;
  const char* key;
  const char* rule;
};

std::optional<Fault> fault_of(const Scenario& scenario) {
  const std::vector<Body>& bodies = scenario.mechanism.bodies;
  const Joint& joint = scenario.mechanism.joints.at(0);
  const bool pair = bodies.size() == 2;
  const Vec3 speed = bodies[0].velocity_m_s - (pair ? bodies[1].velocity_m_s : Vec3{});
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    if (dot(body.spin_rad_s, body.spin_rad_s) != 0) return Fault{i, "spin", "must be 0"};
    const Vec3 anchor = anchor_m(joint.kind) + (i == 0 ? joint.opening_m : Vec3{});
    const Vec3 arm = anchor - body.position_m;
    const double rounding = 8 * epsilon * (length(anchor) + length(body.position_m));
    const auto along = [&](const Vec3& pull) {
      const Vec3 torque = cross(arm, pull);
      return length(torque) <= rounding * length(pull);
    };
    if (!along(joint.opening_m))
      return Fault{i, "position", "must be the joint's anchor or lie along its displacement"};
    if (!along(speed)) return Fault{i, "velocity", "must lie along the line from the body to the joint"};
    if (!along({0, 0, pair ? 0 : scenario.gravity})) {
      return Fault{i, "position", "must be the joint's anchor, above or below it"};
    }
  }
  return std::nullopt;
}

/// What is the same for every law: which body moves how much, and what they do together.
class JointMotion : public BodyMotion {
 public:
  explicit JointMotion(const Scenario& scenario)
      : bodies_(scenario.mechanism.bodies), joint_(scenario.mechanism.joints.at(0)), gravity_(scenario.gravity) {
    if (const auto fault = fault_of(scenario)) {
      throw UserError(fmt::format("{}: bodies.{}.{} {}, or the motion has no closed form", scenario.name, fault->body,
                                  fault->key, fault->rule));
    }
  }

  void at(double t, std::span<BodyState> states, std::span<JointState> joints) const final {
    const bool pair = bodies_.size() == 2;
    const double shares[] = {pair ? bodies_[1].mass_kg / total() : 1, pair ? -bodies_[0].mass_kg / total() : 0};
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      BodyState& state = states[i] = BodyState{};
      state.rotation = rotation_of(rotation_vector(bodies_[i].attitude));
      for (std::size_t k = 0; k < 3; ++k) {
        const Deflection start = starts(k);
        const Deflection now = deflection(t, k);
        const Deflection centre = centre_of_mass(t, k);
        state.position[k] = bodies_[i].position_m[k] + shares[i] * (now.x - start.x) + centre.x;
        state.velocity[k] = shares[i] * now.v + centre.v;
      }
    }
    // `force` is that on the first body; the joint tells that on the one it carries.
    for (std::size_t k = 0; k < 3; ++k) joints[0].force[k] = (pair ? -1 : 1) * force(t, k);
  }

  BodyUncertainty uncertainty(double t) const final {
    BodyUncertainty uncertainty{0, 4 * epsilon};
    double squares = 0;
    for (std::size_t k = 0; k < 3; ++k) squares += std::pow(deflection_uncertainty(t, k), 2);
    for (const Body& body : bodies_) {
      double way = std::fabs(t) * length(body.velocity_m_s) + gravity_ * t * t / 2;
      for (std::size_t k = 0; k < 3; ++k) way += std::fabs(body.position_m[k]) + std::fabs(joint_.opening_m[k]);
      uncertainty.position_m = std::fmax(uncertainty.position_m, std::sqrt(squares) + 4 * epsilon * way);
    }
    return uncertainty;
  }

 protected:
  /// Of one body its mass, of two their reduced mass.
  double mass() const {
    return bodies_.size() == 2 ? bodies_[0].mass_kg * bodies_[1].mass_kg / total() : bodies_[0].mass_kg;
  }
  /// What pulls the joint open: of two bodies gravity pulls both alike.
  double pull(std::size_t axis) const { return bodies_.size() == 1 && axis == 2 ? gravity_ : 0; }
  double gravity() const { return gravity_; }
  Deflection starts(std::size_t axis) const {
    const double other = bodies_.size() == 2 ? bodies_[1].velocity_m_s[axis] : 0;
    return {joint_.opening_m[axis], bodies_[0].velocity_m_s[axis] - other};
  }

  virtual Deflection deflection(double t, std::size_t axis) const = 0;
  virtual double deflection_uncertainty(double t, std::size_t axis) const = 0;
  virtual double force(double t, std::size_t axis) const = 0;
  /// How far a free body has fallen, and how fast it falls.
  virtual Deflection fall(double t) const { return {-gravity_ * t * t / 2, -gravity_ * t}; }

 private:
  double total() const { return bodies_[0].mass_kg + bodies_[1].mass_kg; }

  /// Of two bodies: the way and the velocity of what they have in common. Of one: none.
  Deflection centre_of_mass(double t, std::size_t axis) const {
    if (bodies_.size() == 1) return {};
    const double v =
        (bodies_[0].mass_kg * bodies_[0].velocity_m_s[axis] + bodies_[1].mass_kg * bodies_[1].velocity_m_s[axis]) /
        total();
    const Deflection fallen = axis == 2 ? fall(t) : Deflection{};
    return {v * t + fallen.x, v + fallen.v};
  }

  std::vector<Body> bodies_;
  Joint joint_;
  double gravity_;
};

class SpringJoint final : public JointMotion {
 public:
  SpringJoint(const Scenario& scenario, const Spring& spring) : JointMotion(scenario), spring_(spring) {}

  std::string origin() const override {
    return fmt::format("closed form: damped oscillator, kp {:.6g} N/m, kd {:.6g} N s/m", spring_.kp_N_m,
                       spring_.kd_Ns_m);
  }

 private:
  DampedOscillator along(std::size_t axis) const { return {mass(), spring_.kp_N_m, spring_.kd_Ns_m, pull(axis)}; }

  Deflection deflection(double t, std::size_t axis) const override { return along(axis).at(t, starts(axis)); }
  double deflection_uncertainty(double t, std::size_t axis) const override {
    return along(axis).uncertainty(t, starts(axis));
  }
  double force(double t, std::size_t axis) const override { return along(axis).force(deflection(t, axis)); }

  Spring spring_;
};

/// x = (1 - ERP)^n x(0), v the difference from the step before over h.
class RigidJoint final : public JointMotion {
 public:
  explicit RigidJoint(const Scenario& scenario)
      : JointMotion(scenario), erp_(scenario.ode.softness(scenario.step_s).erp), step_s_(scenario.step_s) {}

  std::string origin() const override {
    return fmt::format("law of a rigid joint: a gap shrinks by {:.6g} a step", erp_);
  }

 private:
  double steps(double t) const { return std::round(t / step_s_); }

  Deflection deflection(double t, std::size_t axis) const override {
    const Deflection start = starts(axis);
    const double n = steps(t);
    if (n <= 0) return start;
    return {start.x * std::pow(1 - erp_, n), -erp_ / step_s_ * start.x * std::pow(1 - erp_, n - 1)};
  }
  double deflection_uncertainty(double t, std::size_t axis) const override {
    return 4 * epsilon * (1 + std::fabs(steps(t))) * std::fabs(deflection(t, axis).x);
  }
  double force(double t, std::size_t axis) const override {
    const double n = std::fmax(1, steps(t));  // before the first step there is none: its own
    const double gained = deflection(n * step_s_, axis).v - deflection((n - 1) * step_s_, axis).v;
    return mass() * (gained / step_s_ + pull(axis));
  }
  // Semi-implicit Euler: n (n + 1) / 2 times g h^2.
  Deflection fall(double t) const override {
    const double now = steps(t) * step_s_;
    return {-gravity() * now * (now + step_s_) / 2, -gravity() * now};
  }

  double erp_;
  double step_s_;
};

}  // namespace

bool has_sprung_motion(const Scenario& scenario) {
  const Joint& joint = scenario.mechanism.joints.at(0);
  return std::visit(HoldsAPoint{}, joint.kind) && (joint.opening_m != Vec3{} || !fault_of(scenario));
}

std::unique_ptr<BodyMotion> make_sprung_joint(const Scenario& scenario) {
  const OdeSettings& ode = scenario.ode;
  const Softness softness = ode.softness(scenario.step_s);
  if (softness.cfm == 0) return std::make_unique<RigidJoint>(scenario);
  return std::make_unique<SpringJoint>(scenario, ode.spring.value_or(spring_of(softness, scenario.step_s)));
}

}  // namespace odeval::reference
