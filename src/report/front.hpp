#pragma once
// A cloud of runs and its Pareto front as a picture of its own.
#include <string>

#include "report/document.hpp"

namespace odeval::report {

/// A PNG on white, by gnuplot: both axes logarithmic, series without points of their own as lines. Throws MachineError
/// as `run_gnuplot`.
std::string front_png(const Panel& panel, const std::string& title);

}  // namespace odeval::report
