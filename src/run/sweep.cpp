#include "run/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "odeval/error.hpp"
#include "run/pool.hpp"

namespace odeval::sweep {
namespace {

using run::Result;

constexpr std::size_t longest_reason = 1000;
constexpr double at_hand_s = 0.05;

/// The runs to do, group by group.
std::vector<run::Job> plan_of(std::span<const std::uint32_t> groups, const Journal& journal, double timeout_s) {
  std::vector<run::Job> plan;
  for (long number = 0; number < journal.runs(); ++number) {
    if (journal.head().shard.holds(number) && !journal.settled(number, timeout_s))
      plan.push_back({static_cast<std::uint32_t>(number), groups[static_cast<std::size_t>(number)]});
  }
  std::stable_sort(plan.begin(), plan.end(), [](auto& a, auto& b) { return a.group < b.group; });
  return plan;
}

/// A run's row comes from its worker as the line of the journal.
Row row_in(const std::string& line, std::uint32_t seed) {
  const auto found = row_of(std::string_view(line).substr(0, line.size() - 1), seed);
  if (!found) throw MachineError("sweep: a worker's answer cannot be read");
  return found->second;
}

Row row_without(const Result& result, double timeout_s) {
  Row row{Status::crashed, result.of_preparation ? "what its runs share: " : "", 0, ""};
  row.reason += result.text.substr(0, longest_reason);
  if (result.kind == Result::Kind::late) {
    row.status = Status::timeout;
    row.cpu_us = std::lround(1e6 * timeout_s);
  }
  return row;
}

}  // namespace

int run_sweep(const Work& work, std::span<const std::uint32_t> groups, Journal& journal, const SweepOptions& options) {
  const std::uint32_t seed = seed_of(journal.head());
  const run::Work jobs{work.prepare, [&](long number, long group, std::string_view prepared) {
                         Row row = work.run(number, group, prepared);
                         row.reason = row.reason.substr(0, longest_reason);
                         return row_line(seed, number, row);
                       }};
  const auto take = [&](long number, const Result& result) {
    if (result.kind == Result::Kind::refused) throw UserError(result.text);
    journal.append(
        number, result.kind == Result::Kind::done ? row_in(result.text, seed) : row_without(result, options.timeout_s));
  };
  const auto passed = [&] {
    journal.sync_in_time();
    if (options.passed) options.passed(journal);
  };
  const int signal = run_pool(jobs, plan_of(groups, journal, options.timeout_s), take,
                              {options.jobs, options.timeout_s, at_hand_s, passed});
  journal.sync();
  return signal;
}

}  // namespace odeval::sweep
