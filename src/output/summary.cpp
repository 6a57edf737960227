#include "output/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "odeval/metrics.hpp"
#include "output/csv_cell.hpp"
#include "output/impacts.hpp"
#include "output/json_number.hpp"
#include "output/mechanism_report.hpp"
#include "output/number.hpp"

namespace odeval {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const std::optional<double>& number) { return number ? json_number(*number) : Json(); }

Json json_of(const std::vector<double>& numbers) {
  Json list = Json::array();
  for (const double number : numbers) list.push_back(json_number(number));
  return list;
}

/// Puts a value where its key says: "links.0.mass" into the first object of a list.
void put(Json& json, std::string_view key, const SettingValue& value) {
  Json* at = &json;
  for (std::size_t end = 0; end != std::string_view::npos; key.remove_prefix(std::min(end + 1, key.size()))) {
    end = key.find('.');
    const std::string part(key.substr(0, end));
    const bool number =
        !part.empty() && std::ranges::all_of(part, [](char letter) { return letter >= '0' && letter <= '9'; });
    at = number ? &(*at)[std::stoul(part)] : &(*at)[part];
    if (end == std::string_view::npos) break;
  }
  *at = std::visit([](const auto& v) { return Json(v); }, value);
}

Json json_of(const Impact& impact) {
  Json json = {{"t", json_number(impact.t)},
               {"q1", json_number(impact.q1)},
               {"qd_before", json_number(impact.qd_before)},
               {"qd_after", json_number(impact.qd_after)},
               {"restitution", json_of(restitution(impact))},
               {"depth", json_number(impact.depth)}};
  if (impact.link) json["link"] = *impact.link;
  return json;
}

bool rubs(const Mechanism& mechanism) {
  return std::ranges::any_of(mechanism.contacts, [](const Contact& contact) { return contact.friction.has_value(); });
}

Json ode_settings(const Scenario& scenario) {
  const OdeSettings& ode = scenario.ode;
  const Softness softness = ode.softness(scenario.step_s);
  const Spring spring = ode.spring.value_or(spring_of(softness, scenario.step_s));
  Json json = {{"erp", softness.erp},
               {"cfm", softness.cfm},
               {"kp", json_number(spring.kp_N_m)},
               {"kd", json_number(spring.kd_Ns_m)},
               {"iterations", ode.iterations},
               {"sor_w", ode.sor_w}};
  if (!scenario.mechanism.contacts.empty()) json["bounce"] = ode.bounce.value_or(scenario.restitution());
  json["bounce_vel"] = ode.bounce_vel;
  json["max_correcting_vel"] = json_number(ode.max_correcting_vel);
  json["surface_layer"] = ode.surface_layer;
  if (rubs(scenario.mechanism)) {
    json["friction_axes"] = ode.friction_axes == FrictionAxes::sliding ? "sliding" : "plane-space";
  }
  json["start"] = ode.start == Start::half_step ? "half-step" : "as-given";
  json["seed"] = ode.seed;
  json["gyroscopic"] = ode.gyroscopic ? "on" : "off";
  json["rotation"] = ode.rotation == Turning::finite ? "finite" : "infinitesimal";
  return json;
}

Json settings(const RunSummary& run) {
  const Scenario& scenario = run.scenario;
  Json json = {{"step", run.grid.step_s},
               {"duration", run.grid.time(run.grid.rows - 1)},
               {"sample", scenario.sample_s.value_or(run.grid.step_s)},
               {"gravity", scenario.gravity}};
  if (scenario.planar) {
    json["q0"] = json_of(scenario.planar->q0);
    json["qd0"] = json_of(scenario.planar->qd0);
  }
  if (run.rtol) json["rtol"] = *run.rtol;
  if (run.atol) json["atol"] = *run.atol;
  for (const auto& [key, value] : scenario.definition) put(json, key, value);
  if (run.uses_ode) json["ode"] = ode_settings(scenario);
  if (run.uses_bounce) {
    json["ode"] = {{"bounce", json_number(scenario.ode.bounce.value_or(scenario.restitution()))}};
  }
  if (run.uses_bullet) {
    json["bullet"] = {{"iterations", scenario.bullet.iterations}, {"erp", scenario.bullet.erp}};
  }
  if (run.uses_mujoco) {
    json["mujoco"] = {{"time_constant", scenario.mujoco.time_constant_s},
                      {"cone", scenario.mujoco.elliptic ? "elliptic" : "pyramidal"}};
  }
  for (const auto& [option, value] : run.told) {
    json["engine"][option] = std::visit([](const auto& v) { return Json(v); }, value);
  }
  if (run.uses_maximal) json["maximal"] = {{"ks", scenario.maximal.ks}, {"kd", scenario.maximal.kd}};
  return json;
}

Json versions(const RunSummary& run) {
  Json json = Json::object();
  for (const auto& [name, version] : run.versions) json[name] = version;
  return json;
}

/// Whether the run may have an error of that quantity against the reference, known or not.
bool is_error(const Quantity& row, const Metrics& metrics) {
  return row.uncertainty && (row.scope == Scope::mechanism || compared(metrics, row.scope));
}

/// The errors of what the run has, angles or bodies, and their bounds.
std::vector<const Quantity*> errors_of(const Metrics& metrics) {
  std::vector<const Quantity*> errors;
  for (const Quantity& row : quantities) {
    const auto bounded_by_row = [&](const Quantity& error) {
      return error.uncertainty == row.id && is_error(error, metrics);
    };
    if (is_error(row, metrics) || std::ranges::any_of(quantities, bounded_by_row)) errors.push_back(&row);
  }
  return errors;
}

