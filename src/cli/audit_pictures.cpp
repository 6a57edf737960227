#include "cli/audit_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>

#include "audit/scene.hpp"
#include "output/audit_answer.hpp"
#include "render/png.hpp"
#include "render/solid_stage.hpp"
#include "render/studio.hpp"

namespace odeval::cli {
namespace {

using audit::Place;
using audit::Scene;
using audit::ShapeSample;
using render::Solid;

constexpr render::View view{30, 14, {}};
constexpr int width = 960;
constexpr int height = 640;

render::LinkPose pose_of(const Place& place) {
  const auto& [w, x, y, z] = place.quaternion;
  return {place.position_m,
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)},
          {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)}};
}

/// Bodies of scenes by their place in poses, and what they look like.
class Troupe {
 public:
  Troupe(const audit::Records& records, const std::vector<Scene>& scenes) : up_(audit::up_of(records.refined.front())) {
    for (const Scene& scene : scenes) {
      for (const auto& [body, place] : scene.own) places_.try_emplace(body, 0);
    }
    std::size_t next = 0;
    for (auto& [body, place] : places_) place = next++;
    shaped_.resize(places_.size());
    for (const ShapeSample& shape : audit::shapes_of(records.refined.front())) take(shape);
    for (const Scene& scene : scenes) shown_.push_back(pose(scene.own));
    put_dots();
  }

  /// Bodies that are not there are nowhere, and not drawn.
  render::Pose pose(const std::map<std::uint32_t, Place>& bodies) const {
    render::Pose pose(places_.size(), {{NAN, NAN, NAN}, {}, {}, {}});
    for (const auto& [body, place] : places_) {
      if (const auto found = bodies.find(body); found != bodies.end()) pose[place] = pose_of(found->second);
    }
    return pose;
  }

  render::Studio studio() const {
    return {std::make_unique<render::SolidStage>(solids_, grounds_, up_, shown_), view, width, height,
            render::caption_font()};
  }

  /// What is not drawn as it is.
  std::string remarks() const {
    std::string text;
    if (bounds_ > 0)
      text += fmt::format(" {} of another kind as the box around it.", counted(bounds_, "A geom", "geoms"));
    if (dots_ > 0) text += fmt::format(" {} without a geom as a ball.", counted(dots_, "A body", "bodies"));
    return text;
  }

 private:
  static std::string counted(std::size_t count, const char* one, const char* many) {
    return count == 1 ? one : fmt::format("{} {}", count, many);
  }

  void take(const ShapeSample& shape) {
    if (shape.kind == ShapeSample::plane) {
      grounds_.push_back({{shape.size[0], shape.size[1], shape.size[2]}, shape.position[0]});
      return;
    }
    Solid solid{.kind = Solid::Kind::box, .size_m = {shape.size[0], shape.size[1], shape.size[2]}, .place = {}};
    if (shape.kind == ShapeSample::sphere) solid.kind = Solid::Kind::sphere;
    if (shape.kind == ShapeSample::capsule) solid.kind = Solid::Kind::capsule;
    if (shape.kind == ShapeSample::cylinder) solid.kind = Solid::Kind::cylinder;
    solid.place = pose_of({{shape.position[0], shape.position[1], shape.position[2]},
                           {shape.quaternion[0], shape.quaternion[1], shape.quaternion[2], shape.quaternion[3]}});
    if (shape.body != 0) {
      const auto found = places_.find(shape.body);
      if (found == places_.end()) return;
      solid.body = found->second;
      shaped_[found->second] = true;
    }
    if (shape.kind == ShapeSample::bounds) ++bounds_;
    solids_.push_back(solid);
  }

  /// A ball for each body without a geom, a fifteenth of how far bodies are apart.
  void put_dots() {
    Vec3 low{1e300, 1e300, 1e300};
    Vec3 high{-1e300, -1e300, -1e300};
    for (const render::Pose& pose : shown_) {
      for (const render::LinkPose& body : pose) {
        for (std::size_t k = 0; k < 3; ++k) {
          low[k] = std::min(low[k], body.centre_m[k]);
          high[k] = std::max(high[k], body.centre_m[k]);
        }
      }
    }
    const double radius = std::max(length(high - low) / 15, 0.02);
    for (std::size_t body = 0; body < shaped_.size(); ++body) {
      if (shaped_[body]) continue;
      solids_.push_back({.kind = Solid::Kind::sphere, .size_m = {radius, 0, 0}, .place = pose_of({}), .body = body});
      ++dots_;
    }
  }

  std::map<std::uint32_t, std::size_t> places_;  // in a pose, of bodies by their numbers
  std::vector<bool> shaped_;
  std::vector<Solid> solids_;
  std::vector<render::Ground> grounds_;
  std::vector<render::Pose> shown_;
  Vec3 up_;
  std::size_t bounds_ = 0;
  std::size_t dots_ = 0;
};

render::Shot shot(const Troupe& troupe, const Scene& scene) {
  return {troupe.pose(scene.own), troupe.pose(scene.limit), ""};
}

/// The step that the outline is of: where there is no limit, the smallest that ran.
std::string outlined(const audit::Answer& answer) {
  return has_limit(answer, answer.told_at) ? "0" : fmt::format("h/{}", finest(answer));
}

render::Caption caption(const audit::Answer& answer, const Scene& scene) {
  return {fmt::format("{}, h = {:.4g} s (outline: at a step of {})", answer.stepper, answer.h_s, outlined(answer)),
          fmt::format("t = {:.3f} s", scene.t_s)};
}

render::PngTexts texts(const audit::Answer& answer) { return {{"program", answer.program}, {"Software", "odeval"}}; }

}  // namespace

std::vector<report::Section> worst_moment(const audit::Answer& answer, const audit::Records& records) {
  const std::vector<Scene> scenes = audit::scenes_at(records, answer.limit_degree, {answer.worst_t_s});
  if (scenes.empty()) return {};
  const Troupe troupe(records, scenes);
  render::Studio studio = troupe.studio();
  const audit::ErrorUntil& row = answer.error_at[answer.told_at];
  report::Picture picture{
      .name = "worst",
      .title = fmt::format("At {:.4g} s, when the error until {:.4g} s was reached.", scenes.front().t_s, row.t_s),
      .caption = fmt::format("Solid: this run. Outline: where it would be at a step of {}. {} is farthest off.{}",
                             outlined(answer), body_name(answer, answer.worst_body), troupe.remarks()),
      .png = render::png(studio.picture(shot(troupe, scenes.front()), caption(answer, scenes.front())), texts(answer))};
  return {{"worst-moment", "The worst moment", {std::move(picture)}}};
}

std::string audit_film(const audit::Answer& answer, const audit::Records& records) {
  constexpr int rate = 25;  // frames a second
  const double end = std::min(answer.until_s, answer.lost_at_s.value_or(answer.until_s));
  std::vector<double> times(static_cast<std::size_t>(end * rate) + 1);
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = static_cast<double>(i) / rate;
  const std::vector<Scene> scenes = audit::scenes_at(records, answer.limit_degree, times);
  if (scenes.empty()) return "";
  const Troupe troupe(records, scenes);
  render::Studio studio = troupe.studio();
  render::Film film(rate, texts(answer));
  for (const Scene& scene : scenes) film.add(studio.picture(shot(troupe, scene), caption(answer, scene)));
  return film.finish();
}

}  // namespace odeval::cli
