#pragma once
// What is told at the times of a report, once all of them are known.
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "audit/judge.hpp"
#include "odeval/audit.hpp"

namespace odeval::audit {

/// What no estimate says after the motion is lost: that the runs, and that with starts moved, went elsewhere.
struct Apart {
  double place_m = 0;
  double attitude_rad = 0;
};

/// Of all bodies, and of each, until a time.
struct ReportRow {
  ErrorUntil error;
  std::vector<Estimate> runs_m;    // of each refined run
  std::vector<Estimate> runs_rad;  // likewise, its turn
  LimitOf limit;
  LimitOf limit_of_turn;
  Apart apart;
  std::uint32_t worst_body = 0;  // that is farthest off, or turned farthest where that is all of the error
  double worst_t_s = 0;          // when it was
  std::vector<std::pair<BodyError, Apart>> bodies{};
};

/// What is not a number is as large as can be.
double larger_of(double value, double uncertainty);
double larger_of(const Estimate& error);
/// One that half a turn is within says nothing: attitudes are never farther apart.
Estimate as_turn(Estimate error);
/// An error until a time is no less than one until a time before.
void raise(Estimate& error, const Estimate& before);

/// In their order.
class Report {
 public:
  using Rows = std::vector<ReportRow>;

  void add(ReportRow row) { rows_.push_back(std::move(row)); }
  const Rows& rows() const { return rows_; }

  /// The last one, which is the end, says what the time just before it says.
  void end_once();
  /// Runs of another motion may agree for a while, and are no limit of this one. Times below 1 s are for what ends
  /// before that, and for what has no limit by then: from the decade on in which the last of them is that does.
  void sum_up(std::optional<double> lost_at_s);
  /// The last until `t_s`, or the first, that has a limit and is before the motion is lost.
  std::size_t last_told(double t_s) const;

 private:
  bool says_nothing(const ReportRow& row) const;
  std::size_t first_from(double t_s) const;
  std::size_t first_told() const;
  void widen_after_loss();
  void end_with_the_limit();

  Rows rows_;
  std::optional<double> lost_at_s_;
};

}  // namespace odeval::audit
