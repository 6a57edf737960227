#include "audit/preload/record.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "audit/preload/rows.hpp"

namespace odeval::audit {
namespace {

constexpr std::size_t piece_bytes = 1 << 20;

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
  head_ = static_cast<Head*>(mapped(descriptor, 0, head_bytes));
  ::close(descriptor);
  if (head_ == nullptr) return;
  head_->magic = record_magic;
  state_ = State::begun;
}

Head* Record::head() {
  if (state_ == State::not_begun) begin();
  return head_;
}

void Record::remark(Remark remark) {
  if (Head* its = head()) its->remarks |= remark;
}

void Record::name(const char* kind, std::uint32_t number, const char* name) {
  if (head() == nullptr) return;
  std::string line = std::string(kind) + ' ' + std::to_string(number) + ' ' + name;
  std::replace_if(
      line.begin(), line.end(), [](unsigned char letter) { return letter < ' '; }, ' ');
  line += '\n';
  const int descriptor = ::open((file_ + names_ending).c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0) return remark(no_room);
  const bool whole = ::write(descriptor, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  ::close(descriptor);
  if (!whole) remark(no_room);
}

bool Record::next_piece() {
  if (piece_ != nullptr) ::munmap(piece_, piece_bytes);
  piece_ = nullptr;
  const std::size_t begin = head_bytes + pieces_ * piece_bytes;
  if (most_bytes_ > 0 && static_cast<double>(begin + piece_bytes) > most_bytes_) return false;
  const int descriptor = ::open(file_.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return false;
  piece_ = static_cast<char*>(mapped(descriptor, begin, piece_bytes));
  ::close(descriptor);
  ++pieces_;
  return piece_ != nullptr;
}

void Record::add(const void* frame, std::size_t bytes) {
  if (head() == nullptr || (head_->remarks & no_room) != 0) return;
  const char* rest = static_cast<const char*>(frame);
  for (std::size_t left = bytes; left > 0;) {
    const std::size_t room = pieces_ * piece_bytes - written_;
    if (room == 0) {
      if (next_piece()) continue;
      return remark(no_room);
    }
    const std::size_t part = std::min(left, room);
    std::memcpy(piece_ + (piece_bytes - room), rest, part);
    rest += part;
    left -= part;
    written_ += part;
  }
  head_->committed = written_;
}

}  // namespace odeval::audit
