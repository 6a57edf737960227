#pragma once
// Numbers that carry their derivatives with respect to M variables: the chain rule as arithmetic.
#include <array>
#include <cmath>
#include <cstddef>

namespace odeval::reference {

template <class Real, std::size_t M>
struct Dual {
  Real value = 0;
  std::array<Real, M> slope{};

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor): constants mix with duals
  Dual(const Real& start, std::size_t variable) : value(start) { slope[variable] = 1; }

  /// f(this), given f's value and derivative there.
  Dual chain(const Real& f, const Real& df) const {
    Dual result;
    result.value = f;
    for (std::size_t i = 0; i < M; ++i) result.slope[i] = df * slope[i];
    return result;
  }

  friend Dual operator-(const Dual& a) { return a.chain(-a.value, Real(-1)); }
  friend Dual operator+(Dual a, const Dual& b) {
    a.value += b.value;
    for (std::size_t i = 0; i < M; ++i) a.slope[i] += b.slope[i];
    return a;
  }
  friend Dual operator-(Dual a, const Dual& b) {
    a.value -= b.value;
    for (std::size_t i = 0; i < M; ++i) a.slope[i] -= b.slope[i];
    return a;
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual result;
    result.value = a.value * b.value;
    for (std::size_t i = 0; i < M; ++i) result.slope[i] = a.slope[i] * b.value + a.value * b.slope[i];
    return result;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    Dual result;
    result.value = a.value / b.value;
    for (std::size_t i = 0; i < M; ++i) result.slope[i] = (a.slope[i] - result.value * b.slope[i]) / b.value;
    return result;
  }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual sin(const Dual& a) {
    using std::cos;
    using std::sin;
    return a.chain(sin(a.value), cos(a.value));
  }
  friend Dual cos(const Dual& a) {
    using std::cos;
    using std::sin;
    return a.chain(cos(a.value), -sin(a.value));
  }
};

}  // namespace odeval::reference
