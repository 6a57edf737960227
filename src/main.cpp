// The program: reads the command line, does it, and turns what went wrong into one line and an exit status.
#include <exception>
#include <iostream>

#include "cli/commands.hpp"
#include "odeval/error.hpp"

int main(int argc, char** argv) try {
  return odeval::cli::run_command_line(argc, argv);
} catch (const odeval::UserError& error) {
  std::cerr << "odeval: " << error.what() << '\n';
  return 2;
} catch (const std::exception& error) {
  std::cerr << "odeval: " << error.what() << '\n';
  return 3;
}
