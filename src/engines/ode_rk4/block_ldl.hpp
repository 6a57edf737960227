#pragma once
// L D L' of a symmetric matrix of 6 x 6 blocks, most of them zero: the system of joint forces, a block a joint.
//
// Blocks are eliminated leaves first (minimum degree), so that chains and trees fill nothing in and cost grows linearly
// with the number of joints. A row that repeats what the rows before it say (a planar closed loop in space has three)
// shows as a pivot of rounding size; it is left out, which changes no acceleration.
#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace odeval::engine_rk4 {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

class BlockLdl {
 public:
  /// Plans for blocks of the given numbers of rows (at most 6; the others are zero) with non-zero blocks on the
  /// diagonal and at the given pairs. Each pair once.
  BlockLdl(const std::vector<Eigen::Index>& rows, const std::vector<std::pair<std::size_t, std::size_t>>& pairs);

  /// The matrix to fill in before `factor`, lower triangle: the diagonal blocks (their lower triangles), and for pair p
  /// of the constructor the block with the rows of the one that is eliminated later and the columns of the other.
  Matrix6& diagonal(std::size_t block) { return diagonal_[place_[block]]; }
  Matrix6& pair(std::size_t p) { return lower_[pair_slot_[p]]; }
  /// True when the first of pair p has the rows.
  bool first_has_rows(std::size_t p) const { return first_has_rows_[p]; }

  /// Sets all to zero. Blocks that elimination fills in must be zero before `factor`.
  void clear();

  /// Overwrites the matrix by its factors. A pivot below `tolerance` times its diagonal element is left out.
  void factor(double tolerance);

  /// Overwrites the right-hand side by the solution; rows left out get 0.
  void solve(std::vector<Vector6>& x) const;

  std::size_t left_out() const { return left_out_; }

 private:
  void factor_block(Eigen::Index rows, Matrix6& block, Vector6& inverse_pivots, const Vector6& least);

  struct Entry {
    std::size_t row;   // place in the order of elimination
    std::size_t slot;  // in lower_
  };
  struct Update {
    std::size_t target;  // slot, or place of a diagonal block when `on_diagonal`
    std::size_t left;    // index into a column's entries
    std::size_t right;
    bool on_diagonal;
  };

  std::vector<std::size_t> place_;            // of each block in the order of elimination
  std::vector<std::size_t> block_at_;         // and back
  std::vector<Eigen::Index> rows_;            // by place
  std::vector<std::vector<Entry>> columns_;   // below the diagonal
  std::vector<std::vector<Update>> updates_;  // what eliminating a column changes
  std::vector<std::size_t> pair_slot_;
  std::vector<char> first_has_rows_;
  std::vector<Matrix6> diagonal_;  // by place; after factor: unit lower triangle
  std::vector<Matrix6> lower_;
  std::vector<Vector6> own_;  // diagonal elements before elimination
  std::vector<Vector6> inverse_pivots_;
  std::vector<Matrix6> scaled_;  // L D of the column at hand
  std::size_t left_out_ = 0;
};

}  // namespace odeval::engine_rk4
