#include "output/checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "output/json_number.hpp"
#include "output/table.hpp"

namespace odeval {
namespace {

using Json = nlohmann::ordered_json;

std::string verdict_of(const CheckRow& row) {
  switch (row.verdict) {
    case CheckRow::Verdict::kept:
      return "kept";
    case CheckRow::Verdict::failed:
      return "FAILED";
    case CheckRow::Verdict::undecided:
      return "UNDECIDED: within the uncertainty";
    case CheckRow::Verdict::left_out:
      break;
  }
  return "not in this build";
}

Json json_of(const std::optional<double>& number) { return number ? json_number(*number) : Json(); }

}  // namespace

std::string checks_table(const std::vector<CheckRow>& rows) {
  TextTable table("lllrrrrl", {"scenario", "method", "metric", "until, s", "measured", "at least", "at most", ""});
  for (const CheckRow& row : rows) {
    const Tolerance& tolerance = row.tolerance;
    table.add({row.scenario, tolerance.method, tolerance.metric, three_digits(tolerance.until_s),
               with_uncertainty(row.measured, row.reference_uncertainty), three_digits(tolerance.at_least),
               three_digits(tolerance.at_most),
               verdict_of(row) + (row.reference.empty() ? "" : ", " + row.reference) +
                   (row.suspect.empty() ? "" : "; suspect: " + row.suspect)});
  }
  const auto count = [&](CheckRow::Verdict verdict) { return std::ranges::count(rows, verdict, &CheckRow::verdict); };
  return table.text() + fmt::format("\n{} tolerances: {} kept, {} failed, {} undecided, {} left out\n", rows.size(),
                                    count(CheckRow::Verdict::kept), count(CheckRow::Verdict::failed),
                                    count(CheckRow::Verdict::undecided), count(CheckRow::Verdict::left_out));
}

std::string checks_json(const std::vector<CheckRow>& rows) {
  Json list = Json::array();
  for (const CheckRow& row : rows) {
    list.push_back({{"scenario", row.scenario},
                    {"method", row.tolerance.method},
                    {"metric", row.tolerance.metric},
                    {"until", row.tolerance.until_s},
                    {"measured", json_of(row.measured)},
                    {"reference_uncertainty", json_of(row.reference_uncertainty)},
                    {"at_least", json_of(row.tolerance.at_least)},
                    {"at_most", json_of(row.tolerance.at_most)},
                    {"verdict", verdict_of(row)}});
    if (!row.reference.empty()) list.back()["reference"] = row.reference;
    if (!row.suspect.empty()) list.back()["suspect"] = row.suspect;
  }
  return list.dump(2) + '\n';
}

}  // namespace odeval
