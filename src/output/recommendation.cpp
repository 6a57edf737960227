#include "output/recommendation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "output/csv_cell.hpp"
#include "output/json_number.hpp"
#include "output/number.hpp"
#include "output/table.hpp"
#include "output/terminal.hpp"

namespace odeval {
namespace {

using Json = nlohmann::ordered_json;
using Kind = Recommended::Kind;

const Quantity& quantity_of(const Target& target) { return quantities[target.id]; }

/// "step = 0.00862, ode.erp = 1"
std::string settings_text(const Recommended& run) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (!run.knob.empty()) add(run.knob + " = " + three_digits(run.setting));
  for (const Change& change : run.changes) add(change.key + " = " + change.value);
  return text.empty() ? "-" : text;
}

std::string reached_text(const Reached& reached) { return with_uncertainty(reached.value, reached.uncertainty); }

std::string worth_text(const Change& change) {
  if (!change.steps_without) {
    return fmt::format("without it: none that was tried, up to {} steps", change.most_steps_without);
  }
  return fmt::format("without it: {} steps, {:.3g} times the cost", *change.steps_without, change.cost_without);
}

/// A line for each setting to change: "ode.erp    0.2 -> 1    without it: 380 steps, 1.6 times the cost".
std::string changes_text(const Recommended& run) {
  TextTable table("llll", {"", "", "", ""});
  if (!run.knob.empty()) {
    table.add({run.knob, number_text(run.before), "-> " + number_text(run.setting), ""});
  }
  for (const Change& change : run.changes)
    table.add({change.key, change.before, "-> " + change.value, worth_text(change)});
  const std::string text = table.text();
  return text.substr(text.find('\n') + 1);  // without the header
}

std::string indented(const std::string& text) {
  std::string lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines += "  " + text.substr(begin, end - begin) + '\n';
    begin = end + 1;
  }
  return lines;
}

/// "; 0.00987 at the worst of 8 steps nearby", and what share of the budget they keep if not all of it.
std::string nearby_text(const Recommended& run, std::size_t target) {
  if (run.nearby.tried == 0) return "";
  std::string text = fmt::format("; {} at the worst of {} {}s nearby", three_digits(run.nearby.worst[target]),
                                 run.nearby.tried, run.knob);
  if (run.nearby.share < 1) {
    text += fmt::format(", which keep {:.3g} % of the budget for those not tried", 100 * run.nearby.share);
  }
  return text;
}

/// "ode.cfm=1e-06, ode.iterations=5 and 3 more"
std::string first_of(const std::vector<std::string>& names) {
  constexpr std::size_t few = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(few, names.size()); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() <= few ? text : fmt::format("{} and {} more", text, names.size() - few);
}

/// What a search that spent its steps looked at, what not, and what to pass for more.
std::string effort_text(const Effort& effort) {
  constexpr long most = 100'000'000;  // that --most-steps takes
  const std::size_t all = static_cast<std::size_t>(effort.settings) + effort.cut.size() + effort.untried.size();
  std::string text = fmt::format("{} of {} choices of settings looked at to the end", effort.settings, all);
  if (!effort.cut.empty()) text += "; begun: " + first_of(effort.cut);
  if (!effort.untried.empty()) text += "; not tried: " + first_of(effort.untried);
  const std::string more = effort.most_steps < most
                               ? fmt::format("--most-steps {} looks further, ", std::min(most, 10 * effort.most_steps))
                               : "";
  return text + "; " + more + "a setting that is given by its flag is not searched";
}

std::string answer_text(const Recommendation& answer, const Recommended& run) {
  std::string text = fmt::format("{}, {} steps ({} µs of CPU for a simulated second)\n", run.method, run.steps,
                                 three_digits(1e6 * run.cpu_per_s));
  text += indented(changes_text(run));
  for (std::size_t i = 0; i < answer.targets.size(); ++i) {
    const Quantity& quantity = quantity_of(answer.targets[i]);
    text += fmt::format("  {}: {} {}{}\n", quantity.meaning, reached_text(run.reached[i]), quantity.unit,
                        nearby_text(run, i));
  }
  if (run.effort.spent())
    text += "  the search spent its steps, others may be cheaper: " + effort_text(run.effort) + '\n';
  return text + "  " + bold(run.command) + '\n';
}

/// That none does is known of searches alone that came to their end.
std::string none_text(const Recommendation& answer, Kind kind) {
  std::string text;
  for (const Recommended& run : answer.runs) {
    if (run.kind != kind || !run.effort.spent()) continue;
    text += fmt::format("  {}: the search spent its steps, {} in all, and found none so far: {}\n", run.method,
                        run.effort.steps, effort_text(run.effort));
  }
  return text.empty() ? "none does\n" : "not known\n" + text;
}

std::string table_text(const Recommendation& answer) {
  std::vector<std::string> header{"method", "settings"};
  for (const Target& target : answer.targets) {
    header.push_back(fmt::format("{}, {}", quantity_of(target).name, quantity_of(target).unit));
  }
  for (const char* column : {"steps", "µs per s", "±", ""}) header.emplace_back(column);
  TextTable table("ll" + std::string(answer.targets.size() + 3, 'r') + "l", header);
  for (const Recommended& run : answer.runs) {
    std::vector<std::string> cells{run.method, settings_text(run)};
    for (const Reached& reached : run.reached) cells.push_back(reached_text(reached));
    cells.push_back(std::to_string(run.steps));
    cells.push_back(run.keeps() ? three_digits(1e6 * run.cpu_per_s) : "-");
    cells.push_back(run.keeps() ? three_digits(1e6 * run.cpu_spread) : "-");
    cells.push_back(run.keeps() ? "" : (run.effort.spent() ? "not known: " : "no: ") + run.why_not);
    table.add(cells);
  }
  return table.text();
}

