#include "reference/bodies/free_bodies.hpp"

#include <cmath>
#include <limits>

#include "odeval/error.hpp"
#include "reference/bodies/rotation.hpp"

namespace odeval::reference {
namespace {

constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();

/// Whether the spin lies along a principal axis, so that it stays.
bool spins_steadily(const Body& body) {
  const Vec3 moments = body.inertia_kgm2();
  const Vec3 spin = turned_back(rotation_of(body.turn_rad), body.spin_rad_s);
  const Vec3 torque = cross(spin, {moments[0] * spin[0], moments[1] * spin[1], moments[2] * spin[2]});
  return dot(torque, torque) == 0;
}

class FreeBodies final : public BodyMotion {
 public:
  explicit FreeBodies(const Scenario& scenario) : bodies_(scenario.bodies), gravity_(scenario.gravity) {
    for (const Body& body : bodies_) {
      if (!spins_steadily(body)) throw UserError(scenario.name + ": bodies: spin must lie along a principal axis");
    }
  }

  void at(double t, std::span<BodyState> states) const override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      BodyState& state = states[i] = BodyState{};
      for (std::size_t k = 0; k < 3; ++k) {
        const double fall = k == 2 ? gravity_ : 0;
        state.position[k] = body.position_m[k] + t * (body.velocity_m_s[k] - fall * t / 2);
        state.velocity[k] = body.velocity_m_s[k] - fall * t;
        state.spin[k] = body.spin_rad_s[k];
      }
      const Vec3 turn{body.spin_rad_s[0] * t, body.spin_rad_s[1] * t, body.spin_rad_s[2] * t};
      put(product(rotation_of(turn), rotation_of(body.turn_rad)), state.rotation);
    }
  }

  BodyDoubt doubt(double t) const override {
    BodyDoubt doubt;
    for (const Body& body : bodies_) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double way = std::fabs(body.position_m[k]) + t * (std::fabs(body.velocity_m_s[k]) + gravity_ * t / 2);
        doubt.position_m = std::fmax(doubt.position_m, rounding * way);
      }
      doubt.turn_rad = std::fmax(doubt.turn_rad, rounding * (1 + t * std::sqrt(dot(body.spin_rad_s, body.spin_rad_s))));
    }
    return doubt;
  }

  std::string described() const override { return "closed form: parabola, and spin about a principal axis"; }

 private:
  std::vector<Body> bodies_;
  double gravity_;
};

}  // namespace

std::unique_ptr<BodyMotion> make_free_bodies(const Scenario& scenario) {
  return std::make_unique<FreeBodies>(scenario);
}

}  // namespace odeval::reference
