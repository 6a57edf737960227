#include "engines/ode_rk4/complementarity.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace odeval::engine_rk4 {
namespace {

using Indices = std::vector<Eigen::Index>;

// Of a diagonal element: what is left of a row that the active ones already say is rounding, 1e-16 times their number
// and condition.
constexpr double dependent = 1e-11;
constexpr double clearly = 1e3;     // of the rounding of energy
constexpr double rounding = 1e-13;  // of the largest b: a row violated by less is satisfied

/// The active rows and columns of A, factored: L L'.
class Active {
 public:
  explicit Active(const Eigen::MatrixXd& a) : a_(a), l_(a.rows(), a.rows()) {}

  /// Begins with rows in which p will be positive, of those that are guessed to be. Returns p.
  Eigen::VectorXd begin(const Eigen::VectorXd& b, Indices guess) {
    Eigen::VectorXd p = Eigen::VectorXd::Zero(b.size());
    while (!guess.empty()) {
      const Eigen::LLT<Eigen::MatrixXd> llt(a_(guess, guess));
      const auto l = llt.matrixLLT();
      const auto own = a_.diagonal()(guess).array();
      if (llt.info() != Eigen::Success || (l.diagonal().array().square() <= dependent * own).any()) break;
      const Eigen::VectorXd x = -llt.solve(b(guess).eval());
      if (x.minCoeff() > 0) {
        rows_ = guess;
        l_.topLeftCorner(size(), size()) = l;
        p(rows_) = x;
        break;
      }
      Indices left;
      for (std::size_t k = 0; k < guess.size(); ++k) {
        if (x[static_cast<Eigen::Index>(k)] > 0) left.push_back(guess[k]);
      }
      guess = std::move(left);
    }
    return p;
  }

  const Indices& rows() const { return rows_; }
  bool holds(Eigen::Index row) const { return std::ranges::find(rows_, row) != rows_.end(); }
  void add(Eigen::Index row) {
    rows_.push_back(row);
    factor_last(size() - 1);
  }
  void remove(Eigen::Index row) {
    const auto at = std::ranges::find(rows_, row);
    const auto first = at - rows_.begin();
    rows_.erase(at);
    for (Eigen::Index k = first; k < size(); ++k) factor_last(k);
  }
  /// Of the active rows of a vector.
  Eigen::VectorXd solve(const Eigen::VectorXd& all) const {
    Eigen::VectorXd x = all(rows_);
    const auto l = l_.topLeftCorner(size(), size());
    l.triangularView<Eigen::Lower>().solveInPlace(x);
    l.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
    return x;
  }

 private:
  Eigen::Index size() const { return static_cast<Eigen::Index>(rows_.size()); }
  /// Row k of L, from those before it.
  void factor_last(Eigen::Index k) {
    const Eigen::Index row = rows_[static_cast<std::size_t>(k)];
    Eigen::VectorXd l(k);
    for (Eigen::Index i = 0; i < k; ++i) l[i] = a_(row, rows_[static_cast<std::size_t>(i)]);
    l_.topLeftCorner(k, k).triangularView<Eigen::Lower>().solveInPlace(l);
    l_.row(k).head(k) = l.transpose();
    l_(k, k) = std::sqrt(std::max(a_(row, row) - l.squaredNorm(), std::numeric_limits<double>::min()));
  }

  const Eigen::MatrixXd& a_;
  Indices rows_;
  Eigen::MatrixXd l_;
};

struct Stop {
  double step;
  Eigen::Index by;  // the row whose p has become 0, or -1
};

/// Moves p by `direction` (over the given rows) as far as it stays positive, at most by `most`.
Stop move(Eigen::VectorXd& p, const Indices& rows, const Eigen::VectorXd& direction, double most) {
  Stop stop{most, -1};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double d = direction[static_cast<Eigen::Index>(k)];
    if (d < 0 && p[rows[k]] + stop.step * d <= 0) stop = {-p[rows[k]] / d, rows[k]};
  }
  if (std::isinf(stop.step)) return stop;
  for (std::size_t k = 0; k < rows.size(); ++k) p[rows[k]] += stop.step * direction[static_cast<Eigen::Index>(k)];
  if (stop.by >= 0) p[stop.by] = 0;
  return stop;
}

