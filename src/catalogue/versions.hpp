#pragma once
// What made a number: the program, its libraries, its compiler.
#include "output/summary.hpp"

namespace odeval::catalogue {

/// odeval, ode_double, ode_single (or "not in this build"), sundials, boost, other libraries, compiler, flags, and the
/// release of the system. The same on every run.
NamedTexts versions();

/// Processor, cores and kernel of this machine; for timings only.
NamedTexts machine();

}  // namespace odeval::catalogue
