#include "audit/judge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "audit/extrapolation.hpp"
#include "audit/loss.hpp"
#include "audit/recording.hpp"
#include "audit/report.hpp"
#include "audit/thinned.hpp"
#include "audit/unseen.hpp"

namespace odeval::audit {
namespace {

using Moment = Recording::Moment;

/// 1, 2, 5, 10, … s, and those below where the run does not reach 1 s.
double report_time(int number) {
  constexpr std::array leads{1.0, 2.0, 5.0};
  const int decade = number >= 0 ? number / 3 : -((2 - number) / 3);
  return leads[static_cast<std::size_t>(number - 3 * decade)] * std::pow(10.0, decade);
}
constexpr int first_report = -9;  // 1 ms

double away(const double* a, const double* b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/// Between attitudes, rad.
double turn(const double* a, const double* b) {
  const std::array<double, 4> near = nearer(a, b);
  double square = 0;
  for (int i = 0; i < 4; ++i) square += (near[i] - b[i]) * (near[i] - b[i]);
  return 4 * std::asin(std::min(1.0, std::sqrt(square) / 2));
}

struct Errors {
  Spread distance;
  Spread turn;
};

// What hardly moves is not lost by moving otherwise: less than a millimetre and half a degree are never a loss.
constexpr double least_lost_m = 1e-3;
constexpr double least_lost_rad = 1e-2;
// One that is farther off may be so by any number of turns.
constexpr double most_kept_rad = 2;

/// Where a body is, or how it is turned, and what no run sees of it.
struct Part {
  Spread spread;
  Bends bends{};
  double grown = 0;      // its error, when that last grew by a hundredth
  double grown_t_s = 0;  // then

  void follow(double t) {
    const double error = spread.off(0, spread.limit());
    if (grown > 0 ? error <= 1.01 * grown : error == 0) return;
    grown = error;
    grown_t_s = t;
  }
};

/// A body, from its start in the unchanged run.
struct Followed {
  BodySample start;
  Part place;
  Part attitude;
  double way_m = 0;                // from there, the farthest
  std::array<double, 3> turned{};  // rad, the sum of its turns, which goes on where an attitude comes back
  double most_turned = 0;          // rad, of that, or from its first attitude
  Loss of_place{least_lost_m, HUGE_VAL};
  Loss of_attitude{least_lost_rad, most_kept_rad};
  BodyError before{};  // at the last time of the report
};

class Judge {
 public:
  Judge(const Records& records, Answer& answer) : records_(records), answer_(answer), all_(fresh()) {
    for (const auto& file : records.refined) runs_.emplace_back(file);
    if (records.moved) moved_.emplace(*records.moved);
    chaos_.moved_by_m = records.moved_by_m;
    bodies_meet_ = std::ranges::any_of(answer.joint_summaries, [](const JointSummary& its) {
      return its.number == 0 && its.bodies[0] != 0 && its.bodies[1] != 0;
    });
  }

  std::vector<LimitOf> judge() {
    while (next()) {
      report_before(moments_.front().frame.t);
      take();
    }
    if (report_.rows().empty() || report_.rows().back().error.t_s < answer_.until_s * (1 - 1e-6)) {
      report(answer_.until_s);
      report_.end_once();
    }
    sum_up();
    std::vector<LimitOf> limits;
    for (const ReportRow& row : report_.rows()) limits.push_back(answer_.by_turn ? row.limit_of_turn : row.limit);
    return limits;
  }

 private:
  Errors fresh() const { return {Spread(records_.refinements), Spread(records_.refinements)}; }

  /// The same step of all runs; false when one has none, or other bodies, or the program's own is no number any more.
  bool next() {
    moments_.clear();
    for (Recording& run : runs_) {
      const auto moment = run.next();
      if (!moment) return false;
      if (!moments_.empty() && !same_bodies(moments_.front(), *moment)) {
        answer_.limits.push_back("refined runs have other bodies or other steps from step " +
                                 std::to_string(moment->frame.step) + " on, and are compared until there");
        return false;
      }
      if (moments_.empty() && not_finite(*moment) != 0) return false;
      moments_.push_back(*moment);
    }
    return true;
  }

  void take() {
    const Moment& own = moments_.front();
    for (std::size_t i = 0; i < own.bodies.size(); ++i) take_body(i);
    energies_.clear();
    for (const Moment& moment : moments_) energies_.push_back(moment.frame.kinetic + moment.frame.potential);
    touched_ = touched_ || own.account->contacts > 0;
    take_moved(own);
    if (own.frame.step <= most_tried) tried_until_s_ = std::max(tried_until_s_, own.frame.t);
    chaos_.steps = own.frame.step * static_cast<std::uint64_t>(records_.refinements.back());
    answer_.until_s = std::max(answer_.until_s, own.frame.t);
    const Spread::Limit place = all_.distance.limit();
    ErrorPoint point{own.frame.t, {}, place.uncertainty + unseen_m_ + chaos_.rounding_m()};
    for (std::size_t run = 0; run < runs_.size(); ++run) point.distance_m.push_back(all_.distance.off(run, place));
    find_chaos(own.frame.t, larger_of(point.distance_m.front(), place.uncertainty));
    curve_.add(std::move(point));
  }

  void take_body(std::size_t i) {
    const BodySample& own = moments_.front().bodies[i];
    auto found = of_body_.find(own.body);
    if (found == of_body_.end()) {
      const Errors none = fresh();
      found =
          of_body_.emplace(own.body, Followed{.start = own, .place = {none.distance}, .attitude = {none.turn}}).first;
    }
    Followed& its = found->second;
    const double h = moments_.front().frame.h;
    const MotionSample& motion = moments_.front().motions[i];
    values_.clear();
    for (const Moment& moment : moments_) {
      const BodySample& body = moment.bodies[i];
      values_.insert(values_.end(), body.position, body.position + 3);
    }
    its.place.spread.add(values_.data(), 3, 1);
    values_.clear();
    for (const Moment& moment : moments_) {
      const std::array<double, 4> quaternion = nearer(moment.bodies[i].quaternion, own.quaternion);
      values_.insert(values_.end(), quaternion.begin(), quaternion.end());
    }
    its.attitude.spread.add(values_.data(), 4, 2);  // a small turn is twice the distance of quaternions
    all_.distance.add(its.place.spread);
    all_.turn.add(its.attitude.spread);
    its.way_m = std::max(its.way_m, away(own.position, its.start.position));
    for (std::size_t k = 0; k < 3; ++k) its.turned[k] += h * motion.spin[k];
    its.most_turned = std::max({its.most_turned, turn(own.quaternion, its.start.quaternion),
                                std::hypot(its.turned[0], its.turned[1], its.turned[2])});
    if (own.kinematic == 0) {
      its.place.bends.add(motion.velocity, h);
      its.attitude.bends.add(motion.spin, h);
    }
    unseen_m_ = std::max(unseen_m_, unseen(its.place));
    for (const double x : own.position) chaos_.extent_m = std::max(chaos_.extent_m, std::fabs(x));
    finest_way_m_ = std::max(finest_way_m_, away(moments_.back().bodies[i].position, its.start.position));
    follow_error(its, moments_.front().frame.t);
  }

  void follow_error(Followed& its, double t) {
    its.of_place.add(t, size_of(its.place), its.way_m);
    its.of_attitude.add(t, size_of(its.attitude), its.most_turned);
    its.place.follow(t);
    its.attitude.follow(t);
  }

  void take_moved(const Moment& own) {
    if (!moved_) return;
    const auto moved = moved_->next();
    if (!moved || !same_bodies(own, *moved)) return moved_.reset();
    for (std::size_t i = 0; i < own.bodies.size(); ++i) {
      chaos_.apart_m = std::max(chaos_.apart_m, away(own.bodies[i].position, moved->bodies[i].position));
    }
  }

  /// Where starts that differ by next to nothing are apart by as much as the steps make, and stay so, any step leads
  /// elsewhere. Both are the most so far, and are held against each other by their sizes. What flies apart much farther
  /// than the finest run goes at all is no chaos, but a step that is too long.
  void find_chaos(double t, double error) {
    if (!moved_) return;
    constexpr double grows = 1e3;
    answer_.flies_apart = chaos_.apart_m > 10 * std::max(finest_way_m_, least_lost_m);
    std::optional<double>& from = answer_.chaos_from_s;
    if (answer_.flies_apart || chaos_.apart_m < error / 10) from.reset();
    if (!from && !answer_.flies_apart && chaos_.growth() >= grows && chaos_.apart_m >= error / 4) from = t;
  }

  /// A time of the report has passed when the first step after it comes, whether or not one ended on it.
  void report_before(double t) {
    for (double at = report_time(next_report_); at < t * (1 - rounding_of_time); at = report_time(++next_report_)) {
      if (answer_.until_s > reported_until_s_) report(at);
    }
  }

  /// Of an error of the program's own run, or of what it may be.
  double size_of(const Part& part) const {
    const Spread::Limit limit = part.spread.limit();
    return larger_of(part.spread.off(0, limit), limit.uncertainty + unseen(part) + chaos_.rounding_m());
  }

  static double most_of(const Estimate& error) {
    const double most = error.value + error.uncertainty;
    return std::isnan(most) ? std::numeric_limits<double>::infinity() : most;
  }

  double unseen(const Part& part) const { return part.bends.unseen(records_.refinements.back()); }
  /// With what its own bends hide: an impact that it has no part in hides nothing of it.
  Estimate estimate(const Part& part, std::size_t run = 0) const {
    return part.spread.error(run, unseen(part), chaos_.rounding_m());
  }
  /// The body that is farthest off, or may be: of those that are so but for rounding, the first made.
  struct Farthest {
    std::uint32_t body = 0;  // from 1
    const Part* part;
  };
  Farthest farthest(Part Followed::*part) const {
    double size = 0;
    for (const auto& [body, followed] : of_body_) size = std::max(size, larger_of(estimate(followed.*part)));
    Farthest its{.part = &nothing_};
    constexpr double but_for_rounding = 1 - 1e-6;
    for (const auto& [body, followed] : of_body_) {
      if (its.body != 0 && body + 1 > its.body) continue;
      if (larger_of(estimate(followed.*part)) < but_for_rounding * size) continue;
      its = {body + 1, &(followed.*part)};
    }
    return its;
  }

  /// Of all bodies: by the limit of the one that is farthest off, as uncertain as that one is, or as another may be
  /// off by more. One that is hard to tell hides nothing of one that is farther off.
  Estimate largest(const Farthest& named, Part Followed::*part, const Spread& all, std::size_t run = 0) const {
    Estimate its{all.off(run, named.part->spread.limit()), 0, Convergence::none};
    const Estimate its_own = estimate(*named.part, run);
    double most = most_of(its_own);
    bool has_limit = true;
    constexpr double counts = 0.1;  // of the error: what is settled is known to that
    for (const auto& [body, followed] : of_body_) {
      const Estimate other = estimate(followed.*part, run);
      most = std::max(most, most_of(other));
      has_limit = has_limit && (other.convergence != Convergence::none || larger_of(other) <= counts * its.value);
    }
    its.uncertainty = std::max(its.value - its_own.value + its_own.uncertainty, most - its.value);
    if (has_limit) its.convergence = named.part->spread.convergence(its, unseen(*named.part));
    // Where bodies hit each other, the order in which they do may be another at a smaller step: runs that move apart by
    // that are not apart by the chance of where one impact falls in a step.
    constexpr double apart = -1.0 / 3;
    const bool parts = bodies_meet_ && named.part->spread.order().value_or(0) < apart;
    if (parts && its.convergence == Convergence::rough) its.convergence = Convergence::none;
    return its;
  }

  void report(double t) {
    reported_until_s_ = answer_.until_s;
    const ReportRow* const before = report_.rows().empty() ? nullptr : &report_.rows().back();
    const Farthest placed = farthest(&Followed::place);
    const Farthest turned = farthest(&Followed::attitude);
    ReportRow row;
    for (std::size_t run = 0; run < runs_.size(); ++run) {
      row.runs_m.push_back(largest(placed, &Followed::place, all_.distance, run));
      row.runs_rad.push_back(as_turn(largest(turned, &Followed::attitude, all_.turn, run)));
      if (before == nullptr) continue;
      raise(row.runs_m.back(), before->runs_m[run]);
      raise(row.runs_rad.back(), before->runs_rad[run]);
    }
    ErrorUntil& error = row.error;
    error.t_s = t;
    error.distance_m = row.runs_m.front();
    error.turn_rad = row.runs_rad.front();
    // Where bodies touch, one that has no limit takes its attitude, or its place, with it.
    if (touched_ && error.convergence() == Convergence::none) {
      error.distance_m.convergence = error.turn_rad.convergence = Convergence::none;
    }
    const Farthest& worst = error.turned() ? turned : placed;
    error.order = worst.part->spread.order();
    error.body = worst.body;
    for (const Estimate& run : error.turned() ? row.runs_rad : row.runs_m) error.of_runs.push_back(run.value);
    row.limit = {placed.part->spread.best_degree(), error.distance_m.uncertainty, unseen(*placed.part)};
    row.limit_of_turn = {turned.part->spread.best_degree(), error.turn_rad.uncertainty, unseen(*turned.part)};
    row.apart = apart(all_.distance, all_.turn);
    row.worst_body = worst.body;
    row.worst_t_s = worst.part->grown_t_s;
    for (auto& [body, followed] : of_body_) row.bodies.push_back(of_body(t, body, followed));
    report_.add(std::move(row));
  }

  std::pair<BodyError, Apart> of_body(double t, std::uint32_t body, Followed& followed) const {
    BodyError its{t, body + 1, estimate(followed.place), as_turn(estimate(followed.attitude))};
    raise(its.distance_m, followed.before.distance_m);
    raise(its.turn_rad, followed.before.turn_rad);
    followed.before = its;
    return {its, apart(followed.place.spread, followed.attitude.spread)};
  }

  Apart apart(const Spread& place, const Spread& attitude) const {
    return {place.last_apart() + chaos_.apart_m, attitude.last_apart() + chaos_.apart_m};
  }

  void sum_up() {
    find_loss();
    report_.sum_up(answer_.lost_at_s);
    for (const ReportRow& row : report_.rows()) {
      answer_.error_at.push_back(row.error);
      for (const auto& [body, apart] : row.bodies) answer_.error_of_body.push_back(body);
    }
    std::ranges::sort(answer_.error_of_body, [](const BodyError& a, const BodyError& b) {
      return a.t_s != b.t_s ? a.t_s < b.t_s : a.body < b.body;
    });
    if (records_.moved && moved_) answer_.growth = chaos_.growth();
    answer_.energy.error_J = energy_error();
    answer_.error_over_time = curve_.points();
    find_steps();
  }

  /// At the end alone: in an impact that comes later energies differ for a moment. Numbers at one time may be near to
  /// each other by chance: they are known no better than the motion until then, a metre counted as a radian. Where it
  /// is lost by then, they are of other motions.
  Estimate energy_error() const {
    Spread spread(records_.refinements);
    if (!energies_.empty()) spread.add(energies_.data(), 1, 1);
    Estimate its = spread.error(0);
    const ErrorUntil& motion = report_.rows().back().error;
    const double off = motion.distance_m.value + motion.turn_rad.value;
    if (off > Estimate::nothing) {
      const double share = (motion.distance_m.uncertainty + motion.turn_rad.uncertainty) / off;
      its.uncertainty = std::max(its.uncertainty, share * its.value);
    }
    its.convergence = answer_.lost_at_s ? Convergence::none : std::max(its.convergence, motion.convergence());
    return its;
  }

  /// Of the body that is lost first; the first made, where several are.
  void find_loss() {
    const auto lost = [this](std::uint32_t body, const Loss& its, bool turned) {
      if (!its.since_s()) return;
      const auto of = std::tuple(*its.since_s(), body, turned);
      if (answer_.lost_at_s && std::tuple(*answer_.lost_at_s, answer_.lost_body, answer_.lost_turned) < of) return;
      std::tie(answer_.lost_at_s, answer_.lost_body, answer_.lost_turned) = of;
    };
    for (const auto& [body, followed] : of_body_) {
      lost(body + 1, followed.of_place, false);
      lost(body + 1, followed.of_attitude, true);
    }
  }

  void find_steps() {
    answer_.told_at = report_.last_told(HUGE_VAL);
    answer_.tried_at = report_.last_told(tried_until_s_ * (1 + rounding_of_time));
    const ReportRow& last = report_.rows()[answer_.told_at];
    answer_.steps_for_t_s = last.error.t_s;
    // Where there is no limit, the finest run is the best there is.
    answer_.by_turn = last.error.turned();
    const LimitOf& limit = answer_.by_turn ? last.limit_of_turn : last.limit;
    if (last.error.convergence() != Convergence::none) answer_.limit_degree = limit.degree;
    answer_.worst_body = last.worst_body;
    answer_.worst_t_s = last.worst_t_s;
    for (const double wanted : {1e-3, 1e-2, 1e-1}) answer_.steps_for.push_back({wanted, step_for(last, wanted)});
  }

  std::optional<double> step_for(const ReportRow& row, double wanted) const {
    if (row.error.convergence() == Convergence::none) return std::nullopt;
    std::vector<StepError> runs;
    for (std::size_t run = 0; run < runs_.size(); ++run) {
      const Estimate& error = (answer_.by_turn ? row.runs_rad : row.runs_m)[run];
      runs.push_back({answer_.h_s / records_.refinements[run], error.value + error.uncertainty});
    }
    const bool settled = row.error.convergence() == Convergence::settled;
    return step_that_keeps(wanted, runs, settled ? row.error.order : std::nullopt, settled);
  }

  const Records& records_;
  Answer& answer_;
  std::vector<Recording> runs_;
  std::optional<Recording> moved_;
  std::vector<Moment> moments_;  // of this step, one a run
  std::vector<double> values_;
  Errors all_;
  const Part nothing_{fresh().distance};  // where there is no body
  std::unordered_map<std::uint32_t, Followed> of_body_;
  // Settings differ by what they do in each step, and not more after a hundred thousand: beyond, what is tried only
  // costs.
  static constexpr std::uint64_t most_tried = 100'000;
  double tried_until_s_ = 0;
  double unseen_m_ = 0;           // of any body
  std::vector<double> energies_;  // of the runs, at this step
  Chaos chaos_;
  double finest_way_m_ = 0;  // of a body, from its start in the unchanged run
  bool touched_ = false;     // bodies, so far
  bool bodies_meet_ = false;
  Thinned<ErrorPoint> curve_;
  Report report_;
  int next_report_ = first_report;
  double reported_until_s_ = 0;
};

}  // namespace

std::vector<LimitOf> judge(const Records& records, Answer& answer) { return Judge(records, answer).judge(); }

}  // namespace odeval::audit
