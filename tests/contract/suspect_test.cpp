// ODE's own messages: counted run by run, the first one's text kept, and told below the section of the page that shows
// the run, whether the section did it or somebody before.
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
  return test::verdict();
}
