// Sheets of pictures, the reference as an outline over them, and what is written below.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "odeval/error.hpp"
#include "tests/render/links_in_pictures.hpp"
#include "tests/scenarios.hpp"

using namespace odeval;
using namespace odeval::render;
using odeval::test::check_links;
using odeval::test::corner;
using odeval::test::pixels_of_link;
using odeval::test::shot_of;

namespace {

bool apart(const Tile& a, const Tile& b) {
  return a.x + a.width <= b.x || b.x + b.width <= a.x || a.y + a.height <= b.y || b.y + b.height <= a.y;
}

void sheets() {
  for (const auto& [shots, width, height] : {std::tuple{1U, 800, 600},
                                             {5U, 800, 600},
                                             {5U, 1920, 300},
                                             {24U, 400, 300},
                                             {2U, 8192, 80},
                                             {2U, 80, 8192},
                                             {3U, 60, 17}}) {
    const std::vector<Panel> panels = sheet_panels(shots, width, height);
    CHECK_EQUAL(panels.size(), shots);
    std::vector<Tile> tiles;
    for (const Panel& panel : panels) {
      tiles.push_back(panel.scene);
      tiles.push_back(panel.label);
    }
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      const Tile& t = tiles[i];
      CHECK(t.x >= 0 && t.y >= 0 && t.width > 0 && t.x + t.width <= width && t.y + t.height <= height);
      for (std::size_t j = 0; j < i; ++j) CHECK(apart(tiles[j], t));
    }
  }
  CHECK(sheet_panels(5, 1920, 300).back().scene.y == sheet_panels(5, 1920, 300).front().scene.y);  // one row
  for (int side = 1; side <= 300; ++side) {
    for (const Panel& panel : sheet_panels(3, 8 * side, side)) {
      CHECK(panel.scene.width >= least_size && panel.scene.height >= least_size);
    }
  }
  CHECK(sheet_panels(1000, 100, 100).empty());

  catalogue::Evaluator evaluator(odeval::test::report_scenario("wall_pendulum", 1.0, 1e-3));
  const Scenario& scenario = evaluator.scenario();
  const Trace trace = evaluator.evaluate(catalogue::find_method("ode-step-double")).trace;
  Studio studio(scenario, corner, 800, 600, caption_font());
  const std::vector<std::size_t> rows{0, 250, 500, 750, 1000};
  std::vector<Shot> shots;
  for (const std::size_t row : rows) shots.push_back(shot_of(scenario, trace, row));
  const Image sheet = studio.sheet(shots, {"left", "right"});
  const Tile above = studio.above_caption();
  const std::vector<Panel> panels = sheet_panels(rows.size(), above.width, above.height);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Tile& tile = panels[k].scene;
    Image part(tile.width, tile.height);
    for (int y = 0; y < tile.height; ++y) {
      for (int x = 0; x < tile.width; ++x) part.mix(x, y, sheet.at(tile.x + x, tile.y + y), 255);
    }
    check_links(scenario, trace, rows[k], part, studio.camera(tile.width, tile.height));
    long dark = 0;  // a label is there
    for (int y = 0; y < panels[k].label.height; ++y) {
      for (int x = 0; x < tile.width; ++x) dark += sheet.at(panels[k].label.x + x, panels[k].label.y + y).r < 128;
    }
    CHECK(dark > 20);
  }
  CHECK(fit_on_sheet(rows.size(), 800, 600));
  CHECK(!fit_on_sheet(5000, 800, 600));
}

/// Along the edges of the boxes of a pose, how many of the points are magenta.
double outlined_edges(const Scenario& scenario, const Pose& pose, const Image& image, const Camera& camera) {
  long found = 0;
  long all = 0;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const Link& link = scenario.planar->links[i];
    for (const double across : {-0.5, 0.5}) {
      for (int k = 5; k <= 95; ++k) {
        const Vec3 point = pose[i].centre_m + ((k / 100.0 - 0.5) * link.length_m) * pose[i].along +
                           (across * link.width_m) * pose[i].across + (0.5 * link.depth_m) * scenario.frame().axis();
        const Pixel at = camera.project(point);
        const Colour seen = image.at(static_cast<int>(at.x), static_cast<int>(at.y));
        found += seen.r > seen.g + 60 && seen.b > seen.g + 30;
        ++all;
      }
    }
  }
  return static_cast<double>(found) / static_cast<double>(all);
}

