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

/// A body of the unchanged run.
struct Path {
  BodySample start;
  Bends velocity{};
  Bends spin{};
};

struct Followed {
  Errors errors;
  Path path;
};

class Judge {
 public:
  Judge(const Records& records, Answer& answer) : records_(records), answer_(answer), all_(fresh()) {
    for (const auto& file : records.refined) runs_.emplace_back(file);
    if (records.moved) moved_.emplace(*records.moved);
    chaos_.moved_by_m = records.moved_by_m;
  }

  std::vector<Hidden> judge() {
    while (next()) {
      report_before(moments_.front().frame.t);
      take();
    }
    if (answer_.error_at.empty() || answer_.error_at.back().t_s < answer_.until_s * (1 - 1e-6)) {
      report(answer_.until_s);
    }
    sum_up();
    return hidden_;
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
    const Spread::Limit attitude = all_.turn.limit();
    const double rounding = chaos_.rounding_m();
    ErrorPoint point{own.frame.t, {}, place.uncertainty + unseen_m_ + rounding};
    for (std::size_t run = 0; run < runs_.size(); ++run) point.distance_m.push_back(all_.distance.off(run, place));
    const double error = larger_of(point.distance_m.front(), point.uncertainty_m);
    const double turned = larger_of(all_.turn.off(0, attitude), attitude.uncertainty + unseen_rad_ + rounding);
    curve_.add(std::move(point));
    if (path_.empty() || error > 1.01 * path_.back().distance || turned > 1.01 * path_.back().turn) {
      path_.push_back({own.frame.t, error, turned});
    }
  }

