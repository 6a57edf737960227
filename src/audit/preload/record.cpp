#include "audit/preload/record.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>

#include "audit/preload/rows.hpp"

namespace odeval::audit {
namespace {

/// Another process of the program was first.
void tell_the_first(const std::string& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return;
  if (void* place = mapped(descriptor, 0, head_bytes)) {
    static_cast<Head*>(place)->remarks |= several_processes;
    ::munmap(place, head_bytes);
  }
  ::close(descriptor);
}

}  // namespace

void Record::begin() {
  state_ = State::none;
  if (file_.empty()) return;
  const int descriptor = ::open(file_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) {
    tell_the_first(file_);
    return;
  }
  auto* const place = static_cast<char*>(mapped(descriptor, 0, head_bytes + window_bytes));
  ::close(descriptor);
  if (place == nullptr) return;
  head_ = reinterpret_cast<Head*>(place);
  window_ = place + head_bytes;
  head_->magic = record_magic;
  state_ = State::begun;
}

Head* Record::head() {
  if (state_ == State::not_begun) begin();
  return head_;
}

void Record::remark(Remark remark) {
  if (Head* its = head()) std::atomic_ref(its->remarks).fetch_or(remark);  // by any thread
}

void Record::name(const char* kind, std::uint32_t number, const char* name) {
  if (head() == nullptr) return;
  std::string line = std::string(kind) + ' ' + std::to_string(number) + ' ' + (name == nullptr ? "" : name);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char letter) { return letter < ' '; }, ' ');
  line += '\n';
  const int descriptor = ::open((file_ + names_ending).c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0) return remark(no_room);
  const bool whole = ::write(descriptor, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  ::close(descriptor);
  if (!whole) remark(no_room);
}

bool Record::is_full() const {
  return most_bytes_ > 0 && static_cast<double>(head_bytes + 2 * window_bytes + head_->behind) > most_bytes_;
}

bool Record::empty_window() {
  const std::size_t begin = head_bytes + window_bytes + head_->behind;
  const int descriptor = within_limit(begin + window_bytes) ? ::open(file_.c_str(), O_WRONLY | O_CLOEXEC) : -1;
  if (descriptor < 0) return false;
  const ssize_t got = ::pwrite(descriptor, window_, window_bytes, static_cast<off_t>(begin));
  const bool whole = ::close(descriptor) == 0 && got == static_cast<ssize_t>(window_bytes);
  if (!whole) return false;
  // Whoever reads after a death here finds the same bytes in both places.
  std::atomic_signal_fence(std::memory_order_seq_cst);
  head_->behind += window_bytes;
  std::atomic_signal_fence(std::memory_order_seq_cst);
  return true;
}

void Record::add(const void* frame, std::size_t bytes, std::uint64_t step, double t) {
  if (head() == nullptr || (head_->remarks & (no_room | record_full)) != 0) return;
  const char* rest = static_cast<const char*>(frame);
  for (std::size_t left = bytes; left > 0;) {
    const std::size_t in_window = written_ - head_->behind;
    if (in_window == window_bytes) {
      if (is_full()) return remark(record_full);
      if (!empty_window()) return remark(no_room);
    }
    const std::size_t at = in_window % window_bytes;  // 0 where it was full
    const std::size_t part = std::min(left, window_bytes - at);
    std::memcpy(window_ + at, rest, part);
    rest += part;
    left -= part;
    written_ += part;
  }
  std::atomic_signal_fence(std::memory_order_seq_cst);
  head_->committed = written_;
  head_->steps = std::max(head_->steps, step);
  head_->t = std::max(head_->t, t);
}

}  // namespace odeval::audit