void overlay_lies_on_the_reference() {
  catalogue::Evaluator evaluator(odeval::test::report_scenario("double_pendulum", 4.0, 1e-3));
  const Scenario& scenario = evaluator.scenario();
  const Trace truth = evaluator.evaluate(catalogue::find_method(catalogue::reference_method)).trace;
  const Trace euler = evaluator.evaluate(catalogue::find_method("lagrange-euler")).trace;
  Studio studio(scenario, corner, 800, 600, caption_font());
  const Tile above = studio.above_caption();
  const Camera camera = studio.camera(above.width, above.height);
  const auto outlined = [&](const Trace& trace, std::size_t row) {
    Shot shot = shot_of(scenario, trace, row);
    shot.outline = pose_at(scenario, evaluator.reference().trace, row);
    return studio.picture(shot, {});
  };

  // On itself: nothing changes but the lines along edges, so the links' colours shrink by a little only.
  const Pose pose = pose_at(scenario, truth, 700);
  const Image plain = studio.picture({pose, {}, ""}, {});
  const Image both = outlined(truth, 700);
  CHECK(plain != both);
  CHECK_BETWEEN(outlined_edges(scenario, pose, both, camera), 0.85, 1.0);
  CHECK_BETWEEN(outlined_edges(scenario, pose, plain, camera), 0.0, 0.0);
  const Image same_pose = studio.picture({pose, pose, ""}, {});
  CHECK(same_pose == both);

  // On a method that is off, the outline stays with the reference.
  const std::size_t row = 4000;
  CHECK_BETWEEN(std::fabs(euler.error_q[1][row]), 0.05, 100.0);
  const Image off = outlined(euler, row);
  CHECK_BETWEEN(outlined_edges(scenario, pose_at(scenario, truth, row), off, camera), 0.85, 1.0);
  check_links(scenario, euler, 0, outlined(euler, 0), camera);
}

void captions() {
  Scenario scenario = odeval::test::report_scenario("single_pendulum", 0.01, 1e-3);
  const Pose pose{{scenario.frame().hinge_m, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}}};
  for (const auto& [width, height] : {std::pair{16, 16}, {16, 300}, {300, 16}, {400, 300}}) {
    Studio studio(scenario, corner, width, height, caption_font());
    const std::string long_text(300, 'm');
    CHECK(studio.picture({pose, {}, ""}, {long_text, "t"}) == studio.picture({pose, {}, ""}, {long_text, "t"}));
    const Image image = studio.picture({pose, {}, ""}, {"", ""});
    CHECK(pixels_of_link(image, 0) > 0);
    const bool room = width > 100 && studio.above_caption().height < height;  // for text one can read
    CHECK_EQUAL(image == studio.picture({pose, {}, ""}, {"m", "t"}), !room);
  }
  // What does not fit loses the end of its left part; nothing at all, and no rule, where the right one has no room.
  Studio studio(scenario, corner, 400, 300, caption_font());
  const auto written = [&](const std::string& left, const std::string& right) {
    return studio.picture({pose, {}, ""}, {left, right});
  };
  const std::string dots(300, '.');
  CHECK(written("m" + dots, "t") == written("m" + dots + dots, "t"));
  CHECK(written("m" + dots, "t") != written("n" + dots, "t"));
  CHECK(written("m" + dots, "t") != written("m" + dots, "u"));
  CHECK(written("", "") == written("m", std::string(300, 'm')));
  CHECK(studio.shows(pose));
  CHECK(!Studio(scenario, {0, 0, 0.5}, 400, 300, caption_font()).shows(pose));
  CHECK_THROWS(Font("no/such/font.ttf"), MachineError, "fonts-dejavu-core");
}

}  // namespace

int main() {
  sheets();
  overlay_lies_on_the_reference();
  captions();
  return odeval::test::verdict();
}
