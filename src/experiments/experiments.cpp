#include <array>

#include "experiments/all.hpp"

namespace odeval::experiments {
namespace {

// clang-format off
constexpr std::array table{
    Experiment{"snapshots", "Pictures of the motions", snapshots},
    Experiment{"double-pendulum", "The double pendulum, as the 2010 report plotted it", double_pendulum},
    Experiment{"accuracy", "Who follows whom (Figure 5.13)", accuracy},
    Experiment{"table-5-2", "What the methods cost (Table 5.2)", table_5_2},
    Experiment{"work-precision", "What an error costs: work and precision", work_precision},
    Experiment{"energy", "Energy: ODE, ode45 and Euler", energy},
    Experiment{"energy-feedback", "Is the feedback of joint errors to blame?", energy_feedback},
    Experiment{"wall-pendulum", "A link against a wall", wall_pendulum},
    Experiment{"contact-delay", "Does ODE see the wall late?", contact_delay},
    Experiment{"quickstep", "What QuickStep loses", quickstep},
    Experiment{"quickstep-chain", "QuickStep on a long chain", quickstep_chain},
    Experiment{"half-step", "Half a step: what ODE's first-order error is", half_step},
    Experiment{"half-step-erp", "The best ERP", half_step_erp},
    Experiment{"half-step-energy", "Energy alone does not tell", half_step_energy},
    Experiment{"order", "Observed order of every method", order},
    Experiment{"sensitivity", "How an error of the start grows (Figure 5.14)", sensitivity},
    Experiment{"dh", "A toolbox's equations and the hand-derived ones", denavit_hartenberg},
    Experiment{"single-pendulum", "Was the double pendulum a good choice?", single_pendulum},
    Experiment{"coordinates", "Cartesian or generalized coordinates?", coordinates},
    Experiment{"chain", "More links: error, conditioning and cost", chain},
    Experiment{"error-sources", "Where the error comes from", error_sources},
    Experiment{"conditioning", "What CFM does for the system to be solved", conditioning},
    Experiment{"orientation", "A quaternion or a rotation matrix?", orientation},
    Experiment{"feedback-term", "What the feedback term keeps together", feedback_term},
    Experiment{"free-box", "A free box: Gazebo's boxes benchmark", free_box},
    Experiment{"thin-body", "Long thin bodies and their long axis", thin_body},
    Experiment{"friction", "Friction: pyramid, constant force and Coulomb", friction},
    Experiment{"bouncing-ball", "A ball that bounces, and rests", bouncing_ball},
    Experiment{"spring-joint", "ERP and CFM as a spring and a damper", spring_joint},
    Experiment{"remedy", "A fourth-order step beside ODE's collision detection", remedy},
    Experiment{"iftomm", "The pendulum of the IFToMM benchmark", iftomm},
    Experiment{"potra", "Two points against a wall (Potra et al. 2006)", potra},
};
// clang-format on

}  // namespace

std::span<const Experiment> experiments() { return table; }

}  // namespace odeval::experiments
