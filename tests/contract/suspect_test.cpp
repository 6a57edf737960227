// ODE's own messages: counted run by run, the first one's text kept, and told below the section of the page that shows
// the run, whether the section did it or somebody before. Likewise where the reference is ODE's own limit.
#include "catalogue/paths.hpp"
#include "experiments/experiment.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "output/summary.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using experiments::Laboratory;

// Without CFM the four corners of a box share its weight in any way, and ODE's solver says so in nearly every step.
Scenario slide(const std::string& name) {
  Scenario scenario = read_scenario(find_scenario(name, catalogue::scenario_folder()), {},
                                    {catalogue::method_names(), {"max_error_position", "rest_time"}});
  scenario.tolerances.clear();
  scenario.ode.cfm = 0;
  return scenario;
}

report::Content shows_a_slide(Laboratory& laboratory, report::Findings&) {
  laboratory.run("friction_slide", "ode-step-double");
  return {};
}
report::Content shows_none(Laboratory& laboratory, report::Findings&) {
  laboratory.run("friction_slide", "analytic");
  return {};
}

/// A box on a horizontal rail, which a floor below carries as well and brakes: nobody but ODE knows how.
Scenario braked(const std::string& name) {
  Scenario scenario;
  scenario.name = scenario.file = name;
  scenario.named = true;
  scenario.duration_s = 0.1;
  scenario.mechanism.bodies = {{.shape = Box{{0.2, 0.2, 0.2}},
                                .mass_kg = 2,
                                .position_m = {0, 0, 0.1},
                                .velocity_m_s = {1, 0, 0},
                                .name = "box"},
                               {.shape = Sphere{0.1}, .mass_kg = 1, .position_m = {0, 3, 0}, .name = "bob"}};
  scenario.mechanism.joints = {{.kind = HingeJoint{{0, 3, 1}, {1, 0, 0}}, .first = 1, .second = {}}};
  scenario.mechanism.obstacles = {{HalfSpace{}, "floor"}};
  scenario.mechanism.contacts = {{.friction = Friction{0.2}, .first = "box", .second = "floor"}};
  scenario.ode.cfm = 1e-7;
  return scenario;
}
report::Content shows_what_rubs(Laboratory& laboratory, report::Findings&) {
  laboratory.evaluator("rubs").reference();
  return {};
}

std::string last_words(const report::Section& section) {
  const auto* const text = section.blocks.empty() ? nullptr : std::get_if<report::Text>(&section.blocks.back());
  return text == nullptr ? "" : text->text;
}

bool begins(const std::string& text, const std::string& with) { return text.starts_with(with); }

}  // namespace

int main() {
  catalogue::Evaluator evaluator(slide("friction_slide"));
  const auto& method = catalogue::find_method("ode-step-double");
  const Outcome first = evaluator.evaluate(method).outcome;
  CHECK(first.messages > 100);
  CHECK(begins(first.first_message, "LCP internal error, s <= 0"));
  CHECK_EQUAL(suspicion(first), std::to_string(first.messages) + " messages of ODE (LCP internal error)");
  const Outcome again = evaluator.evaluate(method).outcome;  // each run its own
  CHECK_EQUAL(again.messages, first.messages);
  CHECK_EQUAL(again.first_message, first.first_message);
  CHECK_EQUAL(suspicion(evaluator.evaluate(catalogue::find_method("analytic")).outcome), "");
  OdeSettings soft = evaluator.scenario().ode;
  soft.cfm = 1e-5;
  const Outcome calm = evaluator.evaluate(method, soft).outcome;
  CHECK_EQUAL(calm.messages, 0);
  CHECK_EQUAL(calm.first_message, "");

  Laboratory laboratory(slide);
  report::Findings findings;
  const std::string told =
      "Suspect: ODE itself complained in 1 of these runs, whose numbers say little: friction_slide "
      "in ode-step-double, h = 0.001 s: " +
      suspicion(first) + ".";
  const auto section = [&](auto run) {
    return last_words(experiments::section_of({"slide", "# Slide\n", run}, laboratory, findings));
  };
  CHECK_EQUAL(section(shows_a_slide), told);
  CHECK_EQUAL(section(shows_none), "");
  CHECK_EQUAL(section(shows_a_slide), told);  // of the run that was kept

  Laboratory own(braked);
  const auto words = [&](auto run) {
    return last_words(experiments::section_of({"own", "# Own\n", run}, own, findings));
  };
  for (int k = 0; k < 2; ++k) {  // of the section that has the reference solved, and of the next
    const std::string limit = words(shows_what_rubs);
    CHECK(begins(limit, "self-converged: in the tables and figures of this section the numbers of what follows are "));
    CHECK(limit.find("reference: rubs (self-converged: dWorldStep's own limit") != std::string::npos);
  }
  CHECK_EQUAL(section(shows_none), "");
  return test::verdict();
}
