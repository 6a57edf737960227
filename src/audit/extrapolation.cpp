#include "audit/extrapolation.hpp"

#include <algorithm>
#include <cmath>

namespace odeval::audit {
namespace {

double square_distance(const double* a, const double* b, std::size_t components) {
  double sum = 0;
  for (std::size_t c = 0; c < components; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

/// NaN, which a run that blew up has, is the largest.
void raise(double& largest, double value) {
  if (!std::isnan(largest) && !(value <= largest)) largest = value;
}

/// T(i, j), with i down and j across, each with its components; those beyond the diagonal stay as they are.
void extrapolate(const std::vector<double>& steps, const double* values, std::size_t components,
                 std::vector<double>& table) {
  const std::size_t n = steps.size();
  table.resize(n * n * components);
  const auto at = [&](std::size_t run, std::size_t degree) { return table.data() + (run * n + degree) * components; };
  for (std::size_t i = 0; i < n; ++i) {
    std::copy_n(values + i * components, components, at(i, 0));
    for (std::size_t j = 1; j <= i; ++j) {
      const double weight = 1 / (steps[i - j] / steps[i] - 1);
      for (std::size_t c = 0; c < components; ++c) {
        at(i, j)[c] = at(i, j - 1)[c] + weight * (at(i, j - 1)[c] - at(i - 1, j - 1)[c]);
      }
    }
  }
}

std::vector<double> steps_of(const std::vector<int>& refinements) {
  std::vector<double> steps;
  for (const int k : refinements) steps.push_back(1.0 / k);
  return steps;
}

}  // namespace

std::array<double, 4> nearer(const double* quaternion, const double* to) {
  double product = 0;
  for (int i = 0; i < 4; ++i) product += quaternion[i] * to[i];
  std::array<double, 4> its{};
  for (std::size_t i = 0; i < 4; ++i) its[i] = product < 0 ? -quaternion[i] : quaternion[i];
  return its;
}

std::vector<double> extrapolated(const std::vector<double>& values, const std::vector<int>& refinements,
                                 std::size_t degree) {
  const std::size_t n = refinements.size();
  const std::size_t components = values.size() / n;
  std::vector<double> table;
  extrapolate(steps_of(refinements), values.data(), components, table);
  const double* limit = table.data() + ((n - 1) * n + degree) * components;
  return {limit, limit + components};
}

Spread::Spread(const std::vector<int>& refinements, std::size_t others)
    : steps_(steps_of(refinements)),
      apart_(refinements.size() * refinements.size()),
      off_((refinements.size() + others) * refinements.size()) {}

void Spread::add(const double* values, std::size_t components, double metric) {
  const std::size_t n = runs();
  const double square = metric * metric;
  extrapolate(steps_, values, components, table_);
  const auto at = [&](std::size_t run, std::size_t degree) { return table_.data() + (run * n + degree) * components; };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      raise(apart_[i * n + j], square * square_distance(at(i, j), at(i - 1, j), components));
    }
  }
  for (std::size_t i = 0; i * n < off_.size(); ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      raise(off_[i * n + j], square * square_distance(values + i * components, at(n - 1, j), components));
    }
  }
}

void Spread::add(const Spread& other) {
  for (std::size_t i = 0; i < apart_.size(); ++i) raise(apart_[i], other.apart_[i]);
  for (std::size_t i = 0; i < off_.size(); ++i) raise(off_[i], other.off_[i]);
}

// T(last, 0) is off by about its distance from T(last-1, 0) where errors halve: twice that. The pair before it, at the
// rate of first order, keeps a chance nearness of the last two from counting.
double Spread::uncertainty_of_values() const {
  const std::size_t last = runs() - 1;
  double its = apart(last, 0);
  if (last >= 2) raise(its, apart(last - 1, 0) * steps_[last] / steps_[last - 1]);
  return 2 * its;
}

// Distances that fall by the factor r from pair to pair leave 1 / (r - 1) of the last one: less than it where they
// fall as the degree promises, and more where the values are no polynomial. The last degree has one pair only, and is
// believed as far as the one below it.
double Spread::uncertainty(std::size_t degree) const {
  if (degree == 0) return uncertainty_of_values();
  const std::size_t last = runs() - 1;
  double its = apart(last, degree);
  if (last < 2) return its;
  const std::size_t witness = std::min(degree, last - 2);
  const double falls = apart(last - 1, witness) / apart(last, witness);
  constexpr double least_fall = 1.05;  // from pair to pair
  if (!(apart(last, witness) > 0)) return its;
  return its * std::max(1.0, 1 / (std::max(falls, least_fall) - 1));
}

std::size_t Spread::best_degree() const {
  std::size_t best = 0;
  for (std::size_t degree = 1; degree + 1 < runs(); ++degree) {
    if (uncertainty(degree) < uncertainty(best)) best = degree;
  }
  return best;
}

Spread::Limit Spread::limit() const {
  const std::size_t degree = best_degree();
  return {degree, uncertainty(degree)};
}

Estimate Spread::error(std::size_t run, double unseen, double rounding) const {
  const Limit its_limit = limit();
  Estimate its{off(run, its_limit), its_limit.uncertainty + unseen + rounding, Convergence::none};
  its.convergence = convergence(its, unseen);
  return its;
}

std::optional<double> Spread::order_of(std::size_t first, std::size_t last) const {
  if (first == 0 || first >= last || !(apart(first, 0) > 0) || !(apart(last, 0) > 0)) return std::nullopt;
  const double order = std::log(apart(first, 0) / apart(last, 0)) / std::log(steps_[first] / steps_[last]);
  return std::isfinite(order) ? std::optional(order) : std::nullopt;
}

std::optional<double> Spread::order() const { return order_of(runs() - 2, runs() - 1); }

// Where an impact falls in a step makes one difference small by chance, so that all of them are asked; and differences
// that are no larger than that chance do not say that there is no limit.
Convergence Spread::convergence(const Estimate& error, double unseen) const {
  if (!std::isfinite(error.value + error.uncertainty)) return Convergence::none;
  if (error.uncertainty <= 0.1 * error.value) return Convergence::settled;
  if (error.value + error.uncertainty <= Estimate::nothing) return Convergence::settled;
  constexpr double least_order = 0.3;  // 2 to the power of it is 1.2: halving the step takes away a fifth
  const std::size_t last = runs() - 1;
  const std::optional<double> falls = order_of(1, last);
  const bool by_chance = apart(last, 0) <= unseen * steps_[last - 1] / steps_[last];
  constexpr double too_fast = 8;  // for any scheme: the coarser runs blow up
  if (falls && *falls > too_fast) return Convergence::none;
  return by_chance || (falls && *falls > least_order) ? Convergence::rough : Convergence::none;
}

std::optional<double> step_that_keeps(double wanted, const std::vector<StepError>& runs, std::optional<double> order,
                                      bool settled) {
  std::size_t keeps = 0;
  while (keeps < runs.size() && !(runs[keeps].most <= wanted)) ++keeps;
  if (keeps == 0) return runs.front().step;
  const StepError& coarser = runs[keeps - 1];
  if (keeps < runs.size()) {
    const StepError& finer = runs[keeps];
    if (!settled || !(finer.most > 0)) return finer.step;
    order = std::log(coarser.most / finer.most) / std::log(coarser.step / finer.step);
  }
  if (!settled || !order || !(*order > 0)) return std::nullopt;
  return coarser.step * std::pow(wanted / coarser.most, 1 / *order);
}

}  // namespace odeval::audit
