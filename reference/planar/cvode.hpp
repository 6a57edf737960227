#pragma once
// Method lagrange-cvode: the closed-form equations of motion, integrated by SUNDIALS CVODE; of free bodies Euler's.
#include <memory>

#include "odeval/engine.hpp"
#include "odeval/scenario.hpp"
#include "reference/cvode_solver.hpp"

namespace odeval::reference {

/// Of the reference, and of the method where the scenario gives none. Not far above the rounding of a double, below
/// which CVODE refuses to go (reference_test.cpp, check_errors).
inline constexpr Tolerances tight_tolerances{3e-15, 3e-16};

/// In joint coordinates, or where there are none of free bodies (maximal/newton_euler.hpp). With a wall, impacts are
/// located and recorded with depth 0. Throws UserError when the link starts inside the wall; run() throws MachineError
/// when CVODE gives up.
std::unique_ptr<Simulation> make_cvode(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
