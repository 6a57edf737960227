#include "reference/closed_form/damped_oscillator.hpp"

#include <cmath>
#include <limits>

namespace odeval::reference {
namespace {

/// Answers of the mass without gravity: to a displacement of 1 (x = c + a s) and to a velocity of 1 (x = s), c = s' + a
/// s. Everything that could cancel or overflow with strong damping, or divide by zero at critical damping, is written
/// out.
struct Answers {
  double c;
  double s;
};

Answers answers(double a, double w2, double t) {
  const double discriminant = a * a - w2;
  const double root = std::sqrt(std::fabs(discriminant));
  if (discriminant < 0) {
    const double decay = std::exp(-a * t);
    return {decay * std::cos(root * t), decay * std::sin(root * t) / root};
  }
  const double slow = std::exp(-w2 / (a + root) * t);
  const double between = root == 0 ? t : -std::expm1(-2 * root * t) / (2 * root);
  return {(slow + std::exp(-(a + root) * t)) / 2, slow * between};
}

}  // namespace

Deflection DampedOscillator::at(double t, const Deflection& start) const {
  const double a = kd_Ns_m / mass_kg / 2;
  const double w2 = kp_N_m / mass_kg;
  if (kp_N_m == 0) {
    const double s = -std::expm1(-2 * a * t) / (2 * a);
    return {start.x + start.v * s - gravity * (t - s) / (2 * a), start.v * (1 - 2 * a * s) - gravity * s};
  }
  const auto [c, s] = answers(a, w2, t);
  const double rest = -gravity / w2;
  const double from_rest = start.x - rest;
  return {rest + from_rest * (c + a * s) + start.v * s, start.v * (c - a * s) - from_rest * w2 * s};
}

// The phase of an oscillation and the exponent of a decay are known to the rounding of rate times time.
double DampedOscillator::uncertainty(double t, const Deflection& start) const {
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
  const double a = kd_Ns_m / mass_kg / 2;
  const double w = std::sqrt(kp_N_m / mass_kg);
  const double rest = kp_N_m == 0 ? gravity * t * t / 2 : gravity / (w * w);
  const double reach = std::fabs(start.x) + std::fabs(start.v) * std::fmin(std::fabs(t), 1 / std::fmax(a, w)) + rest;
  return rounding * (1 + (a + w) * std::fabs(t)) * reach;
}

Deflection StepLaw::next(const Deflection& now) const {
  const double free = now.v - step_s * gravity;
  const double v = (mass_kg * cfm * free - erp * now.x) / (mass_kg * cfm + step_s);
  return {now.x + step_s * v, v};
}

}  // namespace odeval::reference
