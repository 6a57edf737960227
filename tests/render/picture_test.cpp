// Pictures show links where mathematics says, the right way round, the same every time.
#include <png.h>

#include <algorithm>
#include <array>
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
#include "tests/scenarios.hpp"

using namespace odeval;
using namespace odeval::render;

namespace {

const View corner{30, 14, {}};
const View front{0, 0, {}};

/// Where a link is, from the angles of a trace: written again, so that it does not agree with pose.cpp by being it.
struct Segment {
  Vec3 near;
  Vec3 far;
  Vec3 across;
};

std::vector<Segment> segments(const Scenario& scenario, const Trace& trace, std::size_t row) {
  const PlanarFrame& frame = scenario.frame();
  std::vector<Segment> all;
  Vec3 near = frame.hinge_m;
  double angle = 0;
  for (std::size_t i = 0; i < scenario.planar->links.size(); ++i) {
    angle += trace.q[i][row];
    const double reach = scenario.planar->links[i].length_m;
    const Vec3 far = near + (reach * std::cos(angle)) * frame.horizontal + (reach * std::sin(angle)) * frame.up;
    all.push_back({near, far, -std::sin(angle) * frame.horizontal + std::cos(angle) * frame.up});
    near = far;
  }
  return all;
}

/// A point on the face of a link that looks along the axis; `s` from 0 at the near hinge to 1, `w` in widths aside.
Vec3 on_face(const Scenario& scenario, const Segment& segment, std::size_t link, double s, double w) {
  const Link& size = scenario.planar->links[link];
  return segment.near + s * (segment.far - segment.near) + (w * size.width_m) * segment.across +
         (0.48 * size.depth_m) * scenario.frame().axis();
}

/// Blue, orange: whatever the light, a link keeps the order and the distance of its colour's parts.
bool has_link_colour(const Image& image, const Pixel& at, std::size_t link) {
  const int x = static_cast<int>(at.x);
  const int y = static_cast<int>(at.y);
  if (x < 0 || y < 0 || x >= image.width() || y >= image.height()) return false;
  const Colour seen = image.at(x, y);
  return link == 0 ? seen.b > seen.r + 60 && seen.b > seen.g : seen.r > seen.g && seen.g > seen.b + 30;
}

long pixels_of_link(const Image& image, std::size_t link) {
  long count = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) count += has_link_colour(image, {x + 0.5, y + 0.5, 1}, link);
  }
  return count;
}

Shot shot_of(const Scenario& scenario, const Trace& trace, std::size_t row) {
  return {pose_at(scenario, trace, row), {}, "label"};
}

/// The links' axes in the picture, and what lies beside them.
void check_links(const Scenario& scenario, const Trace& trace, std::size_t row, const Image& scene,
                 const Camera& camera) {
  const std::vector<Segment> all = segments(scenario, trace, row);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto pixel = [&](double s, double w) { return camera.project(on_face(scenario, all[i], i, s, w)); };
    for (const double s : {0.15, 0.3, 0.5, 0.7, 0.85}) CHECK(has_link_colour(scene, pixel(s, 0), i));
    // The end points: 3 % before the far end is link unless a hinge lies there, 8 % behind it is none.
    if (i + 1 == all.size()) {
      CHECK(has_link_colour(scene, pixel(0.97, 0), i));
      CHECK(!has_link_colour(scene, pixel(1.08, 0), i));
    }
    for (const double w : {-1.8, 1.8}) CHECK(!has_link_colour(scene, pixel(0.5, w), i));
  }
}

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

/// Chunks of a PNG file, in order.
std::vector<std::pair<std::string, std::string>> chunks(const std::string& file) {
  std::vector<std::pair<std::string, std::string>> all;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    std::size_t length = 0;
    for (std::size_t k = 0; k < 4; ++k) length = length << 8 | static_cast<unsigned char>(file[at + k]);
    all.emplace_back(file.substr(at + 4, 4), file.substr(at + 8, length));
    at += 12 + length;
  }
  return all;
}

std::vector<std::uint8_t> decoded(const std::string& file, int width, int height) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  CHECK(png_image_begin_read_from_memory(&header, file.data(), file.size()) != 0);
  CHECK_EQUAL(static_cast<int>(header.width), width);
  CHECK_EQUAL(static_cast<int>(header.height), height);
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(header));
  CHECK(png_image_finish_read(&header, nullptr, bytes.data(), 0, nullptr) != 0);
  return bytes;
}

void files_hold_picture_and_texts() {
  Image image(31, 17);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 31; ++x)
      image.mix(x, y, {static_cast<std::uint8_t>(8 * x), static_cast<std::uint8_t>(y), 7}, 255);
  }
  const std::string file = png(image, {{"scenario", "chain"}, {"method", "a-b"}, {"t", "0.500"}, {"note", "\u00e9"}});
  const std::vector<std::uint8_t> bytes = decoded(file, 31, 17);
  CHECK(std::equal(bytes.begin(), bytes.end(), image.pixel(0, 0)));
  std::vector<std::string> texts;
  for (const auto& [name, data] : chunks(file)) {
    if (name == "tEXt") texts.push_back(data);
    CHECK(name != "tIME");  // same bytes whatever the clock says
  }
  using namespace std::string_literals;
  CHECK(texts == std::vector({"scenario\0chain"s, "method\0a-b"s, "t\0000.500"s}));
  CHECK(file.find("iTXt") != std::string::npos);
}

std::uint32_t number(const std::string& data, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(data[at + k]);
  return value;
}

void film_is_a_whole_apng() {
  Film film(25, {{"t", "0..1"}});
  Image frame(40, 30);
  const Image first = frame;
  film.add(frame);
  frame.mix(10, 20, {0, 0, 0}, 255);
  frame.mix(13, 22, {0, 0, 0}, 255);
  film.add(frame);
  film.add(frame);
  const std::string file = film.finish();
  const std::vector<std::uint8_t> bytes = decoded(file, 40, 30);  // libpng checks every CRC on the way
  CHECK(std::equal(bytes.begin(), bytes.end(), first.pixel(0, 0)));

  std::string order;
  std::uint32_t sequence = 0;
  std::vector<std::array<std::uint32_t, 4>> rectangles;
  for (const auto& [name, data] : chunks(file)) {
    order += name + " ";
    if (name == "acTL") CHECK_EQUAL(number(data, 0), 3U);
    if (name == "fcTL" || name == "fdAT") CHECK_EQUAL(number(data, 0), sequence++);
    if (name != "fcTL") continue;
    rectangles.push_back({number(data, 4), number(data, 8), number(data, 12), number(data, 16)});
    CHECK_EQUAL(number(data, 20), (1U << 16) + 25U);  // 1/25 s
  }
  CHECK_EQUAL(order, std::string("IHDR tEXt acTL fcTL IDAT fcTL fdAT fcTL fdAT IEND "));
  CHECK((rectangles[0] == std::array<std::uint32_t, 4>{40, 30, 0, 0}));
  CHECK((rectangles[1] == std::array<std::uint32_t, 4>{4, 3, 10, 20}));
  CHECK((rectangles[2] == std::array<std::uint32_t, 4>{1, 1, 0, 0}));
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
  files_hold_picture_and_texts();
  film_is_a_whole_apng();
  unequal_links();
  smooth_edges_whole_hinges();
  shadows_and_wall();
  sheets();
  overlay_lies_on_the_reference();
  captions();
  return odeval::test::verdict();
}
