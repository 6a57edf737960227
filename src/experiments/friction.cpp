// Friction as a pyramid, as a constant force and as the fourth-order step's cone, beside Coulomb's law: claim C14.
#include <cmath>
#include <numbers>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "model/generate.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Panel;
using std::numbers::pi;

constexpr double directions_deg[] = {0, 7.5, 15, 22.5, 30, 37.5, 45};
constexpr std::string_view step_double = "ode-step-double";
constexpr std::string_view quickstep_double = "ode-quickstep-double";
constexpr std::string_view fourth_order = "ode-rk4-double";

struct Case {
  std::string_view label;
  std::string_view method;
  FrictionModel model;
  FrictionAxes axes;
};
constexpr Case cases[] = {
    {"dWorldStep, pyramid", step_double, FrictionModel::pyramid, FrictionAxes::plane_space},
    {"dWorldStep, constant force", step_double, FrictionModel::constant, FrictionAxes::plane_space},
    {"QuickStep, pyramid", quickstep_double, FrictionModel::pyramid, FrictionAxes::plane_space},
    {"QuickStep, constant force", quickstep_double, FrictionModel::constant, FrictionAxes::plane_space},
    {"dWorldStep, pyramid along the slide", step_double, FrictionModel::pyramid, FrictionAxes::sliding},
    {"fourth-order step, round cone", fourth_order, FrictionModel::pyramid, FrictionAxes::plane_space},
};

struct Slide {
  double way = 0;       // m, from start to end
  double true_way = 0;  // m
  double stops_s = 0;
  double true_stops_s = 0;
  double turned_deg = 0;   // of that way, away from where it set out for
  double error = 0;        // m, largest distance from the reference
  double uncertainty = 0;  // m
};

Friction& friction_of(Scenario& scenario) { return scenario.mechanism.contacts.front().friction.value(); }
double coefficient(const Scenario& scenario) { return scenario.mechanism.contacts.front().friction.value().limit; }

Slide slide(Scenario scenario, const Case& how, double direction_deg) {
  const Body& box = scenario.mechanism.bodies.front();
  const double direction = direction_deg * pi / 180;
  const double speed = std::sqrt(dot(box.velocity_m_s, box.velocity_m_s));
  scenario.mechanism.bodies.front().velocity_m_s = {speed * std::cos(direction), speed * std::sin(direction), 0};
  Friction& friction = friction_of(scenario);
  if (how.model == FrictionModel::constant) friction.limit *= box.mass_kg * scenario.gravity;
  friction.model = how.model;
  scenario.ode.friction_axes = how.axes;
  Evaluator evaluator(scenario);
  const Evaluation run = evaluator.evaluate(*available(how.method));
  const auto way = [](const Trace& trace) {
    const auto& [x, y, z] = trace.bodies.front().position;
    return Vec3{x.back() - x.front(), y.back() - y.front(), 0};
  };
  const Vec3 gone = way(run.trace);
  const Vec3 wanted = way(evaluator.reference().trace);
  const Metrics metrics = evaluator.measure(run, scenario.duration_s);
  return {std::sqrt(dot(gone, gone)),
          std::sqrt(dot(wanted, wanted)),
          metrics[quantity::rest_time].value_or(NAN),
          evaluator.reference().at_rest_from,
          std::atan2(gone[1], gone[0]) * 180 / pi - direction_deg,
          metrics[quantity::max_error_position].value_or(NAN),
          metrics[quantity::position_uncertainty].value_or(NAN)};
}

/// How far a box slips in the scenario's time, from rest on a slope of so much of the angle of friction.
double slips(const Scenario& level, std::string_view method, double part) {
  Scenario scenario = level;
  const double slope = std::atan(coefficient(level) * part);
  set_slope(scenario, slope);
  const double half = sides_m(level.mechanism.bodies.front().shape)[2] / 2;
  Body& box = scenario.mechanism.bodies.front();
  box.position_m = {half * std::sin(slope), 0, half * std::cos(slope)};
  box.attitude = Vec3{0, slope, 0};
  box.velocity_m_s = {};
  Evaluator evaluator(scenario);
  const Evaluation run = evaluator.evaluate(*available(method));
  const auto& [x, y, z] = run.trace.bodies.front().position;
  return std::hypot(x.back() - x.front(), y.back() - y.front(), z.back() - z.front());
}

