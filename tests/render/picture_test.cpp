// Pictures show links where mathematics says, the right way round, the same every time.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <tuple>

#include "catalogue/paths.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "render/png.hpp"
#include "render/studio.hpp"
#include "tests/check.hpp"
#include "tests/render/links_in_pictures.hpp"
#include "tests/scenarios.hpp"

using namespace odeval;
using namespace odeval::render;
using odeval::test::check_links;
using odeval::test::corner;
using odeval::test::front;
using odeval::test::has_link_colour;
using odeval::test::on_face;
using odeval::test::pixels_of_link;
using odeval::test::Segment;
using odeval::test::segments;
using odeval::test::shot_of;

namespace {

void links_where_mathematics_says() {
  for (const char* name : {"double_pendulum", "wall_pendulum", "single_pendulum"}) {
    catalogue::Evaluator evaluator(odeval::test::report_scenario(name, 1.0, 1e-3));
    const Scenario& scenario = evaluator.scenario();
    for (const char* method : {"ode-step-double", "lagrange-rk4"}) {
      const Trace trace = evaluator.evaluate(catalogue::find_method(method)).trace;
      CHECK_EQUAL(trace.bodies.empty(), method[0] == 'l');
      for (const auto& [width, height] : {std::pair{400, 300}, {801, 533}, {1500, 1100}}) {  // the last in four tiles
        for (const View& view : {corner, front}) {
          Studio studio(scenario, view, width, height, caption_font());
          const Tile above = studio.above_caption();
          const Camera camera = studio.camera(above.width, above.height);
          for (const std::size_t row : {0U, 150U, 400U, 1000U}) {
            if (width > 1024 && row != 400) continue;
            const Image image = studio.picture(shot_of(scenario, trace, row), {"left", "right"});
            CHECK_EQUAL(image.width(), width);
            CHECK_EQUAL(image.height(), height);
            check_links(scenario, trace, row, image, camera);
          }
        }
      }
    }
  }
}

/// A falling box that turns and a ball, seen from the front, where x lies to the right and z up: the box's long axis
/// runs where its turn says, the ball is round, and in free flight the camera goes with them.
void bodies_where_mathematics_says() {
  Scenario scenario = odeval::test::report_scenario("free_box", 1.0, 1e-3);
  constexpr double rate = 0.8;  // rad/s about +y: what points up turns to the right
  scenario.mechanism.bodies = {
      {.shape = Box{{0.2, 0.3, 1.0}}, .mass_kg = 1, .attitude = Vec3{0, 0.4, 0}, .spin_rad_s = {0, rate, 0}},
      {.shape = Sphere{0.4}, .mass_kg = 1, .position_m = {1, 0, 0.2}, .spin_rad_s = {0, 0, 1}}};
  catalogue::Evaluator evaluator(scenario);
  const Trace trace = evaluator.evaluate(catalogue::find_method("ode-step-double")).trace;
  const std::vector<Pose> shown{pose_at(scenario, trace, 0), pose_at(scenario, trace, 1000)};
  Studio studio(scenario, front, 800, 600, caption_font(), shown);
  const Tile above = studio.above_caption();
  const Camera camera = studio.camera(above.width, above.height);
  for (const std::size_t row : {0U, 500U, 1000U}) {
    const Image image = studio.picture(shot_of(scenario, trace, row), {"left", "right"});
    const double turn = 0.4 + rate * trace.t[row];
    const Vec3 middle{-0.5, 0, -0.1};  // of the box, beside the middle of both
    const Vec3 along{std::sin(turn), 0, std::cos(turn)};
    const Vec3 across{std::cos(turn), 0, -std::sin(turn)};
    const auto at = [&](double up, double aside) { return camera.project(middle + up * along + aside * across); };
    for (const double up : {-0.46, -0.2, 0.0, 0.2, 0.46}) {
      CHECK(has_link_colour(image, at(up, 0.07), 0));
      CHECK(!has_link_colour(image, at(up, 0.2), 0));
      CHECK(!has_link_colour(image, at(up, -0.2), 0));
    }
    CHECK(!has_link_colour(image, at(0.62, 0), 0));
    CHECK(!has_link_colour(image, at(-0.62, 0), 0));
    for (int k = 0; k < 12; ++k) {
      const double angle = (k + 0.5) * std::numbers::pi / 6;
      const Vec3 outward{std::cos(angle), 0, std::sin(angle)};
      CHECK(has_link_colour(image, camera.project(Vec3{0.5, 0, 0.1} + 0.17 * outward), 1));
      CHECK(!has_link_colour(image, camera.project(Vec3{0.5, 0, 0.1} + 0.24 * outward), 1));
    }
    CHECK(studio.shows(pose_at(scenario, trace, row)));
  }
}

/// On a joint to the world the camera stays: a body that sinks is seen to sink.
void held_bodies_move_in_the_picture() {
  Scenario scenario = odeval::test::report_scenario("free_box", 0.3, 1e-3);
  scenario.gravity = 9.81;
  scenario.mechanism.joints = {Joint{.kind = BallJoint{}, .second = {}}};
  scenario.ode.spring = Spring{100, 2};
  scenario.mechanism.bodies = {{.shape = Box{{0.1, 0.1, 0.1}}, .mass_kg = 1}};
  catalogue::Evaluator evaluator(scenario);
  const Trace trace = evaluator.evaluate(catalogue::find_method("ode-step-double")).trace;
  const std::vector<Pose> shown{pose_at(scenario, trace, 0), pose_at(scenario, trace, 300)};
  CHECK(shown[1][0].centre_m[2] < -0.15);
  Studio studio(scenario, front, 800, 600, caption_font(), shown);
  const Tile above = studio.above_caption();
  const Camera camera = studio.camera(above.width, above.height);
  for (const std::size_t row : {0U, 300U}) {
    const Image image = studio.picture(shot_of(scenario, trace, row), {"left", "right"});
    for (const Pose& pose : shown) {
      const bool here = pose[0].centre_m == pose_at(scenario, trace, row)[0].centre_m;
      // Beside the pin, which the camera looks along.
      CHECK_EQUAL(has_link_colour(image, camera.project(pose[0].centre_m + Vec3{0.04, 0, 0.04}), 0), here);
    }
  }
}

/// The camera against facts of the world that are not its own: who looks from the axis' tip sees `horizontal` to the
/// right and z upwards. The report's double pendulum turns about x, so y points right; the wall's about y, seen from
/// -y.
void right_handed() {
  for (const auto& [frame, right, towards] :
       {std::tuple{hanging_frame, Vec3{0, 1, 0}, Vec3{1, 0, 0}}, {lying_frame, Vec3{1, 0, 0}, Vec3{0, -1, 0}}}) {
    const std::array points{frame.hinge_m + right, frame.hinge_m - right, frame.hinge_m + Vec3{0, 0, 1},
                            frame.hinge_m - Vec3{0, 0, 1}};
    const Camera camera(frame, front, points, 400, 300);
    const Pixel hinge = camera.project(frame.hinge_m);
    CHECK_NEAR(hinge.x, 200, 1e-9);
    CHECK_NEAR(hinge.y, 150, 1e-9);
    CHECK(camera.project(frame.hinge_m + right).x > hinge.x + 50);
    CHECK(camera.project(frame.hinge_m + Vec3{0, 0, 1}).y < hinge.y - 50);
    CHECK(camera.project(frame.hinge_m + towards).depth_m < hinge.depth_m - 0.9);
    for (const Vec3& point : points) {
      const Pixel at = camera.project(point);
      CHECK(at.x > 0 && at.x < 400 && at.y > 0 && at.y < 300);
    }
    const Camera near(frame, {0, 0, 7.0}, points, 400, 300);
    CHECK_NEAR(near.project(frame.hinge_m).depth_m, 7, 1e-12);
    const Camera from_right(frame, {90, 0, {}}, points, 400, 300);
    CHECK(from_right.project(frame.hinge_m + right).depth_m < from_right.project(frame.hinge_m).depth_m);
    const Camera from_above(frame, {0, 80, {}}, points, 400, 300);
    CHECK(from_above.project(frame.hinge_m + Vec3{0, 0, 1}).depth_m < from_above.project(frame.hinge_m).depth_m);
  }

  // And in pixels: a link at 45 degrees lies to the right of its hinge and above, as many pixels as its area.
  for (const char* name : {"single_pendulum", "wall_pendulum"}) {
    Scenario scenario = odeval::test::report_scenario(name, 0.01, 1e-3);
    change_planar(scenario, [](odeval::PlanarView& view) { view.q0 = {0.785}; });
    catalogue::Evaluator evaluator(scenario);
    const Trace trace = evaluator.evaluate(catalogue::find_method("ode-step-double")).trace;
    Studio studio(scenario, front, 400, 300, caption_font());
    const Image image = studio.picture(shot_of(scenario, trace, 0), {});
    const Tile above = studio.above_caption();
    const Camera camera = studio.camera(above.width, above.height);
    const Pixel hinge = camera.project(scenario.frame().hinge_m);
    double x = 0;
    double y = 0;
    double count = 0;
    for (int row = 0; row < above.height; ++row) {
      for (int column = 0; column < above.width; ++column) {
        if (!has_link_colour(image, {column + 0.5, row + 0.5, 1}, 0)) continue;
        x += column + 0.5;
        y += row + 0.5;
        ++count;
      }
    }
    const double metre = 1 / camera.pixel_m(scenario.frame().hinge_m);
    CHECK_BETWEEN(count / (0.1 * metre * metre), 0.8, 1.15);  // 1 x 0.1 m, less edges and hinge, a little nearer
    CHECK_NEAR((x / count - hinge.x) / metre, 0.354, 0.03);   // the middle of the link
    CHECK_NEAR((y / count - hinge.y) / metre, -0.354, 0.03);
  }
}

/// Of two links in line of sight the nearer is seen.
void nearer_hides_farther() {
  Scenario scenario = odeval::test::report_scenario("double_pendulum", 0.01, 1e-3);
  const Vec3 hinge = scenario.frame().hinge_m;
  const Vec3 axis = scenario.frame().axis();
  const LinkPose middle{hinge, {0, 0, -1}, {0, 1, 0}, axis};
  Studio studio(scenario, front, 400, 300, caption_font());
  for (const double side : {-1.0, 1.0}) {
    Pose pose{middle, middle};
    pose[1].centre_m = hinge + (0.5 * side) * axis + Vec3{0, 0, 0.2};
    const Image image = studio.picture({pose, {}, ""}, {});
    const Tile above = studio.above_caption();
    const Pixel at = studio.camera(above.width, above.height).project(pose[1].centre_m + Vec3{0, 0, -0.1});
    CHECK(has_link_colour(image, at, side > 0 ? 1 : 0));
  }
}

/// A run that blew up leaves poses no picture can show.
void hopeless_poses_are_left_out() {
  Scenario scenario = odeval::test::report_scenario("double_pendulum", 0.01, 1e-3);
  Studio studio(scenario, corner, 400, 300, caption_font());
  const LinkPose good{scenario.frame().hinge_m, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}};
  for (const double far : {1e9, 1e150, HUGE_VAL, std::nan("")}) {
    Pose pose{good, good};
    pose[1].centre_m = {far, 0, 0};
    const Image image = studio.picture({pose, pose, ""}, {});
    CHECK(pixels_of_link(image, 0) > 20);
    CHECK_EQUAL(pixels_of_link(image, 1), 0L);
    for (Vec3 LinkPose::*direction : {&LinkPose::along, &LinkPose::across, &LinkPose::hinge}) {
      Pose bent{good, good};
      bent[1].centre_m = good.centre_m + Vec3{0, 0.5, 0};
      (bent[1].*direction)[1] = far;
      CHECK_EQUAL(pixels_of_link(studio.picture({bent, bent, ""}, {}), 1), 0L);
    }
  }
}

