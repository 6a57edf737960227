// The program: reads the command line, does it, and turns what went wrong into one line and an exit status.
#include <csignal>
#include <exception>
#include <iostream>
#include <new>

#include "cli/commands.hpp"
#include "odeval/error.hpp"

int main(int argc, char** argv) try {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may grow no further is an error like a full disk
  odeval::cli::CommandLine line;
  const int status = line.read({argv + 1, argv + argc})();
  if (!std::cout.flush()) throw odeval::MachineError("standard output cannot be written");
  return status;
} catch (const odeval::UserError& error) {
  std::cerr << "odeval: " << error.what() << '\n';
  return 2;
} catch (const std::bad_alloc&) {
  std::cerr << "odeval: out of memory; fewer rows or pixels need less: --sample DT, --duration T, --size WxH\n";
  return 3;
} catch (const std::exception& error) {
  std::cerr << "odeval: " << error.what() << '\n';
  return 3;
}
