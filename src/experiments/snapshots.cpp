// Pictures of the motions: the two that the report shows, its Figures 5.8 and 6.2, and those of the new scenarios.
#include <fmt/format.h>

#include <cmath>

#include "experiments/all.hpp"
#include "odeval/error.hpp"
#include "output/number.hpp"
#include "render/png.hpp"
#include "render/studio.hpp"

namespace odeval::experiments {
namespace {

constexpr std::string_view shown_method = "ode-step-double";
const render::View corner{30, 14, {}};

struct Wanted {
  const char* name;
  const char* scenario;
  std::vector<double> times;  // s
  int width, height;          // pixels: four times the area that a phone shows, and no more
};

/// Short motions whole, others for as long as a look tells something.
const Wanted others[] = {
    {"picture-chain", "chain", {0, 0.2, 0.4, 0.6, 0.8, 1}, 720, 480},
    {"picture-potra", "potra_pendulum", {0, 0.3, 0.6, 0.9, 1.2, 1.5}, 720, 480},
    {"picture-iftomm", "iftomm_pendulum", {0, 1}, 720, 480},
    {"picture-free-box", "free_box", {0, 0.5, 1, 1.5, 2, 2.5}, 720, 480},
    {"picture-thin-body", "thin_body", {0, 0.5, 1, 1.5, 2, 2.5}, 720, 480},
    {"picture-bouncing-ball", "bouncing_ball", {0, 0.25, 0.45, 0.75, 1.085, 1.3}, 720, 480},
    {"picture-friction", "friction_slide", {0, 0.25, 0.5, 0.75}, 720, 480},
    {"picture-spring-joint", "spring_joint", {0, 0.1, 0.2, 0.3, 0.4, 0.5}, 720, 480},
};

/// The sample nearest to each time.
std::vector<std::size_t> rows_of(const Trace& trace, const std::vector<double>& times) {
  std::vector<std::size_t> rows;
  const double spacing = trace.t.at(1);
  for (const double t : times) {
    rows.push_back(std::min(static_cast<std::size_t>(std::lround(t / spacing)), trace.rows() - 1));
  }
  return rows;
}

std::string label(const Trace& trace, std::size_t row) { return fmt::format("t = {:.3f} s", trace.t[row]); }

report::Picture picture(const Wanted& wanted, const Scenario& scenario, const Trace& trace) {
  std::vector<render::Shot> shots;
  std::vector<render::Pose> poses;
  for (const std::size_t row : rows_of(trace, wanted.times)) {
    poses.push_back(render::pose_at(scenario, trace, row));
    shots.push_back({poses.back(), {}, label(trace, row)});
  }
  render::Studio studio(scenario, corner, wanted.width, wanted.height, render::caption_font(), poses);
  const std::string who = scenario.name + ", " + std::string(shown_method);
  const std::string step = "h = " + number_text(scenario.step_s) + " s";
  const render::Image image = shots.size() == 1
                                  ? studio.picture(shots.front(), {who, step + ", " + shots.front().label})
                                  : studio.sheet(shots, {who, step});
  return {.name = wanted.name,
          .png = render::png(image, {{"scenario", scenario.name}, {"method", std::string(shown_method)}})};
}

/// From the release to the way back after the first touch, in even steps.
std::vector<double> through_first_touch(const catalogue::Evaluation& run, int poses) {
  const double touch = run.outcome.impacts.empty() ? run.trace.t.back() / 2 : run.outcome.impacts.front().t;
  std::vector<double> times;
  for (int i = 0; i < poses; ++i) times.push_back(2 * touch * i / (poses - 1));
  return times;
}

report::Exhibit exhibit(const Wanted& wanted, Laboratory& laboratory) try {
  return picture(wanted, laboratory.scenario(wanted.scenario), laboratory.run(wanted.scenario, shown_method)->trace);
} catch (const MachineError& error) {  // no OpenGL, no font
  return report::Lacking{wanted.name, error.what()};
}

}  // namespace

Content snapshots(Laboratory& laboratory, Findings&) {
  Content content;
  content.values = {{"method", shown_method}};
  content.exhibits.push_back(exhibit({"picture-5-8", "double_pendulum", {0}, 720, 540}, laboratory));
  const auto times = through_first_touch(*laboratory.run("wall_pendulum", shown_method), 6);
  content.exhibits.push_back(exhibit({"picture-6-2", "wall_pendulum", times, 960, 640}, laboratory));
  for (const Wanted& wanted : others) content.exhibits.push_back(exhibit(wanted, laboratory));
  return content;
}

}  // namespace odeval::experiments
