#include "catalogue/equal_error.hpp"

#include "catalogue/timing.hpp"

namespace odeval::catalogue {

std::vector<EqualErrorRow> at_equal_error(const Accuracy& accuracy, const std::string& scenario,
                                          std::span<const Method* const> methods, const EqualError& wanted,
                                          const std::function<void(const std::string& what)>& begins) {
  std::vector<EqualErrorRow> rows;
  std::vector<Evaluator> evaluators;
  evaluators.reserve(methods.size());  // timed runs point at them
  std::vector<TimedRun> runs;
  std::vector<std::size_t> row_of_run;
  for (const Method* method : methods) {
    if (begins) begins(std::string(method->name) + ": searching");
    const Search search = accuracy.cheapest(*method, wanted.max_error, wanted.most_steps_tried);
    EqualErrorRow row{scenario,      std::string(method->name), "", {}, search.trial.error, search.trial.uncertainty,
                      search.why_not};
    row.knob = knob_name(knob_of(*method));
    if (!row.knob.empty()) row.setting = search.trial.setting;
    row.steps = search.trial.steps;
    row.evaluations = search.trial.evaluations;
    if (search.reached) {
      evaluators.push_back(accuracy.at(*method, search.trial.setting));
      runs.push_back({&evaluators.back(), method, 0, 0, {}});
      row_of_run.push_back(rows.size());
    }
    rows.push_back(std::move(row));
  }
  time_in_turns(runs, wanted.repeats, [&](int round) {
    if (begins) begins(round == 0 ? "warm-up" : "round " + std::to_string(round));
  });
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EqualErrorRow& row = rows[row_of_run[i]];
    row.repeats = wanted.repeats;
    row.median_s = runs[i].median_s();
    row.mad_s = runs[i].mad_s();
  }
  return rows;
}

}  // namespace odeval::catalogue
