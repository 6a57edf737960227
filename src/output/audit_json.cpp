// The answer of an audit for programs: answer.json and steps.csv.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "output/audit_answer.hpp"
#include "output/number.hpp"

namespace odeval {
namespace {

using audit::Answer;
using audit::ErrorUntil;
using audit::Estimate;
using Json = nlohmann::ordered_json;

/// Null where there is no number: of a run that blew up, or has ended.
Json json_or_null(double number) { return std::isfinite(number) ? Json(number) : Json(); }

Json joint_json(const audit::JointSummary& joint) {
  const bool is_contact = joint.number == 0;
  Json json = {{"kind", joint.kind},
               {"bodies", {joint.bodies[0], joint.bodies[1]}},
               {"steps", joint.steps},
               {is_contact ? "depth" : "gap", json_or_null(joint.largest_m)},
               {"at", std::isnan(joint.largest_m) ? Json() : json_or_null(joint.largest_t_s)},
               {"force", json_or_null(joint.force_N)},
               {"work", json_or_null(joint.work_J)}};
  if (is_contact) {
    json["friction_share"] = joint.rough > 0 ? json_or_null(joint.friction_share) : Json();
    json["steps_sliding"] = joint.sliding;
    return json;
  }
  json["joint"] = joint.number;
  json["torque"] = json_or_null(joint.torque_Nm);
  json["motor_work"] = json_or_null(joint.motor_work_J);
  json["stop_work"] = json_or_null(joint.stop_work_J);
  json["steps_at_limit"] = joint.at_limit ? Json(*joint.at_limit) : Json();
  json["steps_at_stop"] = joint.at_stop ? Json(*joint.at_stop) : Json();
  return json;
}

void add_ledger(const Answer& answer, Json& json) {
  const audit::Work& work = answer.work;
  json["work"] = {{"added", json_or_null(work.added)},
                  {"motors", json_or_null(work.motors)},
                  {"stops", json_or_null(work.stops)},
                  {"joints", json_or_null(work.joints)},
                  {"contacts", json_or_null(work.contacts)},
                  {"damping", json_or_null(work.damping)},
                  {"program", json_or_null(work.program)},
                  {"step", json_or_null(answer.energy.end_J - answer.energy.begin_J - work.sum())}};
  json["joint_list"] = Json::array();
  json["contact_list"] = Json::array();
  for (const audit::JointSummary& joint : answer.joint_summaries) {
    json[joint.number > 0 ? "joint_list" : "contact_list"].push_back(joint_json(joint));
  }
}

Json json_of(const Estimate& error) {
  return {{"value", json_or_null(error.value)},
          {"uncertainty", json_or_null(error.uncertainty)},
          {"only_bounded", only_bounded(error)},
          {"convergence", convergence_word(error.convergence)}};
}
void add_turn(Json& row, const Estimate& turn) {
  row["turn"] = json_or_null(turn.value);
  row["turn_uncertainty"] = json_or_null(turn.uncertainty);
  row["turn_only_bounded"] = only_bounded(turn);
  row["turn_convergence"] = convergence_word(turn.convergence);
}
Json json_of(const std::optional<double>& number) { return number ? json_or_null(*number) : Json(); }

Json errors_json(const Answer& answer) {
  Json list = Json::array();
  for (const ErrorUntil& row : answer.error_at) {
    Json one = {{"t", row.t_s}};
    one.update(json_of(row.distance_m));
    add_turn(one, row.turn_rad);
    one["order"] = json_of(row.order);
    one["body"] = row.body;
    list.push_back(std::move(one));
  }
  return list;
}

Json bodies_json(const Answer& answer) {
  Json list = Json::array();
  for (const audit::BodyError& row : answer.error_of_body) {
    Json one = {{"t", row.t_s}, {"body", row.body}};
    one.update(json_of(row.distance_m));
    add_turn(one, row.turn_rad);
    list.push_back(std::move(one));
  }
  return list;
}

/// By number.
Json names_json(const std::map<std::uint32_t, std::string>& names) {
  Json object = Json::object();
  for (const auto& [number, name] : names) object[std::to_string(number)] = name;
  return object;
}

Json tried_json(const Answer& answer) {
  Json list = Json::array();
  for (const audit::Tried& tried : answer.tried) {
    Json errors = Json::array();
    for (std::size_t i = 0; i < tried.error.size(); ++i) {
      Json one = {{"t", answer.error_at[i].t_s}};
      one.update(json_of(tried.error[i]));
      errors.push_back(std::move(one));
    }
    list.push_back({{"set", tried.set},
                    {"unit", unit(answer)},
                    {"error_at", std::move(errors)},
                    {"changes_nothing", tried.is_own},
                    {"work_ratio", json_or_null(tried.work)},
                    {"cpu_ratio", json_or_null(tried.cpu)}});
  }
  return list;
}

/// What leaves less than half of the error; nothing where nothing does.
Json recommended_json(const Answer& answer) {
  if (!has_limit(answer, answer.tried_at)) return {};
  const auto error = [&](const audit::Tried& one) { return one.error[answer.tried_at].value; };
  const audit::Tried* best = nullptr;
  for (const audit::Tried& one : answer.tried) {
    if (std::isnan(error(one))) continue;  // it has ended before
    if (best == nullptr || error(one) < error(*best)) best = &one;
  }
  const bool worth_it =
      best != nullptr && error(*best) < 0.5 * answer.error_at[answer.tried_at].by(answer.by_turn).value;
  return worth_it ? Json(best->set) : Json();
}

Json runs_json(const Answer& answer) {
  Json list = Json::array();
  for (const audit::ProgramRun& run : answer.runs) {
    list.push_back({{"run", run.what},
                    {"refinement", run.refinement},
                    {"end", run.end},
                    {"steps", run.steps},
                    {"simulated_s", json_or_null(run.simulated_s)}});
  }
  return list;
}

}  // namespace

std::string audit_json(const Answer& answer) {
  const audit::ProgramRun& own = answer.runs.front();
  std::vector<int> refinements;
  for (const audit::ProgramRun& run : answer.runs) {
    if (refinements.empty() || run.refinement > refinements.back()) refinements.push_back(run.refinement);
  }
  Json json = {{"program", answer.program},
               {"exit_status", own.exit_status ? Json(*own.exit_status) : Json()},
               {"end", own.end},
               {"repeatable", !answer.parting},
               {"stepper", answer.stepper},
               {"h", json_or_null(answer.h_s)},
               {"h_varies", answer.h_varies},
               {"steps", own.steps},
               {"bodies", answer.bodies},
               {"bodies_made", answer.bodies_made},
               {"joints", answer.joints},
               {"contact_s", answer.contact_s > 0 ? json_or_null(answer.contact_s) : Json()},
               {"messages", answer.messages},
               {"first_message", answer.first_message},
               {"refinements", refinements},
               {"hold", answer.springs_held ? "springs" : "numbers"},
               {"reason", answer.reason.empty() ? Json() : Json(answer.reason)}};
  if (answer.parting) {
    json["parting"] = {{"step", answer.parting->step}, {"t", answer.parting->t_s}, {"body", answer.parting->body}};
  }
  if (answer.diverged) {
    json["diverged"] = {{"step", answer.diverged->step}, {"t", answer.diverged->t_s}, {"body", answer.diverged->body}};
  }
  const ErrorUntil* last = answer.error_at.empty() ? nullptr : &answer.error_at.back();
  json["order"] = last != nullptr ? json_of(last->order) : Json();
  json["convergence"] = last != nullptr ? Json(convergence_word(last->convergence())) : Json();
  json["until"] = json_or_null(answer.until_s);
  json["lost_at"] = json_of(answer.lost_at_s);
  json["lost_body"] = answer.lost_at_s ? Json(answer.lost_body) : Json();
  json["growth"] = json_of(answer.growth);
  json["chaos_from"] = json_of(answer.chaos_from_s);
  json["error_at"] = errors_json(answer);
  json["error_of_body"] = bodies_json(answer);
  Json steps = Json::array();
  for (const audit::StepFor& one : answer.steps_for) {
    steps.push_back(
        {{"error", one.error}, {"unit", unit(answer)}, {"until", answer.steps_for_t_s}, {"h", json_of(one.h_s)}});
  }
  json["step_for"] = std::move(steps);
  json["settings"] = tried_json(answer);
  json["recommended"] = recommended_json(answer);
  const audit::Tried* cheap = has_limit(answer, answer.tried_at) ? cheapest(answer) : nullptr;
  json["cheapest"] = cheap != nullptr ? Json(cheap->set) : Json();
  json["softness"] = json_of(answer.softness_m);
  json["energy"] = {{"begin", json_or_null(answer.energy.begin_J)},
                    {"end", json_or_null(answer.energy.end_J)},
                    {"error", json_of(answer.energy.error_J)}};
  json["worst"] = {{"body", answer.worst_body > 0 ? Json(answer.worst_body) : Json()},
                   {"t", answer.worst_body > 0 ? json_or_null(answer.worst_t_s) : Json()},
                   {"joint", answer.gap.joint > 0 ? Json(answer.gap.joint) : Json()},
                   {"gap", json_or_null(answer.gap.largest_m)},
                   {"contacts", answer.contacts},
                   {"depth", json_or_null(answer.depth_m)}};
  add_ledger(answer, json);
  json["body_names"] = names_json(answer.body_names);
  json["joint_names"] = names_json(answer.joint_names);
  json["runs"] = runs_json(answer);
  json["limits"] = answer.limits;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

AuditSteps::AuditSteps(const std::filesystem::path& file) : file_(file) {
  file_.write(
      "world,t,kinetic,potential,energy,work_added,work_motors,work_stops,work_joints,work_contacts,work_damping,"
      "work_program,gap,contacts,depth,messages\n");
}

void AuditSteps::add(const audit::StepRow& row) {
  const audit::Work& work = row.work;
  std::string line = std::to_string(row.world);
  for (const double value :
       {row.t_s, row.kinetic_J, row.potential_J, row.kinetic_J + row.potential_J, work.added, work.motors, work.stops,
        work.joints, work.contacts, work.damping, work.program, row.gap_m}) {
    line += ',' + number_text(value);
  }
  file_.write(fmt::format("{},{},{},{}\n", line, row.contacts, number_text(row.depth_m), row.messages));
}

}  // namespace odeval
