// Every claim's rule against numbers written by hand, and the rules against each other: what a rule says about its
// numbers stands here a second time, so that a relation turned round or a bound moved is found.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "experiments/experiment.hpp"
#include "report/claims.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using namespace odeval::report;

constexpr Verdict yes = Verdict::confirmed;
constexpr Verdict no = Verdict::refuted;
constexpr Verdict limits = Verdict::confirmed_with_limits;

struct Number {
  std::string_view name;  // without the claim's id: "order_off"
  double value;
  double uncertainty = 0;
};

struct Case {
  std::string_view claim;
  std::vector<Number> numbers;
  Verdict verdict;
};

// Values lie within a tenth or so of each bound, on both sides of it, so that a bound moved by a quarter changes a
// verdict. Each claim's last rows have a bound within the uncertainty: nobody can tell.
// clang-format off
const std::vector<Case> cases{
    {"C1", {{"order_off", 0.09}}, yes},
    {"C1", {{"order_off", 0.11}}, limits},
    {"C1", {{"order_off", 0.28}}, limits},
    {"C1", {{"order_off", 0.32}}, no},
    {"C1", {{"order_off", 0.09, 0.02}}, limits},
    {"C1", {{"order_off", 0.32, 0.03}}, limits},

    {"C2", {{"error_ratio", 2.2}, {"chain_error_ratio", 2.2}}, yes},
    {"C2", {{"error_ratio", 1.8}, {"chain_error_ratio", 2.2}}, limits},
    {"C2", {{"error_ratio", 2.2}, {"chain_error_ratio", 1.8}}, limits},
    {"C2", {{"error_ratio", 1.2}, {"chain_error_ratio", 1.0}}, limits},
    {"C2", {{"error_ratio", 1.0}, {"chain_error_ratio", 1.2}}, limits},
    {"C2", {{"error_ratio", 1.0}, {"chain_error_ratio", 1.0}}, no},
    {"C2", {{"error_ratio", 2.2, 0.3}, {"chain_error_ratio", 2.2}}, limits},
    {"C2", {{"error_ratio", 1.0}, {"chain_error_ratio", 1.0, 0.2}}, limits},

    {"C3", {{"error_ratio", 1.1}, {"condition_ratio", 1.1}, {"error_exponent", 0.22}}, yes},
    {"C3", {{"error_ratio", 0.9}, {"condition_ratio", 1.1}, {"error_exponent", 0.22}}, limits},
    {"C3", {{"error_ratio", 1.1}, {"condition_ratio", 0.9}, {"error_exponent", 0.22}}, limits},
    {"C3", {{"error_ratio", 1.1}, {"condition_ratio", 1.1}, {"error_exponent", 0.18}}, limits},
    {"C3", {{"error_ratio", 0.55}, {"condition_ratio", 0.9}, {"error_exponent", -0.02}}, limits},
    {"C3", {{"error_ratio", 0.45}, {"condition_ratio", 1.1}, {"error_exponent", -0.02}}, limits},
    {"C3", {{"error_ratio", 0.45}, {"condition_ratio", 0.9}, {"error_exponent", 0.02}}, limits},
    {"C3", {{"error_ratio", 0.45}, {"condition_ratio", 0.9}, {"error_exponent", -0.02}}, no},
    {"C3", {{"error_ratio", 1.1, 0.2}, {"condition_ratio", 1.1}, {"error_exponent", 0.22}}, limits},
    {"C3", {{"error_ratio", 1.1}, {"condition_ratio", 1.1}, {"error_exponent", 0.22, 0.05}}, limits},
    {"C3", {{"error_ratio", 0.45}, {"condition_ratio", 0.9, 0.2}, {"error_exponent", -0.02}}, limits},

    {"C4", {{"long_axis_spin_single", 1.1}, {"long_axis_spin_double", 0.9e-3}}, yes},
    {"C4", {{"long_axis_spin_single", 0.9}, {"long_axis_spin_double", 0.9e-3}}, limits},
    {"C4", {{"long_axis_spin_single", 1.1}, {"long_axis_spin_double", 1.1e-3}}, limits},
    {"C4", {{"long_axis_spin_single", 1.1e-3}, {"long_axis_spin_double", 0}}, limits},
    {"C4", {{"long_axis_spin_single", 0.9e-3}, {"long_axis_spin_double", 0}}, no},
    {"C4", {{"long_axis_spin_single", 1.1, 0.2}, {"long_axis_spin_double", 0.9e-3}}, limits},
    {"C4", {{"long_axis_spin_single", 0.9e-3, 2e-4}, {"long_axis_spin_double", 0}}, limits},

    {"C5", {{"digits_regained", 3.3}, {"error_ratio", 1.8}}, yes},
    {"C5", {{"digits_regained", 2.7}, {"error_ratio", 1.8}}, limits},
    {"C5", {{"digits_regained", 3.3}, {"error_ratio", 2.2}}, limits},
    {"C5", {{"digits_regained", 0.05}, {"error_ratio", 1.8}}, limits},
    {"C5", {{"digits_regained", -0.05}, {"error_ratio", 1.8}}, no},
    {"C5", {{"digits_regained", 3.3, 0.5}, {"error_ratio", 1.8}}, limits},
    {"C5", {{"digits_regained", 3.3}, {"error_ratio", 1.8, 0.3}}, limits},
    {"C5", {{"digits_regained", -0.05, 0.1}, {"error_ratio", 1.8}}, limits},

    {"C6", {{"discrete_law_error", 0.9e-12}, {"oscillator_order", 1.0}}, yes},
    {"C6", {{"discrete_law_error", 1.1e-12}, {"oscillator_order", 1.0}}, limits},
    {"C6", {{"discrete_law_error", 0.9e-12}, {"oscillator_order", 0.8}}, limits},
    {"C6", {{"discrete_law_error", 0.9e-3}, {"oscillator_order", 1.0}}, limits},
    {"C6", {{"discrete_law_error", 1.1e-3}, {"oscillator_order", 1.0}}, no},
    {"C6", {{"discrete_law_error", 0.9e-12, 2e-13}, {"oscillator_order", 1.0}}, limits},
    {"C6", {{"discrete_law_error", 1.1e-3, 2e-4}, {"oscillator_order", 1.0}}, limits},

    {"C7", {{"ode45_over_ode", 1.1}, {"euler_over_ode", 2.2}, {"dh_over_lagrange", 2.2}}, yes},
    {"C7", {{"ode45_over_ode", 1.9}, {"euler_over_ode", 2.2}, {"dh_over_lagrange", 2.2}}, yes},
    {"C7", {{"ode45_over_ode", 0.9}, {"euler_over_ode", 2.2}, {"dh_over_lagrange", 2.2}}, limits},
    {"C7", {{"ode45_over_ode", 2.2}, {"euler_over_ode", 2.2}, {"dh_over_lagrange", 2.2}}, limits},
    {"C7", {{"ode45_over_ode", 1.1}, {"euler_over_ode", 1.8}, {"dh_over_lagrange", 2.2}}, limits},
    {"C7", {{"ode45_over_ode", 1.1}, {"euler_over_ode", 2.2}, {"dh_over_lagrange", 1.8}}, limits},
    {"C7", {{"ode45_over_ode", 0.45}, {"euler_over_ode", 0.45}, {"dh_over_lagrange", 2.2}}, no},
    {"C7", {{"ode45_over_ode", 0.55}, {"euler_over_ode", 0.45}, {"dh_over_lagrange", 2.2}}, limits},
    {"C7", {{"ode45_over_ode", 0.45}, {"euler_over_ode", 0.55}, {"dh_over_lagrange", 2.2}}, limits},
    {"C7", {{"ode45_over_ode", 1.1, 0.2}, {"euler_over_ode", 2.2}, {"dh_over_lagrange", 2.2}}, limits},
    {"C7", {{"ode45_over_ode", 0.45, 0.1}, {"euler_over_ode", 0.45}, {"dh_over_lagrange", 2.2}}, limits},

    {"C8a", {{"fluctuation_over_ode45", 2.2}, {"fluctuation_over_euler", 2.2}}, yes},
    {"C8a", {{"fluctuation_over_ode45", 1.8}, {"fluctuation_over_euler", 2.2}}, limits},
    {"C8a", {{"fluctuation_over_ode45", 2.2}, {"fluctuation_over_euler", 1.8}}, limits},
    {"C8a", {{"fluctuation_over_ode45", 0.9}, {"fluctuation_over_euler", 0.9}}, no},
    {"C8a", {{"fluctuation_over_ode45", 1.1}, {"fluctuation_over_euler", 0.9}}, limits},
    {"C8a", {{"fluctuation_over_ode45", 0.9}, {"fluctuation_over_euler", 1.1}}, limits},
    {"C8a", {{"fluctuation_over_ode45", 2.2, 0.3}, {"fluctuation_over_euler", 2.2}}, limits},
    {"C8a", {{"fluctuation_over_ode45", 0.9}, {"fluctuation_over_euler", 0.9, 0.2}}, limits},

    {"C8b", {{"largest_ratio", 0.45}, {"least_ratio", 0.1}}, yes},
    {"C8b", {{"largest_ratio", 0.55}, {"least_ratio", 0.1}}, limits},
    {"C8b", {{"largest_ratio", 1.1}, {"least_ratio", 1.1}}, no},
    {"C8b", {{"largest_ratio", 1.1}, {"least_ratio", 0.9}}, limits},
    {"C8b", {{"largest_ratio", 0.9}, {"least_ratio", 1.1}}, limits},
    {"C8b", {{"largest_ratio", 0.45, 0.1}, {"least_ratio", 0.1}}, limits},
    {"C8b", {{"largest_ratio", 2}, {"least_ratio", 1.1, 0.2}}, limits},

    {"C9", {{"distance_ratio", 0.45}, {"ode_parts_at", 6.3}}, yes},
    {"C9", {{"distance_ratio", 0.55}, {"ode_parts_at", 6.3}}, limits},
    {"C9", {{"distance_ratio", 0.45}, {"ode_parts_at", 5.5}}, limits},
    {"C9", {{"distance_ratio", 0.45}, {"ode_parts_at", 7.5}}, limits},
    {"C9", {{"distance_ratio", 0.9}, {"ode_parts_at", 2}}, limits},
    {"C9", {{"distance_ratio", 1.1}, {"ode_parts_at", 6.3}}, no},
    {"C9", {{"distance_ratio", 0.45}, {"ode_parts_at", 6.3, 0.5}}, limits},
    {"C9", {{"distance_ratio", 1.1, 0.2}, {"ode_parts_at", 6.3}}, limits},

    {"C10", {{"perturbed_parts_at", 3.3}, {"growth_at_6s", 11}}, yes},
    {"C10", {{"perturbed_parts_at", 2.7}, {"growth_at_6s", 11}}, limits},
    {"C10", {{"perturbed_parts_at", 4.4}, {"growth_at_6s", 11}}, limits},
    {"C10", {{"perturbed_parts_at", 3.3}, {"growth_at_6s", 9}}, limits},
    {"C10", {{"perturbed_parts_at", 3.3}, {"growth_at_6s", 2.2}}, limits},
    {"C10", {{"perturbed_parts_at", 3.3}, {"growth_at_6s", 1.8}}, no},
    {"C10", {{"perturbed_parts_at", 3.3, 0.5}, {"growth_at_6s", 11}}, limits},
    {"C10", {{"perturbed_parts_at", 3.3}, {"growth_at_6s", 1.8, 0.3}}, limits},

    {"C11a", {{"after_vertical", 9}, {"after_touch", 5.5}}, yes},
    {"C11a", {{"after_vertical", 11}, {"after_touch", 5.5}}, yes},
    {"C11a", {{"after_vertical", 7}, {"after_touch", 5.5}}, limits},
    {"C11a", {{"after_vertical", 13}, {"after_touch", 5.5}}, limits},
    {"C11a", {{"after_vertical", 9}, {"after_touch", 4.5}}, limits},
    {"C11a", {{"after_vertical", 9}, {"after_touch", 1.1}}, limits},
    {"C11a", {{"after_vertical", 9}, {"after_touch", 0.9}}, no},
    {"C11a", {{"after_vertical", 9, 2}, {"after_touch", 5.5}}, limits},
    {"C11a", {{"after_vertical", 9}, {"after_touch", 0.9, 0.2}}, limits},

    {"C11b", {{"by_settings", 0.75}, {"by_face", 0}}, yes},
    {"C11b", {{"by_settings", 0.6}, {"by_face", 0}}, limits},
    {"C11b", {{"by_settings", 0.3}, {"by_face", 0.75}}, no},
    {"C11b", {{"by_settings", 0.36}, {"by_face", 0.75}}, limits},
    {"C11b", {{"by_settings", 0.3}, {"by_face", 0.6}}, limits},
    {"C11b", {{"by_settings", 0.75, 0.1}, {"by_face", 0}}, limits},
    {"C11b", {{"by_settings", 0.3, 0.05}, {"by_face", 0.75}}, limits},
    {"C11b", {{"by_settings", 0.3}, {"by_face", 0.75, 0.1}}, limits},

    {"C12", {{"smooth_gain", 1100}, {"impact_gain", 1100}, {"friction_gain", 1100}, {"motor_gain", 1100}, {"stop_gain", 1100}}, yes},
    {"C12", {{"smooth_gain", 900}, {"impact_gain", 1100}, {"friction_gain", 1100}, {"motor_gain", 1100}, {"stop_gain", 1100}}, limits},
    {"C12", {{"smooth_gain", 1100}, {"impact_gain", 900}, {"friction_gain", 1100}, {"motor_gain", 1100}, {"stop_gain", 1100}}, limits},
    {"C12", {{"smooth_gain", 1100}, {"impact_gain", 1100}, {"friction_gain", 900}, {"motor_gain", 1100}, {"stop_gain", 1100}}, limits},
    {"C12", {{"smooth_gain", 1100}, {"impact_gain", 1100}, {"friction_gain", 1100}, {"motor_gain", 900}, {"stop_gain", 1100}}, limits},
    {"C12", {{"smooth_gain", 1100}, {"impact_gain", 1100}, {"friction_gain", 1100}, {"motor_gain", 1100}, {"stop_gain", 900}}, limits},
    {"C12", {{"smooth_gain", 2.2}, {"impact_gain", 1}, {"friction_gain", 1100}, {"motor_gain", 1100}, {"stop_gain", 1100}}, limits},
    {"C12", {{"smooth_gain", 1.8}, {"impact_gain", 1}, {"friction_gain", 1100}, {"motor_gain", 1100}, {"stop_gain", 1100}}, no},
    {"C12", {{"smooth_gain", 1100}, {"impact_gain", 1100, 200}, {"friction_gain", 1100}, {"motor_gain", 1100}, {"stop_gain", 1100}}, limits},
    {"C12", {{"smooth_gain", 1.8, 0.3}, {"impact_gain", 1}, {"friction_gain", 1100}, {"motor_gain", 1100}, {"stop_gain", 1100}}, limits},

    {"C13", {{"largest_difference", 0.9e-6}}, yes},
    {"C13", {{"largest_difference", 1.1e-6}}, limits},
    {"C13", {{"largest_difference", 0.9e-3}}, limits},
    {"C13", {{"largest_difference", 1.1e-3}}, no},
    {"C13", {{"largest_difference", 0.9e-6, 2e-7}}, limits},
    {"C13", {{"largest_difference", 1.1e-3, 2e-4}}, limits},

    {"C14", {{"anisotropy", 0.11}}, yes},
    {"C14", {{"anisotropy", 0.09}}, limits},
    {"C14", {{"anisotropy", 0.011}}, limits},
    {"C14", {{"anisotropy", 0.009}}, no},
    {"C14", {{"anisotropy", 0.11, 0.02}}, limits},
    {"C14", {{"anisotropy", 0.009, 0.002}}, limits},

    {"C15", {{"matrix_drift", 1.1e-6}, {"quaternion_drift", 0.9e-12}, {"cost_ratio", 0.9}}, yes},
    {"C15", {{"matrix_drift", 0.9e-6}, {"quaternion_drift", 0.9e-12}, {"cost_ratio", 0.9}}, limits},
    {"C15", {{"matrix_drift", 1.1e-6}, {"quaternion_drift", 1.1e-12}, {"cost_ratio", 0.9}}, limits},
    {"C15", {{"matrix_drift", 1.1e-6}, {"quaternion_drift", 0.9e-12}, {"cost_ratio", 1.1}}, limits},
    {"C15", {{"matrix_drift", 1.1e-12}, {"quaternion_drift", 0.9e-12}, {"cost_ratio", 0.9}}, limits},
    {"C15", {{"matrix_drift", 0.9e-12}, {"quaternion_drift", 0.9e-12}, {"cost_ratio", 0.9}}, no},
    {"C15", {{"matrix_drift", 1.1e-6}, {"quaternion_drift", 0.9e-12, 2e-13}, {"cost_ratio", 0.9}}, limits},
    {"C15", {{"matrix_drift", 1.1e-6}, {"quaternion_drift", 0.9e-12}, {"cost_ratio", 0.9, 0.2}}, limits},
    {"C15", {{"matrix_drift", 0.9e-12, 2e-13}, {"quaternion_drift", 0.9e-12}, {"cost_ratio", 0.9}}, limits},

    {"C16", {{"gap_ratio", 11}}, yes},
    {"C16", {{"gap_ratio", 9}}, limits},
    {"C16", {{"gap_ratio", 1.1}}, limits},
    {"C16", {{"gap_ratio", 0.9}}, no},
    {"C16", {{"gap_ratio", 11, 2}}, limits},
    {"C16", {{"gap_ratio", 0.9, 0.2}}, limits},

    {"C17", {{"growth_ratio", 11}}, yes},
    {"C17", {{"growth_ratio", 9}}, limits},
    {"C17", {{"growth_ratio", 2.2}}, limits},
    {"C17", {{"growth_ratio", 1.8}}, no},
    {"C17", {{"growth_ratio", 11, 2}}, limits},
    {"C17", {{"growth_ratio", 1.8, 0.3}}, limits},

    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 11}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5}}, yes},
    {"O1", {{"shift", 0.4}, {"order", 1.9}, {"gain", 11}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5}}, limits},
    {"O1", {{"shift", 0.6}, {"order", 1.9}, {"gain", 11}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5}}, limits},
    {"O1", {{"shift", 0.5}, {"order", 1.5}, {"gain", 11}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5}}, limits},
    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 9}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5}}, limits},
    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 1.3}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5}}, limits},
    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 1.1}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5}}, no},
    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 11}, {"order_at_speed", 1.5}, {"shift_at_speed", 0.5}}, limits},
    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 11}, {"order_at_speed", 1.8, 0.2}, {"shift_at_speed", 0.5}}, limits},
    {"O1", {{"shift", 0.5, 0.06}, {"order", 1.9}, {"gain", 11}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5}}, limits},
    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 1.1, 0.2}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5}}, limits},
    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 11}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.4}}, limits},
    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 11}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.6}}, limits},
    {"O1", {{"shift", 0.5}, {"order", 1.9}, {"gain", 11}, {"order_at_speed", 1.9}, {"shift_at_speed", 0.5, 0.06}}, limits},

    {"O2", {{"gain", 2.2}}, yes},
    {"O2", {{"gain", 1.8}}, limits},
    {"O2", {{"gain", 1.1}}, limits},
    {"O2", {{"gain", 0.9}}, no},
    {"O2", {{"gain", 2.2, 0.3}}, limits},
    {"O2", {{"gain", 0.9, 0.2}}, limits},

    {"O3", {{"drift_ratio", 1.3}}, yes},
    {"O3", {{"drift_ratio", 1.1}}, limits},
    {"O3", {{"drift_ratio", 0.9}}, no},
    {"O3", {{"drift_ratio", 1.3, 0.2}}, limits},
    {"O3", {{"drift_ratio", 0.9, 0.2}}, limits},
};
// clang-format on

