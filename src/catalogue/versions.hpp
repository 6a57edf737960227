#pragma once
// What made a number: the program, its libraries, its compiler.
#include <span>

#include "catalogue/methods.hpp"
#include "output/summary.hpp"

namespace odeval::catalogue {

/// odeval, ode_double, ode_single (or "not in this build"), sundials, boost, other libraries, compiler, flags, and the
/// release of the system. The same on every run.
NamedTexts versions();

/// What the engines beside ODE among these methods call themselves, each once: "mujoco", "2.2.2". Loads their modules,
/// as a run does.
NamedTexts engine_versions(std::span<const Method* const> asked);
/// Of all that this build has.
NamedTexts engine_versions();

/// Processor, cores and kernel of this machine; for timings only.
NamedTexts machine();

}  // namespace odeval::catalogue
