#include "catalogue/grid_runs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "catalogue/reference_bytes.hpp"
#include "catalogue/self_converged.hpp"
#include "odeval/error.hpp"
#include "output/summary.hpp"
#include "output/sweep_table.hpp"

namespace odeval::catalogue {
namespace {

// Keys that only say at which times the true motion is looked at.
constexpr std::array time_keys{"step", "sample", "duration"};

bool moves_the_reference(const std::string& key, const Scenario& scenario) {
  const auto is_key = [&](std::string_view other) { return other == key; };
  // ERP and CFM are another spring at each step.
  if (joints_are_springs(scenario) && (key == "step" || is_of_spring(key))) return true;
  // Controllers that look once a step are others as well.
  if (key == "step" && std::ranges::any_of(scenario.mechanism.joints, &Joint::sampled)) return true;
  // Everything moves ODE's own limit.
  if (can_self_converge(scenario) && (key == "step" || is_engine_setting(key))) return true;
  return !is_engine_setting(key) && std::ranges::none_of(time_keys, is_key);
}

/// Up to the rounding that `compare` forgives.
bool same_times(const SampleGrid& a, const SampleGrid& b) {
  return a.rows == b.rows && std::fabs(a.time(1) - b.time(1)) <= 2 * std::numeric_limits<double>::epsilon() * b.time(1);
}

}  // namespace

Scenario with_enough_rows(Scenario scenario, long intervals) {
  const double steps = std::ceil(scenario.duration_s / scenario.step_s * (1 - 1e-12));
  const double stride = std::ceil(steps / static_cast<double>(intervals));
  if (stride > 1) scenario.sample_s = stride * scenario.step_s;
  return scenario;
}

GridRuns::GridRuns(const ScenarioFile& file, std::vector<Override> settings, Names names, sweep::Grid grid)
    : file_(file), settings_(std::move(settings)), names_(std::move(names)), grid_(std::move(grid)) {}

std::vector<Override> GridRuns::settings(long run) const {
  std::vector<Override> settings = settings_;
  const std::vector<std::size_t> places = grid_.places(run);
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    settings.push_back({grid_.axes()[i].key, grid_.axes()[i].values[places[i]], "--grid"});
  }
  return settings;
}

Scenario GridRuns::scenario(long run) const {
  Scenario scenario = file_.read(settings(run), names_);
  scenario.tolerances.clear();
  return scenario.sample_s ? scenario : with_enough_rows(std::move(scenario));
}

std::vector<std::uint32_t> GridRuns::groups(const std::function<void(long run)>& checked) {
  struct Kind {
    std::uint32_t group;
    SampleGrid times;
  };
  std::map<std::vector<std::size_t>, std::vector<Kind>> kinds;  // by the values that move the reference, 0 for others

  std::vector<std::uint32_t> groups(static_cast<std::size_t>(grid_.runs()));
  first_of_group_.clear();
  std::vector<std::size_t> point_before;  // but for the method
  for (long run = 0; run < grid_.runs(); ++run) {
    std::vector<std::size_t> places = grid_.places(run);
    places.pop_back();
    if (run > 0 && places == point_before) {
      groups[static_cast<std::size_t>(run)] = groups[static_cast<std::size_t>(run - 1)];
      continue;
    }
    if (checked) checked(run);
    const Scenario point = scenario(run);
    for (const std::string& name : grid_.axes().back().values) {
      try {
        require_does(find_method(name), point, "--method");
      } catch (const UserError& error) {
        throw UserError(blamed(error.what(), settings(run)));
      }
    }
    const SampleGrid times = sample_grid(point);
    std::vector<std::size_t> key = places;
    for (std::size_t i = 0; i < key.size(); ++i) {
      if (!moves_the_reference(grid_.axes()[i].key, point)) key[i] = 0;
    }
    std::vector<Kind>& alike = kinds[key];
    auto kind = std::ranges::find_if(alike, [&](const Kind& other) { return same_times(times, other.times); });
    if (kind == alike.end()) {
      kind = alike.insert(alike.end(), {static_cast<std::uint32_t>(first_of_group_.size()), times});
      first_of_group_.push_back(run);
    }
    groups[static_cast<std::size_t>(run)] = kind->group;
    point_before = std::move(places);
  }
  return groups;
}

sweep::Work GridRuns::work() {
  return {[this](long group) {
            Evaluator evaluator(scenario(first_of_group_[static_cast<std::size_t>(group)]));
            try {
              return reference_bytes(evaluator.reference());
            } catch (const UserError& error) {  // a motion that cannot be followed: the others can
              throw MachineError(error.what());
            }
          },
          [this](long run, long group, std::string_view prepared) { return this->run(run, group, prepared); }};
}

sweep::Row GridRuns::run(long run, long group, std::string_view prepared) {
  if (group != group_) {
    reference_ = std::make_shared<const Reference>(reference_of(prepared));
    group_ = group;
  }
  Evaluator evaluator(scenario(run), reference_);
  const Evaluation evaluation = evaluator.evaluate(find_method(grid_.values(run).back()));
  const SampleGrid& rows = evaluator.grid();
  const Metrics metrics = evaluator.measure(evaluation, rows.time(rows.rows - 1));
  const Outcome& outcome = evaluation.outcome;
  const sweep::Status status = outcome.diverged       ? sweep::Status::diverged
                               : outcome.messages > 0 ? sweep::Status::suspect
                                                      : sweep::Status::ok;
  std::string reason = outcome.diverged ? outcome.reason : suspicion(outcome);
  if (const std::string_view mark = mark_of(*reference_); !mark.empty()) {
    reason = std::string(mark) + (reason.empty() ? "" : "; ") + reason;
  }
  return {status, reason, std::lround(1e6 * evaluator.stepping_s(evaluation)), result_cells(outcome, metrics)};
}

}  // namespace odeval::catalogue
