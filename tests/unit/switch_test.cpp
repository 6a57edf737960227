// The rule of "Should I switch?": of measurements that are made up each gives the advice that the page states.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "experiments/free_box_published.hpp"
#include "experiments/rolling.hpp"
#include "experiments/should_i_switch.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using namespace odeval::experiments::engines;

const catalogue::Method& row(std::string_view name) {
  return *std::ranges::find(catalogue::methods(), name, &catalogue::Method::name);
}

/// The ways of every motion below, in the order of what they ask of a program.
std::vector<Way> all_ways() {
  return {{&row("ode-step-double"), Move::stay, "", nullptr},
          {&row("ode-step-double"), Move::change_a_setting, "ERP 0.8", nullptr},
          {&row("ode-rk4-double"), Move::accurate_step, "", nullptr},
          {&row("mujoco-euler"), Move::leave, "", nullptr},
          {&row("bullet-hinge-double"), Move::leave, "100 iterations", nullptr}};
}

/// A motion on which each way keeps the error at a CPU time, µs; 0: nowhere. ODE as it is has a time in any case.
Result motion(const std::vector<double>& us, bool plain_keeps = true) {
  Result result{all_ways(), {}};
  for (std::size_t i = 0; i < us.size(); ++i) {
    Tried tried;
    tried.keeps = us[i] > 0 && (i > 0 || plain_keeps);
    tried.us_per_s = us[i];
    tried.setting = 1e-3;
    tried.error = {1e-3 * static_cast<double>(i + 1)};
    result.tried.push_back(tried);
  }
  return result;
}

std::string advised(const std::vector<Result>& results) {
  const auto advice = advice_of(results);
  return advice ? sentence_of(*advice) : "none";
}

struct Case {
  std::vector<std::vector<double>> us;  // of each motion
  std::string sentence;
};

// ODE as it is takes 100 µs throughout; a gain of 1.5 is worth a change, and a step further 1.5 times that.
const std::vector<Case> cases{
    {{{100, 90, 90, 90, 90}}, "stay"},
    {{{100, 70, 70, 70, 70}}, "stay"},
    {{{100, 60, 70, 70, 70}}, "change a setting, ERP 0.8: 1.67 times less CPU time"},
    {{{100, 48, 40, 35, 90}}, "change a setting, ERP 0.8: 2.08 times less CPU time"},
    {{{100, 48, 30, 90, 90}}, "use accurate_step: 3.33 times less CPU time"},
    {{{100, 48, 30, 25, 90}}, "use accurate_step: 3.33 times less CPU time"},
    {{{100, 48, 40, 9, 90}}, "switch to mujoco-euler: 11.1 times less CPU time"},
    {{{100, 48, 40, 9, 6}}, "switch to bullet-hinge-double (100 iterations): 16.7 times less CPU time"},
    // Over two motions the geometric mean counts, and only who keeps the error on both.
    {{{100, 90, 90, 5, 90}, {100, 90, 90, 18, 90}}, "switch to mujoco-euler: 10.5 times less CPU time"},
    {{{100, 90, 90, 5, 90}, {100, 90, 90, 0, 90}}, "stay"},
    {{{100, 90, 21, 1, 0}, {100, 90, 21, 0, 1}}, "use accurate_step: 4.76 times less CPU time"},
    {{{100, 0, 0, 2, 0}, {100, 0, 0, 190, 0}}, "switch to mujoco-euler: 5.13 times less CPU time"},
};

void every_move_has_its_rule() {
  for (const Case& one : cases) {
    std::vector<Result> results;
    for (const auto& us : one.us) results.push_back(motion(us));
    CHECK_EQUAL(advised(results), one.sentence);
  }
}

/// The least and the largest of the motions stand beside the mean.
void the_spread_is_told() {
  const std::vector<Result> results{motion({100, 0, 50, 0, 0}), motion({100, 0, 2, 0, 0}), motion({100, 0, 10, 0, 0})};
  const auto advice = advice_of(results);
  CHECK_NEAR(advice->factor, 10, 1e-12);
  CHECK_EQUAL(spread_of(*advice), "2 to 50");
  CHECK_EQUAL(advice->stages, 3U);
}

/// Where ODE as it is keeps the error nowhere its time bounds the gain, and it can not be the advice.
void a_bound_is_called_one() {
  std::vector<Result> results{motion({100, 0, 200, 0, 0}, false), motion({100, 0, 50, 0, 0})};
  CHECK_EQUAL(advised(results),
              "use accurate_step: at least 1 times less CPU time (ODE as it is keeps the error at no step on 1 of 2 "
              "motions)");
  CHECK_EQUAL(spread_of(*advice_of(results)), "at least 0.5 to at least 2");
  results = {motion({100, 0, 10, 0, 0}, false), motion({100, 0, 50, 0, 0})};
  CHECK_EQUAL(spread_of(*advice_of(results)), "2 to at least 10");
}

void nobody_keeps_it() {
  const std::vector<Result> results{motion({100, 0, 0, 0, 0}, false)};
  CHECK_EQUAL(advised(results), "none");
}

