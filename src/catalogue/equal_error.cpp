#include "catalogue/equal_error.hpp"

#include <deque>

#include "catalogue/timing.hpp"

namespace odeval::catalogue {
namespace {

using Begins = std::function<void(const std::string& what)>;

/// What was found of a method, and how it runs there: without an evaluator nothing keeps the error.
struct Found {
  EqualErrorRow row;
  std::optional<Evaluator> evaluator;
};

std::vector<EqualErrorRow> timed(std::deque<Found> found, std::span<const Method* const> methods,
                                 const EqualError& wanted, const Begins& begins) {
  std::vector<TimedRun> runs;
  std::vector<EqualErrorRow*> rows;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i].evaluator) continue;
    runs.push_back({&*found[i].evaluator, methods[i], 0, 0, {}});
    rows.push_back(&found[i].row);
  }
  time_in_turns(runs, wanted.repeats, [&](int round) {
    if (begins) begins(round == 0 ? "warm-up" : "round " + std::to_string(round));
  });
  for (std::size_t i = 0; i < runs.size(); ++i) {
    rows[i]->evaluations = runs[i].evaluations;
    rows[i]->repeats = wanted.repeats;
    rows[i]->median_s = runs[i].median_s();
    rows[i]->mad_s = runs[i].mad_s();
  }
  std::vector<EqualErrorRow> all;
  for (Found& one : found) all.push_back(std::move(one.row));
  return all;
}

EqualErrorRow row_of(const std::string& scenario, const Method& method) {
  EqualErrorRow row;
  row.scenario = scenario;
  row.method = method.name;
  row.knob = knob_name(knob_of(method));
  return row;
}

}  // namespace

std::vector<EqualErrorRow> at_equal_error(const Accuracy& accuracy, const std::string& scenario,
                                          std::span<const Method* const> methods, const EqualError& wanted,
                                          const Begins& begins) {
  std::deque<Found> found;
  for (const Method* method : methods) {
    if (begins) begins(std::string(method->name) + ": searching");
    const Search search = accuracy.cheapest(*method, wanted.max_error, wanted.most_steps_tried);
    Found& one = found.emplace_back(Found{row_of(scenario, *method), std::nullopt});
    one.row.error = search.trial.error;
    one.row.uncertainty = search.trial.uncertainty;
    one.row.why_not = search.why_not;
    if (!one.row.knob.empty()) one.row.setting = search.trial.setting;
    one.row.steps = search.trial.steps;
    one.row.evaluations = search.trial.evaluations;
    if (search.reached) one.evaluator.emplace(accuracy.at(*method, search.trial.setting));
  }
  return timed(std::move(found), methods, wanted, begins);
}

std::vector<EqualErrorRow> at_equal_error(SettingsSearch& search, std::span<const Method* const> methods,
                                          const EqualError& wanted, const Begins& begins) {
  std::deque<Found> found;
  for (const Method* method : methods) {
    if (begins) begins(std::string(method->name) + ": searching");
    const Recommended run = search.cheapest(*method);
    Found& one = found.emplace_back(Found{row_of(search.scenario().name, *method), std::nullopt});
    one.row.error = run.reached.front().value.value_or(std::numeric_limits<double>::infinity());
    one.row.uncertainty = run.reached.front().uncertainty.value_or(0);
    one.row.why_not = run.why_not;
    if (!one.row.knob.empty()) one.row.setting = run.setting;
    one.row.steps = run.steps;
    if (run.keeps()) one.evaluator.emplace(search.scenario(*method, {}, run.setting));
  }
  return timed(std::move(found), methods, wanted, begins);
}

}  // namespace odeval::catalogue
