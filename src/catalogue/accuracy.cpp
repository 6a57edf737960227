#include "catalogue/accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "odeval/error.hpp"
#include "output/summary.hpp"
#include "reference/planar/reference_solution.hpp"

namespace odeval::catalogue {
namespace {

Scenario until(Scenario scenario, double until_s, double widest_spacing_s) {
  const double spacing = until_s / std::max(1.0, std::ceil(until_s / widest_spacing_s - 1e-9));
  scenario.duration_s = until_s;
  scenario.step_s = spacing;
  scenario.sample_s = spacing;
  scenario.rtol.reset();
  scenario.atol.reset();
  return scenario;
}

/// Settings from coarse to fine, by number.
struct Ladder {
  double (*setting)(double spacing_s, long n);
  long (*finer)(long n);  // the next to look at while nothing keeps the error
  long first;
  long last;
};

Ladder step_ladder(double most_steps_a_row) {
  return {[](double spacing_s, long n) { return spacing_s / static_cast<double>(n); }, [](long n) { return 2 * n; }, 1,
          std::max(1L, static_cast<long>(most_steps_a_row))};
}

constexpr long a_decade = 16;
constexpr Ladder rtol_ladder{
    [](double, long n) { return std::pow(10.0, -2 - static_cast<double>(n) / static_cast<double>(a_decade)); },
    [](long n) { return n + a_decade; }, 0, 200};

long finest_difference(long n) { return std::max(1L, n / 50); }

}  // namespace

Knob knob_of(const Method& method) {
  if (method.order > 0) return Knob::step;
  return method.rtol > 0 ? Knob::rtol : Knob::none;
}

void set_knob(Scenario& scenario, const Method& method, double setting) {
  switch (knob_of(method)) {
    case Knob::step:
      scenario.step_s = setting;
      break;
    case Knob::rtol:
      scenario.rtol = setting;
      scenario.atol = setting * atol_over_rtol;
      break;
    case Knob::none:
      break;
  }
}

std::string_view knob_name(Knob knob) {
  switch (knob) {
    case Knob::step:
      return "h";
    case Knob::rtol:
      return "rtol";
    case Knob::none:
      break;
  }
  return "";
}

Accuracy::Accuracy(const Scenario& scenario, double until_s, double widest_spacing_s)
    : scenario_(until(scenario, until_s, widest_spacing_s)),
      spacing_s_(scenario_.step_s),
      reference_(scenario_.planar ? reference::solve_reference(scenario_, sample_grid(scenario_))
                                  : Evaluator(scenario_).reference()) {}

double Accuracy::fitting_step(double h) const { return spacing_s_ / std::max(1.0, std::round(spacing_s_ / h)); }

Evaluator Accuracy::at(const Method& method, double setting) const {
  Scenario scenario = scenario_;
  set_knob(scenario, method, setting);
  return Evaluator(std::move(scenario), reference_);
}

Trial Accuracy::try_setting(const Method& method, double setting) const {
  Trial trial;
  trial.setting = setting;
  trial.uncertainty = uncertainty();
  try {
    Evaluator evaluator = at(method, setting);
    const Evaluation run = evaluator.evaluate(method);
    trial.error = *evaluator.measure(run, scenario_.duration_s)[searched_error(scenario_)];
    trial.steps = run.outcome.steps;
    trial.evaluations = run.outcome.evaluations;
    trial.suspect = suspicion(run.outcome);
  } catch (const MachineError&) {  // CVODE gave up at a tolerance it cannot keep
  }
  return trial;
}

double Accuracy::uncertainty() const {
  return std::ranges::max(scenario_.planar ? reference_.uncertainty_q : reference_.uncertainty_turn);
}

Search Accuracy::cheapest(const Method& method, double max_error, long most_steps) const {
  Search search;
  const Knob knob = knob_of(method);
  if (knob == Knob::none) {
    search.trial = try_setting(method, 0);
    search.reached = search.trial.keeps(max_error);
    if (!search.reached) search.why_not = "it has no step and no tolerance to change";
    return search;
  }
  const Ladder ladder = knob == Knob::rtol
                            ? rtol_ladder
                            : step_ladder(static_cast<double>(most_steps) * spacing_s_ / scenario_.duration_s);
  const auto attempt = [&](long n) { return try_setting(method, ladder.setting(spacing_s_, n)); };

  long coarse = ladder.first - 1;  // keeps it not, or was never tried
  int stalled = 0;
  for (long n = ladder.first;; n = ladder.finer(n)) {
    if (n > ladder.last) {
      search.why_not = knob == Knob::step ? "it would take more than " + std::to_string(most_steps) + " steps"
                                          : "no tighter rtol is left";
      return search;
    }
    const Trial trial = attempt(n);
    stalled = trial.error < search.trial.error || search.trial.error > divergence_rad ? 0 : stalled + 1;
    if (trial.keeps(max_error)) {
      search = {true, trial, ""};
      for (long fine = n; fine - coarse > finest_difference(fine);) {
        // Halfway between the logarithms of the steps, or of rtol.
        const long middle = knob == Knob::step ? std::clamp(std::lround(std::sqrt(static_cast<double>(coarse * fine))),
                                                            coarse + 1, fine - 1)
                                               : (coarse + fine) / 2;
        const Trial between = attempt(middle);
        if (between.keeps(max_error)) {
          search.trial = between;
          fine = middle;
        } else {
          coarse = middle;
        }
      }
      return search;
    }
    if (trial.error < search.trial.error || n == ladder.first) search.trial = trial;
    if (stalled == 2) {
      search.why_not = "the error no longer falls";
      return search;
    }
    coarse = n;
  }
}

}  // namespace odeval::catalogue
