#pragma once
// What two files of one place among the results may differ by; comparison.hpp says what and why.
#include <array>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "odeval/quantity.hpp"
#include "output/comparison.hpp"
#include "output/trace_csv.hpp"

namespace odeval {

/// Where a file stands among the results.
enum class Kind { summary, trace, summaries, report, verdicts, sweep, timing, other };

struct Place {
  Kind kind = Kind::other;
  std::string scenario;
  std::string method;
};

Place place_of(const std::filesystem::path& file);

/// The bounds that a summary states, by the time until which each holds.
class Uncertainty {
 public:
  explicit Uncertainty(const nlohmann::ordered_json* summary);  // null: states none

  double at(quantity::Id bound, double t) const;

 private:
  std::array<std::map<double, double>, quantity::count> until_;
};

/// A word or a number as the tables show it; null: absent.
std::string shown_json(const nlohmann::ordered_json* json);

// Each adds what differs, and says in a line how the two compare.

void compare_summaries(const Place& place, const nlohmann::ordered_json& json_a, const nlohmann::ordered_json& json_b,
                       FileComparison& file);

/// Throws UserError for what is no trace.
void compare_traces(const Place& place, const CsvColumns& a, const CsvColumns& b, const Uncertainty& of_a,
                    const Uncertainty& of_b, FileComparison& file);

/// Cells that differ; those of the first `columns` columns alone, where that is asked for.
void compare_tables(const Place& place, const std::string& text_a, const std::string& text_b, FileComparison& file,
                    std::size_t columns = std::numeric_limits<std::size_t>::max());

}  // namespace odeval