void same_bytes() {
  catalogue::Evaluator evaluator(odeval::test::report_scenario("wall_pendulum", 0.5, 1e-3));
  const Scenario& scenario = evaluator.scenario();
  const Trace trace = evaluator.evaluate(catalogue::find_method("ode-step-double")).trace;
  const PngTexts texts{{"scenario", "wall_pendulum"}};
  const auto bytes = [&](Studio& studio, std::size_t row) {
    return png(studio.picture(shot_of(scenario, trace, row), {"a", "b"}), texts);
  };
  Studio studio(scenario, corner, 400, 300, caption_font());
  const std::string first = bytes(studio, 300);
  const std::string other = bytes(studio, 0);
  CHECK(first != other);
  CHECK(bytes(studio, 300) == first);
  Studio again(scenario, corner, 400, 300, caption_font());
  CHECK(bytes(again, 300) == first);
}

/// Frames of a film, of which only what moves is painted, are whole pictures: with a wall, on a ground, in free flight,
/// in several tiles, with an outline.
void frames_are_pictures() {
  for (const char* name : {"wall_pendulum", "double_pendulum", "bouncing_ball", "free_box"}) {
    Names names{catalogue::method_names(), {}};
    for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
    catalogue::Evaluator evaluator(read_scenario(find_scenario(name, catalogue::scenario_folder()),
                                                 {{"duration", "0.5", ""}, {"step", "0.001", ""}}, names));
    const Scenario& scenario = evaluator.scenario();
    const Trace trace = evaluator.evaluate(catalogue::find_method("ode-step-double")).trace;
    const std::vector<Pose> shown{pose_at(scenario, trace, 0), pose_at(scenario, trace, 500)};
    for (const auto& [width, height] : {std::pair{400, 300}, {1300, 200}}) {
      Studio studio(scenario, corner, width, height, caption_font(), shown);
      for (const std::size_t row : {0U, 200U, 500U}) {
        Shot shot = shot_of(scenario, trace, row);
        if (row == 200) shot.outline = pose_at(scenario, trace, 100);
        CHECK(studio.frame(shot, {"a", "b"}) == studio.picture(shot, {"a", "b"}));
      }
    }
  }
}