Findings findings_of(const Case& one) {
  Findings findings;
  for (const Number& number : one.numbers) {
    findings.add(std::string(one.claim) + "." + std::string(number.name),
                 {"", "", number.value, number.uncertainty, ""});
  }
  return findings;
}

/// How many cases a rule decides otherwise than written above.
int contradictions(const Claim& claim) {
  return static_cast<int>(std::ranges::count_if(cases, [&](const Case& one) {
    return one.claim == claim.id && judge(claim, findings_of(one)).verdict != one.verdict;
  }));
}

void every_verdict_is_as_written() {
  for (const Case& one : cases) {
    const auto claim = std::ranges::find(claims(), one.claim, &Claim::id);
    CHECK(claim != claims().end());
    if (claim == claims().end()) continue;
    const Verdict verdict = judge(*claim, findings_of(one)).verdict;
    if (verdict != one.verdict) {
      CHECK_EQUAL(std::string(one.claim) + " with " + odeval::test::shown(one.numbers.front().value) + ": " +
                      std::string(verdict_text(verdict)),
                  std::string(verdict_text(one.verdict)));
    }
  }
  for (const Claim& claim : claims()) {
    for (const Verdict verdict : {yes, no, limits}) {
      CHECK(
          std::ranges::any_of(cases, [&](const Case& one) { return one.claim == claim.id && one.verdict == verdict; }));
    }
  }
}

