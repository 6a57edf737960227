#include "catalogue/confirmation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "catalogue/accurate_method.hpp"
#include "catalogue/methods.hpp"
#include "measure/body_trace.hpp"
#include "output/table.hpp"

namespace odeval::catalogue {
namespace {

constexpr double order = 8;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// The columns of a body whose numbers an extrapolation moves.
template <class Change>
void for_columns(BodyColumns& body, const BodyColumns& other, Change&& change) {
  const auto all = [&]<std::size_t N>(std::array<Column, N>& a, const std::array<Column, N>& b) {
    for (std::size_t i = 0; i < N; ++i) change(a[i], b[i]);
  };
  all(body.position, other.position);
  all(body.rotation, other.rotation);
  all(body.spin, other.spin);
}

/// What both runs tend to as the step goes to 0. Where the motion is not smooth enough for the order, the finer run.
Trace extrapolated(Trace fine, const Trace& coarse) {
  const double part = 1 / (std::exp2(order) - 1);
  for (std::size_t i = 0; i < fine.bodies.size(); ++i) {
    for_columns(fine.bodies[i], coarse.bodies[i], [&](Column& a, const Column& b) {
      for (std::size_t k = 0; k < a.size(); ++k) a[k] += part * (a[k] - b[k]);
    });
  }
  return fine;
}

/// Of the worst body in each row.
struct Differences {
  Column position, turn, spin;
};

Differences differences(Trace trace, const Reference& reference) {
  compare_bodies(trace, reference);
  const std::size_t rows = trace.rows();
  Differences worst{Column(rows), Column(rows), Column(rows)};
  for (std::size_t i = 0; i < trace.bodies.size(); ++i) {
    const auto& spin = trace.bodies[i].spin;
    const auto& wanted = reference.trace.bodies[i].spin;
    for (std::size_t k = 0; k < rows; ++k) {
      worst.position[k] = std::fmax(worst.position[k], trace.error_position[i][k]);
      worst.turn[k] = std::fmax(worst.turn[k], trace.error_turn[i][k]);
      worst.spin[k] = std::fmax(
          worst.spin[k], std::hypot(spin[0][k] - wanted[0][k], spin[1][k] - wanted[1][k], spin[2][k] - wanted[2][k]));
    }
  }
  return worst;
}

/// The difference over what the reference states, where that ratio is the largest: up to 1 they agree.
double excess(const Column& difference, const Column& bound) {
  double most = 0;
  for (std::size_t k = 0; k < bound.size(); ++k) {
    if (difference[k] > 0) most = std::fmax(most, difference[k] / bound[k]);
  }
  return most;
}

double excess(const Differences& apart, const Reference& reference) {
  return std::max({excess(apart.position, reference.uncertainty_position),
                   excess(apart.turn, reference.uncertainty_turn), excess(apart.spin, reference.uncertainty_spin)});
}

void raise(Column& bound, const Column& difference) {
  std::ranges::transform(bound, difference, bound.begin(), [](double a, double b) { return std::fmax(a, b); });
}

/// The accurate step on the rows of the reference; without a run, why.
struct Second {
  Trace trace;
  std::string why_not;
};

Second second(const Scenario& scenario, const SampleGrid& grid, int parts) {
  const std::unique_ptr<Simulation> simulation = make_accurate_8_in_parts(scenario, grid, parts);
  Motion motion(simulation->shape(), static_cast<std::size_t>(grid.rows));
  const Outcome outcome = simulation->run(Recorder(motion));
  if (outcome.diverged) return {{}, outcome.reason};
  return {body_trace(scenario, grid, motion), ""};
}

std::string not_confirmed(const std::string& why) { return "; not confirmed by a second formulation: " + why; }

}  // namespace

void confirm(Reference& reference, const Scenario& scenario, const SampleGrid& grid) {
  Scenario plain = scenario;
  plain.ode = {};  // of another engine's settings nothing shall count
  for (Contact& contact : plain.mechanism.contacts) contact.softness.reset();
  if (const Method& step = find_method("ode-rk8-double"); !does(step, plain)) {
    reference.origin += not_confirmed("the accurate step can not do " + listed(features_of(plain) - step.can));
    return;
  }
  const double steps = static_cast<double>(grid.steps()) * static_cast<double>(plain.mechanism.bodies.size());
  if (3 * steps > most_steps_to_confirm) {
    reference.origin += not_confirmed("two runs of it take " + three_digits(3 * steps) +
                                      " steps of a body, more than " + three_digits(most_steps_to_confirm));
    return;
  }
  Trace before;
  Differences nearest;
  double least = infinity;  // excess
  int finest = 0;
  double taken = 0;
  for (int parts = 1; least > 1 && parts <= 8 && taken + parts * steps <= most_steps_to_confirm; parts *= 2) {
    Second run = second(plain, grid, parts);
    if (!run.why_not.empty()) {
      if (finest > 0) break;  // the runs before say what they say
      reference.origin += not_confirmed(run.why_not);
      return;
    }
    taken += parts * steps;
    if (parts > 1) {
      Differences apart = differences(extrapolated(run.trace, before), reference);
      const double now = excess(apart, reference);
      if (now >= least / 2) break;  // rounding, or motion that is not smooth
      nearest = std::move(apart);
      least = now;
      finest = parts;
    }
    before = std::move(run.trace);
  }
  const bool agree = least <= 1;
  const std::string sign = agree ? "± " : "";
  reference.origin += (agree ? "; confirmed by" : "; differs from") +
                      (" a second formulation, the accurate step of order 8 at h/" + std::to_string(finest)) +
                      (agree ? " to " : " by ") + sign + three_digits(std::ranges::max(nearest.position)) + " m and " +
                      sign + three_digits(std::ranges::max(nearest.turn)) + " rad" +
                      (agree ? "" : ", which is the uncertainty where it is the larger");
  raise(reference.uncertainty_position, nearest.position);
  raise(reference.uncertainty_turn, nearest.turn);
  raise(reference.uncertainty_spin, nearest.spin);
}

}  // namespace odeval::catalogue
