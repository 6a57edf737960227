#include "cli/progress.hpp"

#include <unistd.h>

#include <cstdio>

namespace odeval::cli {

Progress::Progress(std::size_t total, bool quiet) : total_(total), shown_(!quiet && isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (shown_) clear();
}

void Progress::next(const std::string& what) {
  ++done_;
  show("[" + std::to_string(done_) + "/" + std::to_string(total_) + "] " + what);
}

void Progress::show(const std::string& line) const {
  if (!shown_) return;
  clear();
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
}

void Progress::clear() const { std::fputs("\r\033[K", stderr); }

}  // namespace odeval::cli
