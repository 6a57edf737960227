#pragma once
// The file that a program is recorded in, written so that it survives whatever becomes of the program.
#include <cstddef>
#include <string>

#include "audit/preload/record_format.hpp"

namespace odeval::audit {

/// No descriptor stays open, since a program may close all there are; and the disk has room for what is written before
/// it is, since writing through a mapping to a full disk would end the program.
class Record {
 public:
  /// Another process of the program that has the file already is told so there, and nothing more is written.
  Record(const std::string& file, double most_bytes);
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  /// Null when nothing is recorded.
  Head* head() const { return head_; }

  void remark(Remark remark);
  /// Adds a frame, or remarks that there is no room.
  void add(const void* frame, std::size_t bytes);

  /// In a child of a fork: the file is the parent's.
  void leave() { head_ = nullptr; }

 private:
  bool next_piece();

  std::string file_;
  double most_bytes_;
  Head* head_ = nullptr;
  char* piece_ = nullptr;  // mapped
  std::size_t pieces_ = 0;
  std::size_t written_ = 0;  // in all pieces
};

}  // namespace odeval::audit
