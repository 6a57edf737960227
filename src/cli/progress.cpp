#include "cli/progress.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>

namespace odeval::cli {

Progress::Progress(std::size_t total, bool quiet, Clock clock)
    : total_(total), shown_(!quiet && isatty(STDERR_FILENO) == 1) {
  if (shown_ && clock == Clock::shown) {
    ticker_ = std::jthread([this](const std::stop_token& stop) { count_seconds(stop); });
  }
}

Progress::~Progress() {
  if (ticker_.joinable()) {
    ticker_.request_stop();
    ticker_.join();
  }
  if (shown_) print("");
}

void Progress::next(const std::string& what) {
  ++done_;
  show("[" + std::to_string(done_) + "/" + std::to_string(total_) + "] " + what);
}

void Progress::show(const std::string& line) {
  if (!shown_) return;
  const std::lock_guard lock(mutex_);
  line_ = line;
  seconds_ = 0;
  print(line_);
}

void Progress::print(const std::string& line) const {
  std::fprintf(stderr, "\r\033[K%s", line.c_str());
  std::fflush(stderr);
}

void Progress::count_seconds(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stopped_.wait_for(lock, stop, std::chrono::seconds(1), [] { return false; }) && !stop.stop_requested()) {
    if (!line_.empty()) print(line_ + ", " + std::to_string(++seconds_) + " s");
  }
}

}  // namespace odeval::cli
