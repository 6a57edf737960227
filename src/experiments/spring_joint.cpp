// ERP and CFM as a spring and a damper: claim C6.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/order.hpp"
#include "reference/closed_form/damped_oscillator.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Missing;
using report::Panel;

constexpr std::string_view method = "ode-step-double";
constexpr double steps_s[] = {8e-3, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4};
constexpr double shown_step_s = 8e-3;  // coarse enough to be seen
constexpr double law_s = 0.5;
constexpr std::size_t gap_steps = 100;

struct Damping {
  const char* name;
  double ratio;  // to the critical
};
constexpr Damping dampings[] = {{"a tenth of critical", 0.1}, {"critical", 1}, {"three times critical", 3}};

/// The largest difference of the body from the law of its steps, of its largest displacement.
double off_the_law(const Scenario& scenario, const Trace& trace) {
  const Softness softness = scenario.ode.softness(scenario.step_s);
  const Body& body = scenario.mechanism.bodies.front();
  double largest = 0;
  double reach = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const reference::StepLaw law{body.mass_kg, softness.erp, softness.cfm, axis == 2 ? scenario.gravity : 0,
                                 scenario.step_s};
    reference::Deflection now{body.position_m[axis], body.velocity_m_s[axis]};
    reach = std::max(reach, std::fabs(now.x));
    for (const double x : trace.bodies.front().position[axis]) {
      largest = std::max(largest, std::fabs(x - now.x));
      now = law.next(now);
    }
  }
  return largest / reach;
}

/// Every kind of joint, gravity and softness; returns the worst.
double measure_law(const Scenario& file, report::Table& table, Panel& gaps) {
  double worst = 0;
  const Vec3 anchor = anchor_m(file.mechanism.joints.front().kind);
  for (const JointKind& kind : {JointKind(BallJoint{anchor}), JointKind(HingeJoint{anchor})}) {
    const bool ball = std::holds_alternative<BallJoint>(kind);
    const char* const kind_name = ball ? "ball" : "hinge";
    for (const double gravity : {0.0, file.gravity}) {
      for (const Softness softness : {Softness{0.2, 0}, Softness{0.8, 0}, Softness{0.2, 1e-5}, Softness{0.2, 1e-2},
                                      file.ode.softness(file.step_s)}) {
        Scenario scenario = file;
        scenario.duration_s = law_s;
        scenario.gravity = gravity;
        scenario.mechanism.joints.front().kind = kind;
        scenario.ode.spring.reset();
        scenario.ode.erp = softness.erp;
        scenario.ode.cfm = softness.cfm;
        const Evaluation run = Evaluator(scenario).evaluate(*available(method));
        const double off = off_the_law(scenario, run.trace);
        worst = std::max(worst, off);
        table.rows.push_back({std::string(kind_name), gravity, softness.erp, softness.cfm, run.trace.gap.back(), off});
        if (!ball || gravity != 0) continue;
        const std::size_t first = std::min<std::size_t>(run.trace.rows(), gap_steps + 1);
        Column steps(first);
        for (std::size_t k = 0; k < first; ++k) steps[k] = static_cast<double>(k);
        gaps.series.push_back(curve(fmt::format("ERP {:.3g}, CFM {:.3g}", softness.erp, softness.cfm), steps,
                                    above_zero(part(run.trace.gap, {0, first}))));
      }
    }
  }
  return worst;
}

Scenario damped(const Scenario& file, double ratio) {
  Scenario scenario = file;
  const double mass = scenario.mechanism.bodies.front().mass_kg;
  scenario.ode.spring->kd_Ns_m = ratio * 2 * std::sqrt(mass * scenario.ode.spring->kp_N_m);
  return scenario;
}

Panel motion(const Scenario& scenario, const char* name) {
  Evaluator evaluator(scenario);
  const Evaluation run = evaluator.evaluate(*available(method));
  Panel panel{.title = fmt::format("damping {}", name), .x_label = "t, s", .y_label = "height of the body, m"};
  panel.series.push_back(curve("closed form", run.trace.t, evaluator.reference().trace.bodies.front().position[2],
                               colour_of(catalogue::reference_method)));
  panel.series.push_back(curve(fmt::format("{}, h = {} s", method, scenario.step_s), run.trace.t,
                               run.trace.bodies.front().position[2], colour_of(method), true));
  return panel;
}

