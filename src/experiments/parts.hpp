#pragma once
// What sections are made of: curves of traces, shades, findings of measured numbers.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/experiment.hpp"
#include "report/text.hpp"

namespace odeval::experiments {

using report::shown;

using report::guide_colour;

/// The colour of the i-th variant, where it has to be the same in several panels.
constexpr int variant(std::size_t i) { return report::first_variant + static_cast<int>(i); }

/// The errors that the reference may itself have, in every figure the same.
report::Series uncertainty_curve(const Column& t, const Column& uncertainty);

/// The colour of a method where ODE's own are told apart, beside all others in grey.
int colour_beside_ode(std::string_view method);

/// What only a line's width parts is drawn once, under the names of all.
report::Panel told_apart(report::Panel panel);

/// Curves over one axis, thinned to what a plot can show.
report::Series curve(std::string label, const Column& x, const Column& y, int colour = -1, bool dashed = false);

/// The rows with from <= t <= until.
struct Span {
  std::size_t first = 0;
  std::size_t end = 0;  // one past
};
Span rows_between(const Column& t, double from_s, double until_s);
Column part(const Column& column, const Span& span);

/// Energy - energy at t = 0, J.
Column energy_drift(const Trace& trace);
Column total_energy(const Trace& trace);

Column sizes(Column column);

/// The largest |angle error| of each sample, rad.
Column largest_error(const Trace& trace);

/// For an axis of powers of ten: a value of 0 or less becomes a gap.
Column above_zero(Column column);

/// From where on a trace tells nothing: its own error passes 0.1 rad, or the reference knows its angles no better.
/// Nothing when neither happens.
std::optional<report::Shade> lost_shade(catalogue::Evaluator& evaluator, const catalogue::Evaluation& run);

/// From when on none of several runs is left that is not lost; nothing while one is.
std::optional<report::Shade> all_lost(catalogue::Evaluator& evaluator,
                                      const std::vector<const catalogue::Evaluation*>& runs);

/// A finding that has its value only when that is finite.
report::Finding measured(std::string meaning, std::string unit, double value, double uncertainty = 0);

/// The same number, whose uncertainty is not the reference's.
report::Finding known_by(report::Source source, report::Finding finding);

/// The same number beside what it is at neighbouring settings, which no user would tell from those that gave it.
report::Finding among(report::Finding finding, const std::vector<double>& at_neighbours);

/// a / b, where each may be off by `uncertainty_a`, `uncertainty_b`; the uncertainty is that of first order.
report::Finding measured_ratio(std::string meaning, double a, double b, double uncertainty_a = 0,
                               double uncertainty_b = 0);

report::Finding unavailable(std::string meaning, std::string unit, std::string why);

/// The number, or that the run blew up.
report::Cell finite_cell(const std::optional<double>& number);

/// A row of a method that this build lacks, from the cells that are known to `columns` of them.
std::vector<report::Cell> row_left_out(std::vector<report::Cell> known, std::size_t columns);

/// For a template: which of the methods this build lacks, and why; empty when it has them all.
std::string left_out(const std::vector<std::string>& methods);

/// The largest angle error until a time, which a run that blew up has no number for.
double error_until(catalogue::Evaluator& evaluator, const catalogue::Evaluation& run, double until_s);
double uncertainty_until(catalogue::Evaluator& evaluator, const catalogue::Evaluation& run, double until_s);

/// For the note of a table of errors, how far the reference may be off: "4e-12 rad until 1 s, 3e-10 rad until 3 s".
std::string reference_known(catalogue::Evaluator& evaluator, std::initializer_list<double> until_s);

OdeSettings half_step_started(OdeSettings settings);

/// Far apart: condition numbers of long chains cost more than the chain.
inline constexpr double chain_rows_s = 0.02;
/// The scenario `chain` with n links, recorded in rows so far apart.
Scenario chain_of(const Scenario& file, std::size_t n, double until_s);

}  // namespace odeval::experiments
