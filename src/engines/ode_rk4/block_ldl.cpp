#include "engines/ode_rk4/block_ldl.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace odeval::engine_rk4 {
namespace {

using Neighbours = std::vector<std::set<std::size_t>>;

/// The order of elimination that takes the block with the fewest neighbours first; joins the neighbours of each.
std::vector<std::size_t> minimum_degree(Neighbours& graph, std::vector<std::vector<std::size_t>>& columns) {
  std::vector<std::size_t> order;
  std::set<std::pair<std::size_t, std::size_t>> waiting;  // degree, block
  for (std::size_t b = 0; b < graph.size(); ++b) waiting.emplace(graph[b].size(), b);
  columns.resize(graph.size());
  while (!waiting.empty()) {
    const std::size_t block = waiting.begin()->second;
    waiting.erase(waiting.begin());
    order.push_back(block);
    columns[block].assign(graph[block].begin(), graph[block].end());
    for (const std::size_t one : graph[block]) {
      waiting.erase({graph[one].size(), one});
      graph[one].erase(block);
    }
    for (const std::size_t one : graph[block]) {
      for (const std::size_t other : graph[block]) {
        if (one != other) graph[one].insert(other);
      }
    }
    for (const std::size_t one : graph[block]) waiting.emplace(graph[one].size(), one);
  }
  return order;
}

}  // namespace

BlockLdl::BlockLdl(const std::vector<Eigen::Index>& rows, const std::vector<std::pair<std::size_t, std::size_t>>& pairs)
    : place_(rows.size()),
      columns_(rows.size()),
      updates_(rows.size()),
      diagonal_(rows.size()),
      own_(rows.size()),
      inverse_pivots_(rows.size(), Vector6::Zero()) {
  const std::size_t size = rows.size();
  Neighbours graph(size);
  for (const auto& [a, b] : pairs) {
    graph[a].insert(b);
    graph[b].insert(a);
  }
  std::vector<std::vector<std::size_t>> below(size);
  block_at_ = minimum_degree(graph, below);
  for (std::size_t p = 0; p < size; ++p) place_[block_at_[p]] = p;
  for (const std::size_t block : block_at_) rows_.push_back(rows[block]);

  std::map<std::pair<std::size_t, std::size_t>, std::size_t> slots;  // row place, column place
  for (std::size_t column = 0; column < size; ++column) {
    for (const std::size_t block : below[block_at_[column]]) columns_[column].push_back({place_[block], 0});
    std::ranges::sort(columns_[column], {}, &Entry::row);
    for (Entry& entry : columns_[column]) {
      entry.slot = slots.size();
      slots.emplace(std::pair(entry.row, column), entry.slot);
    }
  }
  lower_.resize(slots.size());
  for (const auto& entries : columns_) scaled_.resize(std::max(scaled_.size(), entries.size()));
  for (std::size_t column = 0; column < size; ++column) {
    const std::vector<Entry>& entries = columns_[column];
    for (std::size_t right = 0; right < entries.size(); ++right) {
      updates_[column].push_back({entries[right].row, right, right, true});
      for (std::size_t left = right + 1; left < entries.size(); ++left) {
        updates_[column].push_back({slots.at({entries[left].row, entries[right].row}), left, right, false});
      }
    }
  }
  for (const auto& [a, b] : pairs) {
    const bool first = place_[a] > place_[b];
    first_has_rows_.push_back(first);
    pair_slot_.push_back(slots.at(first ? std::pair(place_[a], place_[b]) : std::pair(place_[b], place_[a])));
  }
}

void BlockLdl::clear() {
  for (Matrix6& block : diagonal_) block.setZero();
  for (Matrix6& block : lower_) block.setZero();
}

// Left- or right-looking makes no difference to the sums; this one updates what stands to the right at once.
void BlockLdl::factor(double tolerance) {
  left_out_ = 0;
  for (std::size_t p = 0; p < diagonal_.size(); ++p) own_[p] = diagonal_[p].diagonal();
  for (std::size_t column = 0; column < columns_.size(); ++column) {
    Matrix6& d = diagonal_[column];
    const Eigen::Index rows = rows_[column];
    factor_block(rows, d, inverse_pivots_[column], tolerance * own_[column]);
    const std::vector<Entry>& entries = columns_[column];
    for (std::size_t e = 0; e < entries.size(); ++e) {
      Matrix6& block = lower_[entries[e].slot];
      for (Eigen::Index j = 1; j < rows; ++j) {
        for (Eigen::Index m = 0; m < j; ++m) block.col(j) -= d(j, m) * block.col(m);
      }
      scaled_[e] = block;
      for (Eigen::Index j = 0; j < rows; ++j) block.col(j) *= inverse_pivots_[column][j];
    }
    for (const Update& update : updates_[column]) {
      Matrix6& target = update.on_diagonal ? diagonal_[update.target] : lower_[update.target];
      target.noalias() -= lower_[entries[update.left].slot] * scaled_[update.right].transpose();
    }
  }
}

/// L D L' in place: the unit lower triangle below the diagonal. Pivots not above their least are left out.
void BlockLdl::factor_block(Eigen::Index rows, Matrix6& d, Vector6& inverse, const Vector6& least) {
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double pivot = d(k, k);
    const bool kept = pivot > least[k];
    left_out_ += kept ? 0 : 1;
    inverse[k] = kept ? 1 / pivot : 0;
    for (Eigen::Index j = k + 1; j < rows; ++j) {
      const double l = d(j, k) * inverse[k];
      for (Eigen::Index i = j; i < rows; ++i) d(i, j) -= l * d(i, k);
    }
    for (Eigen::Index i = k + 1; i < rows; ++i) d(i, k) *= inverse[k];
  }
}

void BlockLdl::solve(std::vector<Vector6>& x) const {
  const std::size_t size = columns_.size();
  for (std::size_t column = 0; column < size; ++column) {
    Vector6& y = x[block_at_[column]];
    const Matrix6& d = diagonal_[column];
    const Eigen::Index rows = rows_[column];
    for (Eigen::Index j = 0; j < rows; ++j) {
      for (Eigen::Index i = j + 1; i < rows; ++i) y[i] -= d(i, j) * y[j];
    }
    for (const Entry& entry : columns_[column]) x[block_at_[entry.row]].noalias() -= lower_[entry.slot] * y;
  }
  for (std::size_t column = size; column-- > 0;) {
    Vector6& y = x[block_at_[column]];
    const Matrix6& d = diagonal_[column];
    y = y.cwiseProduct(inverse_pivots_[column]);
    for (const Entry& entry : columns_[column]) {
      y.noalias() -= lower_[entry.slot].transpose() * x[block_at_[entry.row]];
    }
    for (Eigen::Index i = rows_[column]; i-- > 0;) {
      for (Eigen::Index k = i + 1; k < rows_[column]; ++k) y[i] -= d(k, i) * y[k];
    }
  }
}

}  // namespace odeval::engine_rk4
