#include "reference/tree/passage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace odeval::reference {
namespace {

using State = TreeEquations::State;

constexpr unsigned nodes_of_a_guess = 8;
constexpr unsigned nodes = 12;  // 0.06 of the passage's length is how near the pose the nearest ones come

/// Each leaves of what it looks for a tenth or less, of 0.45 rad to either end.
constexpr int looks_for_pose = 2;

/// Gauss and Legendre's formula on -1 to 1.
struct Rule {
  std::vector<double> nodes;
  Eigen::MatrixXd until;       // (i, j): the weight of node j in the integral up to node i
  Eigen::VectorXd to_the_end;  // likewise up to 1

  explicit Rule(unsigned count) : until(count, count), to_the_end(count) {
    for (unsigned i = 0; i < count; ++i) nodes.push_back(node(count, i));
    for (unsigned j = 0; j < count; ++j) {
      const double x = nodes[j];
      const double slope = count * (x * std::legendre(count, x) - std::legendre(count - 1, x)) / (x * x - 1);
      const double weight = 2 / ((1 - x * x) * slope * slope);
      to_the_end[j] = weight;
      for (unsigned i = 0; i < count; ++i) until(i, j) = weight * basis_until(count, x, nodes[i]);
    }
  }

 private:
  static double node(unsigned count, unsigned i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    for (int step = 0; step < 8; ++step) {  // Newton's method
      const double value = std::legendre(count, x);
      x -= value * (x * x - 1) / (count * (x * value - std::legendre(count - 1, x)));
    }
    return x;
  }
  /// The integral up to x of what is 1 at one node, over that node's weight, and 0 at the others.
  static double basis_until(unsigned count, double node, double x) {
    double sum = (x + 1) / 2;
    for (unsigned k = 1; k < count; ++k) {
      sum += std::legendre(k, node) * (std::legendre(k + 1, x) - std::legendre(k - 1, x)) / 2;
    }
    return sum;
  }
};

/// The slope at a small state, and the state, which is looked for near what it holds.
bool slope_near(const Across& across, double t, const double* small, State& state, double* slope) {
  if (!across.chart->find_near(small, state)) return false;
  State whole(state.size());
  across.equations(t, state.data(), whole.data(), across.grips);
  across.chart->small(whole.data(), slope);
  return std::all_of(slope, slope + across.chart->size(), [](double value) { return std::isfinite(value); });
}

/// A classical Runge-Kutta step.
bool move_on(const Across& across, double t, double h, Eigen::VectorXd& small, State& state) {
  Eigen::VectorXd sum = small;
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(small.size());
  constexpr std::array<std::pair<double, double>, 4> stages{{{0, 1. / 6}, {0.5, 1. / 3}, {0.5, 1. / 3}, {1, 1. / 6}}};
  for (const auto& [part, weight] : stages) {
    const Eigen::VectorXd at = small + part * h * slope;
    if (!slope_near(across, t + part * h, at.data(), state, slope.data())) return false;
    sum += weight * h * slope;
  }
  small = sum;
  return across.chart->find_near(small.data(), state);
}

double time_of(const Across& across, double node) {
  return across.begin_s + (node + 1) / 2 * (across.end_s - across.begin_s);
}

/// Runge-Kutta steps up to the pose and on from it, and between its two neighbours by the polynomial so far.
std::optional<Way> guess(const Across& across, const State& from) {
  Way way;
  way.add(across.begin_s, from);
  State state = from;
  const State start = across.chart->small(from);
  Eigen::VectorXd small = Eigen::Map<const Eigen::VectorXd>(start.data(), static_cast<Eigen::Index>(start.size()));
  std::vector<double> stations = Rule(nodes_of_a_guess).nodes;
  stations.push_back(1);
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const double t = time_of(across, stations[i]);
    if (i == nodes_of_a_guess / 2) {
      state = way.at(t);
      across.chart->small(state.data(), small.data());
      if (!across.chart->find_near(small.data(), state)) return std::nullopt;
    } else if (!move_on(across, way.end(), t - way.end(), small, state)) {
      return std::nullopt;
    }
    way.add(t, state);
  }
  return way;
}

/// When a guess is at the pose: margins fall to 0 there in proportion to the time, and rise from it.
double pose_on(const Across& across, const Way& way) {
  constexpr std::size_t before = nodes_of_a_guess / 2;  // after the first state, which is at the start
  const double falling = across.chart->closure(way.state(before)).margin;
  const double rising = across.chart->closure(way.state(before + 1)).margin;
  return way.time(before) + (way.time(before + 1) - way.time(before)) * falling / (falling + rising);
}

