// Two points on rods against a wall (Potra et al. 2006): where the impacts are, and what the engine makes of them.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "model/generate.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Missing;

constexpr const char* name = "potra_pendulum";
constexpr const char* compared[] = {"ode-step-double", "ode-quickstep-double", "ode-rk4-double"};
constexpr double thinnest_m = 1e-4;
constexpr double worst_followed_steps = 10;  // an impact farther off is of another motion

/// The times at which balls as small as a scenario may have would touch: how near the spheres are to points.
double off_points(const Scenario& file, const Reference& spheres) {
  Scenario points = file;
  change_planar(points, [](PlanarView& view) {
    view.wall->face_m += (view.links[0].width_m - thinnest_m) / 2;
    for (Link& link : view.links) link.width_m = link.depth_m = thinnest_m;
  });
  Evaluator evaluator(points);
  const Reference& reference = evaluator.reference();
  if (reference.impacts.size() != spheres.impacts.size()) return NAN;
  double largest = 0;
  for (std::size_t i = 0; i < spheres.impacts.size(); ++i) {
    largest = std::fmax(largest, std::fabs(reference.impacts[i].t - spheres.impacts[i].t));
  }
  return largest;
}

}  // namespace

Content potra(Laboratory& laboratory, Findings& findings) {
  Evaluator& evaluator = laboratory.evaluator(name);
  const Reference& reference = evaluator.reference();
  report::Table table{.name = "potra-impacts",
                      .columns = {"impact", "ball", "t of the reference, s", "± s", "dWorldStep later by, s",
                                  "QuickStep later by, s", "fourth-order step later by, s"}};
  std::array<double, std::size(compared)> worst{};
  for (std::size_t i = 0; i < reference.impacts.size(); ++i) {
    const Impact& impact = reference.impacts[i];
    std::vector<Cell> row{static_cast<double>(i + 1), static_cast<double>(impact.link.value_or(0)), impact.t,
                          reference.impact_uncertainty_s[i]};
    for (std::size_t m = 0; m < std::size(compared); ++m) {
      const std::vector<Impact>& impacts = laboratory.run(name, compared[m])->outcome.impacts;
      if (i < impacts.size() && impacts[i].link == impact.link) {
        row.emplace_back(impacts[i].t - impact.t);
        const double late = std::fabs(impacts[i].t - impact.t);
        if (!(late <= worst[m]) && !std::isnan(worst[m]))
          worst[m] = late;  // fmax would forget an impact that is missing
      } else {
        row.emplace_back(Missing{"another ball's, or none"});
        worst[m] = NAN;
      }
    }
    table.rows.push_back(std::move(row));
  }
  const double step_s = evaluator.scenario().step_s;
  findings.add(
      "potra.late_steps",
      measured("largest distance of an impact of dWorldStep from the reference's, in steps", "", worst[0] / step_s));
  findings.add("potra.impacts",
               measured("impacts of the reference", "", static_cast<double>(reference.impacts.size())));
  findings.add("potra.until", measured("end of the motion", "s", evaluator.scenario().duration_s));
  findings.add("potra.step", measured("step of the motion", "ms", 1e3 * step_s));
  findings.add("potra.late_fourth_order",
               measured("the same of ode-rk4-double", "s", worst[2], reference.impact_uncertainty_s.back()));
  const double spheres = off_points(evaluator.scenario(), reference);
  findings.add("potra.spheres_off_points",
               measured(fmt::format("largest change of an impact's time when spheres of {} m stand for the points "
                                    "instead of spheres of {} m",
                                    evaluator.scenario().planar->links[0].width_m, thinnest_m),
                        "s", spheres));

  report::Panel errors{.x_label = "t, s", .y_label = "error, rad", .log_y = true};
  report::Panel distance{.x_label = "t, s", .y_label = "distance of the points from x = 0, m"};
  for (const char* method : compared) {
    const Evaluation& run = *laboratory.run(name, method);
    errors.series.push_back(curve(method, run.trace.t, above_zero(largest_error(run.trace)), colour_of(method)));
  }
  errors.series.push_back(uncertainty_curve(reference.trace.t, reference.uncertainty_q));
  const Evaluation& shown_run = *laboratory.run(name, compared[0]);
  for (std::size_t ball = 0; ball < 2; ++ball) {
    distance.series.push_back(curve(fmt::format("point {}, {}", ball + 1, compared[0]), shown_run.trace.t,
                                    shown_run.trace.bodies[ball].position[0]));
  }
  report::Figure figure{.name = "potra-figure", .columns = 2};
  figure.panels = {std::move(errors), std::move(distance)};
  const double quickstep_late_steps = worst[1] / step_s;
  Content content;
  content.values = {{"sphere", evaluator.scenario().planar->links[0].width_m},
                    {"iterations", evaluator.scenario().ode.iterations},
                    {"late_steps", shown(worst[0] / step_s)},
                    {"quickstep_follows", quickstep_late_steps <= worst_followed_steps},
                    {"quickstep_late_steps", std::isnan(quickstep_late_steps) ? "" : shown(quickstep_late_steps)}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
