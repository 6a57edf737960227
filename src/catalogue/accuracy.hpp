#pragma once
// A method made more or less accurate: its step or its tolerance, and the cheapest of them that keeps an error.
#include <array>
#include <limits>
#include <string>
#include <string_view>

#include "catalogue/evaluation.hpp"
#include "catalogue/keeping.hpp"

namespace odeval::catalogue {

/// What a method is made more accurate by.
enum class Knob {
  step,
  rtol,  // with atol = rtol / 1000, the ratio of MATLAB's defaults
  none,
};

inline constexpr double atol_over_rtol = 1e-3;

/// Keys of a scenario file that a search chooses itself.
inline constexpr std::array<std::string_view, 5> searched_keys{"step", "duration", "rtol", "atol", "sample"};

Knob knob_of(const Method& method);
/// Sets it; where the method has none, nothing.
void set_knob(Scenario& scenario, const Method& method, double setting);
std::string_view knob_name(Knob knob);  // "h", "rtol", ""

/// The error that searches are about: of angles, or without them the largest angle between a body's attitude and the
/// true one, rad.
inline quantity::Id searched_error(const Scenario& scenario) {
  return scenario.planar ? quantity::max_error_q : quantity::max_error_turn;
}

/// One setting of the knob, and what it led to.
struct Trial {
  double setting = 0;                                      // h in s, or rtol
  double error = std::numeric_limits<double>::infinity();  // rad, largest until the end; infinite where the run failed
  double uncertainty = 0;                                  // rad, the reference's uncertainty
  long steps = 0;
  long evaluations = 0;  // of the equations of motion; 0 for an engine that does not say
  std::string suspect;   // what ODE itself said of the run; empty: nothing

  /// Of a run that is to be believed.
  bool keeps(double max_error) const { return suspect.empty() && catalogue::keeps(error, uncertainty, max_error); }
};

/// The cheapest setting found, or why there is none.
struct Search {
  bool reached = false;
  Trial trial;  // where nothing was reached: that with the least error
  std::string why_not;
};

/// A scenario until a time of choice, at settings of choice, beside one reference.
///
/// Errors are measured at rows that all settings share, 0.05 s apart or as asked, or a little less, so that they fill
/// the time:
/// steps are whole fractions of that, and adaptive methods are read off there by their own interpolation.
class Accuracy {
 public:
  /// Solves the reference, which is the same at every step: no controller looks once a step. `scenario`'s own duration,
  /// step, sampling and tolerances do not matter.
  Accuracy(const Scenario& scenario, double until_s, double widest_spacing_s = 0.05);

  double row_spacing_s() const { return spacing_s_; }
  /// The step nearest to h that fits the rows.
  double fitting_step(double h) const;

  /// Any setting will do where the method has no knob.
  Evaluator at(const Method& method, double setting) const;
  Trial try_setting(const Method& method, double setting) const;

  /// The largest step (to 2 %, and of those that fit the rows), or the loosest rtol (16 a decade, from 1e-2), that
  /// keeps error and uncertainty together within max_error. Found by doubling the steps, or a decade of rtol at a time,
  /// and then by bisection of the logarithm; a larger step that keeps the error by luck may stay unseen.
  ///
  /// Not reached: when the next doubling would take more than `most_steps`, when rtol comes to 3e-15, or when the error
  /// no longer falls.
  Search cheapest(const Method& method, double max_error, long most_steps) const;

  /// Of the reference until the end, rad: no error below it can be told.
  double uncertainty() const;

 private:
  Scenario scenario_;
  double spacing_s_;
  Reference reference_;
};

}  // namespace odeval::catalogue
