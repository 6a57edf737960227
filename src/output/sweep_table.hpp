#pragma once
// The table of a sweep: a row a run.
#include <span>
#include <string>
#include <vector>

#include "odeval/metrics.hpp"
#include "odeval/motion.hpp"

namespace odeval {

/// The names of what a run that went through leaves: steps, evaluations, messages and every metric of the table.
std::vector<std::string> result_columns();

/// Those values as cells with commas between; empty where a metric has no meaning for the run.
std::string result_cells(const Outcome& outcome, const Metrics& metrics);

/// `run`, the keys of the grid, `status`, `reason` and the columns of results, with a line feed.
std::string sweep_header(std::span<const std::string> keys, std::span<const std::string> columns);

/// A line under that header. `cells` of a run without results may be empty.
std::string sweep_line(long run, std::span<const std::string> values, std::string_view status,
                       const std::string& reason, const std::string& cells, std::size_t columns);

/// The cell of that number in a list of cells, or not-a-number where it is empty.
double number_in(std::string_view cells, std::size_t place);

}  // namespace odeval
