#include "reference/maximal/box_lcp.hpp"

#include <cmath>

namespace odeval::reference::maximal {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void BoxLcp::reserve(Index rows) {
  if (factor_.rows() >= rows) return;
  place_.reserve(static_cast<std::size_t>(rows));
  free_.reserve(static_cast<std::size_t>(rows));
  factor_.resize(rows, rows);
  right_.resize(rows);
}

bool BoxLcp::solve(Index rows, const MatrixXd& a, const VectorXd& b, const VectorXd& lo, const VectorXd& hi,
                   VectorXd& x) {
  reserve(rows);
  place_.assign(static_cast<std::size_t>(rows), Place::free);
  for (Index i = 0; i < rows; ++i) {
    if (std::isinf(lo[i]) && std::isinf(hi[i])) continue;
    const bool low = !std::isinf(lo[i]);
    place_[static_cast<std::size_t>(i)] = low ? Place::at_lo : Place::at_hi;
    x[i] = low ? lo[i] : hi[i];
  }
  // Far more than the sets that contacts of one body go through; rounding alone can make the pivoting go round.
  const Index most = 100 + 10 * rows;
  for (Index turn = 0; turn < most; ++turn) {
    solve_free(rows, a, b, x);
    if (!move_one(rows, a, b, lo, hi, x)) return true;
  }
  return false;
}

void BoxLcp::solve_free(Index rows, const MatrixXd& a, const VectorXd& b, VectorXd& x) {
  free_.clear();
  for (Index i = 0; i < rows; ++i) {
    if (place_[static_cast<std::size_t>(i)] == Place::free) free_.push_back(i);
  }
  const auto n = static_cast<Index>(free_.size());
  const auto row = [this](Index k) { return free_[static_cast<std::size_t>(k)]; };
  for (Index i = 0; i < n; ++i) {
    right_[i] = b[row(i)];
    for (Index j = 0; j < rows; ++j) {
      if (place_[static_cast<std::size_t>(j)] != Place::free) right_[i] -= a(row(i), j) * x[j];
    }
    for (Index j = 0; j <= i; ++j) factor_(i, j) = a(row(i), row(j));
  }
  for (Index j = 0; j < n; ++j) {
    for (Index i = j + 1; i < n; ++i) {
      const double l = factor_(i, j) / factor_(j, j);
      for (Index k = j + 1; k <= i; ++k) factor_(i, k) -= l * factor_(k, j);
    }
    for (Index i = j + 1; i < n; ++i) factor_(i, j) /= factor_(j, j);
  }
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < i; ++j) right_[i] -= factor_(i, j) * right_[j];
  }
  for (Index i = n; i-- > 0;) {
    right_[i] /= factor_(i, i);
    for (Index j = i + 1; j < n; ++j) right_[i] -= factor_(j, i) * right_[j];
    x[row(i)] = right_[i];
  }
}

// The row of the least number that breaks its rule changes its place; false when none does.
bool BoxLcp::move_one(Index rows, const MatrixXd& a, const VectorXd& b, const VectorXd& lo, const VectorXd& hi,
                      VectorXd& x) {
  for (Index i = 0; i < rows; ++i) {
    Place& place = place_[static_cast<std::size_t>(i)];
    if (place == Place::free) {
      if (x[i] < lo[i]) {
        place = Place::at_lo;
        x[i] = lo[i];
        return true;
      }
      if (x[i] > hi[i]) {
        place = Place::at_hi;
        x[i] = hi[i];
        return true;
      }
      continue;
    }
    const double w = a.row(i).head(rows).dot(x.head(rows)) - b[i];
    if (place == Place::at_lo ? w < 0 : w > 0) {
      place = Place::free;
      return true;
    }
  }
  return false;
}

}  // namespace odeval::reference::maximal
