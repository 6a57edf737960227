// The program: reads the command line, does it, and turns what went wrong into one line and an exit status.
#include <unistd.h>

#include <csignal>
#include <exception>
#include <iostream>
#include <new>

#include "cli/commands.hpp"
#include "odeval/error.hpp"
#include "output/terminal.hpp"

namespace {

/// What went wrong, in one line.
int fail(const char* what, int status) {
  const bool coloured = odeval::wants_colours(STDERR_FILENO);
  std::cerr << (coloured ? "\033[1;31modeval:\033[0m " : "odeval: ") << what << '\n';
  return status;
}

}  // namespace

int main(int argc, char** argv) try {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may grow no further is an error like a full disk
  odeval::colour_tables(odeval::wants_colours(STDOUT_FILENO));
  odeval::cli::CommandLine line;
  const int status = line.read({argv + 1, argv + argc})();
  if (!std::cout.flush()) throw odeval::MachineError("standard output cannot be written");
  return status;
} catch (const odeval::UserError& error) {
  return fail(error.what(), 2);
} catch (const std::bad_alloc&) {
  return fail("out of memory; fewer rows or pixels need less: --sample DT, --duration T, --size WxH", 3);
} catch (const std::exception& error) {
  return fail(error.what(), 3);
}
