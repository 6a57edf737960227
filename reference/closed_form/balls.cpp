#include "reference/closed_form/balls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "odeval/error.hpp"
#include "reference/closed_form/rotation.hpp"

namespace odeval::reference {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// 1 + e + ... + e^(n - 1), each digit of it also for e close to 1.
double geometric_sum(double e, double n) {
  if (e == 1) return n;
  if (e == 0) return n > 0 ? 1 : 0;
  return std::expm1(n * std::log(e)) / (e - 1);
}

/// The height of a ball above the plane it bounces on.
class Bounces {
 public:
  Bounces(double height, double rate, double gravity, double restitution)
      : height_(height), rate_(rate), gravity_(gravity), restitution_(restitution) {
    if (gravity > 0) {
      speed_ = std::sqrt(rate * rate + 2 * gravity * height);
      first_ = rate > 0 ? (rate + speed_) / gravity : 2 * height / (speed_ - rate);  // nothing cancels
      if (speed_ == 0) first_ = 0;
    } else if (rate < 0) {
      speed_ = -rate;
      first_ = -height / rate;
    }
  }

  struct State {
    double height;
    double rate;
  };

  State at(double t) const {
    if (t < first_) return {height_ + t * (rate_ - gravity_ * t / 2), rate_ - gravity_ * t};
    if (t >= last()) return {0, 0};
    const double impact = latest(t);
    const double rate = speed_ * std::pow(restitution_, impact);
    const double since = t - time_of(impact);
    return {since * (rate - gravity_ * since / 2), rate - gravity_ * since};
  }

  /// When the impacts are over and the ball rests; infinite: never.
  double last() const {
    if (speed_ == 0 || restitution_ == 0) return first_;
    if (restitution_ == 1 || gravity_ == 0) return infinity;
    return first_ + flight() / (1 - restitution_);
  }

  /// Impact 1, 2, ...
  double time_of(double impact) const {
    return impact == 1 ? first_ : first_ + flight() * geometric_sum(restitution_, impact - 1);
  }
  double speed_before(double impact) const { return speed_ * std::pow(restitution_, impact - 1); }
  double first_speed() const { return speed_; }
  double restitution() const { return restitution_; }

 private:
  /// From the first impact to the second.
  double flight() const { return gravity_ == 0 ? infinity : 2 * speed_ * restitution_ / gravity_; }

  /// The number of the latest impact, first_ <= t < last().
  double latest(double t) const {
    if (gravity_ == 0) return 1;
    const double flights = (t - first_) / flight();  // lengths of the second flight
    double more = restitution_ == 1 ? std::floor(flights)
                                    : std::floor(std::log1p(flights * (restitution_ - 1)) / std::log(restitution_));
    while (more > 0 && time_of(more + 1) > t) --more;
    while (time_of(more + 2) <= t) ++more;
    return more + 1;
  }

  double height_;
  double rate_;
  double gravity_;
  double restitution_;
  double speed_ = 0;
  double first_ = infinity;
};

class BouncingBalls final : public BodyMotion {
 public:
  explicit BouncingBalls(const Scenario& scenario)
      : bodies_(scenario.mechanism.bodies),
        plane_(std::get<HalfSpace>(scenario.mechanism.obstacles.at(0).shape)),
        gravity_{0, 0, -scenario.gravity} {
    const double restitution = scenario.mechanism.contacts.at(0).restitution;
    for (std::size_t i = 0; i < bodies_.size(); ++i) check(scenario, i);
    for (const Body& body : bodies_) {
      bounces_.emplace_back(std::fmax(0, height_of(body)), dot(plane_.normal, body.velocity_m_s),
                            -dot(plane_.normal, gravity_), restitution);
    }
  }