Eigen::VectorXd complementary_of_coupled(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                         const Eigen::VectorXd& guess) {
  if (b.size() == 0) return b;
  const double enough = rounding * b.cwiseAbs().maxCoeff();
  Active active(a);
  Indices positive;
  for (Eigen::Index i = 0; i < guess.size(); ++i) {
    if (guess[i] > 0) positive.push_back(i);
  }
  Eigen::VectorXd p = active.begin(b, std::move(positive));
  std::vector<char> hopeless(static_cast<std::size_t>(b.size()), 0);
  // A round adds a row or gives one up; few leave again.
  for (Eigen::Index round = 0; round < 10 * b.size(); ++round) {
    const Eigen::VectorXd w = a * p + b;
    Eigen::Index worst = -1;
    for (Eigen::Index i = 0; i < b.size(); ++i) {
      if (w[i] >= -enough || hopeless[static_cast<std::size_t>(i)] != 0 || active.holds(i)) continue;
      if (worst < 0 || w[i] < w[worst]) worst = i;
    }
    if (worst < 0) break;

    const Eigen::VectorXd share = active.solve(a.col(worst));
    const Eigen::VectorXd with_active = a.col(worst)(active.rows());
    const double is_new = a(worst, worst) - std::inner_product(share.begin(), share.end(), with_active.begin(), 0.0);
    if (!(is_new > dependent * a(worst, worst))) {
      // It says what the active ones say: it takes over what they push, until one of them pushes no more.
      const Stop stop = move(p, active.rows(), -share, INFINITY);
      if (stop.by < 0) {
        hopeless[static_cast<std::size_t>(worst)] = 1;
        continue;
      }
      p[worst] = stop.step;
      active.remove(stop.by);
    }
    active.add(worst);
    for (;;) {
      const Stop stop = move(p, active.rows(), -active.solve(b) - p(active.rows()), 1);
      if (stop.by < 0) break;
      active.remove(stop.by);
      if (stop.by == worst) hopeless[static_cast<std::size_t>(worst)] = 1;  // violated by rounding only
    }
  }
  // Once more, for what rounding has left.
  if (!active.rows().empty()) {
    const Eigen::VectorXd more = active.solve(a * p + b);
    const Eigen::VectorXd better = p(active.rows()) - more;
    if (better.minCoeff() >= 0) p(active.rows()) = better;
  }
  return p;
}

}  // namespace

std::vector<std::vector<Eigen::Index>> coupled(const Eigen::MatrixXd& a) {
  std::vector<Indices> groups;
  std::vector<char> met(static_cast<std::size_t>(a.rows()), 0);
  for (Eigen::Index first = 0; first < a.rows(); ++first) {
    if (met[static_cast<std::size_t>(first)] != 0) continue;
    met[static_cast<std::size_t>(first)] = 1;
    Indices group{first};
    for (std::size_t k = 0; k < group.size(); ++k) {
      for (Eigen::Index other = 0; other < a.rows(); ++other) {
        if (met[static_cast<std::size_t>(other)] != 0 || a(group[k], other) == 0) continue;
        met[static_cast<std::size_t>(other)] = 1;
        group.push_back(other);
      }
    }
    std::ranges::sort(group);
    groups.push_back(std::move(group));
  }
  return groups;
}

bool takes_energy(const Eigen::MatrixXd& a, const Eigen::VectorXd& v, const Eigen::VectorXd& p) {
  const Eigen::VectorXd size = p.cwiseAbs();
  const double rounding_of_energy = std::numeric_limits<double>::epsilon() * size.dot(a.cwiseAbs() * size);
  return p.dot(2 * v + a * p) < -clearly * rounding_of_energy;
}

Eigen::VectorXd complementary(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& guess) {
  const auto groups = coupled(a);
  if (groups.size() == 1) return complementary_of_coupled(a, b, guess);
  Eigen::VectorXd p = Eigen::VectorXd::Zero(b.size());
  for (const Indices& group : groups) {
    p(group) = complementary_of_coupled(a(group, group), b(group),
                                        guess.size() > 0 ? Eigen::VectorXd(guess(group)) : Eigen::VectorXd());
  }
  return p;
}

}  // namespace odeval::engine_rk4