/// Calls with every way to spoil one condition of a claim.
void for_each_spoilt(const Claim& claim, const std::function<void(const Claim&, const Condition&)>& call) {
  constexpr double quarter = 1.25;
  for (const bool confirmed : {true, false}) {
    const std::span<const Condition> rule = confirmed ? claim.confirmed_if : claim.refuted_if;
    for (std::size_t i = 0; i < rule.size(); ++i) {
      std::vector<Condition> spoilt(rule.begin(), rule.end());
      const auto with = [&](const Condition& condition) {
        spoilt[i] = condition;
        Claim other = claim;
        (confirmed ? other.confirmed_if : other.refuted_if) = spoilt;
        call(other, condition);
      };
      const auto& [finding, relation, bound] = rule[i];
      with({finding, relation == Relation::at_most ? Relation::at_least : Relation::at_most, bound});
      with({finding, relation, bound == 0 ? 0.1 : bound * quarter});
      with({finding, relation, bound == 0 ? -0.1 : bound / quarter});
    }
  }
}

void a_spoilt_rule_is_found() {
  for (const Claim& claim : claims()) {
    for_each_spoilt(claim, [&](const Claim& spoilt, const Condition& condition) {
      if (contradictions(spoilt) > 0) return CHECK(true);
      CHECK_EQUAL("no case finds " + std::string(claim.id) + ": " + std::string(condition.finding) +
                      (condition.relation == Relation::at_most ? " <= " : " >= ") +
                      odeval::test::shown(condition.bound),
                  std::string("found"));
    });
  }
}

