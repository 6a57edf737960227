#pragma once
// Jacobi's elliptic functions close to their degenerate ends.

namespace odeval::reference {

struct Jacobi {
  double sn, cn, dn;
};

/// Of u and 1 - k^2, which keeps its digits where k is close to 1. Boost's jacobi_elliptic takes k, too late there.
Jacobi jacobi(double u, double complement);

}  // namespace odeval::reference
