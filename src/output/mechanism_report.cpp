#include "output/mechanism_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "odeval/ways.hpp"
#include "output/json_number.hpp"
#include "output/table.hpp"

namespace odeval {
namespace {

double largest_size(const Column& column) {
  double most = 0;
  for (const double value : column) most = std::isnan(value) ? INFINITY : std::max(most, std::fabs(value));
  return most;
}

const std::string& name_of(const RunSummary& run, std::size_t joint) {
  return run.scenario.mechanism.joints[joint].name;
}

bool has_works(const RunSummary& run) { return run.parts.works.has_value(); }

std::string works_table(const std::vector<RunSummary>& runs) {
  std::vector<std::size_t> kinds;
  for (std::size_t kind = 0; kind < work_names.size(); ++kind) {
    if (std::ranges::any_of(runs,
                            [&](const RunSummary& run) { return has_works(run) && (*run.parts.works)[kind] != 0; }))
      kinds.push_back(kind);
  }
  if (kinds.empty()) return "";
  std::vector<std::string> header{"works to the end, J", "energy gained"};
  for (const std::size_t kind : kinds) header.emplace_back(work_names[kind]);
  header.insert(header.end(), {"unaccounted", "at most"});
  TextTable table("l" + std::string(header.size() - 1, 'r'), header);
  for (const RunSummary& run : runs) {
    if (!has_works(run)) continue;
    std::vector<std::string> cells{run.method, three_digits(run.parts.energy_gained)};
    for (const std::size_t kind : kinds) cells.push_back(three_digits((*run.parts.works)[kind]));
    cells.push_back(three_digits(run.parts.unaccounted));
    cells.push_back(three_digits(run.metrics[quantity::max_unaccounted_energy]));
    table.add(std::move(cells));
  }
  return "\n" + table.text() + "unaccounted is, of ODE, what its steps lose or gain; of the reference, its own error\n";
}

/// "motor2": what files call what drives or stops a motion.
std::string numbered(const char* key, std::size_t motion) { return motion == 1 ? key : key + std::to_string(motion); }

std::string motors_table(const std::vector<RunSummary>& runs) {
  TextTable table("llrr", {"motor", "method", "at its limit, % of the time", "from, s"});
  bool any = false;
  for (const RunSummary& run : runs) {
    for (const MotorUse& motor : run.outcome.motors) {
      any = true;
      const std::string key = motor.motion == 0 ? "" : " " + numbered("motor", motor.motion);
      table.add({name_of(run, motor.joint) + key, run.method, fmt::format("{:.3g}", 100 * motor.share),
                 motor.first_s ? fmt::format("{:.6g}", *motor.first_s) : "-"});
    }
  }
  return any ? "\n" + table.text() : "";
}

/// The strikes of a joint, or of one of its motions, in the order of time.
std::vector<StopStrike> strikes_of(const std::vector<StopStrike>& all, std::size_t joint, std::size_t motion) {
  std::vector<StopStrike> of_joint;
  std::ranges::copy_if(all, std::back_inserter(of_joint),
                       [&](const StopStrike& strike) { return strike.joint == joint && strike.motion == motion; });
  return of_joint;
}

std::string strikes_table(const std::vector<RunSummary>& runs, const std::vector<StopStrike>& reference) {
  constexpr std::size_t most = 3;  // as of impacts
  TextTable table("llrlrrrr",
                  {"stop", "method", "strike", "end", "t, s", "rate before", "after", "later than the reference, s"});
  bool any = false;
  const auto add = [&](const RunSummary& run, std::size_t joint, std::size_t motion) {
    const std::vector<StopStrike> strikes = strikes_of(run.outcome.strikes, joint, motion);
    const std::vector<StopStrike> wanted = strikes_of(reference, joint, motion);
    const double sign = sign_in_files(run.scenario.mechanism.joints[joint]);
    const std::string name = name_of(run, joint) + (motion == 0 ? "" : " " + numbered("stops", motion));
    for (std::size_t i = 0; i < std::min(strikes.size(), most); ++i) {
      const StopStrike& strike = strikes[i];
      any = true;
      table.add({name, run.method, std::to_string(i + 1), strike.low == (sign > 0) ? "low" : "high",
                 fmt::format("{:.6g}", strike.t), three_digits(sign * strike.rate_before),
                 three_digits(sign * strike.rate_after),
                 i < wanted.size() ? fmt::format("{:+.3g}", strike.t - wanted[i].t) : "-"});
    }
    if (strikes.size() > most) table.add({name, run.method, fmt::format("... {} in all", strikes.size())});
  };
  for (const RunSummary& run : runs) {
    const std::vector<Joint>& joints = run.scenario.mechanism.joints;
    for (std::size_t joint = 0; joint < joints.size(); ++joint) {
      add(run, joint, 0);
      for (const AxisDrive& drive : joints[joint].drives) add(run, joint, drive.number);
    }
  }
  return any ? "\n" + table.text() : "";
}

/// Of each kind of joint the widest, in the order in which the kinds come.
std::string gaps_table(const std::vector<RunSummary>& runs) {
  TextTable table("llrl", {"joints of kind", "method", "widest gap, m", "of"});
  bool any = false;
  for (const RunSummary& run : runs) {
    std::map<std::size_t, std::size_t> widest;  // kind to joint
    for (std::size_t j = 0; j < run.parts.joints.size(); ++j) {
      const auto [place, first] = widest.emplace(run.scenario.mechanism.joints[j].kind.index(), j);
      if (!first && run.parts.joints[j].max_gap > run.parts.joints[place->second].max_gap) place->second = j;
    }
    for (const auto& [kind, joint] : widest) {
      if (run.is_reference) continue;  // generalized coordinates have none
      any = true;
      table.add({std::string(word_of(run.scenario.mechanism.joints[joint].kind)), run.method,
                 three_digits(run.parts.joints[joint].max_gap), name_of(run, joint)});
    }
  }
  return any ? "\n" + table.text() : "";
}

}  // namespace

PartsSummary parts_of(const Scenario& scenario, const Trace& trace) {
  PartsSummary parts;
  if (!scenario.named || trace.rows() == 0) return parts;
  for (const JointColumns& joint : trace.joints) {
    JointSummary summary{.max_gap = largest_size(joint.gap)};
    if (!joint.error_q.empty()) summary.max_error = largest_size(joint.error_q);
    if (!joint.load.empty()) summary.max_torque = largest_size(joint.load);
    parts.joints.push_back(summary);
  }
  if (trace.works.empty()) return parts;
  const std::size_t last = trace.rows() - 1;
  parts.works.emplace();
  for (std::size_t kind = 0; kind < trace.works.size(); ++kind) (*parts.works)[kind] = trace.works[kind][last];
  parts.energy_gained = trace.kinetic[last] + trace.potential[last] - (trace.kinetic[0] + trace.potential[0]);
  parts.unaccounted = trace.unaccounted[last];
  return parts;
}

std::string mechanism_tables(const std::vector<RunSummary>& runs, const std::vector<StopStrike>& reference) {
  return works_table(runs) + motors_table(runs) + strikes_table(runs, reference) + gaps_table(runs);
}

void put_parts(nlohmann::ordered_json& json, const RunSummary& run) {
  using Json = nlohmann::ordered_json;
  const auto number = [](const std::optional<double>& value) { return value ? json_number(*value) : Json(); };
  if (!run.scenario.named) return;
  const std::vector<Joint>& joints = run.scenario.mechanism.joints;
  if (run.parts.works) {
    Json& works = json["works"];
    for (std::size_t kind = 0; kind < work_names.size(); ++kind) {
      works[std::string(work_names[kind])] = json_number((*run.parts.works)[kind]);
    }
    works["energy_gained"] = json_number(run.parts.energy_gained);
    works["unaccounted"] = json_number(run.parts.unaccounted);
    json["motors"] = Json::array();
    for (const MotorUse& motor : run.outcome.motors) {
      json["motors"].push_back({{"joint", joints[motor.joint].name},
                                {"share_at_limit", json_number(motor.share)},
                                {"at_limit_from", number(motor.first_s)}});
      if (motor.motion != 0) json["motors"].back()["motor"] = numbered("motor", motor.motion);
    }
    json["strikes"] = Json::array();
    for (const StopStrike& strike : run.outcome.strikes) {
      const double sign = sign_in_files(joints[strike.joint]);
      json["strikes"].push_back({{"t", json_number(strike.t)},
                                 {"joint", joints[strike.joint].name},
                                 {"end", strike.low == (sign > 0) ? "low" : "high"},
                                 {"rate_before", json_number(sign * strike.rate_before)},
                                 {"rate_after", json_number(sign * strike.rate_after)}});
      if (strike.motion != 0) json["strikes"].back()["stop"] = numbered("stops", strike.motion);
    }
  }
  json["joints"] = Json::array();
  for (std::size_t j = 0; j < run.parts.joints.size(); ++j) {
    const JointSummary& joint = run.parts.joints[j];
    json["joints"].push_back({{"name", joints[j].name},
                              {"kind", word_of(joints[j].kind)},
                              {"max_gap", json_number(joint.max_gap)},
                              {"max_error_q", number(joint.max_error)},
                              {"max_torque", number(joint.max_torque)}});
  }
}

}  // namespace odeval
