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
  if (!shown_) return;
  clear();
  std::fprintf(stderr, "[%zu/%zu] %s", done_, total_, what.c_str());
  std::fflush(stderr);
}

void Progress::clear() const { std::fputs("\r\033[K", stderr); }

}  // namespace odeval::cli
