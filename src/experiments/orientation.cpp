// A quaternion or a rotation matrix for the orientation of a body: claim C15.
#include "reference/maximal/orientation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/spread.hpp"

namespace odeval::experiments {
namespace {

using reference::Keeps;

constexpr double step_s = 1e-3;
constexpr double until_s = 10;
constexpr int rows = 500;
constexpr int rounds = 15;
constexpr long timed_steps = 20'000;

struct Way {
  Keeps keeps;
  const char* label;
};

constexpr Way ways[] = {
    {Keeps::matrix, "rotation matrix"},
    {Keeps::matrix_orthonormal, "rotation matrix, made orthonormal"},
    {Keeps::quaternion, "quaternion"},
    {Keeps::quaternion_normalised, "quaternion, normalised"},
};

struct Cost {
  double ns = 0;  // a step, median
  double uncertainty = 0;
};

/// The ways take turns.
std::vector<Cost> costs() {
  std::vector<std::vector<double>> seconds(std::size(ways));
  volatile double kept = 0;  // so that no step is left out
  for (int round = 0; round <= rounds; ++round) {
    for (std::size_t i = 0; i < std::size(ways); ++i) {
      const double start = catalogue::cpu_seconds();
      kept = kept + reference::turn(ways[i].keeps, step_s, timed_steps);
      if (round > 0) seconds[i].push_back((catalogue::cpu_seconds() - start) / static_cast<double>(timed_steps));
    }
  }
  std::vector<Cost> all;
  for (const auto& times : seconds) all.push_back({1e9 * median(times), 1e9 * median_half_width(times)});
  return all;
}

/// The largest entry of |R^T R - 1| of any body in a run of ODE.
Column squeeze_of(const Trace& trace) {
  Column squeeze(trace.rows(), 0.0);
  for (const auto& body : trace.bodies) {
    for (std::size_t k = 0; k < trace.rows(); ++k) {
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < 3; ++b) {
          double product = a == b ? -1 : 0;
          for (std::size_t c = 0; c < 3; ++c) product += body.rotation[3 * c + a][k] * body.rotation[3 * c + b][k];
          squeeze[k] = std::max(squeeze[k], std::fabs(product));
        }
      }
    }
  }
  return squeeze;
}

}  // namespace

Content orientation(Laboratory& laboratory, Findings& findings) {
  const reference::Precession motion;
  const std::vector<Cost> cost = costs();
  report::Table table{
      .name = "orientation",
      .columns = {"orientation kept as", "not orthonormal by", "off by, rad", "ns a step", "deviation, ns"}};
  report::Panel squeeze{.x_label = "t, s", .y_label = "not orthonormal by", .log_y = true};
  report::Panel error{.x_label = "t, s", .y_label = "off by, rad", .log_y = true};
  double worst[std::size(ways)];
  for (std::size_t i = 0; i < std::size(ways); ++i) {
    const reference::Kept kept = reference::keep_orientation(ways[i].keeps, motion, step_s, until_s, rows);
    worst[i] = std::ranges::max(kept.squeeze);
    table.rows.push_back(
        {std::string(ways[i].label), worst[i], std::ranges::max(kept.error), cost[i].ns, cost[i].uncertainty});
    const int colour = variant(i);
    squeeze.series.push_back(curve(ways[i].label, kept.t, above_zero(kept.squeeze), colour));
    error.series.push_back(curve(ways[i].label, kept.t, above_zero(kept.error), colour));
  }
  const catalogue::Evaluation& ode = *laboratory.run("double_pendulum", "ode-step-double");
  const Column of_ode = squeeze_of(ode.trace);
  const double worst_of_ode = std::ranges::max(of_ode);
  table.rows.push_back({std::string("ODE: links of the double pendulum, dWorldStep"), worst_of_ode,
                        report::Missing{"the links' own motion, which is not this one"},
                        report::Missing{"not timed by itself"}, report::Missing{"not timed by itself"}});
  squeeze.series.push_back(
      curve("links of ode-step-double", ode.trace.t, above_zero(of_ode), colour_of("ode-step-double"), true));

  const std::string of = fmt::format("in {} s at h = {} s", until_s, step_s);
  findings.add("C15.matrix_drift", measured("how far a rotation matrix gets from orthonormal " + of, "", worst[0]));
  findings.add("C15.quaternion_drift", measured("the same for a normalised quaternion, and for the links in ODE", "",
                                                std::max(worst[3], worst_of_ode)));
  findings.add("C15.cost_ratio",
               known_by(report::Source::timing,
                        measured_ratio("time of a normalised quaternion's step over that of a matrix made orthonormal",
                                       cost[3].ns, cost[1].ns, cost[3].uncertainty, cost[1].uncertainty)));

  Content content;
  content.values = {{"until", until_s}, {"step", step_s}};
  content.exhibits.emplace_back(
      report::Figure{.name = "orientation-figure", .panels = {std::move(squeeze), std::move(error)}, .columns = 2});
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