  void take_body(std::size_t i) {
    const BodySample& own = moments_.front().bodies[i];
    auto found = of_body_.find(own.body);
    if (found == of_body_.end()) found = of_body_.emplace(own.body, Followed{fresh(), Path{own}}).first;
    auto& [its, path] = found->second;
    values_.clear();
    for (const Moment& moment : moments_) {
      const BodySample& body = moment.bodies[i];
      values_.insert(values_.end(), body.position, body.position + 3);
    }
    its.distance.add(values_.data(), 3, 1);
    values_.clear();
    for (const Moment& moment : moments_) {
      const std::array<double, 4> quaternion = nearer(moment.bodies[i].quaternion, own.quaternion);
      values_.insert(values_.end(), quaternion.begin(), quaternion.end());
    }
    its.turn.add(values_.data(), 4, 2);  // a small turn is twice the distance of quaternions
    all_.distance.add(its.distance);
    all_.turn.add(its.turn);
    answer_.motion_m = std::max(answer_.motion_m, away(own.position, path.start.position));
    most_turned_ = std::max(most_turned_, audit::turn(own.quaternion, path.start.quaternion));
    const double h = moments_.front().frame.h;
    if (own.kinematic == 0) {
      path.velocity.add(moments_.front().motions[i].velocity, h);
      path.spin.add(moments_.front().motions[i].spin, h);
    }
    unseen_m_ = std::max(unseen_m_, path.velocity.unseen(records_.refinements.back()));
    unseen_rad_ = std::max(unseen_rad_, path.spin.unseen(records_.refinements.back()));
    for (const double x : own.position) chaos_.extent_m = std::max(chaos_.extent_m, std::fabs(x));
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

  Estimate distance(const Spread& spread, std::size_t run = 0) const {
    return spread.error(run, unseen_m_, chaos_.rounding_m());
  }
  /// One that half a turn is within says nothing: attitudes are never farther apart.
  Estimate turn(const Spread& spread) const {
    Estimate its = spread.error(0, unseen_rad_, chaos_.rounding_m());
    if (!(its.uncertainty < std::numbers::pi)) its.convergence = Convergence::none;
    return its;
  }

  /// With what its own bends hide: an impact that it has no part in hides nothing of it.
  BodyError of_body(double t, std::uint32_t body, const Followed& followed) const {
    const auto& [errors, path] = followed;
    const int finest = records_.refinements.back();
    const double rounding = chaos_.rounding_m();
    return {t, body + 1, errors.distance.error(0, path.velocity.unseen(finest), rounding),
            errors.turn.error(0, path.spin.unseen(finest), rounding)};
  }

  void report(double t) {
    reported_until_s_ = answer_.until_s;
    ErrorUntil row;
    row.t_s = t;
    row.distance_m = distance(all_.distance);
    row.turn_rad = turn(all_.turn);
    // Where bodies touch, one that has no limit takes its attitude, or its place, with it.
    if (touched_ && row.convergence() == Convergence::none) {
      row.distance_m.convergence = row.turn_rad.convergence = Convergence::none;
    }
    // The turn is what tells only where next to nothing is a distance.
    const bool rather_turned = row.distance_m.value < ErrorUntil::little * row.turn_rad.value;
    row.order = (rather_turned ? all_.turn : all_.distance).order();
    double largest = -1;
    for (const auto& [body, followed] : of_body_) {
      const BodyError its = of_body(t, body, followed);
      answer_.error_of_body.push_back(its);
      const double size = larger_of(rather_turned ? its.turn_rad : its.distance_m);
      if (size < largest || (size == largest && its.body > row.body)) continue;
      largest = size;
      row.body = its.body;
    }
    for (std::size_t run = 0; run < runs_.size(); ++run) row.of_runs_m.push_back(distance(all_.distance, run).value);
    answer_.error_at.push_back(row);
    std::vector<Estimate> of_runs;
    for (std::size_t run = 0; run < runs_.size(); ++run) of_runs.push_back(distance(all_.distance, run));
    distances_.push_back(std::move(of_runs));
    hidden_.push_back({unseen_m_, chaos_.rounding_m()});
    degrees_.push_back(all_.distance.best_degree());
  }

  void sum_up() {
    leave_out_early_times();
    std::ranges::sort(answer_.error_of_body, [](const BodyError& a, const BodyError& b) {
      return a.t_s != b.t_s ? a.t_s < b.t_s : a.body < b.body;
    });
    find_loss();
    if (records_.moved && moved_) answer_.growth = chaos_.growth();
    answer_.energy.error_J = energy_error();
    answer_.error_over_time = curve_.points();
    find_steps();
  }

  /// At the end alone: in an impact that comes later energies differ for a moment.
  Estimate energy_error() const {
    Spread spread(records_.refinements);
    if (!energies_.empty()) spread.add(energies_.data(), 1, 1);
    return spread.error(0);
  }

  /// What hardly moves is not lost by moving otherwise: less than a millimetre and half a degree are never a loss.
  void find_loss() {
    constexpr double part = 0.1;
    const double distance = std::max(part * answer_.motion_m, 1e-3);
    const double turned = std::max(part * most_turned_, 1e-2);
    const auto lost = std::ranges::find_if(
        path_, [&](const PathPoint& point) { return point.distance > distance || point.turn > turned; });
    if (lost != path_.end()) answer_.lost_at_s = lost->t;
  }

  /// Times below 1 s are for what ends before that.
  void leave_out_early_times() {
    const double first =
        std::pow(10.0, std::floor(std::log10(std::min(1.0, answer_.until_s * (1 + rounding_of_time)))));
    while (answer_.error_at.size() > 1 && answer_.error_at.front().t_s < first * (1 - rounding_of_time)) {
      answer_.error_at.erase(answer_.error_at.begin());
      distances_.erase(distances_.begin());
      hidden_.erase(hidden_.begin());
      degrees_.erase(degrees_.begin());
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
    answer_.limit_degree = degrees_[last];
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
  std::unordered_map<std::uint32_t, Followed> of_body_;
  // Settings differ by what they do in each step, and not more after a hundred thousand: beyond, what is tried only
  // costs.
  static constexpr std::uint64_t most_tried = 100'000;
  double tried_until_s_ = 0;
  double unseen_m_ = 0;  // of any body
  double unseen_rad_ = 0;
  std::vector<double> energies_;  // of the runs, at this step
  Chaos chaos_;
  double most_turned_ = 0;
  bool touched_ = false;  // bodies, so far
  Thinned<ErrorPoint> curve_;
  std::vector<PathPoint> path_;                   // of the error, each time it has grown by a hundredth
  std::vector<std::vector<Estimate>> distances_;  // of the runs, at each time of the report
  std::vector<std::size_t> degrees_;              // of the limit, likewise
  std::vector<Hidden> hidden_;                    // likewise
  int next_report_ = first_report;
  double reported_until_s_ = 0;
};

}  // namespace

std::vector<Hidden> judge(const Records& records, Answer& answer) { return Judge(records, answer).judge(); }

}  // namespace odeval::audit