// Each number in turn is never measured, has no value, or is none.
void a_claim_with_a_number_missing_is_not_measured() {
  for (const Claim& claim : claims()) {
    const auto one = std::ranges::find_if(cases, [&](const Case& other) { return other.claim == claim.id; });
    const auto judged_with = [&](std::size_t left_out, const Finding* instead) {
      Case rest = *one;
      rest.numbers.erase(rest.numbers.begin() + static_cast<std::ptrdiff_t>(left_out));
      Findings findings = findings_of(rest);
      const std::string name = std::string(claim.id) + "." + std::string(one->numbers[left_out].name);
      if (instead != nullptr) findings.add(name, *instead);
      return judge(claim, findings);
    };
    for (std::size_t i = 0; i < one->numbers.size(); ++i) {
      const Judged absent = judged_with(i, nullptr);
      CHECK(absent.verdict == Verdict::not_measured);
      CHECK(absent.missing.find(one->numbers[i].name) != std::string::npos);
      const Finding unbuilt{"", "", {}, 0, "no single precision"};
      CHECK(judged_with(i, &unbuilt).verdict == Verdict::not_measured);
      CHECK_EQUAL(judged_with(i, &unbuilt).missing, "no single precision");
      for (const double none : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        const Finding finding{"the ratio", "", none, 0, ""};
        CHECK(judged_with(i, &finding).verdict == Verdict::not_measured);
        CHECK_EQUAL(judged_with(i, &finding).missing, "the ratio: not a finite number");
      }
    }
    CHECK_EQUAL(judge(claim, findings_of(*one)).findings.size(), one->numbers.size());
  }
}

