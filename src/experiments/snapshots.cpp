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
  const char* title;
  const char* after;  // whose picture it is like
  const char* scenario;
  std::vector<double> times;  // s
  int width, height;          // pixels: four times the area that a phone shows, and no more
};

/// Short motions whole, others for as long as a look tells something.
const Wanted others[] = {
    {"picture-chain", "A chain of eight links.", "", "chain", {0, 0.2, 0.4, 0.6, 0.8, 1}, 720, 480},
    {"picture-potra",
     "Two points on rods that both hit a wall.",
     ", points drawn small as they are",
     "potra_pendulum",
     {0, 0.3, 0.6, 0.9, 1.2, 1.5},
     720,
     480},
    {"picture-iftomm", "The pendulum of the IFToMM benchmark.", "", "iftomm_pendulum", {0, 1}, 720, 480},
    {"picture-free-box",
     "A free box that tumbles.",
     ", seen by a camera that falls with it",
     "free_box",
     {0, 0.5, 1, 1.5, 2, 2.5},
     720,
     480},
    {"picture-thin-body",
     "A long thin body that spins across its length.",
     "",
     "thin_body",
     {0, 0.5, 1, 1.5, 2, 2.5},
     720,
     480},
    {"picture-bouncing-ball", "A ball that bounces.", "", "bouncing_ball", {0, 0.25, 0.45, 0.75, 1.085, 1.3}, 720, 480},
    {"picture-friction",
     "A box that slides until friction holds it.",
     "",
     "friction_slide",
     {0, 0.25, 0.5, 0.75},
     720,
     480},
    {"picture-spring-joint",
     "A cube on a joint that is a spring and a damper.",
     "",
     "spring_joint",
     {0, 0.1, 0.2, 0.3, 0.4, 0.5},
     720,
     480},
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
  return {wanted.name, wanted.title, fmt::format("Of the run with {}{}.", shown_method, wanted.after),
          render::png(image, {{"scenario", scenario.name}, {"method", std::string(shown_method)}})};
}

/// From the release to the way back after the first touch, in even steps.
std::vector<double> through_first_touch(const catalogue::Evaluation& run, int poses) {
  const double touch = run.outcome.impacts.empty() ? run.trace.t.back() / 2 : run.outcome.impacts.front().t;
  std::vector<double> times;
  for (int i = 0; i < poses; ++i) times.push_back(2 * touch * i / (poses - 1));
  return times;
}

report::Block block(Wanted wanted, Laboratory& laboratory, bool sheet) {
  const catalogue::Evaluation* const run = laboratory.run(wanted.scenario, shown_method);
  if (run == nullptr) return report::Text{fmt::format("{} is missing: {}.", wanted.title, catalogue::why_missing)};
  if (sheet) wanted.times = through_first_touch(*run, 6);
  try {
    return picture(wanted, laboratory.scenario(wanted.scenario), run->trace);
  } catch (const MachineError& error) {  // no OpenGL, no font
    return report::Text{fmt::format("{} is missing: {}.", wanted.title, error.what())};
  }
}

}  // namespace

Section snapshots(Laboratory& laboratory, Findings&) {
  Section section{"snapshots", "Pictures of the motions", {}};
  section.blocks.emplace_back(report::Text{
      "The bodies as ODE has them, drawn from the samples of its runs. The same pictures, of any scenario, method and "
      "time, are made by odeval snapshot."});
  section.blocks.push_back(block({"picture-5-8",
                                  "The double pendulum at its release.",
                                  ", as Figure 5.8 of the 2010 report shows it",
                                  "double_pendulum",
                                  {0},
                                  720,
                                  540},
                                 laboratory, false));
  section.blocks.push_back(block({"picture-6-2",
                                  "The wall pendulum from its release to its way back from the wall.",
                                  ", as Figure 6.2 of the 2010 report shows it",
                                  "wall_pendulum",
                                  {},
                                  960,
                                  640},
                                 laboratory, true));
  for (const Wanted& wanted : others) section.blocks.push_back(block(wanted, laboratory, false));
  return section;
}

}  // namespace odeval::experiments
