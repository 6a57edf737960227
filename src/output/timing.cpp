#include "output/timing.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "output/json_number.hpp"
#include "output/number.hpp"
#include "output/table.hpp"

namespace odeval {
namespace {

using nlohmann::ordered_json;

template <class Number>
std::string or_dash(const std::optional<Number>& number) {
  return number ? std::to_string(*number) : "-";
}

std::optional<double> times_1e3(const std::optional<double>& seconds) {
  return seconds ? std::optional(1e3 * *seconds) : std::nullopt;
}

template <class Number>
ordered_json or_null(const std::optional<Number>& number) {
  if (!number) return nullptr;
  if constexpr (std::is_floating_point_v<Number>) return json_number(*number);
  return *number;
}

ordered_json object_of(const std::vector<std::pair<std::string, std::string>>& texts) {
  ordered_json object = ordered_json::object();
  for (const auto& [name, text] : texts) object[name] = text;
  return object;
}

std::string file_of(const ordered_json& json) {
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

/// What the row's time is in units of that of the report's case 5, ODE.
std::optional<double> over_ode(const std::vector<Table52Row>& rows, std::optional<double> Table52Row::*seconds,
                               const Table52Row& row) {
  for (const Table52Row& other : rows) {
    if (other.number == 5 && other.*seconds && row.*seconds) return *(row.*seconds) / *(other.*seconds);
  }
  return std::nullopt;
}

}  // namespace

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

std::string table_5_2_text(const std::vector<Table52Row>& rows) {
  TextTable table("rllrrrlrrrr",
                  {"case", "equations", "solver", "steps 2010", "s", "x ODE", "method", "steps", "ms", "±", "x ODE"});
  for (const Table52Row& row : rows) {
    table.add({or_dash(row.number), row.equations, row.solver, or_dash(row.steps_2010), three_digits(row.seconds_2010),
               three_digits(over_ode(rows, &Table52Row::seconds_2010, row)), row.method, or_dash(row.steps),
               three_digits(times_1e3(row.median_s)), three_digits(times_1e3(row.mad_s)),
               three_digits(over_ode(rows, &Table52Row::median_s, row))});
  }
  return table.text();
}

std::string equal_error_table(const std::vector<EqualErrorRow>& rows) {
  TextTable table("lllrrrrrl",
                  {"scenario", "method", "setting", "error, rad", "steps", "evaluations", "median, ms", "±", ""});
  for (const EqualErrorRow& row : rows) {
    const bool reached = row.why_not.empty();
    const std::string setting = row.setting ? row.knob + " = " + three_digits(row.setting) : "-";
    table.add({row.scenario, row.method, setting, with_uncertainty(row.error, row.uncertainty),
               std::to_string(row.steps), row.evaluations > 0 ? std::to_string(row.evaluations) : "-",
               reached ? three_digits(1e3 * row.median_s) : "-", reached ? three_digits(1e3 * row.mad_s) : "-",
               reached ? "" : "not reached: " + row.why_not});
  }
  return table.text();
}

std::string equal_error_csv(const std::vector<EqualErrorRow>& rows, double max_error, double until_s) {
  std::string text =
      "scenario,method,max_error,until,reached,knob,setting,error,uncertainty,steps,evaluations,repeats,median_s,mad_"
      "s\n";
  for (const EqualErrorRow& row : rows) {
    const bool timed = row.repeats > 0;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", row.scenario, row.method, number_text(max_error),
                        number_text(until_s), row.why_not.empty() ? 1 : 0, row.knob,
                        row.setting ? number_text(*row.setting) : "", number_text(row.error),
                        number_text(row.uncertainty), row.steps, row.evaluations, row.repeats,
                        timed ? number_text(row.median_s) : "", timed ? number_text(row.mad_s) : "");
  }
  return text;
}

std::string timing_json(const std::vector<TimingRow>& rows, const std::vector<Table52Row>& table_5_2,
                        const std::vector<std::pair<std::string, std::string>>& environment) {
  ordered_json json{{"environment", object_of(environment)}, {"rows", ordered_json::array()}};
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
  for (const Table52Row& row : table_5_2) {
    json["table_5_2"].push_back({{"case", or_null(row.number)},
                                 {"equations", row.equations},
                                 {"solver", row.solver},
                                 {"steps_2010", or_null(row.steps_2010)},
                                 {"seconds_2010", or_null(row.seconds_2010)},
                                 {"method", row.method},
                                 {"steps", or_null(row.steps)},
                                 {"median_s", or_null(row.median_s)},
                                 {"mad_s", or_null(row.mad_s)}});
  }
  return file_of(json);
}

std::string equal_error_json(const std::vector<EqualErrorRow>& rows, double max_error, double until_s,
                             const std::vector<std::pair<std::string, std::string>>& environment) {
  ordered_json json{{"environment", object_of(environment)},
                    {"max_error", json_number(max_error)},
                    {"until", json_number(until_s)},
                    {"rows", ordered_json::array()}};
  for (const EqualErrorRow& row : rows) {
    const bool timed = row.repeats > 0;
    json["rows"].push_back({{"scenario", row.scenario},
                            {"method", row.method},
                            {"reached", row.why_not.empty()},
                            {"why_not", row.why_not},
                            {"knob", row.knob},
                            {"setting", or_null(row.setting)},
                            {"error", json_number(row.error)},
                            {"uncertainty", json_number(row.uncertainty)},
                            {"steps", row.steps},
                            {"evaluations", row.evaluations},
                            {"repeats", row.repeats},
                            {"median_s", or_null(timed ? std::optional(row.median_s) : std::nullopt)},
                            {"mad_s", or_null(timed ? std::optional(row.mad_s) : std::nullopt)}});
  }
  return file_of(json);
}

}  // namespace odeval