void a_condition_holds_with_all_of_its_uncertainty() {
  const Condition most{"x", Relation::at_most, 2};
  const Condition least{"x", Relation::at_least, 2};
  const auto with = [](double value, double uncertainty) { return Finding{"", "", value, uncertainty, ""}; };
  CHECK(holds(most, with(2, 0)) == true && holds(least, with(2, 0)) == true);
  CHECK(holds(most, with(1, 0.9)) == true && holds(least, with(1, 0.9)) == false);
  CHECK(holds(most, with(1, 1.1)) == std::nullopt && holds(least, with(1, 1.1)) == std::nullopt);
  CHECK(holds(most, with(3, 0.9)) == false && holds(least, with(3, 0.9)) == true);
  CHECK(holds(most, with(3, 1.1)) == std::nullopt);
  CHECK(holds(most, with(1, std::nan(""))) == std::nullopt);  // an uncertainty that nobody knows
}

/// What the settings beside the measured ones give counts as well; where it turns a condition, nothing is settled.
void neighbouring_settings_count() {
  const Condition least{"C16.gap_ratio", Relation::at_least, 10};
  Finding finding{"", "", 12, 0, ""};
  CHECK(holds(least, finding) == true);
  finding.nearby = {11, 13};
  CHECK(holds(least, finding) == true);
  finding.nearby = {9, 13};
  CHECK(holds(least, finding) == std::nullopt);
  const auto claim = std::ranges::find(claims(), std::string_view("C16"), &Claim::id);
  Findings findings;
  findings.add("C16.gap_ratio", finding);
  CHECK(judge(*claim, findings).verdict == Verdict::not_settled);
  finding.nearby = {10.5, 13};
  Findings others;
  others.add("C16.gap_ratio", finding);
  CHECK(judge(*claim, others).verdict == Verdict::confirmed);
}

