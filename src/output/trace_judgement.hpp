#pragma once
// What `odeval judge` says of a trace.
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "odeval/metrics.hpp"
#include "output/trace_csv.hpp"

namespace odeval {

/// A row a quantity that has a value, a column a time; each list of metrics is taken until another time.
std::string judgement_table(std::span<const Metrics> metrics);
std::string judgement_json(std::span<const Metrics> metrics);

/// The largest difference of two runs in the columns of one kind ("q", "x", "vx"), until each time.
struct TraceDifference {
  std::string column;
  std::string_view unit;
  std::map<double, double> until;
};

/// Of columns that both have, whatever their names; the second has `every` rows for each of the first.
std::vector<TraceDifference> differences_of(const CsvColumns& whole, const CsvColumns& half, std::size_t every,
                                            std::span<const double> times);
/// With what they mean at first order.
std::string differences_table(std::span<const TraceDifference> differences);
std::string differences_json(std::span<const TraceDifference> differences);

}  // namespace odeval
