#include "audit/judge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "audit/extrapolation.hpp"
#include "audit/recording.hpp"
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

/// Where a body is, or how it is turned, and what no run sees of it.
struct Part {
  Spread spread;
  Bends bends{};
};

/// A body, from its start in the unchanged run.
struct Followed {
  BodySample start;
  Part place;
  Part attitude;
  std::array<double, 3> turned{};  // rad, the sum of its turns, which goes on where an attitude comes back
  double most_turned = 0;          // rad, of that
  BodyError before{};              // at the last time of the report
};

/// What no estimate says after the motion is lost: that the runs, and that with starts moved, went elsewhere.
struct Apart {
  double place_m = 0;
  double attitude_rad = 0;
};

void widen(Estimate& error, double apart) {
  error.uncertainty += apart;
  error.convergence = std::max(error.convergence, Convergence::rough);
}

/// An error until a time is no less than until one before.
void raise(Estimate& error, const Estimate& before) {
  if (before.convergence == Convergence::none || !(before.value > error.value)) return;
  error.value = before.value;
  error.uncertainty = std::max(error.uncertainty, before.uncertainty);
}

class Judge {
 public:
  Judge(const Records& records, Answer& answer)
      : records_(records), answer_(answer), all_(fresh()), turns_(records.refinements) {
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
    if (answer_.error_at.empty() || answer_.error_at.back().t_s < answer_.until_s * (1 - 1e-6)) {
      report(answer_.until_s);
    }
    sum_up();
    return limits_;
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
    const Spread::Limit attitude = turns_.limit();
    const double rounding = chaos_.rounding_m();
    ErrorPoint point{own.frame.t, {}, place.uncertainty + unseen_m_ + rounding};
    for (std::size_t run = 0; run < runs_.size(); ++run) point.distance_m.push_back(all_.distance.off(run, place));
    const double error = larger_of(point.distance_m.front(), point.uncertainty_m);
    double turned = larger_of(turns_.off(0, attitude), attitude.uncertainty + unseen_rad_ + rounding);
    if (turned_away_) turned = HUGE_VAL;
    curve_.add(std::move(point));
    if (path_.empty() || error > 1.01 * path_.back().distance || turned > 1.01 * path_.back().turn) {
      path_.push_back({own.frame.t, error, turned});
    }
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
    follow_turn(its, own, motion);
    answer_.motion_m = std::max(answer_.motion_m, away(own.position, its.start.position));
    if (own.kinematic == 0) {
      its.place.bends.add(motion.velocity, h);
      its.attitude.bends.add(motion.spin, h);
    }
    unseen_m_ = std::max(unseen_m_, its.place.bends.unseen(records_.refinements.back()));
    if (its.most_turned <= std::numbers::pi)
      unseen_rad_ = std::max(unseen_rad_, its.attitude.bends.unseen(records_.refinements.back()));
    for (const double x : own.position) chaos_.extent_m = std::max(chaos_.extent_m, std::fabs(x));
  }

  /// One that turns by more than half a turn is held against that, up to where an attitude says nothing any more.
  void follow_turn(Followed& its, const BodySample& own, const MotionSample& motion) {
    const double h = moments_.front().frame.h;
    for (std::size_t k = 0; k < 3; ++k) its.turned[k] += h * motion.spin[k];
    most_turned_ = std::max(most_turned_, turn(own.quaternion, its.start.quaternion));
    its.most_turned = std::max(its.most_turned, std::hypot(its.turned[0], its.turned[1], its.turned[2]));
    if (its.most_turned <= std::numbers::pi) return turns_.add(its.attitude.spread);
    constexpr double any_turn = 2;  // rad: one that is farther off may be so by any number of turns
    if (turned_away_) return;
    turned_away_ = larger_of(estimate(its.attitude)) > std::min(lost_part * its.most_turned, any_turn);
  }

  void take_moved(const Moment& own) {
    if (!moved_) return;
    const auto moved = moved_->next();
    if (!moved || !same_bodies(own, *moved)) return moved_.reset();
    for (std::size_t i = 0; i < own.bodies.size(); ++i) {
      chaos_.apart_m = std::max(chaos_.apart_m, away(own.bodies[i].position, moved->bodies[i].position));
    }
  }

  /// A time of the report has passed when the first step after it comes, whether or not one ended on it.
  void report_before(double t) {
    for (double at = report_time(next_report_); at < t * (1 - rounding_of_time); at = report_time(++next_report_)) {
      if (answer_.until_s > reported_until_s_) report(at);
    }
  }

  /// What is not a number is as large as can be.
  static double larger_of(double value, double uncertainty) {
    if (std::isnan(value) || std::isnan(uncertainty)) return std::numeric_limits<double>::infinity();
    return std::max(value, uncertainty);
  }
  static double larger_of(const Estimate& error) { return larger_of(error.value, error.uncertainty); }