bool all_hold(std::span<const Condition> conditions, const Findings& findings) {
  return std::ranges::all_of(
      conditions, [&](const Condition& one) { return holds(one, *findings.find(one.finding)).value_or(false); });
}

/// Whether some numbers on, or a little beside, the bounds both confirm and refute the claim.
bool contradicts_itself(const Claim& claim, const std::vector<std::string_view>& names, std::size_t next,
                        const Findings& chosen) {
  if (next == names.size()) return all_hold(claim.confirmed_if, chosen) && all_hold(claim.refuted_if, chosen);
  for (const auto& conditions : {claim.confirmed_if, claim.refuted_if}) {
    for (const Condition& condition : conditions) {
      if (condition.finding != names[next]) continue;
      const double beside = condition.bound == 0 ? 1e-3 : std::fabs(condition.bound) * 1e-3;
      for (const double value : {condition.bound - beside, condition.bound, condition.bound + beside}) {
        Findings more = chosen;
        more.add(std::string(names[next]), {"", "", value, 0, ""});
        if (contradicts_itself(claim, names, next + 1, more)) return true;
      }
    }
  }
  return false;
}

void no_numbers_confirm_and_refute() {
  for (const Claim& claim : claims()) {
    if (contradicts_itself(claim, findings_named(claim), 0, {})) {
      CHECK_EQUAL(claim.id, std::string_view("a claim that the same numbers do not confirm and refute"));
    }
  }
  constexpr Condition at_least_one[] = {{"x", Relation::at_least, 1}};
  constexpr Condition at_most_two[] = {{"x", Relation::at_most, 2}};
  CHECK(contradicts_itself({"", "", "", at_least_one, at_most_two, "", ""}, {"x"}, 0, {}));
}

