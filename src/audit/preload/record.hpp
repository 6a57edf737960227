#pragma once
// The file that a program is recorded in, written so that it survives whatever becomes of the program.
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "audit/preload/record_format.hpp"

namespace odeval::audit {

/// No descriptor stays open, since a program may close all there are; and the disk has room for what is mapped before
/// it is, since writing through a mapping to a full disk would end the program.
class Record {
 public:
  Record(std::string file, double most_bytes) : file_(std::move(file)), most_bytes_(most_bytes) {}
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  /// The record's head; null when nothing is recorded. The first call begins the file: a process of the program that
  /// only starts another has none. Where another process has begun it, that is remarked there, and nothing is recorded.
  Head* head();

  void remark(Remark remark);
  /// Adds a frame, or remarks that there is no room, or that the record is as long as it may be.
  void add(const void* frame, std::size_t bytes, std::uint64_t step, double t);

  /// `kind` is "body" or "joint".
  void name(const char* kind, std::uint32_t number, const char* name);

  /// In a child of a fork: a file that was begun is the parent's.
  void leave_to_parent() {
    if (state_ == State::begun) state_ = State::not_begun;
    head_ = nullptr;
  }

 private:
  enum class State { not_begun, begun, none };
  void begin();
  /// Whether the record may not be longer than with what is in the window.
  bool is_full() const;
  /// Makes room in the window, which is full; false when there is none behind it.
  bool empty_window();

  std::string file_;
  double most_bytes_;
  State state_ = State::not_begun;
  Head* head_ = nullptr;
  char* window_ = nullptr;
  std::size_t written_ = 0;  // through the window
};

}  // namespace odeval::audit