  static double most_of(const Estimate& error) {
    const double most = error.value + error.uncertainty;
    return std::isnan(most) ? std::numeric_limits<double>::infinity() : most;
  }

  double unseen(const Part& part) const { return part.bends.unseen(records_.refinements.back()); }
  /// With what its own bends hide: an impact that it has no part in hides nothing of it.
  Estimate estimate(const Part& part, std::size_t run = 0) const {
    return part.spread.error(run, unseen(part), chaos_.rounding_m());
  }
  /// One that half a turn is within says nothing: attitudes are never farther apart.
  static Estimate as_turn(Estimate error) {
    if (!(error.uncertainty < std::numbers::pi)) error.convergence = Convergence::none;
    return error;
  }

  /// The body that is farthest off, or may be.
  struct Farthest {
    std::uint32_t body = 0;  // from 1
    const Part* part;
    double size = -1;
  };
  Farthest farthest(Part Followed::*part) const {
    Farthest its{.part = &nothing_};
    for (const auto& [body, followed] : of_body_) {
      const double size = larger_of(estimate(followed.*part));
      if (size < its.size || (size == its.size && body + 1 > its.body)) continue;
      its = {body + 1, &(followed.*part), size};
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
    for (auto& [body, followed] : of_body_) report_body(t, body, followed);
    const Farthest placed = farthest(&Followed::place);
    const Farthest turned = farthest(&Followed::attitude);
    std::vector<Estimate> of_runs;
    for (std::size_t run = 0; run < runs_.size(); ++run) {
      of_runs.push_back(largest(placed, &Followed::place, all_.distance, run));
      if (!distances_.empty()) raise(of_runs.back(), distances_.back()[run]);
    }
    ErrorUntil row;
    row.t_s = t;
    row.distance_m = of_runs.front();
    row.turn_rad = as_turn(largest(turned, &Followed::attitude, all_.turn));
    if (!answer_.error_at.empty()) raise(row.turn_rad, answer_.error_at.back().turn_rad);
    // Where bodies touch, one that has no limit takes its attitude, or its place, with it.
    if (touched_ && row.convergence() == Convergence::none) {
      row.distance_m.convergence = row.turn_rad.convergence = Convergence::none;
    }
    // The turn is what tells only where next to nothing is a distance.
    const bool rather_turned = row.distance_m.value < ErrorUntil::little * row.turn_rad.value;
    row.order = (rather_turned ? turned : placed).part->spread.order();
    row.body = (rather_turned ? turned : placed).body;
    for (const Estimate& run : of_runs) row.of_runs_m.push_back(run.value);
    answer_.error_at.push_back(row);
    apart_.push_back(apart(all_.distance, all_.turn));
    limits_.push_back({placed.part->spread.best_degree(), row.distance_m.uncertainty, unseen(*placed.part)});
    distances_.push_back(std::move(of_runs));
  }

  void report_body(double t, std::uint32_t body, Followed& followed) {
    BodyError its{t, body + 1, estimate(followed.place), as_turn(estimate(followed.attitude))};
    raise(its.distance_m, followed.before.distance_m);
    raise(its.turn_rad, followed.before.turn_rad);
    followed.before = its;
    answer_.error_of_body.push_back(its);
    apart_of_body_.push_back(apart(followed.place.spread, followed.attitude.spread));
  }

  Apart apart(const Spread& place, const Spread& attitude) const {
    return {place.last_apart() + chaos_.apart_m, attitude.last_apart() + chaos_.apart_m};
  }

  void sum_up() {
    find_loss();
    widen_after_loss();
    leave_out_early_times();
    std::ranges::sort(answer_.error_of_body, [](const BodyError& a, const BodyError& b) {
      return a.t_s != b.t_s ? a.t_s < b.t_s : a.body < b.body;
    });
    if (records_.moved && moved_) answer_.growth = chaos_.growth();
    answer_.energy.error_J = energy_error();
    answer_.error_over_time = curve_.points();
    find_steps();
  }

  /// At the end alone: in an impact that comes later energies differ for a moment. Where the motion is lost by then,
  /// they are of other motions, and their agreement is chance.
  Estimate energy_error() const {
    Spread spread(records_.refinements);
    if (!energies_.empty()) spread.add(energies_.data(), 1, 1);
    Estimate its = spread.error(0);
    if (answer_.lost_at_s) its.convergence = Convergence::none;
    return its;
  }

  /// What hardly moves is not lost by moving otherwise: less than a millimetre and half a degree are never a loss.
  void find_loss() {
    const double distance = std::max(lost_part * answer_.motion_m, 1e-3);
    const double turned = std::max(lost_part * most_turned_, 1e-2);
    const auto lost = std::ranges::find_if(
        path_, [&](const PathPoint& point) { return point.distance > distance || point.turn > turned; });
    if (lost != path_.end()) answer_.lost_at_s = lost->t;
  }

  /// Runs of another motion may agree for a while, and are no limit of this one.
  void widen_after_loss() {
    if (!answer_.lost_at_s) return;
    const auto is_after = [this](double t) { return t > *answer_.lost_at_s; };
    for (std::size_t i = 0; i < answer_.error_at.size(); ++i) {
      ErrorUntil& row = answer_.error_at[i];
      if (!is_after(row.t_s)) continue;
      widen(row.distance_m, apart_[i].place_m);
      widen(row.turn_rad, apart_[i].attitude_rad);
      row.turn_rad = as_turn(row.turn_rad);
      limits_[i].uncertainty_m = row.distance_m.uncertainty;
      for (Estimate& run : distances_[i]) widen(run, apart_[i].place_m);
    }
    for (std::size_t i = 0; i < answer_.error_of_body.size(); ++i) {
      BodyError& row = answer_.error_of_body[i];
      if (!is_after(row.t_s)) continue;
      widen(row.distance_m, apart_of_body_[i].place_m);
      widen(row.turn_rad, apart_of_body_[i].attitude_rad);
      row.turn_rad = as_turn(row.turn_rad);
    }
  }

  /// Times below 1 s are for what ends before that.
  void leave_out_early_times() {
    const double first =
        std::pow(10.0, std::floor(std::log10(std::min(1.0, answer_.until_s * (1 + rounding_of_time)))));
    while (answer_.error_at.size() > 1 && answer_.error_at.front().t_s < first * (1 - rounding_of_time)) {
      answer_.error_at.erase(answer_.error_at.begin());
      distances_.erase(distances_.begin());
      limits_.erase(limits_.begin());
    }
    std::erase_if(answer_.error_of_body, [&](const BodyError& row) { return row.t_s < answer_.error_at.front().t_s; });
  }

  /// The last time of the report until `t_s`, or the first, that has a limit and is before the motion is lost.
  std::size_t last_told(double t_s) const {
    const auto says_nothing = [&](const ErrorUntil& row) {
      return row.convergence() == Convergence::none || row.t_s > std::min(t_s, answer_.lost_at_s.value_or(HUGE_VAL));
    };
    std::size_t last = answer_.error_at.size() - 1;
    while (last > 0 && says_nothing(answer_.error_at[last])) --last;
    return last;
  }

  void find_steps() {
    const std::size_t last = last_told(HUGE_VAL);
    answer_.told_at = last;
    answer_.tried_at = last_told(tried_until_s_ * (1 + rounding_of_time));
    answer_.steps_for_t_s = answer_.error_at[last].t_s;
    answer_.limit_degree = limits_[last].degree;
    for (const PathPoint& point : path_) {
      if (point.t <= answer_.steps_for_t_s * (1 + rounding_of_time)) answer_.worst_t_s = point.t;
    }
    for (const double wanted : {1e-3, 1e-2, 1e-1}) answer_.steps_for.push_back({wanted, step_for(last, wanted)});
  }

  std::optional<double> step_for(std::size_t report, double wanted) const {
    const ErrorUntil& own = answer_.error_at[report];
    if (own.convergence() == Convergence::none) return std::nullopt;
    std::vector<StepError> runs;
    for (std::size_t run = 0; run < runs_.size(); ++run) {
      const Estimate& error = distances_[report][run];
      runs.push_back({answer_.h_s / records_.refinements[run], error.value + error.uncertainty});
    }
    const bool settled = own.convergence() == Convergence::settled;
    return step_that_keeps(wanted, runs, settled ? own.order : std::nullopt, settled);
  }

  struct PathPoint {
    double t;
    double distance;
    double turn;
  };

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
  double unseen_m_ = 0;  // of any body
  double unseen_rad_ = 0;
  std::vector<double> energies_;  // of the runs, at this step
  Chaos chaos_;
  static constexpr double lost_part = 0.1;  // of how far bodies go or turn, is another motion
  Spread turns_;                            // of bodies until they have turned by more than half a turn
  bool turned_away_ = false;                // one of those that have
  double most_turned_ = 0;
  bool touched_ = false;  // bodies, so far
  bool bodies_meet_ = false;
  Thinned<ErrorPoint> curve_;
  std::vector<PathPoint> path_;                   // of the error, each time it has grown by a hundredth
  std::vector<std::vector<Estimate>> distances_;  // of the runs, at each time of the report
  std::vector<LimitOf> limits_;                   // likewise
  std::vector<Apart> apart_;                      // likewise
  std::vector<Apart> apart_of_body_;              // of Answer::error_of_body, before they are sorted
  int next_report_ = first_report;
  double reported_until_s_ = 0;
};

}  // namespace

std::vector<LimitOf> judge(const Records& records, Answer& answer) { return Judge(records, answer).judge(); }

}  // namespace odeval::audit