/// Of those that cost about the same the first in the list of methods: times differ by so much from one machine, or
/// minute, to the next.
const Recommended* answer_of(const Recommendation& answer, Kind kind) {
  constexpr double about = 1.2;
  const Recommended* best = nullptr;
  double least = 0;
  for (const Recommended& run : answer.runs) {  // cheapest first
    if (run.kind != kind) continue;
    if (best == nullptr) {
      best = &run;
      least = run.cpu_per_s;
    } else if (run.keeps() && run.cpu_per_s <= about * least && run.place < best->place) {
      best = &run;
    }
  }
  return best;
}

constexpr std::array<std::pair<Kind, std::string_view>, 3> kinds{
    {{Kind::plain_ode, "plain ODE"}, {Kind::accurate_step, "accurate step"}, {Kind::other, "other methods"}}};

Json json_of(const Recommendation& answer, const Recommended& run) {
  Json set = Json::object();
  if (!run.knob.empty()) set[run.knob] = run.setting;
  for (const Change& change : run.changes) set[change.key] = change.value;
  Json json = {{"method", run.method}, {"ode", run.kind == Kind::plain_ode}, {"set", set}, {"steps", run.steps}};
  if (run.reached.front().value) json["error"] = json_number(*run.reached.front().value);
  json["reached"] = Json::object();
  for (std::size_t i = 0; i < answer.targets.size(); ++i) {
    const auto& value = run.reached[i].value;
    json["reached"][std::string(quantity_of(answer.targets[i]).name)] = value ? json_number(*value) : Json();
  }
  json["search"] = {{"steps", run.effort.steps},
                    {"ended", run.effort.settings},
                    {"cut", run.effort.cut},
                    {"untried", run.effort.untried},
                    {"spent", run.effort.spent()}};
  if (!run.keeps()) {
    json["why_not"] = run.why_not;
    return json;
  }
  json["nearby"] = {{"tried", run.nearby.tried}, {"share", run.nearby.share}, {"worst", Json::object()}};
  for (std::size_t i = 0; i < run.nearby.worst.size(); ++i) {
    json["nearby"]["worst"][std::string(quantity_of(answer.targets[i]).name)] = json_number(run.nearby.worst[i]);
  }
  json["us_per_s"] = 1e6 * run.cpu_per_s;
  json["command"] = run.command;
  json["worth"] = Json::array();
  for (const Change& change : run.changes) {
    json["worth"].push_back({{"without", change.key},
                             {"steps", change.steps_without ? Json(*change.steps_without) : Json()},
                             {"cost", change.steps_without ? Json(change.cost_without) : Json()}});
  }
  return json;
}

}  // namespace

std::string budget_text(std::span<const Target> targets) {
  std::string text;
  for (const Target& target : targets) {
    const Quantity& quantity = quantity_of(target);
    text += fmt::format("{}{} at most {} {}", text.empty() ? "" : ", ", quantity.meaning, number_text(target.at_most),
                        quantity.unit);
  }
  return text;
}

std::string recommendation_text(const Recommendation& answer) {
  std::string text =
      fmt::format("{} until {} s: {}\n", answer.scenario, number_text(answer.until_s), budget_text(answer.targets));
  for (const auto& [kind, name] : kinds) {
    const Recommended* const first = answer_of(answer, kind);
    if (first == nullptr) continue;
    text += fmt::format("\n{}: {}", bold(std::string(name)),
                        first->keeps() ? answer_text(answer, *first) : none_text(answer, kind));
  }
  return text + "\nall methods, cheapest first\n" + table_text(answer);
}

std::string recommendation_csv(const Recommendation& answer) {
  std::string text = "method,ode,changes,knob,setting";
  for (const Target& target : answer.targets)
    text += fmt::format(",{0},{0}_uncertainty,{0}_nearby", quantity_of(target).name);
  text += ",nearby,steps,cpu_s_per_s,cpu_s_per_s_spread,keeps,why_not,command\n";
  for (const Recommended& run : answer.runs) {
    std::string changes;
    for (const Change& change : run.changes) changes += (changes.empty() ? "" : " ") + change.key + "=" + change.value;
    text += fmt::format("{},{},{},{},{}", run.method, run.kind == Kind::plain_ode ? 1 : 0, csv_cell(changes), run.knob,
                        run.knob.empty() ? "" : number_text(run.setting));
    for (std::size_t i = 0; i < run.reached.size(); ++i) {
      const Reached& reached = run.reached[i];
      text += fmt::format(",{},{},{}", reached.value ? number_text(*reached.value) : "",
                          reached.uncertainty ? number_text(*reached.uncertainty) : "",
                          run.nearby.tried > 0 ? number_text(run.nearby.worst[i]) : "");
    }
    text += fmt::format(",{},{},{},{},{},{},{}\n", run.nearby.tried, run.steps,
                        run.keeps() ? number_text(run.cpu_per_s) : "", run.keeps() ? number_text(run.cpu_spread) : "",
                        run.keeps() ? 1 : 0, csv_cell(run.why_not), csv_cell(run.command));
  }
  return text;
}

std::string recommendation_json(const Recommendation& answer) {
  Json json = {{"scenario", answer.scenario}, {"until", answer.until_s}, {"targets", Json::object()}};
  for (const Target& target : answer.targets) json["targets"][std::string(quantity_of(target).name)] = target.at_most;
  json["answers"] = Json::array();
  json["others"] = Json::array();
  for (const Recommended& run : answer.runs) json[run.keeps() ? "answers" : "others"].push_back(json_of(answer, run));
  return json.dump(2) + '\n';
}

}  // namespace odeval
