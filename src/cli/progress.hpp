#pragma once
// One line on a terminal that says how far long work is; nothing at all in a pipe.
#include <cstddef>
#include <string>

namespace odeval::cli {

class Progress {
 public:
  /// `total` pieces of work. `quiet` silences a terminal as well.
  Progress(std::size_t total, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows that the next piece begins.
  void next(const std::string& what);

  bool shown() const { return shown_; }
  /// Shows the line as it is.
  void show(const std::string& line) const;

 private:
  void clear() const;

  std::size_t total_;
  std::size_t done_ = 0;
  bool shown_;
};

}  // namespace odeval::cli
