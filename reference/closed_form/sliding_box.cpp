#include "reference/closed_form/sliding_box.hpp"

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

struct Slide {
  double downhill = 0;  // m
  double across = 0;
  double downhill_rate = 0;  // m/s
  double across_rate = 0;
};

/// (1 - e^-ps) / p, which is s for p = 0. s may be infinite when p > 0.
double decayed(double p, double s) { return p == 0 ? s : -std::expm1(-p * s) / p; }

/// Coulomb friction `hold` against `pull`, both per mass.
class Coulomb {
 public:
  Coulomb(double downhill, double across, double pull, double hold)
      : pull_(pull), hold_(hold), across_(across), downhill_(downhill), speed_(std::hypot(downhill, across)) {
    // Of v + u and v - u one may cancel: their product is across^2.
    const double large = speed_ + std::fabs(downhill);
    const double small = large == 0 ? 0 : across * across / large;
    towards_ = downhill >= 0 ? large : small;
    against_ = downhill >= 0 ? small : large;
    if (pull > 0) ratio_ = hold / pull;
    if (speed_ == 0) {
      stops_ = 0;
    } else if (pull == 0) {
      stops_ = hold > 0 ? speed_ / hold : infinity;
    } else if (towards_ == 0 || ratio_ > 1) {
      stops_ = time(infinity);
    }
  }

  /// First standstill; infinite: never.
  double stops() const { return stops_; }
  /// From when on it stays; infinite: never.
  double rests() const { return hold_ >= pull_ ? stops_ : infinity; }

  Slide at(double t) const {
    if (t < stops_) return pull_ == 0 ? on_the_level(t) : on_the_slope(parameter(t));
    Slide slide = stops_ == 0 ? Slide{} : (pull_ == 0 ? on_the_level(stops_) : on_the_slope(infinity));
    slide.downhill_rate = slide.across_rate = 0;
    if (hold_ < pull_) {
      const double since = t - stops_;
      slide.downhill += (pull_ - hold_) * since * since / 2;
      slide.downhill_rate = (pull_ - hold_) * since;
    }
    return slide;
  }

 private:
  Slide on_the_level(double t) const {
    if (hold_ == 0) return {downhill_ * t, across_ * t, downhill_, across_};
    const double left = 1 - hold_ * t / speed_;
    const double way = t * (1 + left) / 2;
    return {downhill_ * way, across_ * way, downhill_ * left, across_ * left};
  }

  Slide on_the_slope(double s) const {
    const double k = ratio_;
    const auto part = [s](double size, double p) { return size == 0 ? 0 : size * decayed(p, s); };
    const auto faded = [s](double size, double p) { return size == 0 ? 0 : size * std::exp(-p * s); };
    Slide slide;
    slide.downhill = (part(towards_ * towards_, 2 * k - 2) - part(against_ * against_, 2 * k + 2)) / (4 * pull_);
    slide.across = across_ * (part(towards_, 2 * k - 1) + part(against_, 2 * k + 1)) / (2 * pull_);
    slide.downhill_rate = (faded(towards_, k - 1) - faded(against_, k + 1)) / 2;
    slide.across_rate = faded(across_, k);
    return slide;
  }

  double time(double s) const {
    const double first = towards_ == 0 ? 0 : towards_ * decayed(ratio_ - 1, s);
    return (first + against_ * decayed(ratio_ + 1, s)) / (2 * pull_);
  }

  /// The s of a time t < stops(): Newton's method, kept between bounds.
  double parameter(double t) const {
    if (t < 0) return before(t);
    double low = 0;
    double high = 1;
    while (time(high) < t && high < 1e300) high *= 2;
    double s = 0;
    for (int i = 0; i < 200 && low < high; ++i) {
      const double late = time(s) - t;
      (late > 0 ? high : low) = s;
      if (late == 0) break;
      const double rate =  // of the time with s
          (towards_ * std::exp(-(ratio_ - 1) * s) + against_ * std::exp(-(ratio_ + 1) * s)) / (2 * pull_);
      double next = s - late / rate;
      if (!(next > low && next < high)) next = (low + high) / 2;
      if (std::fabs(next - s) <= epsilon * s) break;
      s = next;
    }
    return s;
  }

  // Of the half-step start: the motion that led to the one given; near enough for Newton's method alone.
  double before(double t) const {
    double s = 0;
    for (int i = 0; i < 20; ++i) {
      const double rate =
          (towards_ * std::exp(-(ratio_ - 1) * s) + against_ * std::exp(-(ratio_ + 1) * s)) / (2 * pull_);
      s -= (time(s) - t) / rate;
    }
    return s;
  }

  double pull_;
  double hold_;
  double across_;
  double downhill_;
  double speed_;
  double towards_ = 0;  // A
  double against_ = 0;  // B
  double ratio_ = infinity;
  double stops_ = infinity;
};

