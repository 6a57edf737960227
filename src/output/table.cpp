#include "output/table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "output/impacts.hpp"
#include "output/terminal.hpp"

namespace odeval {

namespace {

// Letters, not bytes: "±" and "µ" have two bytes in UTF-8.
std::size_t width_of(const std::string& cell) {
  return static_cast<std::size_t>(std::count_if(
      cell.begin(), cell.end(), [](char letter) { return (static_cast<unsigned char>(letter) & 0xC0) != 0x80; }));
}

/// In the colour of what it says: what went wrong, and what was kept.
std::string coloured(const std::string& cell) {
  for (const char* bad : {"diverged", "failed", "different", "crashed", "suspect", "no:"}) {
    if (cell.starts_with(bad)) return red(cell);
  }
  return cell == "kept" || cell == "ok" ? green(cell) : cell;
}

const Metrics* metrics_until(const RunSummary& run, double time) {
  const auto found = std::find_if(run.error_at.begin(), run.error_at.end(),
                                  [time](const Metrics& metrics) { return metrics.until_s == time; });
  return found == run.error_at.end() ? nullptr : &*found;
}

/// An error beside the reference's uncertainty; of the reference that alone.
std::string error_cell(const RunSummary& run, const Metrics* metrics, quantity::Id error) {
  if (metrics == nullptr) return "-";
  const std::optional<double> uncertainty = uncertainty_of(error, *metrics);
  const bool angle = quantities[error].scope == Scope::coordinate;
  if (angle && uncertainty.value_or(0) > 1) return "reference lost";
  if (run.is_reference) return "± " + fmt::format("{:.1g}", uncertainty.value_or(0));
  return with_uncertainty((*metrics)[error], uncertainty);
}

/// In a few words: reasons are sentences, and stand below the table.
std::string status(const RunSummary& run) {
  if (run.outcome.diverged) return "diverged";
  if (run.outcome.messages > 0) return "suspect: " + suspicion(run.outcome);
  return run.is_reference ? "reference" : "ok";
}

}  // namespace

TextTable::TextTable(std::string_view align, std::vector<std::string> header) : align_(align) {
  rows_.push_back(std::move(header));
}

void TextTable::add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

std::string TextTable::text() const {
  std::vector<std::size_t> widths(align_.size());
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width_of(row[i]));
  }
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string padding(widths[i] - width_of(row[i]), ' ');
      const std::string cell = &row == &rows_.front() ? bold(row[i]) : coloured(row[i]);
      line += (i == 0 ? "" : "  ") + (align_[i] == 'l' ? cell + padding : padding + cell);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

std::string three_digits(const std::optional<double>& number) { return number ? fmt::format("{:.3g}", *number) : "-"; }

std::string with_uncertainty(const std::optional<double>& value, const std::optional<double>& uncertainty) {
  if (!value || !uncertainty) return three_digits(value);
  return fmt::format("{:.3g} ± {:.1g}", *value, *uncertainty);
}

namespace {

std::string cost_cell(std::span<const double> ns_per_step, std::size_t run) {
  return run < ns_per_step.size() ? three_digits(ns_per_step[run] / 1e3) : "-";
}

std::string impacts_cell(const RunSummary& run) {
  return tells_impacts(run.scenario) ? std::to_string(run.outcome.impacts.size()) : "-";
}

std::string body_table(const std::vector<RunSummary>& runs, std::span<const double> ns_per_step) {
  const bool forces = runs.front().metrics[quantity::max_reaction_error].has_value();
  const auto force_or_momentum = forces ? quantity::max_reaction_error : quantity::max_angular_momentum_drift;
  TextTable table("lrrrrrrrrl",
                  {"method", "distance to 1 s, m", "to the end", "turned to 1 s, rad", "to the end", "drift, J",
                   forces ? "force error, N" : "momentum, N m s", "impacts", "µs/step", "status"});
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunSummary& run = runs[i];
    const Metrics* const early = metrics_until(run, 1);
    table.add(
        {run.method, error_cell(run, early, quantity::max_error_position),
         error_cell(run, &run.metrics, quantity::max_error_position), error_cell(run, early, quantity::max_error_turn),
         error_cell(run, &run.metrics, quantity::max_error_turn), three_digits(run.metrics[quantity::max_energy_drift]),
         three_digits(run.metrics[force_or_momentum]), impacts_cell(run), cost_cell(ns_per_step, i), status(run)});
  }
  return table.text();
}

}  // namespace

std::string summary_table(const std::vector<RunSummary>& runs, std::span<const double> ns_per_step) {
  if (compared(runs.front().metrics, Scope::body)) return body_table(runs, ns_per_step);
  TextTable table("lrrrrrrrrl", {"method", "error to 1 s, rad", "to 3 s", "to the end", "lost at, s", "drift, J",
                                 "gap, m", "impacts", "µs/step", "status"});
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunSummary& run = runs[i];
    table.add({run.method, error_cell(run, metrics_until(run, 1), quantity::max_error_q),
               error_cell(run, metrics_until(run, 3), quantity::max_error_q),
               error_cell(run, &run.metrics, quantity::max_error_q),
               three_digits(run.metrics[quantity::divergence_time]),
               three_digits(run.metrics[quantity::max_energy_drift]), three_digits(run.metrics[quantity::max_gap]),
               impacts_cell(run), cost_cell(ns_per_step, i), status(run)});
  }
  return table.text();
}

std::string impacts_table(const std::vector<RunSummary>& runs, const std::vector<Impact>& reference, std::size_t most) {
  const bool bodies = compared(runs.front().metrics, Scope::body);
  const auto of_ball = [](const RunSummary& run) {
    return std::ranges::any_of(run.outcome.impacts, [](const Impact& impact) { return impact.link.has_value(); });
  };
  const bool balls = std::ranges::any_of(runs, of_ball);
  TextTable table("lrrrrrrrr", {"method", balls ? "impact of link" : "impact", "t, s", bodies ? "height, m" : "q1, rad",
                                bodies || balls ? "velocity before, m/s" : "rate before, rad/s", "after", "restitution",
                                "depth, m", "later than the reference, s"});
  for (const RunSummary& run : runs) {
    const std::vector<Impact>& impacts = run.outcome.impacts;
    for (std::size_t i = 0; i < std::min(impacts.size(), most); ++i) {
      const Impact& impact = impacts[i];
      const std::string number = std::to_string(i + 1);
      table.add({run.method, impact.link ? fmt::format("{} of {}", number, *impact.link) : number,
                 fmt::format("{:.6g}", impact.t), fmt::format("{:.6g}", impact.q1), three_digits(impact.qd_before),
                 three_digits(impact.qd_after), three_digits(restitution(impact)), three_digits(impact.depth),
                 i < reference.size() ? fmt::format("{:+.3g}", impact.t - reference[i].t) : "-"});
    }
    if (impacts.size() > most) table.add({run.method, fmt::format("... {} in all", impacts.size())});
  }
  return table.text();
}

}  // namespace odeval
