#include "output/sweep_table.hpp"

#include <fmt/format.h>

#include <charconv>
#include <limits>

#include "output/csv_cell.hpp"
#include "output/number.hpp"

namespace odeval {
std::vector<std::string> result_columns() {
  std::vector<std::string> columns{"steps", "evaluations", "messages"};
  for (const Quantity& row : quantities) columns.emplace_back(row.name);
  return columns;
}

std::string result_cells(const Outcome& outcome, const Metrics& metrics) {
  std::string cells = fmt::format("{},{},{}", outcome.steps, outcome.evaluations, outcome.messages);
  for (const Quantity& row : quantities) {
    const std::optional<double> value = metrics[row.id];
    cells += ',' + (value ? number_text(*value) : "");
  }
  return cells;
}

std::string sweep_header(std::span<const std::string> keys, std::span<const std::string> columns) {
  std::string line = "run";
  for (const std::string& key : keys) line += ',' + csv_cell(key);
  line += ",status,reason";
  for (const std::string& column : columns) line += ',' + column;
  return line + '\n';
}

std::string sweep_line(long run, std::span<const std::string> values, std::string_view status,
                       const std::string& reason, const std::string& cells, std::size_t columns) {
  std::string line = std::to_string(run);
  for (const std::string& value : values) line += ',' + csv_cell(value);
  line += fmt::format(",{},{},", status, csv_cell(reason));
  return line + (cells.empty() ? std::string(columns - 1, ',') : cells) + '\n';
}

double number_in(std::string_view cells, std::size_t place) {
  for (; place > 0; --place) {
    const std::size_t comma = cells.find(',');
    if (comma == std::string_view::npos) return std::numeric_limits<double>::quiet_NaN();
    cells.remove_prefix(comma + 1);
  }
  cells = cells.substr(0, cells.find(','));
  double number = 0;
  const auto [stop, error] = std::from_chars(cells.data(), cells.data() + cells.size(), number);
  const bool whole = !cells.empty() && error == std::errc() && stop == cells.data() + cells.size();
  return whole ? number : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace odeval
