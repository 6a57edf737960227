#pragma once
// One line on a terminal that says how far long work is; nothing at all in a pipe.
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>

namespace odeval::cli {

class Progress {
 public:
  /// Whether a piece that takes long shows its seconds. A thread does, so not beside what is timed, nor in a process
  /// that forks.
  enum class Clock { none, shown };

  /// `total` pieces of work. `quiet` silences a terminal as well.
  Progress(std::size_t total, bool quiet, Clock clock = Clock::none);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows that the next piece begins.
  void next(const std::string& what);

  bool shown() const { return shown_; }
  /// Shows the line as it is.
  void show(const std::string& line);

 private:
  void print(const std::string& line) const;
  void count_seconds(const std::stop_token& stop);

  std::size_t total_;
  std::size_t done_ = 0;
  bool shown_;
  std::mutex mutex_;  // of the line
  std::condition_variable_any stopped_;
  std::string line_;
  int seconds_ = 0;      // that the line has stood
  std::jthread ticker_;  // the last member: it ends first
};

}  // namespace odeval::cli
