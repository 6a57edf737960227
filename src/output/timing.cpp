#include "output/timing.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "output/json_number.hpp"
#include "output/number.hpp"
#include "output/table.hpp"

namespace odeval {

std::string timing_table(const std::vector<TimingRow>& rows) {
  TextTable table("llrrrrrr", {"scenario", "method", "h, s", "steps", "median, ms", "±", "ns/step", "times real time"});
  for (const TimingRow& row : rows) {
    table.add({row.scenario, row.method, three_digits(row.step_s), std::to_string(row.steps),
               three_digits(1e3 * row.median_s), three_digits(1e3 * row.mad_s), three_digits(row.ns_per_step),
               three_digits(row.realtime_factor)});
  }
  return table.text();
}

std::string timing_csv(const std::vector<TimingRow>& rows) {
  std::string text = "scenario,method,h,steps,simulated_s,repeats,median_s,mad_s,min_s,ns_per_step,realtime_factor\n";
  for (const TimingRow& row : rows) {
    text +=
        fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", row.scenario, row.method, number_text(row.step_s), row.steps,
                    number_text(row.simulated_s), row.repeats, number_text(row.median_s), number_text(row.mad_s),
                    number_text(row.min_s), number_text(row.ns_per_step), number_text(row.realtime_factor));
  }
  return text;
}

std::string timing_json(const std::vector<TimingRow>& rows,
                        const std::vector<std::pair<std::string, std::string>>& environment) {
  nlohmann::ordered_json json;
  json["environment"] = nlohmann::ordered_json::object();
  for (const auto& [name, text] : environment) json["environment"][name] = text;
  json["rows"] = nlohmann::ordered_json::array();
  for (const TimingRow& row : rows) {
    json["rows"].push_back({{"scenario", row.scenario},
                            {"method", row.method},
                            {"h", json_number(row.step_s)},
                            {"steps", row.steps},
                            {"simulated_s", json_number(row.simulated_s)},
                            {"repeats", row.repeats},
                            {"median_s", json_number(row.median_s)},
                            {"mad_s", json_number(row.mad_s)},
                            {"min_s", json_number(row.min_s)},
                            {"ns_per_step", json_number(row.ns_per_step)},
                            {"realtime_factor", json_number(row.realtime_factor)}});
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace odeval