report::Table threshold(const Scenario& scenario) {
  report::Table table{
      .name = "friction-threshold",
      .columns = {"method", "way at 99 % of the angle of friction, m", "at 101 %, m", "Coulomb's at 101 %, m"}};
  const double slope = std::atan(1.01 * coefficient(scenario));
  const double net = scenario.gravity * (std::sin(slope) - coefficient(scenario) * std::cos(slope));
  for (const char* method :
       {"ode-step-double", "ode-step-single", "ode-quickstep-double", "ode-quickstep-single", "ode-rk4-double"}) {
    const auto cell = [&](double part) -> Cell {
      if (available(method) == nullptr) return report::Missing{"not in this build"};
      return slips(scenario, method, part);
    };
    table.rows.push_back(
        {std::string(method), cell(0.99), cell(1.01), net * scenario.duration_s * scenario.duration_s / 2});
  }
  return table;
}

}  // namespace

Content friction(Laboratory& laboratory, Findings& findings) {
  const Scenario& scenario = laboratory.scenario("friction_slide");
  report::Table table{.name = "friction",
                      .columns = {"friction", "direction, degrees", "way, m", "Coulomb's way, m", "way over Coulomb's",
                                  "stops at, s", "Coulomb's stop, s", "turned aside, degrees",
                                  "largest distance from Coulomb's motion, m", "reference off by, m"}};
  Panel ways{.x_label = "direction of the slide, degrees", .y_label = "way over Coulomb's"};
  Panel turns{.x_label = "direction of the slide, degrees", .y_label = "turned aside, degrees"};
  double straight = NAN;
  double diagonal = NAN;
  double told_off = 0;      // of the way, where contacts are told the way they slide
  double off_the_cone = 0;  // m
  double uncertainty = 0;   // m, of the reference there
  for (const Case& how : cases) {
    const bool told = how.axes == FrictionAxes::sliding;
    const bool own_colour = how.model == FrictionModel::pyramid && !told;
    report::Series way{
        std::string(how.label), {}, {}, report::Mark::line_and_points, own_colour ? colour_of(how.method) : -1};
    report::Series turned = way;
    for (const double direction : directions_deg) {
      const Slide slid = slide(scenario, how, direction);
      table.rows.push_back({std::string(how.label), direction, slid.way, slid.true_way, slid.way / slid.true_way,
                            slid.stops_s, slid.true_stops_s, slid.turned_deg, slid.error, slid.uncertainty});
      way.x.push_back(direction);
      way.y.push_back(slid.way / slid.true_way);
      turned.x.push_back(direction);
      turned.y.push_back(slid.turned_deg);
      if (told) told_off = std::max(told_off, std::fabs(slid.way / slid.true_way - 1));
      if (&how == &cases[0] && direction == 0) straight = slid.way;
      if (&how == &cases[0] && direction == 45) {
        diagonal = slid.way;
        findings.add("friction.stop_at_45",
                     known_by(report::Source::step,
                              measured("time to a stop at 45 degrees to the axes of the pyramid over Coulomb's", "",
                                       slid.stops_s / slid.true_stops_s, scenario.step_s / slid.true_stops_s)));
      }
      if (how.method != fourth_order) continue;
      off_the_cone = std::max(off_the_cone, slid.error);
      uncertainty = std::max(uncertainty, slid.uncertainty);
    }
    ways.series.push_back(std::move(way));
    turns.series.push_back(std::move(turned));
  }
  // Of two of ODE's own ways: no reference has a part in it.
  findings.add("C14.anisotropy",
               measured("friction of the pyramid at 45 degrees to its axes over that along one, less 1", "",
                        straight / diagonal - 1));
  findings.add("friction.told_off",
               measured("way of dWorldStep's box over Coulomb's, less 1, where each contact is told "
                        "the way it slides: the largest of all directions",
                        "", told_off));
  findings.add("friction.cone_error",
               measured("largest distance of ode-rk4-double from Coulomb's motion, over all directions", "m",
                        off_the_cone, uncertainty));

  report::Figure figure{.name = "friction-figure", .columns = 2};
  figure.panels = {told_apart(std::move(ways)), told_apart(std::move(turns))};
  Content content;
  content.values = {
      {"held_for", scenario.duration_s},
      {"diagonal", directions_deg[std::size(directions_deg) - 1]},
      {"cone_error", shown(off_the_cone)},
      {"friction", coefficient(scenario)},
      {"mass", scenario.mechanism.bodies[0].mass_kg},
      {"speed", std::sqrt(dot(scenario.mechanism.bodies[0].velocity_m_s, scenario.mechanism.bodies[0].velocity_m_s))},
      {"step", scenario.step_s}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  content.exhibits.emplace_back(threshold(scenario));
  return content;
}

}  // namespace odeval::experiments
