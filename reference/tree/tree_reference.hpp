#pragma once
// Trees of bodies, on any joints, and loops that these close, in generalized coordinates: the reference, and method
// mechanism-cvode.
#include <functional>
#include <memory>

#include "odeval/engine.hpp"
#include "odeval/reference.hpp"
#include "reference/cvode_solver.hpp"

namespace odeval::reference {

/// What is known of trees.
inline constexpr Features known_of_trees{
    Feature::space,       Feature::joints_in_space, Feature::inertia,      Feature::motors,
    Feature::stops,       Feature::bouncing_stops,  Feature::loads,        Feature::ground,
    Feature::loops,       Feature::rare_joints,     Feature::struts,       Feature::rare_shapes,
    Feature::axis_drives, Feature::cross_stops,     Feature::plane_motors, Feature::soft_contacts};

/// Bodies in space whose joints start closed, as a tree or in loops; what touches is of contact_points.hpp.
bool is_tree(const Scenario& scenario);

/// CVODE at the reference's two tolerances, with the bound of tree_uncertainty.hpp on every sample.
/// Throws UserError when bodies start with velocities that their joints do not allow, MachineError when CVODE gives up.
Reference solve_tree(const Scenario& scenario, const SampleGrid& grid);
/// The same at tolerances of choice: for tests, which see the bound at work where rounding does not hide it.
Reference solve_tree(const Scenario& scenario, const SampleGrid& grid, Tolerances tight, Tolerances loose);
/// The same for rows at any times, all of one integration, which goes as far as the latest asks.
std::function<Reference(const SampleGrid&)> follow_tree(const Scenario& scenario);
/// The same as a method: samples of bodies and joints. Takes chains in a plane as well.
std::unique_ptr<Simulation> make_mechanism_cvode(const Scenario& scenario, const SampleGrid& grid);

/// The scenario with the velocities that its bodies had half a step before the start.
Scenario tree_half_a_step_earlier(const Scenario& scenario);

}  // namespace odeval::reference