/// The poses that are shown fill the picture, from margin to margin, across or upright; and the bar in the corner is as
/// long as its label says where the camera looks.
void poses_fill_the_picture() {
  catalogue::Evaluator evaluator(odeval::test::report_scenario("double_pendulum", 1.0, 1e-3));
  const Scenario& scenario = evaluator.scenario();
  const Trace trace = evaluator.evaluate(catalogue::find_method("ode-step-double")).trace;
  const std::vector<Pose> shown{pose_at(scenario, trace, 0), pose_at(scenario, trace, 700)};
  Studio studio(scenario, front, 800, 600, caption_font(), shown);
  const Tile above = studio.above_caption();
  const Camera camera = studio.camera(above.width, above.height);
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  for (const std::size_t row : {0U, 700U}) {
    const std::vector<Segment> links = segments(scenario, trace, row);
    for (std::size_t i = 0; i < links.size(); ++i) {
      for (const double side : {-0.5, 0.5}) {
        for (const Vec3& end : {links[i].near, links[i].far}) {
          const Pixel at = camera.project(end + (side * scenario.planar->links[i].width_m) * links[i].across);
          left = std::min(left, at.x);
          right = std::max(right, at.x);
          top = std::min(top, at.y);
          bottom = std::max(bottom, at.y);
        }
      }
    }
  }
  // 94 % between the margins; a link's nearer face looks a little larger than its middle.
  const double across = (right - left) / above.width;
  const double upright = (bottom - top) / above.height;
  CHECK_BETWEEN(std::max(across, upright), 0.9, 0.95);
  CHECK_BETWEEN(std::min({left, above.width - right, top, above.height - bottom}), 0, 0.06 * above.width);
  const Vec3 hinge = scenario.frame().hinge_m;
  const double metre = (camera.project(hinge + 0.1 * scenario.frame().horizontal).x - camera.project(hinge).x) / 0.1;
  double bar = 0;  // the longest of these that is no longer than a fifth of the picture
  for (const double length : {0.05, 0.1, 0.2, 0.5, 1.0}) bar = length * metre <= above.width / 5.0 ? length : bar;
  const Image image = studio.picture({{}, {}, ""}, {"", ""});
  int longest = 0;  // dark row in the lower left corner
  for (int y = above.height - 60; y < above.height; ++y) {
    int run = 0;
    for (int x = 0; x < above.width / 2; ++x) {
      run = image.at(x, y).r < 60 ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  CHECK_NEAR(longest, bar * metre, 2);
}

/// Links that differ in every size, so that none stands in for another.
void unequal_links() {
  Scenario scenario = odeval::test::report_scenario("double_pendulum", 0.3, 1e-3);
  change_planar(scenario, [](odeval::PlanarView& view) { view.links = {{1, 1, 0.1, 0.2}, {1, 0.6, 0.14, 0.05}}; });
  catalogue::Evaluator evaluator(scenario);
  Studio studio(scenario, front, 800, 600, caption_font());
  const Tile above = studio.above_caption();
  const Camera camera = studio.camera(above.width, above.height);
  for (const char* method : {"ode-step-double", "lagrange-rk4"}) {
    const Trace trace = evaluator.evaluate(catalogue::find_method(method)).trace;
    for (const std::size_t row : {0U, 300U}) {
      const std::vector<Segment> all = segments(scenario, trace, row);
      const Pose pose = pose_at(scenario, trace, row);
      const Image image = studio.picture({pose, {}, ""}, {});
      for (std::size_t i = 0; i < all.size(); ++i) {
        const Vec3 off = pose[i].centre_m - 0.5 * (all[i].near + all[i].far);
        CHECK_NEAR(length(off), 0, 1e-4);
        const auto seen = [&](double s, double w) {
          return has_link_colour(image, camera.project(on_face(scenario, all[i], i, s, w)), i);
        };
        for (const double side : {-1.0, 1.0}) {
          CHECK(seen(0.5, 0.36 * side));
          CHECK(!seen(0.5, 0.64 * side));
        }
        if (i + 1 == all.size()) CHECK(seen(0.96, 0));
        CHECK(!seen(1.05, i + 1 == all.size() ? 0.0 : 0.4));
      }
    }
  }
}

/// Edges at an angle are smooth, and no edge of a link crosses the cap of a hinge.
void smooth_edges_whole_hinges() {
  Scenario scenario = odeval::test::report_scenario("double_pendulum", 0.01, 1e-3);
  catalogue::Evaluator evaluator(scenario);
  const Trace trace = evaluator.evaluate(catalogue::find_method("lagrange-rk4")).trace;
  Studio studio(scenario, front, 1600, 1200, caption_font());
  const Image image = studio.picture(shot_of(scenario, trace, 0), {});
  const Tile above = studio.above_caption();
  const Camera camera = studio.camera(above.width, above.height);
  const Segment first = segments(scenario, trace, 0)[0];  // at 45 degrees
  long between = 0;                                       // the dark edge and the white behind it
  for (double s = 0.1; s < 0.9; s += 0.002) {
    const Pixel at = camera.project(on_face(scenario, first, 0, s, 0.5));
    for (int x = -4; x <= 4; ++x) {
      const Colour seen = image.at(static_cast<int>(at.x) + x, static_cast<int>(at.y));
      between += seen.r > 80 && seen.r < 225;
    }
  }
  CHECK(between > 50);
  const Vec3 cap = first.far + 0.08 * scenario.frame().axis();
  for (const Vec3& aside :
       {Vec3{0, 0, 0}, Vec3{0, 0.015, 0}, Vec3{0, -0.015, 0}, Vec3{0, 0, 0.015}, Vec3{0, 0, -0.015}}) {
    const Pixel at = camera.project(cap + aside);
    const Colour seen = image.at(static_cast<int>(at.x), static_cast<int>(at.y));
    CHECK_BETWEEN(seen.r, 70.0, 120.0);
    CHECK_BETWEEN(seen.b, seen.r - 10.0, seen.r + 15.0);
  }
}

/// The wall ends at its face; the links' shadows fall on it and on the ground.
void shadows_and_wall() {
  Scenario scenario = odeval::test::report_scenario("wall_pendulum", 0.01, 1e-3);
  catalogue::Evaluator evaluator(scenario);
  const Trace trace = evaluator.evaluate(catalogue::find_method("ode-step-double")).trace;
  const PlanarFrame& frame = scenario.frame();
  {
    Studio studio(scenario, front, 800, 600, caption_font());
    const Image image = studio.picture({{}, {}, ""}, {});
    const Tile above = studio.above_caption();
    const Camera camera = studio.camera(above.width, above.height);
    const double to_face = scenario.planar->wall->face_m - dot(frame.hinge_m, frame.horizontal);
    const auto red = [&](double beyond) {
      // At the depth of the wall's front, which is 0.42 reaches from the plane of swing.
      const Pixel at = camera.project(frame.hinge_m + (to_face + beyond) * frame.horizontal + 0.42 * frame.axis());
      return static_cast<int>(image.at(static_cast<int>(at.x), static_cast<int>(at.y)).r);
    };
    CHECK(red(-0.04) < 235);
    CHECK(std::min({red(-0.004), red(0), red(0.004)}) < 160);  // the edge
    CHECK(red(0.08) > 245);                                    // 0.04 would still be the face, from the side
  }
  Studio studio(scenario, corner, 800, 600, caption_font());
  const Image empty = studio.picture({{}, {}, ""}, {});
  const Image full = studio.picture(shot_of(scenario, trace, 0), {});
  long on_wall = 0;
  long on_floor = 0;
  for (int y = 0; y < empty.height(); ++y) {
    for (int x = 0; x < empty.width(); ++x) {
      const Colour a = empty.at(x, y);
      const Colour b = full.at(x, y);
      const int step = a.r - b.r;  // a shadow takes as much off each part
      if (step <= 8 || std::abs(a.g - b.g - step) >= 4 || std::abs(a.b - b.b - step) >= 4) continue;
      ++(a.r > a.b + 8 ? on_wall : on_floor);  // the wall is yellowish
    }
  }
  CHECK_BETWEEN(static_cast<double>(on_wall), 1500, 4000);
  CHECK_BETWEEN(static_cast<double>(on_floor), 2500, 6000);
}

}  // namespace

// With "skip-without-context" a machine whose driver gives no context skips the test instead of failing it.
int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "skip-without-context") {
    try {
      odeval::render::open_painter(16, 16);
    } catch (const odeval::MachineError& error) {
      std::printf("skipped: %s\n", error.what());
      return 77;
    }
  }
  right_handed();
  bodies_where_mathematics_says();
  held_bodies_move_in_the_picture();
  links_where_mathematics_says();
  nearer_hides_farther();
  hopeless_poses_are_left_out();
  same_bytes();
  frames_are_pictures();
  poses_fill_the_picture();
  unequal_links();
  smooth_edges_whole_hinges();
  shadows_and_wall();
  return odeval::test::verdict();
}
