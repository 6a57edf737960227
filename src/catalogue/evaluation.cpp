#include "catalogue/evaluation.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

#include "catalogue/confirmation.hpp"
#include "catalogue/self_converged.hpp"
#include "catalogue/timing.hpp"
#include "measure/body_trace.hpp"
#include "measure/cartesian_trace.hpp"
#include "measure/conditioning.hpp"
#include "measure/explosion.hpp"
#include "measure/metrics.hpp"
#include "model/generate.hpp"
#include "odeval/error.hpp"
#include "output/number.hpp"
#include "output/summary.hpp"
#include "reference/planar/generalized_trace.hpp"
#include "reference/planar/reference_solution.hpp"
#include "reference/providers.hpp"

namespace odeval::catalogue {
namespace {

Trace read(const Scenario& scenario, const SampleGrid& grid, const Motion& motion) {
  if (motion.shape().coordinates > 0) return reference::generalized_trace(scenario, grid, motion);
  return scenario.planar ? cartesian_trace(scenario, grid, motion) : body_trace(scenario, grid, motion);
}

// ODE's stored velocities belong to the middle of the step before (claim O1). The half-step start gives it those of
// t = -h/2, to first order, as bodies in the pose of t = 0 can have them. In half a step a body's velocity changes by
// h/2 M^-1 (weight + forces of the hinges). The hinges' part is M-orthogonal to every motion that they leave, so along
// these only the weight counts: qdot - h/2 M(q)^-1 G(q), with the accelerations at rest. The velocity products in the
// joint accelerations come from the hinges' own turning, which ODE does itself: it takes the velocities of the old pose
// through the hinges of the new one. Two links that start at speed tell the difference, which is of first order.
std::unique_ptr<Simulation> make_as_asked(const Method& method, const Scenario& scenario, const SampleGrid& grid) {
  if (!has_half_step_start(method) || scenario.ode.start != Start::half_step) {
    return method.make(scenario, grid);
  }
  if (!scenario.planar) return method.make(reference::half_a_step_earlier(scenario), grid);
  Scenario earlier = scenario;
  const PlanarView& view = *scenario.planar;
  const std::vector<double> at_rest(view.qd0.size(), 0.0);
  const std::vector<double> acceleration = reference::joint_accelerations(scenario, view.q0, at_rest);
  change_planar(earlier, [&](PlanarView& half_a_step) {
    for (std::size_t i = 0; i < acceleration.size(); ++i) half_a_step.qd0[i] -= acceleration[i] * scenario.step_s / 2;
  });
  return method.make(earlier, grid);
}

/// By who knows the motion, or ODE itself where he finds that he does not.
Reference solve(const Scenario& scenario, const SampleGrid& grid) {
  const ReferenceProvider& provider = provider_of(scenario);
  try {
    Reference solved = provider.solve(scenario, grid);
    if (provider.to_confirm) confirm(solved, scenario, grid);
    return solved;
  } catch (const UserError& why) {
    if (provider.method.empty() || !can_self_converge(scenario)) throw;
    Reference own = self_converged(scenario, grid);
    own.origin += std::string(" (") + why.what() + ")";
    return own;
  }
}

Suspects* keeper = nullptr;  // the youngest that lives

}  // namespace

Suspects::Suspects() : outer_(std::exchange(keeper, this)) {}
Suspects::~Suspects() { keeper = outer_; }

void Suspects::note(const Evaluation& run, const Scenario& scenario) {
  const std::string why = suspicion(run.outcome);
  if (keeper == nullptr || why.empty()) return;
  std::vector<std::string>& lines = keeper->lines_;
  std::string line =
      scenario.name + " in " + std::string(run.method->name) + ", h = " + number_text(scenario.step_s) + " s: " + why;
  if (std::ranges::find(lines, line) == lines.end()) lines.push_back(std::move(line));
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Evaluator::Evaluator(Scenario scenario) : scenario_(std::move(scenario)), grid_(sample_grid(scenario_)) {}

Evaluator::Evaluator(Scenario scenario, Reference reference)
    : Evaluator(std::move(scenario), std::make_shared<const Reference>(std::move(reference))) {}

Evaluator::Evaluator(Scenario scenario, std::shared_ptr<const Reference> reference) : Evaluator(std::move(scenario)) {
  reference_ = std::move(reference);
}

const Reference& Evaluator::reference() {
  if (!reference_) {
    Reference solved = solve(scenario_, grid_);
    add_joint_columns(scenario_, solved.trace);
    reference_ = std::make_shared<const Reference>(std::move(solved));
  }
  OwnLimits::note(*reference_, scenario_);
  return *reference_;
}

std::unique_ptr<Simulation> Evaluator::make(const Method& method) const {
  return make_as_asked(method, scenario_, grid_);
}

Evaluation Evaluator::evaluate(const Method& method) { return evaluate(method, scenario_.ode); }

Evaluation Evaluator::evaluate(const Method& method, const OdeSettings& ode) {
  Scenario changed = scenario_;
  changed.ode = ode;
  const std::unique_ptr<Simulation> simulation = make_as_asked(method, changed, grid_);
  Motion motion(simulation->shape(), static_cast<std::size_t>(grid_.rows));
  const double start = cpu_seconds();
  Outcome outcome = simulation->run(Recorder(motion));
  const double cpu_s = cpu_seconds() - start;
  Trace trace = read(scenario_, grid_, motion);
  compare(trace, reference());
  if (const auto row = explosion(scenario_, grid_, trace, reference()); row && !outcome.diverged) {
    outcome.diverged = true;
    outcome.reason = "exploded: from t = " + number_text(trace.t[*row]) +
                     " s on bodies have more than 100 times the energy that the true motion or a fall could give them";
  }
  if (scenario_.planar) add_conditioning(trace, scenario_, method.inverts);
  Evaluation run{&method, std::move(outcome), std::move(trace), cpu_s};
  Suspects::note(run, scenario_);
  return run;
}

Metrics Evaluator::measure(const Evaluation& evaluation, double until_s) {
  return odeval::measure(evaluation.trace, &reference(), until_s, &evaluation.outcome.impacts);
}

double Evaluator::stepping_s(const Evaluation& evaluation, double (*clock)()) const {
  const Method& method = *evaluation.method;
  if (method.order > 0 && !method.tells) return evaluation.cpu_s;
  const std::unique_ptr<Simulation> simulation = make(method);
  const double start = clock();
  simulation->run(Recorder());
  const double once = clock() - start;
  constexpr double unseen_s = 5e-4;  // cold caches and the clock would show in less
  if (once > unseen_s) return once;
  TimedRun timed{this, &method, 0, 0, {}};
  time_in_turns(std::span(&timed, 1), 1, {}, clock);
  return timed.median_s();
}

}  // namespace odeval::catalogue
