#include "engines/ode_rk4/complementarity.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace odeval::engine_rk4 {
namespace {

using Indices = std::vector<Eigen::Index>;

// Of a diagonal element: what is left of a row that the active ones already say is rounding, 1e-16 times their number
// and condition.
constexpr double dependent = 1e-11;
constexpr double rounding = 1e-13;  // of the largest b: a row violated by less is satisfied

/// The active rows and columns of A, factored.
class Active {
 public:
  explicit Active(const Eigen::MatrixXd& a) : a_(a) {}

  const Indices& rows() const { return rows_; }
  bool holds(Eigen::Index row) const { return std::ranges::find(rows_, row) != rows_.end(); }
  void add(Eigen::Index row) {
    rows_.push_back(row);
    factor();
  }
  void remove(Eigen::Index row) {
    std::erase(rows_, row);
    factor();
  }
  /// Of the active rows of a vector.
  Eigen::VectorXd solve(const Eigen::VectorXd& all) const {
    Eigen::VectorXd x = all(rows_);
    if (!rows_.empty()) cholesky_.solveInPlace(x);
    return x;
  }

 private:
  void factor() {
    if (!rows_.empty()) cholesky_.compute(a_(rows_, rows_));
  }

  const Eigen::MatrixXd& a_;
  Indices rows_;
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
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

}  // namespace

Eigen::VectorXd complementary(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  Eigen::VectorXd p = Eigen::VectorXd::Zero(b.size());
  if (b.size() == 0) return p;
  const double enough = rounding * b.cwiseAbs().maxCoeff();
  Active active(a);
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
    const double is_new = a(worst, worst) - share.dot(a.col(worst)(active.rows()));
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
  return p;
}

}  // namespace odeval::engine_rk4
