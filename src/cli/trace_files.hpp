#pragma once
// Traces in files that somebody else may have written, and the reference at their times.
#include <string>

#include "catalogue/evaluation.hpp"
#include "cli/settings.hpp"

namespace odeval::cli {

/// Distance of the rows of a column t, which must be even and begin at 0. Throws UserError, which begins with `name`.
double spacing(const Column& t, const std::string& name);

/// The scenario with its reference at so many rows, `dt` apart, which a trace named `name` has. Throws UserError for a
/// setting that the trace gives.
catalogue::Evaluator evaluator_at(const std::string& scenario, const Settings& settings, double dt, std::size_t rows,
                                  const std::string& name);

}  // namespace odeval::cli
