// What a film costs, in work rather than in time: what stands still is painted once, each frame once, and of each frame
// only the part where something moves. The painter here counts and paints nothing.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "odeval/error.hpp"
#include "render/studio.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

struct Count {
  long paints = 0;
  double pixels = 0;
  double triangles = 0;
};
Count count;

}  // namespace

namespace odeval::render {

namespace {

class Counting final : public Painter {
 public:
  using Painter::paint;
  Image paint(std::span<const Layer> layers, const Camera& camera, const Tile& part) override {
    ++count.paints;
    count.pixels += static_cast<double>(part.width) * part.height;
    for (const Layer& layer : layers) count.triangles += static_cast<double>(layer.triangles.size()) / 3;
    return Image(camera.width(), camera.height());
  }
  std::string version() const override { return "none"; }
};

}  // namespace

// An executable's own definition goes before a library's.
std::unique_ptr<Painter> open_painter(int, int) { return std::make_unique<Counting>(); }
std::string opengl_version() { return "none"; }

}  // namespace odeval::render

namespace {

using namespace odeval;
using namespace odeval::render;

constexpr int width = 800;
constexpr int height = 600;
constexpr double whole = static_cast<double>(width) * height;
const View corner{30, 14, {}};

/// The double pendulum of that turn of its first link, hanging straight.
Pose turned(const Scenario& scenario, double angle) {
  const PlanarFrame& frame = scenario.frame();
  const Vec3 along = std::cos(angle) * frame.horizontal + std::sin(angle) * frame.up;
  const Vec3 across = cross(frame.axis(), along);
  return {{frame.hinge_m + 0.5 * along, along, across, frame.hinge_axis},
          {frame.hinge_m + 1.5 * along, along, across, frame.hinge_axis}};
}

/// Frames of a film of one second, as `odeval snapshot --film` takes them.
Count filmed(Studio& studio, const Scenario& scenario, int frames, bool outline) {
  count = {};
  for (int frame = 0; frame < frames; ++frame) {
    Shot shot{turned(scenario, -std::numbers::pi / 2 + 0.3 * std::sin(0.2 * frame)), {}, ""};
    if (outline) shot.outline = turned(scenario, -std::numbers::pi / 2);
    studio.frame(shot, {"film", ""});
  }
  return count;
}

void a_frame_is_painted_once_and_only_where_it_moves() {
  const Scenario scenario = test::report_scenario("double_pendulum", 4, 1e-3);
  for (const bool outline : {false, true}) {
    Studio studio(scenario, corner, width, height, caption_font());
    constexpr int frames = 25;
    const Count first = filmed(studio, scenario, frames, outline);
    CHECK_EQUAL(first.paints, 1L + frames);  // one of what stands still
    // Two links that swing by 0.3 rad to either side, and their shadow, about a fifth of what the camera holds.
    CHECK_BETWEEN((first.pixels / whole - 1) / frames, 0.02, 0.35);
    // It stands still for the next film as well.
    CHECK_EQUAL(filmed(studio, scenario, frames, outline).paints, static_cast<long>(frames));
    studio.restage(scenario, {});
    CHECK_EQUAL(filmed(studio, scenario, frames, outline).paints, 1L + frames);  // another camera
  }
}

/// A picture by itself is painted whole, and a sheet a scene each.
void pictures_and_sheets() {
  const Scenario scenario = test::report_scenario("double_pendulum", 4, 1e-3);
  Studio studio(scenario, corner, width, height, caption_font());
  const Shot shot{turned(scenario, 0), {}, ""};
  count = {};
  studio.picture(shot, {});
  CHECK_EQUAL(count.paints, 1L);
  count = {};
  studio.sheet(std::vector<Shot>(5, shot), {});
  CHECK_EQUAL(count.paints, 5L);
  CHECK(count.pixels < whole);
}

/// A frame has no more to paint than a picture, and twice as many of them twice as much: nothing is kept of frames
/// before.
void work_does_not_grow_with_the_film() {
  const Scenario scenario = test::report_scenario("double_pendulum", 4, 1e-3);
  Studio studio(scenario, corner, width, height, caption_font());
  filmed(studio, scenario, 1, false);
  const double ten = filmed(studio, scenario, 10, false).triangles;
  const double thirty = filmed(studio, scenario, 30, false).triangles;
  CHECK_NEAR(thirty / ten, 3, 0.3);  // shadows: a turn hides some faces from the lamp
}

}  // namespace

int main() {
  a_frame_is_painted_once_and_only_where_it_moves();
  pictures_and_sheets();
  work_does_not_grow_with_the_film();
  return test::verdict();
}
