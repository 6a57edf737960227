// The motion of the double pendulum in three methods: the report's Figures 5.9, 5.11 and 5.12.
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using report::Figure;
using report::Panel;
using report::Series;
using report::Shade;

struct Wanted {
  const char* method;
  const char* name;
  const char* of_2010;
};
// The 2010 report's caption of Figure 5.9, and its program.
constexpr double caption_step_s = 1e-4;
constexpr double program_step_s = 1e-3;
constexpr Wanted wanted[] = {
    {"ode-step-double", "fig-5-9", "Figure 5.9"},
    {"lagrange-euler", "fig-5-11", "Figure 5.11"},
    {"lagrange-ode45", "fig-5-12", "Figure 5.12"},
};

/// A curve in a plane, drawn on with dashes from where time does not tell any more.
void add_path(Panel& panel, const std::string& label, const Column& t, const Column& x, const Column& y, int colour,
              const std::optional<Shade>& shade) {
  const double until = shade ? shade->from : t.back();
  const Span sound = rows_between(t, 0, until);
  panel.series.push_back(curve(label, part(x, sound), part(y, sound), colour));
  if (!shade) return;
  const Span lost = rows_between(t, until, t.back());
  panel.series.push_back(curve(label + ", lost", part(x, lost), part(y, lost), colour, true));
}

struct Path {
  Column across;  // m, from the first hinge
  Column up;      // m
};

/// Centre of mass of each link in the plane of motion: from the bodies themselves, or from angles and lengths.
std::vector<Path> centres(const Scenario& scenario, const Trace& trace) {
  const PlanarFrame& frame = scenario.planar->frame;
  std::vector<Path> paths(scenario.planar->links.size(), {Column(trace.rows()), Column(trace.rows())});
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    double angle = 0;
    double across = 0;
    double up = 0;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      if (!trace.bodies.empty()) {
        Vec3 from_hinge;
        for (std::size_t d = 0; d < 3; ++d) from_hinge[d] = trace.bodies[i].position[d][k] - frame.hinge_m[d];
        paths[i].across[k] = dot(from_hinge, frame.horizontal);
        paths[i].up[k] = dot(from_hinge, frame.up);
        continue;
      }
      const Link& link = scenario.planar->links[i];
      angle += trace.q[i][k];
      paths[i].across[k] = across + link.centre_m() * std::cos(angle);
      paths[i].up[k] = up + link.centre_m() * std::sin(angle);
      across += link.length_m * std::cos(angle);
      up += link.length_m * std::sin(angle);
    }
  }
  return paths;
}

Panel over_time(const char* what, std::vector<Series> series, const std::optional<Shade>& shade) {
  return {.x_label = "t, s", .y_label = what, .series = std::move(series), .shade = shade};
}

std::vector<Series> per_joint(const Trace& trace, const std::vector<Column>& columns, const char* letter) {
  std::vector<Series> series;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    series.push_back(curve(letter + std::to_string(i + 1), trace.t, columns[i], variant(i)));
  }
  return series;
}

Figure figure(const Wanted& which, catalogue::Evaluator& evaluator, const Evaluation& run) {
  const Trace& trace = run.trace;
  const Scenario& scenario = evaluator.scenario();
  const std::optional<Shade> shade = lost_shade(evaluator, run);

  Figure figure{.name = which.name, .columns = 2};
  figure.panels.push_back(over_time("angle, rad", per_joint(trace, trace.q, "q"), shade));
  figure.panels.push_back(over_time("rate, rad/s", per_joint(trace, trace.qd, "rate of q"), shade));

  const std::vector<Path> paths = centres(scenario, trace);
  Panel way{.title = "centres of mass",
            .x_label = "across, m from the hinge",
            .y_label = "up, m from the hinge",
            .equal_axes = true};
  for (std::size_t i = 0; i < trace.q.size(); ++i) {
    const int colour = variant(i);
    const std::string number = std::to_string(i + 1);
    Panel phase{.title = "phase plane of q" + number,
                .x_label = "q" + number + ", rad",
                .y_label = "rate of q" + number + ", rad/s"};
    add_path(phase, "q" + number, trace.t, trace.q[i], trace.qd[i], colour, shade);
    figure.panels.push_back(std::move(phase));
    add_path(way, "link " + number, trace.t, paths[i].across, paths[i].up, colour, shade);
  }
  figure.panels.push_back(std::move(way));
  figure.panels.push_back(
      over_time("energy, J",
                {curve("kinetic", trace.t, trace.kinetic), curve("potential", trace.t, trace.potential),
                 curve("total", trace.t, total_energy(trace))},
                shade));
  Panel conditioning = over_time("condition; manipulability", {}, shade);
  conditioning.log_y = true;
  if (!trace.condition.empty()) {
    conditioning.series.push_back(curve("condition number", trace.t, above_zero(trace.condition)));
  }
  if (!trace.manipulability.empty()) {
    conditioning.series.push_back(curve("manipulability", trace.t, above_zero(trace.manipulability)));
  }
  if (!conditioning.series.empty()) figure.panels.push_back(std::move(conditioning));
  return figure;
}

/// What the template says of a figure.
report::Values words_of(const Wanted& which, catalogue::Evaluator& evaluator, const Evaluation& run) {
  const auto shade = lost_shade(evaluator, run);
  const Metrics metrics = evaluator.measure(run, evaluator.scenario().duration_s);
  return {{"name", which.name},
          {"of_2010", which.of_2010},
          {"method", which.method},
          {"trusted_until", shade ? shown(shade->from) : ""},
          {"drift", shown(*metrics[quantity::max_energy_drift])}};
}

}  // namespace

Content double_pendulum(Laboratory& laboratory, Findings&) {
  catalogue::Evaluator& evaluator = laboratory.evaluator("double_pendulum");
  Content content;
  std::vector<report::Values> figures;
  for (const Wanted& which : wanted) {
    const Evaluation& run = *laboratory.run("double_pendulum", which.method);
    figures.push_back(words_of(which, evaluator, run));
    content.exhibits.emplace_back(figure(which, evaluator, run));
  }
  content.values = {{"step", evaluator.scenario().step_s},
                    {"caption_step", caption_step_s},
                    {"program_step", program_step_s},
                    {"lost", divergence_rad},
                    {"figures", figures}};
  return content;
}

}  // namespace odeval::experiments
