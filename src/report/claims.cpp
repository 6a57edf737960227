#include "report/claims.hpp"

#include <fmt/format.h>

#include <array>

namespace odeval::report {
namespace {

constexpr auto at_most = Relation::at_most;
constexpr auto at_least = Relation::at_least;

// Conditions of one claim; named after it.
// clang-format off
constexpr Condition c1_confirmed[] = {{"C1.order_off", at_most, 0.1}};
constexpr Condition c1_refuted[]   = {{"C1.order_off", at_least, 0.3}};

constexpr Condition c2_confirmed[] = {{"C2.error_ratio", at_least, 2}, {"C2.chain_error_ratio", at_least, 2}};
constexpr Condition c2_refuted[]   = {{"C2.error_ratio", at_most, 1.1}, {"C2.chain_error_ratio", at_most, 1.1}};

constexpr Condition c3_confirmed[] = {{"C3.error_ratio", at_least, 1}, {"C3.condition_ratio", at_least, 1}, {"C3.error_exponent", at_least, 0.2}};
constexpr Condition c3_refuted[]   = {{"C3.error_ratio", at_most, 0.5}, {"C3.condition_ratio", at_most, 1}, {"C3.error_exponent", at_most, 0}};

constexpr Condition c4_confirmed[] = {{"C4.long_axis_spin_single", at_least, 1}, {"C4.long_axis_spin_double", at_most, 1e-3}};  // 1: as fast as its own spin
constexpr Condition c4_refuted[]   = {{"C4.long_axis_spin_single", at_most, 1e-3}};  // by 0.02 rad in 10 s

constexpr Condition c5_confirmed[] = {{"C5.digits_regained", at_least, 3}, {"C5.error_ratio", at_most, 2}};
constexpr Condition c5_refuted[]   = {{"C5.digits_regained", at_most, 0}};

constexpr Condition c6_confirmed[] = {{"C6.discrete_law_error", at_most, 1e-12}, {"C6.oscillator_order", at_least, 0.9}};
constexpr Condition c6_refuted[]   = {{"C6.discrete_law_error", at_least, 1e-3}};

constexpr Condition c7_confirmed[] = {{"C7.ode45_over_ode", at_least, 1}, {"C7.ode45_over_ode", at_most, 2}, {"C7.euler_over_ode", at_least, 2}, {"C7.dh_over_lagrange", at_least, 2}};
constexpr Condition c7_refuted[]   = {{"C7.ode45_over_ode", at_most, 0.5}, {"C7.euler_over_ode", at_most, 0.5}};

constexpr Condition c8a_confirmed[] = {{"C8a.fluctuation_over_ode45", at_least, 2}, {"C8a.fluctuation_over_euler", at_least, 2}};
constexpr Condition c8a_refuted[]   = {{"C8a.fluctuation_over_ode45", at_most, 1}, {"C8a.fluctuation_over_euler", at_most, 1}};

constexpr Condition c8b_confirmed[] = {{"C8b.largest_ratio", at_most, 0.5}};
constexpr Condition c8b_refuted[]   = {{"C8b.largest_ratio", at_least, 1}, {"C8b.least_ratio", at_least, 1}};

constexpr Condition c9_confirmed[] = {{"C9.distance_ratio", at_most, 0.5}, {"C9.ode_parts_at", at_least, 6}, {"C9.ode_parts_at", at_most, 7}};
constexpr Condition c9_refuted[]   = {{"C9.distance_ratio", at_least, 1}};

constexpr Condition c10_confirmed[] = {{"C10.perturbed_parts_at", at_least, 3}, {"C10.perturbed_parts_at", at_most, 4}, {"C10.growth_at_6s", at_least, 10}};
constexpr Condition c10_refuted[]   = {{"C10.growth_at_6s", at_most, 2}};

constexpr Condition c11a_confirmed[] = {{"C11a.after_vertical", at_least, 8}, {"C11a.after_vertical", at_most, 12}, {"C11a.after_touch", at_least, 5}};
constexpr Condition c11a_refuted[]   = {{"C11a.after_touch", at_most, 1}};

constexpr Condition c11b_confirmed[] = {{"C11b.by_settings", at_least, 0.67}};
constexpr Condition c11b_refuted[]   = {{"C11b.by_settings", at_most, 0.33}, {"C11b.by_face", at_least, 0.67}};

constexpr Condition c12_confirmed[] = {{"C12.smooth_gain", at_least, 1000}, {"C12.impact_gain", at_least, 1000}, {"C12.friction_gain", at_least, 1000}, {"C12.motor_gain", at_least, 1000}, {"C12.stop_gain", at_least, 1000}};
constexpr Condition c12_refuted[]   = {{"C12.smooth_gain", at_most, 2}};

constexpr Condition c13_confirmed[] = {{"C13.largest_difference", at_most, 1e-6}};
constexpr Condition c13_refuted[]   = {{"C13.largest_difference", at_least, 1e-3}};

constexpr Condition c14_confirmed[] = {{"C14.anisotropy", at_least, 0.1}};
constexpr Condition c14_refuted[]   = {{"C14.anisotropy", at_most, 0.01}};

constexpr Condition c15_confirmed[] = {{"C15.matrix_drift", at_least, 1e-6}, {"C15.quaternion_drift", at_most, 1e-12}, {"C15.cost_ratio", at_most, 1}};
constexpr Condition c15_refuted[]   = {{"C15.matrix_drift", at_most, 1e-12}};

constexpr Condition c16_confirmed[] = {{"C16.gap_ratio", at_least, 10}};
constexpr Condition c16_refuted[]   = {{"C16.gap_ratio", at_most, 1}};

constexpr Condition c17_confirmed[] = {{"C17.growth_ratio", at_least, 10}};
constexpr Condition c17_refuted[]   = {{"C17.growth_ratio", at_most, 2}};

constexpr Condition o1_confirmed[] = {{"O1.shift", at_least, 0.45}, {"O1.shift", at_most, 0.55}, {"O1.order", at_least, 1.7}, {"O1.gain", at_least, 10}, {"O1.order_at_speed", at_least, 1.7}, {"O1.shift_at_speed", at_least, 0.45}, {"O1.shift_at_speed", at_most, 0.55}};
constexpr Condition o1_refuted[]   = {{"O1.gain", at_most, 1.2}};

constexpr Condition o2_confirmed[] = {{"O2.gain", at_least, 2}};
constexpr Condition o2_refuted[]   = {{"O2.gain", at_most, 1}};

constexpr Condition o3_confirmed[] = {{"O3.drift_ratio", at_least, 1.2}};
constexpr Condition o3_refuted[]   = {{"O3.drift_ratio", at_most, 1}};

constexpr std::array table{
    Claim{"C1", "§3.5.1, §5.1.3", "ODE's integration is first order in the step size.", c1_confirmed, c1_refuted,
          "Halving the step halves the error, and doubles the cost.", "order"},
    Claim{"C2", "§3.5.1", "QuickStep is a lot less accurate than the big-matrix step.", c2_confirmed, c2_refuted,
          "What QuickStep loses depends on its iterations, not on its scheme.", "quickstep", Verdict::confirmed_with_limits},
    Claim{"C3", "§3.5.2", "The error grows with the number of states, and Cartesian coordinates are worse conditioned than generalized ones.", c3_confirmed, c3_refuted,
          "The system is worse conditioned and the motion better: what counts is the scheme, and in Cartesian coordinates the feedback that keeps the joints closed. Leave ERP on.", "coordinates", Verdict::confirmed_with_limits},
    Claim{"C4", "§3.5.3", "In single precision, long thin bodies spin up about their long axis.", c4_confirmed, c4_refuted,
          "The inertia survives; it is ODE's gyroscopic term that loses the digits, long before the moments differ as much as the report thought. Use double precision, or leave the term out (dBodySetGyroscopicMode). A long body that does spin about its length loses that spin to the term, in double precision as well.", "thin-body"},
    Claim{"C5", "§3.4.1", "A positive CFM takes the system matrix away from singularity.", c5_confirmed, c5_refuted,
          "Where joints, or the corners on which a box stands, say the same thing twice, CFM is what makes the system solvable. Elsewhere it buys nothing in double precision, and heavy parts sag.", "conditioning"},
    Claim{"C6", "§3.4.2", "ERP = h kp / (h kp + kd) and CFM = 1 / (h kp + kd) make a joint a spring and damper.", c6_confirmed, c6_refuted,
          "Turn the stiffness and the damping that you want into ERP and CFM by these formulas, at your step, and again whenever the step changes: fixed numbers are a stiffer spring at a smaller step.", "spring-joint"},
    Claim{"C7", "§5.7.1", "ODE is marginally faster than hand-derived equations with ode45 and four times faster than Euler with the same steps; a toolbox costs a multiple.", c7_confirmed, c7_refuted,
          "The times of 2010 compare interpreted with compiled code. Compare at equal error.", "table-5-2", Verdict::refuted},
    Claim{"C8a", "§5.7.2", "ODE's energy fluctuates with much larger amplitude than ode45's and Euler's.", c8a_confirmed, c8a_refuted,
          "Read how far the energy gets from its start, not how restless it looks; and no drift of energy tells how wrong the angles are.", "energy", Verdict::refuted},
    Claim{"C8b", "§5.7.2", "The reason is the feedback of joint errors (ERP).", c8b_confirmed, c8b_refuted,
          "Feedback costs no energy worth the name; leaving it out does.", "energy-feedback", Verdict::refuted},
    Claim{"C9", "§5.7.3", "ODE follows ode45 more closely than explicit Euler does, until just over 6 s.", c9_confirmed, c9_refuted,
          "ode45 at its default tolerance is no truth to judge by: a tighter tolerance or a reference with a known error is.", "accuracy", Verdict::confirmed_with_limits},
    Claim{"C10", "§5.7.3", "The divergence after that is sensitivity to the initial state: an error of 0.006 separates q2 after just over 3 s.", c10_confirmed, c10_refuted,
          "Runs of such a mechanism part, whatever computes them. Judge settings before that, and a design by many runs from starts that differ a little.", "sensitivity"},
    Claim{"C11a", "§6.3", "ODE sees the wall about 10 steps late.", c11a_confirmed, c11a_refuted,
          "Compute where the outlines touch before calling a contact late. A fixed step cannot see a touch to better than a step.", "contact-delay", Verdict::refuted},
    Claim{"C11b", "§6.3", "The default ERP and CFM may be the cause of the late contact.", c11b_confirmed, c11b_refuted,
          "Leave the feedback on: without it the hinge opens on the way, which makes the contact later still.", "contact-delay", Verdict::refuted},
    Claim{"C12", "§3.5.5, §7", "A fixed-step solver of higher order (RK4) beside ODE's collision detection would cure the accuracy.", c12_confirmed, c12_refuted,
          "Where the motion counts, take the fourth-order step: odeval::accurate_step, one call in the place of dWorldStep, impacts, friction, motors and stops included. Contacts that crowd stay of first order.", "remedy"},
    Claim{"C13", "§5.6.3", "Recursive Newton-Euler from DH parameters gives results identical to the hand-derived equations.", c13_confirmed, c13_refuted,
          "Trust either; derive by hand only what has to be fast.", "dh"},
    Claim{"C14", "§3.3, §3.5.4", "Friction knows only a constant limit and a pyramid, which may be a large error.", c14_confirmed, c14_refuted,
          "Give each contact the way it slides as first direction of friction (dContactFDir1) and the pyramid is Coulomb's law for a box that does not turn; or take odeval::accurate_step, whose cone is round.", "friction"},
    Claim{"C15", "§5.4", "A quaternion keeps an orientation cheaply and can be normalised; a rotation matrix drifts.", c15_confirmed, c15_refuted,
          "ODE keeps a normalised quaternion: its matrices stay rotations to the last digits.", "orientation"},
    Claim{"C16", "§5.3.4", "The feedback term -ks C - kd C' keeps the joints together.", c16_confirmed, c16_refuted,
          "It keeps the joints closed, and costs a solver of higher order some accuracy of the angles.", "feedback-term", Verdict::confirmed_with_limits},
    Claim{"C17", "§5.7.3", "A single pendulum would have been the more meaningful comparison.", c17_confirmed, c17_refuted,
          "Compare methods before a chaotic motion has multiplied their errors, or on a motion that is not chaotic: the end of a long run tells how unstable the motion is.", "single-pendulum"},
    Claim{"O1", "odeval", "The first-order part of ODE's error is a time shift of half a step; starting with the velocities of t = -h/2 takes it away for nothing.", o1_confirmed, o1_refuted,
          "It costs one evaluation of the accelerations (--start half-step). Of a start at speed the error is more than a shift of time, and the half-step start takes it away all the same. From the first impact on it harms more often than it helps, and on a long chain it gains less than a larger ERP does.", "half-step", Verdict::confirmed_with_limits},
    Claim{"O2", "odeval", "The default ERP of 0.2 is not the best: with the half-step start, 0.8 is several times better again.", o2_confirmed, o2_refuted,
          "With the usual start ERP hardly matters on a pendulum from the default up; with the half-step start it does.", "half-step-erp"},
    Claim{"O3", "odeval", "Energy alone never tells: from half-step velocities part of ODE's drift is gone while the motion stays the same.", o3_confirmed, o3_refuted,
          "To watch the energy of an ODE world, average each velocity with that of the next step.", "half-step-energy"},
};
// clang-format on

}  // namespace

std::span<const Claim> claims() { return table; }

std::string advice_of(const Judged& judged) {
  const Claim& claim = *judged.claim;
  if (judged.verdict == claim.advised_on) return std::string(claim.advice);
  return fmt::format("Look at the evidence first: here it is {}. Advice for where it is {}: {}",
                     verdict_text(judged.verdict), verdict_text(claim.advised_on), claim.advice);
}

}  // namespace odeval::report