  void at(double t, std::span<BodyState> states, std::span<JointState>) const override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      BodyState& state = states[i] = BodyState{};
      const Bounces::State away = bounces_[i].at(t);
      const Vec3 from = aside(body.position_m);
      const Vec3 rate = aside(body.velocity_m_s);
      const Vec3 pull = aside(gravity_);
      for (std::size_t k = 0; k < 3; ++k) {
        state.position[k] = from[k] + t * (rate[k] + pull[k] * t / 2) +
                            (plane_.offset_m + radius(body) + away.height) * plane_.normal[k];
        state.velocity[k] = rate[k] + pull[k] * t + away.rate * plane_.normal[k];
      }
      state.spin = body.spin_rad_s;
      state.rotation = product(rotation_of(t * body.spin_rad_s), rotation_of(rotation_vector(body.attitude)));
    }
  }

  // The time of an impact is a sum of positive terms, each good to some roundings; the height between impacts is off by
  // its own rounding and by that of the time at the speed of the first impact, which none of the later ones has.
  BodyUncertainty uncertainty(double t) const override {
    BodyUncertainty uncertainty;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      const double way = length(body.position_m) + t * (length(body.velocity_m_s) + length(gravity_) * t / 2) +
                         t * bounces_[i].first_speed();
      uncertainty.position_m = std::fmax(uncertainty.position_m, 16 * epsilon * way);
      uncertainty.turn_rad = std::fmax(uncertainty.turn_rad, 4 * epsilon * (1 + t * length(body.spin_rad_s)));
    }
    return uncertainty;
  }

  // The impacts of a ball that comes to rest are without end: those count that are faster than a billionth of the
  // first.
  std::vector<Impact> impacts(double until_s) const override {
    const Bounces& ball = bounces_.front();
    const double height = radius(bodies_.front());
    std::vector<Impact> impacts;
    for (double number = 1; ball.time_of(number) <= until_s; ++number) {
      const double speed = ball.speed_before(number);
      if (speed <= 1e-9 * ball.first_speed()) break;
      impacts.push_back({ball.time_of(number), height, -speed, ball.restitution() * speed, 0});
    }
    return impacts;
  }

  double at_rest_from() const override {
    const bool stays = dot(plane_.normal, gravity_) == -length(gravity_);  // nothing pulls it along
    const Body& body = bodies_.front();
    const Vec3 aside = cross(plane_.normal, body.velocity_m_s);
    const double last = bounces_.front().last();
    return stays && dot(aside, aside) == 0 && std::isfinite(last) ? last : -1;
  }

  std::string origin() const override { return "closed form: parabolas between impacts by Newton's law"; }

 private:
  static double radius(const Body& body) { return sides_m(body.shape)[0] / 2; }
  /// The part along the plane.
  Vec3 aside(const Vec3& v) const {
    const double away = dot(plane_.normal, v);
    return v - away * plane_.normal;
  }
  double height_of(const Body& body) const {
    return dot(plane_.normal, body.position_m) - plane_.offset_m - radius(body);
  }

  void check(const Scenario& scenario, std::size_t i) const {
    const Body& body = bodies_[i];
    const auto fail = [&](const char* key, const std::string& rule) {
      throw UserError(fmt::format("{}: bodies.{}.{} {}", scenario.file, i, key, rule));
    };
    if (!is_sphere(body.shape)) fail("shape", "must be sphere, or the motion has no closed form");
    if (height_of(body) < -4 * epsilon * (radius(body) + length(body.position_m))) {
      fail("position",
           fmt::format("must be at least {:.10g} m above the ground, or the ball starts inside it", radius(body)));
    }
    for (std::size_t other = 0; other < i; ++other) {
      if (may_meet(body, bodies_[other], scenario.duration_s)) {
        fail("position", fmt::format("lets the ball meet that of bodies.{}; no closed form is known for that", other));
      }
    }
  }

  // Seen along the normal, two balls move past each other on a straight line, whatever they bounce.
  bool may_meet(const Body& a, const Body& b, double duration_s) const {
    const Vec3 between = aside(a.position_m - b.position_m);
    const Vec3 rate = aside(a.velocity_m_s - b.velocity_m_s);
    const double speed = dot(rate, rate);
    const double nearest = speed == 0 ? 0 : std::clamp(-dot(between, rate) / speed, 0.0, duration_s);
    return length(between + nearest * rate) <= radius(a) + radius(b);
  }

  std::vector<Body> bodies_;
  HalfSpace plane_;
  Vec3 gravity_;
  std::vector<Bounces> bounces_;
};

}  // namespace

std::unique_ptr<BodyMotion> make_bouncing_balls(const Scenario& scenario) {
  return std::make_unique<BouncingBalls>(scenario);
}

}  // namespace odeval::reference
