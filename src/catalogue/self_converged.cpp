#include "catalogue/self_converged.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "audit/extrapolation.hpp"
#include "catalogue/methods.hpp"
#include "measure/body_trace.hpp"
#include "odeval/error.hpp"
#include "output/number.hpp"
#include "output/table.hpp"
#include "reference/providers.hpp"

namespace odeval::catalogue {
namespace {

const std::vector<int> refinements{1, 2, 4, 8};

constexpr std::string_view engine = "ode-step-double";

/// Whether the file asks for ERP and CFM as numbers.
bool keeps_numbers(const Scenario& scenario) {
  const std::pair<std::string, SettingValue> asked{"limit", std::string("numbers")};
  return std::ranges::find(scenario.definition, asked) != scenario.definition.end();
}

Scenario refined(Scenario scenario, int parts) {
  OdeSettings& ode = scenario.ode;
  const double h = scenario.step_s;
  if (!keeps_numbers(scenario) && !ode.spring && ode.cfm > 0) ode.spring = spring_of(ode.softness(h), h);
  for (Contact& contact : scenario.mechanism.contacts) {
    if (keeps_numbers(scenario) || !contact.softness || contact.softness->cfm == 0) continue;
    contact.softness = softness_of(spring_of(*contact.softness, h), h / parts);
  }
  scenario.step_s = h / parts;
  scenario.sample_s = h;
  ode.start = Start::as_given;
  return scenario;
}

Trace run(const Scenario& scenario, const SampleGrid& grid, int parts) {
  const Scenario finer = refined(scenario, parts);
  const SampleGrid steps{grid.step_s / parts, grid.stride * parts, grid.rows};
  const std::unique_ptr<Simulation> simulation = find_method(engine).make(finer, steps);
  Motion motion(simulation->shape(), static_cast<std::size_t>(steps.rows));
  const Outcome outcome = simulation->run(Recorder(motion));
  if (outcome.diverged) {
    throw UserError(scenario.file + ": there is no reference: ODE's own run at h/" + std::to_string(parts) +
                    " of h = " + number_text(scenario.step_s) + " s blew up: " + outcome.reason +
                    "; take a shorter step");
  }
  if (outcome.messages > 0) {
    throw UserError(scenario.file + ": there is no reference: ODE's own run at h/" + std::to_string(parts) +
                    " of h = " + number_text(scenario.step_s) + " s is not to be believed, it made " +
                    std::to_string(outcome.messages) + " complaints, the first: " + outcome.first_message +
                    "; start clear of what does not leave each other");
  }
  return body_trace(scenario, grid, motion);
}

/// Some columns of a body at a step of 0, row by row, as far as the rows before tell how the runs come together.
class Limit {
 public:
  /// `metric` is what a unit of the columns' distance means.
  explicit Limit(double metric) : metric_(metric) {}

  /// The limit of a row goes into the last run's place; returns what it may be off by.
  template <std::size_t N>
  double take(const std::array<std::array<Column, N>*, 4>& runs, std::size_t row) {
    values_.clear();
    for (const auto* run : runs) {
      for (const Column& column : *run) values_.push_back(column[row]);
    }
    spread_.add(values_.data(), N, metric_);
    const std::vector<double> limit = audit::extrapolated(values_, refinements, spread_.best_degree());
    for (std::size_t i = 0; i < N; ++i) (*runs.back())[i][row] = limit[i];
    return spread_.error(refinements.size() - 1).uncertainty;
  }

  /// Whether the runs come nearer to each other, so far, as their steps get shorter.
  bool converges() const { return spread_.error(refinements.size() - 1).convergence != audit::Convergence::none; }

 private:
  double metric_;
  audit::Spread spread_{refinements};
  std::vector<double> values_;
};

/// All that is told of a body.
struct BodyLimit {
  Limit position{1};
  Limit turn{1 / std::sqrt(2.0)};  // two attitudes a small angle a apart differ by sqrt(2) a
  Limit velocity{1};
  Limit spin{1};
};

const ReferenceProvider own{"", can_self_converge, self_converged};

}  // namespace

bool can_self_converge(const Scenario& scenario) {
  const Mechanism& mechanism = scenario.mechanism;
  return scenario.named && !mechanism.contacts.empty() && std::ranges::none_of(mechanism.joints, &Joint::sampled) &&
         does(find_method(engine), scenario);
}

Reference self_converged(const Scenario& scenario, const SampleGrid& grid) {
  std::array<Trace, 4> runs;
  for (std::size_t i = 0; i < runs.size(); ++i) runs[i] = run(scenario, grid, refinements[i]);
  Reference reference;
  const std::size_t bodies = scenario.mechanism.bodies.size();
  std::vector<BodyLimit> limits(bodies);
  std::optional<double> lost_from;
  for (std::size_t row = 0; row < runs.back().rows(); ++row) {
    double position = 0, turn = 0, spin = 0;
    for (std::size_t i = 0; i < bodies; ++i) {
      const auto of = [&](auto part) {
        return std::array{&(runs[0].bodies[i].*part), &(runs[1].bodies[i].*part), &(runs[2].bodies[i].*part),
                          &(runs[3].bodies[i].*part)};
      };
      position = std::fmax(position, limits[i].position.take(of(&BodyColumns::position), row));
      turn = std::fmax(turn, limits[i].turn.take(of(&BodyColumns::rotation), row));
      spin = std::fmax(spin, limits[i].spin.take(of(&BodyColumns::spin), row));
      limits[i].velocity.take(of(&BodyColumns::velocity), row);
    }
    const auto converges = [](const BodyLimit& limit) { return limit.position.converges() && limit.turn.converges(); };
    if (!lost_from && !std::ranges::all_of(limits, converges)) lost_from = grid.time(static_cast<long>(row));
    reference.uncertainty_position.push_back(position);
    reference.uncertainty_turn.push_back(turn);
    reference.uncertainty_spin.push_back(spin);
  }
  reference.trace = std::move(runs.back());
  reference.origin = self_converged_origin;
  reference.origin += ": dWorldStep's own limit, from h, h/2, h/4 and h/8, with ERP and CFM as ";
  reference.origin += keeps_numbers(scenario) ? "numbers" : "springs";
  reference.origin += "; uncertainty from the spread";
  if (lost_from) {
    reference.origin +=
        ", which does not fall with the step from t = " + three_digits(*lost_from) + " s on: not converged";
  }
  return reference;
}

namespace {

OwnLimits* keeper = nullptr;  // the youngest that lives

}  // namespace

OwnLimits::OwnLimits() : outer_(std::exchange(keeper, this)) {}
OwnLimits::~OwnLimits() { keeper = outer_; }

void OwnLimits::note(const Reference& reference, const Scenario& scenario) {
  if (keeper == nullptr || mark_of(reference).empty()) return;
  std::string line = scenario.name + " (" + reference.origin + ")";
  std::vector<std::string>& lines = keeper->lines_;
  if (std::ranges::find(lines, line) == lines.end()) lines.push_back(std::move(line));
}

std::string_view mark_of(const Reference& reference) {
  return reference.origin.starts_with(self_converged_origin) ? self_converged_origin : std::string_view();
}

const ReferenceProvider& provider_of(const Scenario& scenario) {
  const bool known = std::ranges::any_of(
      reference::providers(), [&](const ReferenceProvider& provider) { return provider.supports(scenario); });
  return !known && can_self_converge(scenario) ? own : reference::provider_for(scenario);
}

}  // namespace odeval::catalogue
