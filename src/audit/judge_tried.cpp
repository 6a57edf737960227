// Settings in the place of the program's own: how far from the limit do they take it, and what do they cost?
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "audit/extrapolation.hpp"
#include "audit/judge.hpp"
#include "audit/recording.hpp"

namespace odeval::audit {
namespace {

using Moment = Recording::Moment;

/// Of the program with `set`, "iterations=50", in the place of its own, over what it is.
double solver_work(const Answer& answer, const std::string& set) {
  const SolverWork& solver = answer.solver;
  const auto of = [&](bool quick, double iterations) {
    return solver.besides + (quick ? iterations * solver.iteration : solver.direct);
  };
  const bool quick = answer.stepper == "dWorldQuickStep";
  const double own = of(quick, solver.iterations);
  const std::size_t sign = set.find('=');
  const std::string key = set.substr(0, sign);
  const std::string value = set.substr(sign + 1);
  if (key == "iterations") return of(quick, std::stod(value)) / own;
  if (key != "stepper") return 1;
  return value == "accurate" ? NAN : of(value == "quick", solver.iterations) / own;
}

/// Of a step within ODE, s: the median, since the machine does other things as well.
double cost_of(std::vector<float>& steps) {
  if (steps.empty()) return NAN;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  return *middle;
}

bool same_poses(const Moment& a, const Moment& b) {
  return std::memcmp(a.bodies.data(), b.bodies.data(), a.bodies.size_bytes()) == 0;
}

/// A run beside the refined ones: as long as it has the same steps and bodies.
class Beside {
 public:
  explicit Beside(const std::filesystem::path& file) : run_(file) {}

  /// Its moment that goes with `own`; null: it has ended, or has other bodies.
  const Moment* next(const Moment& own) {
    if (run_) moment_ = run_->next();
    if (!moment_ || !same_bodies(own, *moment_)) {
      moment_.reset();
      run_.reset();
      return nullptr;
    }
    if (moment_->frame.ode_s > 0) steps_.push_back(static_cast<float>(moment_->frame.ode_s));
    return &*moment_;
  }
  double cost_of_step() { return cost_of(steps_); }

 private:
  std::optional<Recording> run_;
  std::optional<Moment> moment_;
  std::vector<float> steps_;  // s within ODE
};

class TriedJudge {
 public:
  TriedJudge(const Records& records, const std::vector<LimitOf>& limits, Answer& answer)
      : records_(records),
        limits_(limits),
        answer_(answer),
        again_(records.unchanged_again),
        all_(records.refinements, records.tried.size() + (records.with_numbers ? 1 : 0)) {
    for (const auto& file : records.refined) runs_.emplace_back(file);
    for (const auto& file : records.tried) others_.emplace_back(file);
    if (records.with_numbers) others_.emplace_back(*records.with_numbers);
    answer_.tried.clear();
    for (std::size_t i = 0; i < records.tried.size(); ++i) {
      answer_.tried.push_back({.set = records.tried_sets[i],
                               .work = solver_work(answer, records.tried_sets[i]),
                               .is_own = true,  // until it is another
                               .asked = records.tried.size() - i <= records.asked});
    }
  }

  void judge() {
    while (next()) {
      report_before(moments_.front().frame.t);
      if (reports_ > answer_.tried_at) break;
      take();
    }
    while (reports_ <= answer_.tried_at) report();
    const double own_cost = again_.cost_of_step();
    for (std::size_t i = 0; i < answer_.tried.size(); ++i) {
      answer_.tried[i].cpu = others_[i].cost_of_step() / own_cost;
    }
  }

 private:
  /// The same step of the refined runs, as far as they were judged.
  bool next() {
    moments_.clear();
    for (Recording& run : runs_) {
      const auto moment = run.next();
      if (!moment || (!moments_.empty() && !same_bodies(moments_.front(), *moment))) return false;
      moments_.push_back(*moment);
    }
    return moments_.front().frame.t <= answer_.until_s * (1 + rounding_of_time);
  }

  void take() {
    const Moment& own = moments_.front();
    of_others_.clear();
    for (Beside& other : others_) of_others_.push_back(other.next(own));
    again_.next(own);
    for (std::size_t i = 0; i < answer_.tried.size(); ++i) {
      if (of_others_[i] == nullptr || !same_poses(own, *of_others_[i])) answer_.tried[i].is_own = false;
    }
    for (std::size_t i = 0; i < own.bodies.size(); ++i) {
      values_.clear();
      for (const Moment& moment : moments_) add(moment.bodies[i], own.bodies[i]);
      for (const Moment* moment : of_others_) {
        if (moment != nullptr) {
          add(moment->bodies[i], own.bodies[i]);
        } else {
          values_.insert(values_.end(), components(), NAN);
        }
      }
      all_.add(values_.data(), components(), answer_.by_turn ? 2 : 1);  // a turn is twice the distance of quaternions
    }
  }

  std::size_t components() const { return answer_.by_turn ? 4 : 3; }
  void add(const BodySample& body, const BodySample& own) {
    if (answer_.by_turn) {
      const std::array<double, 4> quaternion = nearer(body.quaternion, own.quaternion);
      values_.insert(values_.end(), quaternion.begin(), quaternion.end());
    } else {
      values_.insert(values_.end(), body.position, body.position + 3);
    }
  }

  void report_before(double t) {
    while (reports_ <= answer_.tried_at && answer_.error_at[reports_].t_s < t * (1 - rounding_of_time)) report();
  }

  void report() {
    const bool has_limit = answer_.error_at[reports_].convergence() != Convergence::none;
    const LimitOf& limit = limits_[reports_++];
    const auto error = [&](std::size_t run) {
      Estimate its{all_.off(run, {limit.degree, limit.uncertainty}), limit.uncertainty, Convergence::none};
      if (has_limit) its.convergence = all_.convergence(its, limit.unseen);
      return its;
    };
    for (std::size_t i = 0; i < answer_.tried.size(); ++i) {
      answer_.tried[i].error.push_back(error(runs_.size() + i));
    }
    if (!records_.with_numbers || answer_.by_turn) return;
    answer_.softness_m = error(runs_.size() + answer_.tried.size()).value;
    answer_.softness_of_step_m = error(1).value;
  }

  const Records& records_;
  const std::vector<LimitOf>& limits_;
  Answer& answer_;
  std::vector<Recording> runs_;
  std::vector<Beside> others_;  // tried, then with numbers
  Beside again_;                // the unchanged run, without a ledger
  Spread all_;
  std::vector<Moment> moments_;           // of this step, of the refined runs
  std::vector<const Moment*> of_others_;  // likewise
  std::vector<double> values_;
  std::size_t reports_ = 0;
};

}  // namespace

void judge_tried(const Records& records, const std::vector<LimitOf>& limits, Answer& answer) {
  TriedJudge(records, limits, answer).judge();
}

}  // namespace odeval::audit
