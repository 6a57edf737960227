#pragma once
// The experiments, one function a file; the table in experiments.cpp puts them in order.
#include "experiments/experiment.hpp"

namespace odeval::experiments {

using report::Content;
using report::Findings;

Content answer(Laboratory& laboratory, Findings& findings);
Content should_i_switch(Laboratory& laboratory, Findings& findings);
Content benchmarks(Laboratory& laboratory, Findings& findings);
Content snapshots(Laboratory& laboratory, Findings& findings);
Content double_pendulum(Laboratory& laboratory, Findings& findings);
Content accuracy(Laboratory& laboratory, Findings& findings);
Content energy(Laboratory& laboratory, Findings& findings);
Content energy_feedback(Laboratory& laboratory, Findings& findings);
Content wall_pendulum(Laboratory& laboratory, Findings& findings);
Content contact_delay(Laboratory& laboratory, Findings& findings);
Content quickstep(Laboratory& laboratory, Findings& findings);
Content half_step(Laboratory& laboratory, Findings& findings);
Content half_step_erp(Laboratory& laboratory, Findings& findings);
Content half_step_energy(Laboratory& laboratory, Findings& findings);
Content order(Laboratory& laboratory, Findings& findings);
Content sensitivity(Laboratory& laboratory, Findings& findings);
Content denavit_hartenberg(Laboratory& laboratory, Findings& findings);
Content single_pendulum(Laboratory& laboratory, Findings& findings);
Content coordinates(Laboratory& laboratory, Findings& findings);
Content feedback_term(Laboratory& laboratory, Findings& findings);
Content table_5_2(Laboratory& laboratory, Findings& findings);
Content work_precision(Laboratory& laboratory, Findings& findings);
Content conditioning(Laboratory& laboratory, Findings& findings);
Content orientation(Laboratory& laboratory, Findings& findings);
Content free_box(Laboratory& laboratory, Findings& findings);
Content thin_body(Laboratory& laboratory, Findings& findings);
Content friction(Laboratory& laboratory, Findings& findings);
Content bouncing_ball(Laboratory& laboratory, Findings& findings);
Content spring_joint(Laboratory& laboratory, Findings& findings);
Content motor_lift(Laboratory& laboratory, Findings& findings);
Content remedy(Laboratory& laboratory, Findings& findings);
Content chain(Laboratory& laboratory, Findings& findings);
Content quickstep_chain(Laboratory& laboratory, Findings& findings);
Content error_sources(Laboratory& laboratory, Findings& findings);
Content iftomm(Laboratory& laboratory, Findings& findings);
Content potra(Laboratory& laboratory, Findings& findings);

}  // namespace odeval::experiments
