#include "reference/closed_form/jacobi.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace odeval::reference {

// By the arithmetic-geometric mean (R. Bulirsch, Numerical calculation of elliptic integrals and elliptic functions,
// Numer. Math. 7, 1965).
Jacobi jacobi(double u, double complement) {
  if (complement == 0) return {std::tanh(u), 1 / std::cosh(u), 1 / std::cosh(u)};
  constexpr int most = 16;  // the mean doubles its digits each time
  const double close = std::sqrt(std::numeric_limits<double>::epsilon()) / 4;
  std::array<double, most> arithmetic;
  std::array<double, most> geometric;
  double a = 1;
  double g = std::sqrt(complement);
  double c = 0;
  int last = 0;
  for (;; ++last) {
    arithmetic[static_cast<std::size_t>(last)] = a;
    geometric[static_cast<std::size_t>(last)] = g;
    c = (a + g) / 2;
    if (std::fabs(a - g) <= close * a || last == most - 1) break;
    g = std::sqrt(a * g);
    a = c;
  }
  const double sine = std::sin(c * u);
  const double cosine = std::cos(c * u);
  if (sine == 0) return {0, cosine, 1};
  double dn = 1;
  a = cosine / sine;
  c *= a;
  for (; last >= 0; --last) {
    const double b = arithmetic[static_cast<std::size_t>(last)];
    a *= c;
    c *= dn;
    dn = (geometric[static_cast<std::size_t>(last)] + a) / (b + a);
    a = c / b;
  }
  const double sn = std::copysign(1 / std::sqrt(c * c + 1), sine);
  return {sn, c * sn, dn};
}

}  // namespace odeval::reference