Json errors_at(const RunSummary& run) {
  const std::vector<const Quantity*> errors = errors_of(run.metrics);
  Json json = Json::object();
  for (const Metrics& metrics : run.error_at) {
    Json& at = json[number_text(metrics.until_s)] = Json::object();
    for (const Quantity* error : errors) at[std::string(error->name)] = json_of(metrics[error->id]);
  }
  return json;
}

/// Why not to believe the run; empty: no reason.
std::string reason_of(const Outcome& outcome) {
  if (outcome.diverged || outcome.messages == 0) return outcome.reason;
  return "suspect: " + suspicion(outcome);
}

/// The quantities that summary.csv shows at each error time as well.
constexpr std::array errors_in_csv{quantity::max_error_q, quantity::rms_error_q, quantity::reference_uncertainty};

std::string cell(const std::optional<double>& number) { return number ? number_text(*number) : ""; }

const Metrics* metrics_at(const RunSummary& run, double time) {
  for (const Metrics& metrics : run.error_at) {
    if (metrics.until_s == time) return &metrics;
  }
  return nullptr;
}

}  // namespace

std::vector<double> error_times_within(const SampleGrid& grid) {
  constexpr double rounding_s = 1e-9;
  std::vector<double> times;
  for (const double time : error_times) {
    if (time <= grid.time(grid.rows - 1) + rounding_s) times.push_back(time);
  }
  return times;
}

std::string suspicion(const Outcome& outcome) {
  if (outcome.messages == 0) return "";
  // Up to its numbers, which are of one step of many: "LCP internal error, s <= 0 (s=-1.6653e-16)".
  return fmt::format("{} message{} of ODE ({})", outcome.messages, outcome.messages == 1 ? "" : "s",
                     outcome.first_message.substr(0, outcome.first_message.find(',')));
}

std::optional<double> restitution(const Impact& impact) {
  if (impact.qd_before == 0) return std::nullopt;
  return -impact.qd_after / impact.qd_before;
}

std::string summary_json(const RunSummary& run) {
  const Outcome& outcome = run.outcome;
  Json json = {{"scenario", run.scenario.name}, {"method", run.method}, {"is_reference", run.is_reference}};
  json["reference"] = run.reference.empty() ? Json() : Json(run.reference);
  json["settings"] = settings(run);
  json["versions"] = versions(run);
  json["steps"] = outcome.steps;
  json["evaluations"] = outcome.evaluations;
  json["messages"] = outcome.messages;
  if (outcome.messages > 0) json["first_message"] = outcome.first_message;
  json["diverged"] = outcome.diverged;
  const std::string reason = reason_of(outcome);
  json["reason"] = reason.empty() ? Json() : Json(reason);
  for (const Quantity& row : quantities) json[std::string(row.name)] = json_of(run.metrics[row.id]);
  json["reference_lost_at"] = json_of(run.metrics.reference_lost_at);
  json["error_at"] = errors_at(run);
  if (outcome.self_difference) json["self_difference"] = json_number(*outcome.self_difference);
  json["at_rest_from"] = outcome.at_rest_from < 0 ? Json() : json_number(outcome.at_rest_from);
  if (tells_impacts(run.scenario)) {
    json["impacts"] = Json::array();
    for (const Impact& impact : outcome.impacts) json["impacts"].push_back(json_of(impact));
  } else {
    json["impacts"] = Json();
  }
  put_parts(json, run);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::string unlike(const std::string& json, const RunSummary& run) {
  const Json whole = Json::parse(json, nullptr, false);
  for (const auto& [part, wanted] : {std::pair{"settings", settings(run)}, std::pair{"versions", versions(run)}}) {
    if (!whole.is_object() || !whole.contains(part)) return std::string("no ") + part;
    const Json there = whole[part].flatten();
    const Json here = wanted.flatten();
    for (const Json& one : {here, there}) {
      for (const auto& [path, ignored] : one.items()) {
        const auto value = [&](const Json& in) { return in.contains(path) ? in[path].dump() : "nothing"; };
        if (value(there) == value(here)) continue;
        std::string key = path.substr(1);
        std::ranges::replace(key, '/', '.');
        return fmt::format("{} = {}, not {}", key, value(there), value(here));
      }
    }
  }
  return "";
}

std::string summary_csv(const std::vector<RunSummary>& runs) {
  std::string text = "scenario,method,is_reference,step,duration,steps,evaluations,diverged,reason";
  for (const Quantity& row : quantities) text += fmt::format(",{}", row.name);
  for (const double time : error_times) {
    for (const quantity::Id error : errors_in_csv) text += fmt::format(",{}_at_{:g}", quantities[error].name, time);
  }
  text += ",impacts,at_rest_from\n";

  for (const RunSummary& run : runs) {
    const Outcome& outcome = run.outcome;
    text += fmt::format("{},{},{},{},{},{},{},{},{}", csv_cell(run.scenario.name), csv_cell(run.method),
                        run.is_reference, number_text(run.grid.step_s), number_text(run.grid.time(run.grid.rows - 1)),
                        outcome.steps, outcome.evaluations, outcome.diverged, csv_cell(reason_of(outcome)));
    for (const Quantity& row : quantities) text += ',' + cell(run.metrics[row.id]);
    for (const double time : error_times) {
      const Metrics* at = metrics_at(run, time);
      for (const quantity::Id error : errors_in_csv) text += ',' + (at == nullptr ? "" : cell((*at)[error]));
    }
    text += fmt::format(",{},{}\n", tells_impacts(run.scenario) ? std::to_string(outcome.impacts.size()) : "",
                        outcome.at_rest_from < 0 ? "" : number_text(outcome.at_rest_from));
  }
  return text;
}

}  // namespace odeval
