#include <array>

#include "experiments/all.hpp"

namespace odeval::experiments {
namespace {

// clang-format off
constexpr std::array table{
    Experiment{"snapshots", "Pictures of the motions", snapshots},
    Experiment{"double-pendulum", "The double pendulum, as the 2010 report plotted it", double_pendulum},
    Experiment{"accuracy", "Who follows whom (Figure 5.13)", accuracy},
    Experiment{"energy", "Energy: ODE, ode45 and Euler", energy},
    Experiment{"energy-feedback", "Is the feedback of joint errors to blame?", energy_feedback},
    Experiment{"wall-pendulum", "A link against a wall", wall_pendulum},
    Experiment{"contact-delay", "Does ODE see the wall late?", contact_delay},
    Experiment{"quickstep", "What QuickStep loses", quickstep},
    Experiment{"half-step", "Half a step: what ODE's first-order error is", half_step},
    Experiment{"half-step-erp", "The best ERP", half_step_erp},
    Experiment{"half-step-energy", "Energy alone does not tell", half_step_energy},
    Experiment{"order", "Observed order of every method", order},
    Experiment{"sensitivity", "How an error of the start grows (Figure 5.14)", sensitivity},
    Experiment{"dh", "A toolbox's equations and the hand-derived ones", denavit_hartenberg},
    Experiment{"single-pendulum", "Was the double pendulum a good choice?", single_pendulum},
    Experiment{"coordinates", "Cartesian or generalized coordinates?", coordinates},
    Experiment{"feedback-term", "What the feedback term keeps together", feedback_term},
    Experiment{"spring-joint", "ERP and CFM as a spring and a damper", spring_joint},
    Experiment{"remedy", "A fourth-order step beside ODE's collision detection", remedy},
};
// clang-format on

}  // namespace

std::span<const Experiment> experiments() { return table; }

}  // namespace odeval::experiments
