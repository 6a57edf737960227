#pragma once
// Tolerances as `odeval check` and `odeval report --check` hold them against runs.
#include <functional>
#include <span>
#include <vector>

#include "catalogue/evaluation.hpp"
#include "output/checks.hpp"

namespace odeval::cli {

/// A run of a method in the evaluator's scenario, made now or before; stays.
using RunOf = std::function<const catalogue::Evaluation&(const catalogue::Method&)>;

/// Every tolerance of an evaluator's scenario.
std::vector<CheckRow> check_runs(catalogue::Evaluator& evaluator, const RunOf& run_of);

/// The same with runs of its own, each over the scenario's duration or until the last tolerance.
std::vector<CheckRow> check_scenario(Scenario scenario);

/// The exit status: 1 where a tolerance failed or nobody knows.
int status_of(std::span<const CheckRow> rows);

}  // namespace odeval::cli