/// Advice that was written for one verdict does not stand unsaid beside another.
void advice_goes_by_the_verdict() {
  const Claim& claim = claims().front();
  CHECK_EQUAL(report::advice_of({&claim, claim.advised_on, {}, ""}), std::string(claim.advice));
  CHECK_EQUAL(
      report::advice_of({&claim, Verdict::refuted, {}, ""}),
      "Look at the evidence first: here it is refuted. Advice for where it is confirmed: " + std::string(claim.advice));
}

void the_table_is_whole() {
  const std::vector<std::string_view> wanted{"C1",  "C2",  "C3",  "C4",   "C5",   "C6",  "C7",  "C8a",
                                             "C8b", "C9",  "C10", "C11a", "C11b", "C12", "C13", "C14",
                                             "C15", "C16", "C17", "O1",   "O2",   "O3"};
  std::vector<std::string_view> ids;
  for (const Claim& claim : claims()) ids.push_back(claim.id);
  CHECK(ids == wanted);

  // Of experiments that the table does not have yet.
  const std::set<std::string_view> to_come{"thin-body", "spring-joint", "friction"};
  for (const Claim& claim : claims()) {
    CHECK(!claim.advice.empty());
    CHECK(!claim.text.empty() && !claim.where.empty() && !claim.confirmed_if.empty() && !claim.refuted_if.empty());
    const bool shown = std::ranges::find(experiments::experiments(), claim.evidence, &experiments::Experiment::name) !=
                       experiments::experiments().end();
    if (!shown && !to_come.contains(claim.evidence)) {
      CHECK_EQUAL(std::string(claim.id) + " points to " + std::string(claim.evidence),
                  std::string("an experiment of the table"));
    }
    for (const std::string_view name : findings_named(claim)) {
      CHECK(name.starts_with(std::string(claim.id) + "."));
    }
  }
}

}  // namespace

int main() {
  every_verdict_is_as_written();
  a_spoilt_rule_is_found();
  a_claim_with_a_number_missing_is_not_measured();
  a_condition_holds_with_all_of_its_uncertainty();
  neighbouring_settings_count();
  no_numbers_confirm_and_refute();
  advice_goes_by_the_verdict();
  the_table_is_whole();
  return odeval::test::verdict();
}
