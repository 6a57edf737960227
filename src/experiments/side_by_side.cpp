#include "experiments/side_by_side.hpp"

#include <unistd.h>

#include <algorithm>
#include <csignal>

#include "run/pool.hpp"

namespace odeval::experiments {
namespace {

std::string outcome_bytes(const Experiment& experiment, Laboratory& laboratory) {
  report::Outcome outcome;
  report::Findings findings;
  outcome.section = section_of(experiment, laboratory, findings);
  for (const auto& finding : findings.all()) outcome.findings.emplace_back(finding);
  return report::outcome_bytes(outcome);
}

report::Outcome failure(const Experiment& experiment, const std::string& why) {
  report::Outcome outcome;
  outcome.failures.push_back(std::string(experiment.name) + ": " + why);
  outcome.section = {std::string(experiment.name),
                     report::title_of(experiment.prose),
                     {report::Text{"This experiment failed, and its numbers are missing: " + why}}};
  return outcome;
}

report::Outcome outcome_of(const Experiment& experiment, const run::Result& result) {
  switch (result.kind) {
    case run::Result::Kind::done:
      return report::outcome_of(result.text);
    case run::Result::Kind::crashed:
      return failure(experiment, "its process " + result.text);
    default:
      return failure(experiment, result.text);
  }
}

}  // namespace

std::vector<report::Outcome> run_side_by_side(std::span<const Experiment> all, Laboratory& laboratory,
                                              unsigned processes,
                                              const std::function<void(const Experiment&)>& finished) {
  const run::Work work{{}, [&](long number, long, std::string_view) {
                         return outcome_bytes(all[static_cast<std::size_t>(number)], laboratory);
                       }};
  std::vector<run::Job> plan;
  for (std::size_t number = 0; number < all.size(); ++number) plan.push_back({static_cast<std::uint32_t>(number)});

  std::vector<report::Outcome> outcomes(all.size());
  const auto take = [&](long number, const run::Result& result) {
    const auto place = static_cast<std::size_t>(number);
    outcomes[place] = outcome_of(all[place], result);
    finished(all[place]);
  };
  run::PoolOptions options;
  options.processes = static_cast<int>(std::max(processes, 1U));
  if (const int signal = run_pool(work, plan, take, options)) {
    // No worker is left: this process ends as it would have without them.
    ::raise(signal);
    ::_exit(128 + signal);
  }
  return outcomes;
}

}  // namespace odeval::experiments
