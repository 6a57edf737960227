#pragma once
// Rows of one size in a file, written in place through memory that is mapped from it: what stands there when the
// program dies is what it came to until then.
#include <cstddef>
#include <string>

namespace odeval::audit {

/// Whether a file of this process may be so long: one more byte would be a signal.
bool within_limit(std::size_t bytes);

/// `bytes` of a file from `begin` on in memory, with room for them on the disk; null when there is none.
void* mapped(int descriptor, std::size_t begin, std::size_t bytes);

/// Rows are zeros at first, and stay where they are.
class RowsOfBytes {
 public:
  RowsOfBytes(std::string file, std::size_t row_bytes) : file_(std::move(file)), row_bytes_(row_bytes) {}
  RowsOfBytes(const RowsOfBytes&) = delete;
  RowsOfBytes& operator=(const RowsOfBytes&) = delete;

  /// Null where there is no room for more, on the disk or within `most_rows`.
  void* add();

 private:
  bool next_piece();

  std::string file_;
  std::size_t row_bytes_;
  std::size_t rows_ = 0;
  char* piece_ = nullptr;
  bool full_ = false;
};

template <class Row>
class Rows : private RowsOfBytes {
 public:
  explicit Rows(std::string file) : RowsOfBytes(std::move(file), sizeof(Row)) {}
  Row* add() { return static_cast<Row*>(RowsOfBytes::add()); }
};

}  // namespace odeval::audit
