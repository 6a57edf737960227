#include "audit/preload/rows.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace odeval::audit {
namespace {

constexpr std::size_t rows_in_piece = 512;  // of a power of two of bytes from 8 on, so that pieces are whole pages
constexpr std::size_t most_rows = 64 * rows_in_piece;

}  // namespace

bool within_limit(std::size_t bytes) {
  rlimit limit{};
  return ::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur >= bytes;
}

void* mapped(int descriptor, std::size_t begin, std::size_t bytes) {
  if (!within_limit(begin + bytes)) return nullptr;
  if (::posix_fallocate(descriptor, static_cast<off_t>(begin), static_cast<off_t>(bytes)) != 0) return nullptr;
  void* place = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, static_cast<off_t>(begin));
  return place == MAP_FAILED ? nullptr : place;
}

bool RowsOfBytes::next_piece() {
  if (rows_ == most_rows) return false;
  const int descriptor = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0) return false;
  piece_ = static_cast<char*>(mapped(descriptor, rows_ * row_bytes_, rows_in_piece * row_bytes_));
  ::close(descriptor);
  return piece_ != nullptr;
}

void* RowsOfBytes::add() {
  if (full_) return nullptr;
  if (rows_ % rows_in_piece == 0 && !next_piece()) {
    full_ = true;
    return nullptr;
  }
  return piece_ + (rows_++ % rows_in_piece) * row_bytes_;
}

}  // namespace odeval::audit
