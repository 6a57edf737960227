#pragma once
// Fixed steps on the Lagrangian equations: classical Runge-Kutta, explicit Euler, symplectic Euler.
//
// The first two are Boost.odeint's. Its symplectic steppers want a separable Hamiltonian, which a double pendulum's
// is not, so the third is our own: qd += h a(q, qd), then q += h qd. That is the order of ODE's dWorldStep. It is
// symplectic where a does not depend on qd (one link); for chains it is the semi-implicit Euler of that name.
//
// A step that meets the wall is taken as pieces: the touch is the length of the piece, found by taking the step again
// with shorter lengths until it ends on the wall; there qd -> -e qd, and the same stepper does what is left of the
// step, so a touch leaves the order as it is. What the steppers make of bounces shorter than a step is their own:
// Runge-Kutta has them right; explicit Euler feeds energy into them, and a cascade never comes to rest;
// symplectic Euler comes back with no speed at all, and rests early.
#include <memory>

#include "odeval/engine.hpp"

namespace odeval::reference {

/// In joint coordinates. Outcome::steps counts grid steps begun before the link came to rest.
std::unique_ptr<Simulation> make_rk4(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_euler(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_symplectic_euler(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