/// The least order of the position over all dampings.
std::optional<ObservedOrder> measure_orders(const Scenario& file, report::Table& errors, report::Table& orders,
                                            report::Figure& figure) {
  std::optional<ObservedOrder> least;
  for (const Damping& damping : dampings) {
    std::vector<ErrorPoint> positions;
    std::vector<ErrorPoint> forces;
    for (const double step_s : steps_s) {
      Scenario scenario = damped(file, damping.ratio);
      scenario.step_s = step_s;
      if (step_s == shown_step_s) figure.panels.push_back(motion(scenario, damping.name));
      Evaluator evaluator(scenario);
      const Evaluation run = evaluator.evaluate(*available(method));
      const Metrics metrics = evaluator.measure(run, scenario.duration_s);
      const Softness softness = scenario.ode.softness(step_s);
      errors.rows.push_back({std::string(damping.name), step_s, softness.erp, softness.cfm,
                             *metrics[quantity::max_error_position], *metrics[quantity::max_reaction_error],
                             *metrics[quantity::position_uncertainty]});
      positions.push_back({step_s, *metrics[quantity::max_error_position], *metrics[quantity::position_uncertainty]});
      forces.push_back({step_s, *metrics[quantity::max_reaction_error],
                        *metrics[quantity::position_uncertainty] * scenario.ode.spring->kp_N_m});
    }
    std::vector<Cell> row{std::string(damping.name)};
    for (const auto* points : {&positions, &forces}) {
      const auto order = observed_order(*points, 1e3);
      if (order) {
        row.insert(row.end(), {order->order, order->half_width});
      } else {
        row.insert(row.end(), {Missing{"too few points"}, Missing{"too few points"}});
      }
      if (points == &positions && order && (!least || order->order < least->order)) least = order;
    }
    orders.rows.push_back(std::move(row));
  }
  return least;
}

}  // namespace

Content spring_joint(Laboratory& laboratory, Findings& findings) {
  const Scenario& file = laboratory.scenario("spring_joint");
  report::Table law{.name = "spring-joint-law",
                    .columns = {"joint", "gravity, m/s²", "ERP", "CFM", "gap at the end, m",
                                "largest difference, of the displacement"}};
  report::Table errors{.name = "spring-joint",
                       .columns = {"damping", "h, s", "ERP", "CFM", "largest distance, m",
                                   "largest error of the joint's force, N", "uncertainty of the closed form, m"}};
  report::Table orders{
      .name = "spring-joint-order",
      .columns = {"damping", "of the position", "half width (position)", "of the joint's force", "half width (force)"}};
  report::Figure figure{.name = "spring-joint-figure", .columns = 2};
  Panel gaps{.title = "gap, no gravity", .x_label = "step", .y_label = "gap, m", .log_y = true};

  const double worst = measure_law(file, law, gaps);
  const std::optional<ObservedOrder> least = measure_orders(file, errors, orders, figure);
  gaps.y_range = std::pair{1e-16, 1.0};
  figure.panels.push_back(std::move(gaps));

  findings.add(
      "C6.discrete_law_error",
      measured("largest difference of a body pulled out of a joint from the law of ODE's step, ball and hinge, "
               "gravity off and on, CFM from 0 to that of the spring",
               "of the displacement", worst));
  const std::string meaning =
      "least observed order of the position against the damped oscillator, damping from a tenth to three times "
      "critical";
  findings.add("C6.oscillator_order",
               least ? known_by(report::Source::fit, measured(meaning, "", least->order, least->half_width))
                     : unavailable(meaning, "", "too few points"));

  Content content;
  content.values = {{"step", file.step_s},           {"law_duration", law_s},       {"law_steps", gap_steps},
                    {"kp", file.ode.spring->kp_N_m}, {"duration", file.duration_s}, {"shown_step", shown_step_s}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(law));
  content.exhibits.emplace_back(std::move(errors));
  content.exhibits.emplace_back(std::move(orders));
  return content;
}

}  // namespace odeval::experiments
