#include "reference/closed_form/free_bodies.hpp"

#include <cmath>
#include <limits>

#include "reference/closed_form/free_body.hpp"

namespace odeval::reference {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double rounding = 4 * epsilon;

/// Angle between two attitudes that are close: |R - R'|_F = sqrt(8) sin(angle / 2).
double angle_between(const Rotation& a, const Rotation& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return 2 * std::asin(std::fmin(std::sqrt(sum / 8), 1.0));
}

/// One body's rotation, and the same with each moment and each component of its spin a little off: by how much the
/// motion itself makes of the rounding of what it starts from.
class Rotating {
 public:
  explicit Rotating(const Body& body) : motion_(body.uniform_moments_kgm2(), attitude(body), body.spin_rad_s) {
    if (motion_.steady()) return;
    const Vec3 own_moments = body.uniform_moments_kgm2();
    for (std::size_t i = 0; i < 3; ++i) {
      Vec3 moments = own_moments;
      for (double& moment : moments) {  // those that are equal are so by symmetry, and stay equal
        if (moment == own_moments[i]) moment *= 1 + nudge;
      }
      beside_.emplace_back(moments, attitude(body), body.spin_rad_s);
      Vec3 own = turned_back(attitude(body), body.spin_rad_s);
      own[i] += nudge * length(own);
      beside_.emplace_back(own_moments, attitude(body), turned(attitude(body), own));
    }
  }

  FreeBody::Turning at(double t) const { return motion_.at(t); }

  struct Uncertainty {
    double turn_rad;
    double spin_rad_s;
  };
  Uncertainty uncertainty(double t) const {
    const FreeBody::Turning here = motion_.at(t);
    const double spin = length(here.spin_rad_s);
    Uncertainty uncertainty{rounding * (1 + t * spin), rounding * spin};
    for (const FreeBody& other : beside_) {
      const FreeBody::Turning there = other.at(t);
      uncertainty.turn_rad += rounding / nudge * angle_between(here.attitude, there.attitude);
      uncertainty.spin_rad_s += rounding / nudge * distance(there.spin_rad_s, here.spin_rad_s);
    }
    return uncertainty;
  }

 private:
  static Rotation attitude(const Body& body) { return rotation_of(rotation_vector(body.attitude)); }
  static constexpr double nudge = 256 * epsilon;  // so that the rounding of the two motions does not show

  FreeBody motion_;
  std::vector<FreeBody> beside_;
};

class FreeBodies final : public BodyMotion {
 public:
  explicit FreeBodies(const Scenario& scenario) : bodies_(scenario.mechanism.bodies), gravity_(scenario.gravity) {
    for (const Body& body : bodies_) rotating_.emplace_back(body);
  }

  void at(double t, std::span<BodyState> states, std::span<JointState>) const override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      const FreeBody::Turning turning = rotating_[i].at(t);
      BodyState& state = states[i] = BodyState{};
      for (std::size_t k = 0; k < 3; ++k) {
        const double fall = k == 2 ? gravity_ : 0;
        state.position[k] = body.position_m[k] + t * (body.velocity_m_s[k] - fall * t / 2);
        state.velocity[k] = body.velocity_m_s[k] - fall * t;
      }
      state.spin = turning.spin_rad_s;
      state.rotation = turning.attitude;
    }
  }

  BodyUncertainty uncertainty(double t) const override {
    BodyUncertainty uncertainty;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      for (std::size_t k = 0; k < 3; ++k) {
        const double way = std::fabs(body.position_m[k]) + t * (std::fabs(body.velocity_m_s[k]) + gravity_ * t / 2);
        uncertainty.position_m = std::fmax(uncertainty.position_m, rounding * way);
      }
      const Rotating::Uncertainty of_turning = rotating_[i].uncertainty(t);
      uncertainty.turn_rad = std::fmax(uncertainty.turn_rad, of_turning.turn_rad);
      uncertainty.spin_rad_s = std::fmax(uncertainty.spin_rad_s, of_turning.spin_rad_s);
    }
    return uncertainty;
  }

  std::string origin() const override {
    return "closed form: a parabola, and Euler's equations in Jacobi elliptic functions; uncertainty from rounding of "
           "the start and the moments, as the motion makes it grow";
  }

 private:
  std::vector<Body> bodies_;
  std::vector<Rotating> rotating_;
  double gravity_;
};

}  // namespace

std::unique_ptr<BodyMotion> make_free_bodies(const Scenario& scenario) {
  return std::make_unique<FreeBodies>(scenario);
}

}  // namespace odeval::reference
