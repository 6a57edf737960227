#pragma once
// The experiments, one function a file; the table in experiments.cpp puts them in order.
#include "experiments/experiment.hpp"

namespace odeval::experiments {

using report::Findings;
using report::Section;

Section snapshots(Laboratory& laboratory, Findings& findings);
Section double_pendulum(Laboratory& laboratory, Findings& findings);
Section accuracy(Laboratory& laboratory, Findings& findings);
Section energy(Laboratory& laboratory, Findings& findings);
Section energy_feedback(Laboratory& laboratory, Findings& findings);
Section wall_pendulum(Laboratory& laboratory, Findings& findings);
Section contact_delay(Laboratory& laboratory, Findings& findings);
Section quickstep(Laboratory& laboratory, Findings& findings);
Section half_step(Laboratory& laboratory, Findings& findings);
Section half_step_erp(Laboratory& laboratory, Findings& findings);
Section half_step_energy(Laboratory& laboratory, Findings& findings);
Section order(Laboratory& laboratory, Findings& findings);
Section sensitivity(Laboratory& laboratory, Findings& findings);
Section denavit_hartenberg(Laboratory& laboratory, Findings& findings);
Section single_pendulum(Laboratory& laboratory, Findings& findings);
Section coordinates(Laboratory& laboratory, Findings& findings);
Section feedback_term(Laboratory& laboratory, Findings& findings);
Section table_5_2(Laboratory& laboratory, Findings& findings);
Section work_precision(Laboratory& laboratory, Findings& findings);
Section conditioning(Laboratory& laboratory, Findings& findings);
Section orientation(Laboratory& laboratory, Findings& findings);
Section free_box(Laboratory& laboratory, Findings& findings);
Section thin_body(Laboratory& laboratory, Findings& findings);
Section friction(Laboratory& laboratory, Findings& findings);
Section bouncing_ball(Laboratory& laboratory, Findings& findings);
Section spring_joint(Laboratory& laboratory, Findings& findings);
Section remedy(Laboratory& laboratory, Findings& findings);
Section chain(Laboratory& laboratory, Findings& findings);
Section quickstep_chain(Laboratory& laboratory, Findings& findings);
Section error_sources(Laboratory& laboratory, Findings& findings);
Section iftomm(Laboratory& laboratory, Findings& findings);
Section potra(Laboratory& laboratory, Findings& findings);

}  // namespace odeval::experiments
