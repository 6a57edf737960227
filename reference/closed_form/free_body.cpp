#include "reference/closed_form/free_body.hpp"

#include <algorithm>
#include <boost/math/special_functions/ellint_rf.hpp>
#include <boost/math/special_functions/ellint_rj.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "reference/closed_form/jacobi.hpp"

namespace odeval::reference {
namespace {

using boost::math::ellint_rf;
using boost::math::ellint_rj;

// Integral of n sn^2 / (cn^2 + n sn^2) from 0 to u, |u| <= K.
double third_kind(const Jacobi& f, double n) {
  const double sine = f.sn * f.sn;
  const double cosine = f.cn * f.cn;
  return sine == 0 ? 0 : n * sine * f.sn / 3 * ellint_rj(cosine, f.dn * f.dn, 1.0, cosine + n * sine);
}

}  // namespace

FreeBody::FreeBody(const Vec3& moments_kgm2, const Rotation& attitude, const Vec3& spin_rad_s)
    : start_(attitude), start_spin_(spin_rad_s) {
  const Vec3 own = turned_back(attitude, spin_rad_s);
  std::array<std::size_t, 3> axis{0, 1, 2};
  std::ranges::sort(axis, {}, [&](std::size_t i) { return moments_kgm2[i]; });

  // L^2 - 2 E I of the middle axis tells which of the others the spin goes round.
  const auto [low, middle, high] = axis;
  const auto moment = [&](std::size_t i) { return moments_kgm2[i]; };
  const auto square = [&](std::size_t i) { return own[i] * own[i]; };
  const double above = moment(high) * (moment(high) - moment(middle)) * square(high) -
                       moment(low) * (moment(middle) - moment(low)) * square(low);
  if (above < 0) std::swap(axis[0], axis[2]);

  for (std::size_t i = 0; i < 3; ++i) {
    sorted_[3 * i + axis[i]] = 1;
    moments_[i] = moments_kgm2[axis[i]];
  }
  const auto row = [&](std::size_t i) { return Vec3{sorted_[3 * i], sorted_[3 * i + 1], sorted_[3 * i + 2]}; };
  if (dot(cross(row(0), row(1)), row(2)) < 0) sorted_[axis[0]] = -1;
  const Vec3 w = turned(sorted_, own);
  const auto [i1, i2, i3] = moments_;
  steady_ = (i3 - i2) * w[1] * w[2] == 0 && (i1 - i3) * w[2] * w[0] == 0 && (i2 - i1) * w[0] * w[1] == 0;
  if (steady_) return;

  // Each difference of energy and momentum as a sum of terms of one sign; negative where axis 3 has the least moment.
  const double below = i1 * (i3 - i1) * w[0] * w[0] + i2 * (i3 - i2) * w[1] * w[1];   // 2 E I3 - L^2
  const double beyond = i3 * (i3 - i1) * w[2] * w[2] + i2 * (i2 - i1) * w[1] * w[1];  // L^2 - 2 E I1
  // A1 and A3 with the signs that w1 and w3 start with, so that |u0| <= K; A2 as I2 w2' = (I3 - I1) w3 w1 then wants.
  amplitudes_ = {std::copysign(std::sqrt(below / (i1 * (i3 - i1))), w[0]), std::sqrt(below / (i2 * (i3 - i2))),
                 std::copysign(std::sqrt(beyond / (i3 * (i3 - i1))), w[2])};
  if ((i3 - i1) * amplitudes_[2] * amplitudes_[0] < 0) amplitudes_[1] = -amplitudes_[1];
  rate_ = std::sqrt((i3 - i2) * beyond / (i1 * i2 * i3));
  complement_ = std::fabs(above) * std::fabs(i3 - i1) / (std::fabs(i3 - i2) * std::fabs(beyond));
  quarter_ = complement_ > 0 ? ellint_rf(0.0, complement_, 1.0) : std::numeric_limits<double>::infinity();

  const double sine = w[1] / amplitudes_[1];
  const double cosine = w[0] / amplitudes_[0];
  const double delta = w[2] / amplitudes_[2];
  phase_ = sine * ellint_rf(cosine * cosine, delta * delta, 1.0);

  const Vec3 angular{i1 * w[0], i2 * w[1], i3 * w[2]};
  momentum_ = length(angular);
  ratio_ = i2 * (i3 - i1) / (i1 * (i3 - i2));
  if (complement_ > 0) {
    const double n = i1 < i2 ? complement_ / ratio_ : ratio_;
    whole_ = n / 3 * ellint_rj(0.0, complement_, 1.0, n);
  }
  start_part_ = precession_part(phase_);
  to_world_ = product(product(attitude, transposed(sorted_)), transposed(euler_angles(w)));
}

// Integral from 0 to u of f1 where I1 < I2, else of f2: of the one that speeds the precession up.
double FreeBody::precession_part(double u) const {
  if (complement_ == 0) {  // the separatrix, where I1 < I2 < I3 and cn = dn
    const double root = std::sqrt(ratio_ - 1);
    return std::atan(root * jacobi(u, 0).sn) / root;
  }
  const bool first = moments_[0] < moments_[1];
  const double halves = std::round(u / (2 * quarter_));
  const double rest = halves == 0 ? u : std::fma(-2 * quarter_, halves, u);
  const Jacobi f = jacobi(rest, complement_);
  if (!first) return 2 * whole_ * halves + third_kind(f, ratio_);
  const double s = std::fabs(f.sn);
  const double c = std::fabs(f.cn);
  const double root = std::sqrt(complement_);
  const Jacobi from_end{c / f.dn, root * s / f.dn, root / f.dn};  // of K - |u|
  return 2 * whole_ * halves + std::copysign(whole_ - third_kind(from_end, complement_ / ratio_), rest);
}

Vec3 FreeBody::spin_at(double u) const {
  const double turns = std::isinf(quarter_) ? 0 : std::round(u / (4 * quarter_));
  const Jacobi f = jacobi(turns == 0 ? u : std::fma(-4 * quarter_, turns, u), complement_);
  return {amplitudes_[0] * f.cn, amplitudes_[1] * f.sn, amplitudes_[2] * f.dn};
}

// From the axes 1, 2, 3 to a frame whose z axis is along L and whose x axis lies across L and axis 3.
Rotation FreeBody::euler_angles(const Vec3& spin) const {
  Vec3 z{moments_[0] * spin[0], moments_[1] * spin[1], moments_[2] * spin[2]};
  const double size = length(z);
  for (double& part : z) part /= size;
  const double across = std::hypot(z[0], z[1]);
  const Vec3 x{z[1] / across, -z[0] / across, 0};
  const Vec3 y = cross(z, x);
  return {x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]};
}

FreeBody::Turning FreeBody::at(double t_s) const {
  if (steady_) {
    return {product(rotation_of(t_s * start_spin_), start_), start_spin_};
  }
  const auto [i1, i2, i3] = moments_;
  const double u = phase_ + rate_ * t_s;
  const Vec3 spin = spin_at(u);
  const double faster = std::fabs(1 / i1 - 1 / i2) * (precession_part(u) - start_part_) / rate_;
  const double precession = momentum_ * (t_s / std::max(i1, i2) + faster);
  const Rotation now = product(to_world_, product(rotation_of({0, 0, precession}), euler_angles(spin)));
  return {product(now, sorted_), turned(now, spin)};
}

}  // namespace odeval::reference
