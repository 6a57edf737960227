#include "output/trace_judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "output/json_number.hpp"
#include "output/table.hpp"

namespace odeval {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> header_of(const std::vector<double>& times, const std::string& first) {
  std::vector<std::string> header{first};
  for (const double t : times) header.push_back(fmt::format("until {:.4g} s", t));
  header.emplace_back("");
  return header;
}

std::string align_of(std::size_t times) { return "l" + std::string(times, 'r') + "l"; }

bool has_value(std::span<const Metrics> metrics, quantity::Id id) {
  return std::ranges::any_of(metrics, [id](const Metrics& one) { return one[id].has_value(); });
}

}  // namespace

std::string judgement_table(std::span<const Metrics> metrics) {
  std::vector<double> times;
  for (const Metrics& one : metrics) times.push_back(one.until_s);
  TextTable table(align_of(times.size()), header_of(times, "quantity"));
  for (const Quantity& row : quantities) {
    if (row.scope == Scope::reference || !has_value(metrics, row.id)) continue;
    std::vector<std::string> cells{std::string(row.name)};
    for (const Metrics& one : metrics) cells.push_back(with_uncertainty(one[row.id], uncertainty_of(row.id, one)));
    cells.emplace_back(row.unit);
    table.add(std::move(cells));
  }
  return table.text();
}

std::string judgement_json(std::span<const Metrics> metrics) {
  Json list = Json::array();
  for (const Metrics& one : metrics) {
    Json row = {{"until", one.until_s}};
    for (const Quantity& what : quantities) {
      if (has_value(metrics, what.id)) row[std::string(what.name)] = one[what.id] ? json_number(*one[what.id]) : Json();
    }
    list.push_back(std::move(row));
  }
  return list.dump(2) + "\n";
}

std::vector<TraceDifference> differences_of(const CsvColumns& whole, const CsvColumns& half, std::size_t every,
                                            std::span<const double> times) {
  std::vector<TraceDifference> differences;
  const auto clock = std::ranges::find(whole.header, "t") - whole.header.begin();
  const Column& t = whole.columns[static_cast<std::size_t>(clock)];
  for (std::size_t i = 0; i < whole.header.size(); ++i) {
    const std::string& name = whole.header[i];
    const auto other = std::ranges::find(half.header, name);
    const TraceColumn* kind = trace_column_of(name);
    if (name == "t" || other == half.header.end() || (kind != nullptr && kind->exact)) continue;
    const Column& finer = half.columns[static_cast<std::size_t>(other - half.header.begin())];
    // q1 and q2 are angles, vx1 and vx2 velocities: one row for all of them. What no trace has is a row of its own.
    const std::string family = kind == nullptr ? name : name.substr(0, name.find_first_of("0123456789"));
    auto place = std::ranges::find(differences, family, &TraceDifference::column);
    if (place == differences.end()) place = differences.insert(place, {family, kind == nullptr ? "" : kind->unit, {}});
    for (const double until : times) {
      double& largest = place->until[until];
      for (std::size_t row = 0; row < t.size() && t[row] <= until * (1 + 1e-9) && row * every < finer.size(); ++row) {
        const double apart = std::fabs(whole.columns[i][row] - finer[row * every]);
        if (!(apart <= largest)) largest = apart;
      }
    }
  }
  return differences;
}

std::string differences_table(std::span<const TraceDifference> differences) {
  std::vector<double> times;
  for (const auto& [t, largest] : differences.front().until) times.push_back(t);
  TextTable table(align_of(times.size()), header_of(times, "difference"));
  for (const TraceDifference& one : differences) {
    std::vector<std::string> cells{one.column};
    for (const auto& [t, largest] : one.until) cells.push_back(three_digits(largest));
    cells.emplace_back(one.unit);
    table.add(std::move(cells));
  }
  return table.text() +
         "\ndifference  largest of a value from the run at half the step; of a method of first order, as ODE's steps "
         "are, the\n"
         "            error of the first run is about twice that and that of the second about as large, where halving "
         "the\n"
         "            step once more halves it: two runs alone can not tell ('odeval audit' can)\n";
}

std::string differences_json(std::span<const TraceDifference> differences) {
  Json list = Json::array();
  for (const TraceDifference& one : differences) {
    Json until = Json::array();
    for (const auto& [t, largest] : one.until) until.push_back({{"t", t}, {"difference", json_number(largest)}});
    list.push_back({{"column", one.column}, {"unit", one.unit}, {"until", std::move(until)}});
  }
  return list.dump(2) + "\n";
}

}  // namespace odeval