/// A setting that is ODE as it is to the last digit is no gain, whatever the clock says.
void the_same_run_is_no_gain() {
  Result result = motion({100, 9, 90, 90, 90});
  result.tried[1].error = result.tried[0].error;
  CHECK_EQUAL(advised({result}), "stay");
  result.tried[1].setting = 2e-3;
  CHECK_EQUAL(advised({result}), "change a setting, ERP 0.8: 11.1 times less CPU time");
}

/// Who does not get there is told so, with the best that was seen.
void a_ladder_that_ends_too_early_says_so() {
  const std::vector<Way> ways = all_ways();
  Tried tried;
  tried.setting = 2e-4;
  CHECK_EQUAL(setting_of(ways[0], tried), "not reached down to 0.2 ms");
  tried.best_setting = 1e-3;
  tried.best = {0.1};
  CHECK_EQUAL(setting_of(ways[0], tried), "not reached down to 0.2 ms, least at 1 ms");
  tried.keeps = true;
  CHECK_EQUAL(setting_of(ways[0], tried), "0.2 ms");
  const Way adaptive{&row("simbody-merson"), Move::leave, "", nullptr};
  CHECK_EQUAL(setting_of(adaptive, tried), "rtol 0.0002");
}

/// Of each engine the figure has the way that keeps the error at the least time, else that with the least error.
void the_figure_has_the_best_of_each() {
  Result result = motion({100, 50, 20, 0, 30});
  result.ways.push_back({&row("mujoco-rk4"), Move::leave, "", nullptr});
  result.tried.push_back(result.tried[3]);
  result.tried[3].best = {0.2};
  result.tried[5].best = {0.1};
  result.ways.push_back({&row("bullet-multibody-double"), Move::leave, "", nullptr});
  result.tried.push_back(result.tried[4]);
  result.tried[6].us_per_s = 40;
  const std::vector<Curve> curves = curves_of(result);
  CHECK_EQUAL(curves.size(), 4U);
  const std::size_t wanted[] = {0, 2, 5, 4};
  for (std::size_t k = 0; k < curves.size(); ++k) CHECK_EQUAL(curves[k].way, wanted[k]);
  CHECK_EQUAL(curves[2].label, "MuJoCo");
}

/// What QuickStep's iterations have to do with the rolling scene follows from its errors.
void rolling_is_told_by_its_errors() {
  namespace rolling = experiments::rolling;
  const auto says = [](const rolling::QuickStep& errors, const std::string& words) {
    return rolling::about(errors, 100, 20).find(words) != std::string::npos;
  };
  CHECK(says({2e-4, 0.4, 3e4}, "what its iterations leave of the sliders: 100 leave 0.0002, 20 leave 0.4."));
  CHECK(says({2e-4, 0.4, 3e4}, "of 0.1 kg, 5 m above the box, it is 30000: it begins each step without forces, 100"));
  CHECK(says({2e-4, 2e-4, 3e4}, "is 0.0002 with 100 iterations and 0.0002 with 20."));
  CHECK(says({2e-4, 0.4, 3e-4}, "5 m above the box, it holds as well."));
}

/// Whose numbers those are that were published of the boxes follows from what is measured here.
void published_boxes_are_told_by_measurements() {
  namespace boxes = experiments::free_box_published;
  constexpr double steps_s[] = {1e-4, 4e-4, 1e-3};
  boxes::Measured measured;
  // Errors as they were published of a method, times a factor, are found of another at a part of the step.
  const auto found = [&](const std::string& method, double part, std::string_view published, double factor) {
    for (const double step_s : steps_s) {
      boxes::Errors errors = *boxes::of(published, true, step_s);
      for (double* const error : {&errors.distance_m, &errors.momentum, &errors.energy}) *error *= factor;
      measured[{method, part * step_s}] = errors;
    }
  };
  CHECK_EQUAL(boxes::about(measured), "");
  found("bullet-hinge-double", 1, "bullet-hinge-double", 1.001);
  CHECK_EQUAL(boxes::about(measured), "Bullet's numbers are those of bullet-hinge-double, within 0.0999 %.");
  found("bullet-hinge-double", 1, "bullet-hinge-double", 1.25);
  CHECK_EQUAL(boxes::about(measured),
              "Bullet's numbers are up to 20.0 % off those of bullet-hinge-double, and no method's here.");
  found("mujoco-implicit", 1, "bullet-hinge-double", 1);
  found("mujoco-rk4", 1, "bullet-hinge-double", 1.0001);
  CHECK_EQUAL(boxes::about(measured),
              "Bullet's numbers are up to 20.0 % off those of bullet-hinge-double; they are those of mujoco-implicit, "
              "within 0 %.");
  measured.clear();
  found("simbody-semi-explicit", 1, "simbody-semi-explicit", 2);
  found("simbody-semi-explicit", 0.5, "simbody-semi-explicit", 1);
  CHECK_EQUAL(boxes::about(measured),
              "Simbody's numbers are up to 50 % off those of simbody-semi-explicit; they are those of "
              "simbody-semi-explicit at half the step, within 0 %.");
}

}  // namespace

int main() {
  every_move_has_its_rule();
  the_spread_is_told();
  a_bound_is_called_one();
  nobody_keeps_it();
  the_same_run_is_no_gain();
  a_ladder_that_ends_too_early_says_so();
  the_figure_has_the_best_of_each();
  rolling_is_told_by_its_errors();
  published_boxes_are_told_by_measurements();
  return odeval::test::verdict();
}