class SlidingBox final : public BodyMotion {
 public:
  explicit SlidingBox(const Scenario& scenario)
      : body_(scenario.mechanism.bodies.front()),
        plane_(std::get<HalfSpace>(scenario.mechanism.obstacles.at(0).shape)),
        friction_(scenario.mechanism.contacts.at(0).friction.value()) {
    const Vec3& normal = plane_.normal;
    const double pull = scenario.gravity * normal[0];
    downhill_ = {normal[2], 0, -normal[0]};
    if (pull < 0) {
      for (double& x : downhill_) x = -x;
    }
    across_ = cross(normal, downhill_);
    const double press = scenario.gravity * normal[2];
    const bool constant = friction_.model == FrictionModel::constant;
    const double hold = constant ? friction_.limit / body_.mass_kg : friction_.limit * press;
    check(scenario, std::fabs(pull), hold, press);
    const double along = dot(downhill_, body_.velocity_m_s);
    motion_ = Coulomb(along, dot(across_, body_.velocity_m_s), std::fabs(pull), hold);
    speed_ = length(body_.velocity_m_s);
    pull_ = std::fabs(pull);
  }

  void at(double t, std::span<BodyState> states, std::span<JointState>) const override {
    const Slide slide = motion_.at(t);
    BodyState& state = states[0] = BodyState{};
    for (std::size_t k = 0; k < 3; ++k) {
      state.position[k] = body_.position_m[k] + slide.downhill * downhill_[k] + slide.across * across_[k];
      state.velocity[k] = slide.downhill_rate * downhill_[k] + slide.across_rate * across_[k];
    }
    state.rotation = rotation_of(rotation_vector(body_.attitude));
  }

  // Terms of one sign, each good to some roundings, of which none is larger than what the box could cover without
  // friction; the slope alone is taken from a sine.
  BodyUncertainty uncertainty(double t) const override {
    const double way = length(body_.position_m) + t * (speed_ + pull_ * t);
    return {64 * epsilon * way, 4 * epsilon};
  }

  double at_rest_from() const override { return std::isfinite(motion_.rests()) ? motion_.rests() : -1; }

  std::string origin() const override { return "closed form: Coulomb friction in the plane"; }

 private:
  [[noreturn]] static void fail(const Scenario& scenario, const std::string& what) {
    throw UserError(scenario.file + ": " + what);
  }

  void check(const Scenario& scenario, double pull, double hold, double press) const {
    if (scenario.mechanism.bodies.size() != 1 || !std::holds_alternative<Box>(body_.shape)) {
      fail(scenario, "bodies must be 1 table [[bodies]] with shape = box, or the motion has no closed form");
    }
    constexpr double flat = 1e-6;  // m and rad: of numbers that were typed with some digits
    const Vec3& normal = plane_.normal;
    const Rotation turn = rotation_of(rotation_vector(body_.attitude));
    const Vec3 up = turned_back(turn, normal);
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (std::fabs(up[k]) > std::fabs(up[axis])) axis = k;
    }
    const Vec3 spin = body_.spin_rad_s;
    const Vec3 sides = sides_m(body_.shape);
    const double half = sides[axis] / 2;
    if (1 - std::fabs(up[axis]) > flat * flat / 2 + 4 * epsilon) {
      fail(scenario, "bodies.0.turn must lay the box flat on the ground: a turn about the ground's normal alone");
    }
    if (std::fabs(dot(normal, body_.position_m) - plane_.offset_m - half) > flat) {
      fail(scenario, fmt::format("bodies.0.position must have the centre {:.10g} m above the ground: the box lies on "
                                 "it",
                                 half));
    }
    if (std::fabs(dot(normal, body_.velocity_m_s)) > 4 * epsilon * length(body_.velocity_m_s))
      fail(scenario, "bodies.0.velocity must lie in the ground");
    if (dot(spin, spin) != 0) fail(scenario, "bodies.0.spin must be 0: the box slides without turning");

    // The force of the ground passes through the centre, so it acts friction / normal force times half the height from
    // the middle of the box, whichever way; within the shorter half side it can not tip.
    double side = infinity;
    for (std::size_t k = 0; k < 3; ++k) {
      if (k != axis) side = std::fmin(side, sides[k] / 2);
    }
    const bool held = dot(body_.velocity_m_s, body_.velocity_m_s) == 0 && hold >= pull;
    const double friction = held ? pull : hold;
    if (friction * half > press * side) {
      fail(scenario, fmt::format("ground.friction could tip the box; this one stays flat up to {:.6g}{}",
                                 friction_.limit * press * side / (friction * half),
                                 friction_.model == FrictionModel::constant ? " N" : ""));
    }
  }

  Body body_;
  HalfSpace plane_;
  Friction friction_;
  Vec3 downhill_{};
  Vec3 across_{};
  Coulomb motion_{0, 0, 0, 0};
  double speed_ = 0;
  double pull_ = 0;
};

}  // namespace

std::unique_ptr<BodyMotion> make_sliding_box(const Scenario& scenario) {
  return std::make_unique<SlidingBox>(scenario);
}

}  // namespace odeval::reference