/// Fixed-point iteration, until it changes nothing but rounding.
std::optional<Way> collocate(const Across& across, const State& from, unsigned count, const Way& near) {
  const Rule rule(count);
  const double half = (across.end_s - across.begin_s) / 2;
  const State start = across.chart->small(from);
  const auto size = static_cast<Eigen::Index>(start.size());
  const Eigen::VectorXd first = Eigen::Map<const Eigen::VectorXd>(start.data(), size);
  std::vector<State> states;
  Eigen::MatrixXd small(size, count), slopes(size, count);
  for (unsigned i = 0; i < count; ++i) {
    states.push_back(near.at(time_of(across, rule.nodes[i])));
    across.chart->small(states[i].data(), small.col(i).data());
  }
  constexpr int most_sweeps = 60;
  double before = std::numeric_limits<double>::infinity();
  for (int sweep = 0;; ++sweep) {
    if (sweep == most_sweeps) return std::nullopt;
    for (unsigned i = 0; i < count; ++i) {
      if (!slope_near(across, time_of(across, rule.nodes[i]), small.col(i).data(), states[i], slopes.col(i).data())) {
        return std::nullopt;
      }
    }
    const Eigen::MatrixXd next = (half * slopes * rule.until.transpose()).colwise() + first;
    const double change = (next - small).cwiseAbs().maxCoeff();
    small = next;
    if (change < most_unsure && change > before / 2) break;
    before = change;
    if (change == 0) break;
  }
  const Eigen::VectorXd end = first + half * slopes * rule.to_the_end;
  State last = near.at(across.end_s);
  if (!across.chart->find_near(end.data(), last)) return std::nullopt;
  Way way;
  way.add(across.begin_s, from);
  for (unsigned i = 0; i < count; ++i) way.add(time_of(across, rule.nodes[i]), states[i]);
  way.add(across.end_s, last);
  return way;
}

BodyUncertainty apart(const std::vector<BodyState>& one, const std::vector<BodyState>& other) {
  BodyUncertainty most;
  for (std::size_t i = 0; i < one.size(); ++i) {
    most.position_m = std::fmax(most.position_m, distance(one[i].position, other[i].position));
    most.spin_rad_s = std::fmax(most.spin_rad_s, distance(one[i].spin, other[i].spin));
    for (std::size_t k = 0; k < 9; ++k) {
      most.turn_rad = std::fmax(most.turn_rad, std::fabs(one[i].rotation[k] - other[i].rotation[k]));
    }
  }
  return most;
}

}  // namespace

void Way::add(double t, State state) {
  times_.push_back(t);
  states_.push_back(std::move(state));
}

/// Lagrange's polynomial in its barycentric form.
Way::State Way::at(double t) const {
  State sum(states_[0].size());
  double weights = 0;
  for (std::size_t i = 0; i < times_.size(); ++i) {
    if (t == times_[i]) return states_[i];
    double weight = 1 / (t - times_[i]);
    for (std::size_t j = 0; j < times_.size(); ++j) {
      if (j != i) weight *= (times_.back() - times_.front()) / (times_[i] - times_[j]);
    }
    weights += weight;
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * states_[i][k];
  }
  for (double& number : sum) number /= weights;
  return sum;
}

std::optional<Passage> pass(Across across, const State& from) {
  std::optional<Way> rough = guess(across, from);
  for (int look = 0; rough && look < looks_for_pose; ++look) {
    across.end_s = 2 * pose_on(across, *rough) - across.begin_s;
    rough = guess(across, from);
  }
  if (!rough) return std::nullopt;
  const std::optional<Way> coarse = collocate(across, from, nodes - 2, *rough);
  if (!coarse) return std::nullopt;
  std::optional<Way> fine = collocate(across, from, nodes, *coarse);
  if (!fine) return std::nullopt;
  Passage passage{*std::move(fine), {}, across.chart->small(coarse->last())};
  const State end = across.chart->small(passage.way.last());
  for (std::size_t k = 0; k < end.size(); ++k) passage.unsure_end[k] = std::fabs(passage.unsure_end[k] - end[k]);
  std::vector<BodyState> one(across.equations.bodies());
  std::vector<BodyState> other = one;
  constexpr int looks = 32;
  for (int k = 1; k < looks; ++k) {
    const double t = across.begin_s + (across.end_s - across.begin_s) * k / looks;
    const State now = passage.way.at(t);
    if (!(across.chart->closure(now).error < most_unsure)) return std::nullopt;
    across.equations.show(now.data(), one);
    across.equations.show(coarse->at(t).data(), other);
    const BodyUncertainty off = apart(one, other);
    passage.unsure = {std::fmax(passage.unsure.position_m, off.position_m),
                      std::fmax(passage.unsure.turn_rad, off.turn_rad),
                      std::fmax(passage.unsure.spin_rad_s, off.spin_rad_s)};
  }
  const double worst = std::max({passage.unsure.position_m, passage.unsure.turn_rad, passage.unsure.spin_rad_s});
  return worst < most_unsure ? std::optional(std::move(passage)) : std::nullopt;
}

std::optional<Way> pass_near(const Across& across, const State& from, const Way& way) {
  return collocate(across, from, nodes, way);
}

}  // namespace odeval::reference
