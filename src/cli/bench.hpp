#pragma once
// Timing as `odeval bench` and `odeval report` do it.
#include <cmath>
#include <string>
#include <vector>

#include "cli/settings.hpp"

namespace odeval::cli {

struct BenchOptions {
  std::vector<std::string> scenarios;  // none: all that come with the program
  std::vector<std::string> methods;    // none: each scenario's own
  Settings settings;
  int repeats = 7;
  double enough_s = HUGE_VAL;  // of CPU time, after which a run is not repeated
  double equal_error = 0;      // rad; 0: at equal steps
  double until = 3;            // s, how long the error has to be kept
  std::string out = "results";
  bool quiet = false;
  bool json = false;
};

/// Times, writes timing.csv and timing.json, at equal error equal_error.csv and equal_error.json, and returns the exit
/// status.
int bench(const BenchOptions& options);

}  // namespace odeval::cli
