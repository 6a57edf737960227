#pragma once
// Observed order of convergence, with what the points leave open about it.
#include <optional>
#include <span>
#include <vector>

namespace odeval {

/// One run: what was varied (step, tolerance, evaluations) and the error it led to.
struct ErrorPoint {
  double setting;          // > 0
  double error;            // of any unit
  double uncertainty = 0;  // how far the error itself may be off: the reference's uncertainty and rounding
};

struct ObservedOrder {
  double order;       // slope of log error over log setting
  double half_width;  // 95 %
  double from;        // least and largest setting of the points that count
  double to;
  int points;
};

/// Points count when their error is at least this many times their uncertainty.
inline constexpr double clear_of_uncertainty = 10;

/// Least-squares slope of log error over log setting.
///
/// Which points count is decided by each point alone, before any slope is known: those whose error is finite, at most
/// `lost` (above it a run is lost and its error says nothing), and `clear_of_uncertainty` times its uncertainty or
/// more.
///
/// half_width  Student's t at 95 % times the slope's standard error, which takes in noise and curvature (a next term of
///             the error) alike; and what the slope would move by if every point were off by its uncertainty, the worst
///             way
/// Empty when fewer than 3 points count or all have one setting.
std::optional<ObservedOrder> observed_order(std::span<const ErrorPoint> points, double lost);

/// Local slopes differ from each other by no more than this where the error has settled to a power of the setting.
inline constexpr double settled_slopes = 0.05;

/// The points of the asymptotic range, from coarse to fine: those that count (as above), from the largest setting on
/// from which the local slope, of a point and the next finer one, stays within `settled_slopes` of all finer ones. The
/// next term of an error shows as a slope that still changes, so what is left of it is smaller than that.
/// Empty when fewer than 3 points are left: then nothing says that the slopes have settled.
std::vector<ErrorPoint> settled_points(std::span<const ErrorPoint> points, double lost);

/// Two-sided 95 % quantile of Student's t (NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.2, column 0.975).
/// Above 30 degrees of freedom that of 30, which is at most 4 % too wide.
double student_t_95(int degrees_of_freedom);

/// What rounding may have done to an angle after a number of steps that round it by half of `epsilon` each, one way or
/// the other at random: epsilon sqrt(steps), rad.
double rounding_uncertainty(double epsilon, long steps);

}  // namespace odeval
