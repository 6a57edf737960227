#include "audit/report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "audit/recording.hpp"

namespace odeval::audit {
namespace {

void widen(Estimate& error, double apart) {
  error.uncertainty += apart;
  error.convergence = std::max(error.convergence, Convergence::rough);
}

/// An error until a time is no less than one until a time before, and where that has no limit, nor has this: whatever
/// smaller steps agree on after it. One of which there is next to nothing says nothing.
void end(Estimate& its, const Estimate& before) {
  if (before.convergence != Convergence::none || larger_of(before) < ErrorUntil::little * larger_of(its)) return;
  its.convergence = Convergence::none;
}

double decade(double t_s) { return std::pow(10.0, std::floor(std::log10(t_s * (1 + rounding_of_time)))); }

}  // namespace

double larger_of(double value, double uncertainty) {
  if (std::isnan(value) || std::isnan(uncertainty)) return std::numeric_limits<double>::infinity();
  return std::max(value, uncertainty);
}
double larger_of(const Estimate& error) { return larger_of(error.value, error.uncertainty); }

Estimate as_turn(Estimate error) {
  if (!(error.uncertainty < std::numbers::pi)) error.convergence = Convergence::none;
  return error;
}

void raise(Estimate& error, const Estimate& before) {
  if (before.convergence == Convergence::none || !(before.value > error.value)) return;
  error.value = before.value;
  error.uncertainty = std::max(error.uncertainty, before.uncertainty);
}

void Report::end_once() {
  constexpr double just_before = 0.95;
  const std::size_t count = rows_.size();
  if (count < 2 || rows_[count - 2].error.t_s < just_before * rows_.back().error.t_s) return;
  rows_.erase(rows_.end() - 2);
}

void Report::sum_up(std::optional<double> lost_at_s) {
  lost_at_s_ = lost_at_s;
  widen_after_loss();
  rows_.erase(rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(first_told()));
  end_with_the_limit();
}

void Report::widen_after_loss() {
  for (ReportRow& row : rows_) {
    if (!lost_at_s_ || row.error.t_s <= *lost_at_s_) continue;
    const auto widen_both = [](Estimate& distance, Estimate& turn, const Apart& apart) {
      widen(distance, apart.place_m);
      widen(turn, apart.attitude_rad);
      turn = as_turn(turn);
    };
    widen_both(row.error.distance_m, row.error.turn_rad, row.apart);
    row.limit.uncertainty = row.error.distance_m.uncertainty;
    row.limit_of_turn.uncertainty = row.error.turn_rad.uncertainty;
    for (std::size_t run = 0; run < row.runs_m.size(); ++run) {
      widen_both(row.runs_m[run], row.runs_rad[run], row.apart);
    }
    for (auto& [body, apart] : row.bodies) widen_both(body.distance_m, body.turn_rad, apart);
  }
}

bool Report::says_nothing(const ReportRow& row) const {
  return row.error.convergence() == Convergence::none || row.error.t_s > lost_at_s_.value_or(HUGE_VAL);
}

/// The first at that time or later, or the last of all.
std::size_t Report::first_from(double t_s) const {
  std::size_t first = 0;
  while (first + 1 < rows_.size() && rows_[first].error.t_s < t_s * (1 - rounding_of_time)) ++first;
  return first;
}

std::size_t Report::first_told() const {
  const std::size_t usual = first_from(decade(std::min(1.0, rows_.back().error.t_s)));
  if (!says_nothing(rows_[usual])) return usual;
  std::optional<std::size_t> last;
  const auto convergence = [this](std::size_t i) { return rows_[i].error.convergence(); };
  for (std::size_t i = 0; i < usual; ++i) {
    if (!says_nothing(rows_[i]) && (!last || convergence(i) <= convergence(*last))) last = i;
  }
  if (!last) return usual;
  std::size_t first = *last;
  while (first > first_from(decade(rows_[*last].error.t_s)) && !says_nothing(rows_[first - 1])) --first;
  return first;
}

void Report::end_with_the_limit() {
  for (std::size_t i = 1; i < rows_.size(); ++i) {
    end(rows_[i].error.distance_m, rows_[i - 1].error.distance_m);
    end(rows_[i].error.turn_rad, rows_[i - 1].error.turn_rad);
  }
  std::unordered_map<std::uint32_t, BodyError> last;
  for (ReportRow& row : rows_) {
    for (auto& [body, apart] : row.bodies) {
      const auto [before, is_first] = last.try_emplace(body.body, body);
      if (is_first) continue;
      end(body.distance_m, before->second.distance_m);
      end(body.turn_rad, before->second.turn_rad);
      before->second = body;
    }
  }
}

std::size_t Report::last_told(double t_s) const {
  std::size_t last = rows_.size() - 1;
  while (last > 0 && (rows_[last].error.t_s > t_s || says_nothing(rows_[last]))) --last;
  return last;
}

}  // namespace odeval::audit
