#include "audit/scene.hpp"

#include <algorithm>
#include <cmath>

#include "audit/extrapolation.hpp"
#include "audit/recording.hpp"

namespace odeval::audit {
namespace {

using Moment = Recording::Moment;

Place limit_of(const std::vector<Moment>& moments, std::size_t body, const std::vector<int>& refinements,
               std::size_t degree) {
  std::vector<double> values;
  for (const Moment& moment : moments) {
    const BodySample& its = moment.bodies[body];
    values.insert(values.end(), its.position, its.position + 3);
    const auto quaternion = nearer(its.quaternion, moments.front().bodies[body].quaternion);
    values.insert(values.end(), quaternion.begin(), quaternion.end());
  }
  const std::vector<double> limit = extrapolated(values, refinements, degree);
  Place place{{limit[0], limit[1], limit[2]}, {limit[3], limit[4], limit[5], limit[6]}};
  const double length =
      std::sqrt(limit[3] * limit[3] + limit[4] * limit[4] + limit[5] * limit[5] + limit[6] * limit[6]);
  for (double& part : place.quaternion) part /= length;
  return place;
}

}  // namespace

std::vector<Scene> scenes_at(const Records& records, std::size_t degree, const std::vector<double>& times) {
  std::vector<Recording> runs;
  for (const auto& file : records.refined) runs.emplace_back(file);
  std::vector<Scene> scenes;
  Scene now;
  std::map<std::uint32_t, std::vector<std::uint32_t>> of_world;  // its bodies in the scene
  std::vector<Moment> moments;
  while (scenes.size() < times.size()) {
    moments.clear();
    for (Recording& run : runs) {
      const auto moment = run.next();
      if (!moment || (!moments.empty() && !same_bodies(moments.front(), *moment))) return scenes;
      moments.push_back(*moment);
    }
    const Moment& own = moments.front();
    constexpr double rounding = 1e-9;
    // Other worlds are as they were last; of this one, bodies that are gone are gone.
    const bool wanted = own.frame.t >= times[scenes.size()] - 2 * own.frame.h - rounding;
    if (!wanted) continue;
    for (const std::uint32_t body : of_world[own.frame.world]) {
      now.own.erase(body);
      now.limit.erase(body);
    }
    of_world[own.frame.world].clear();
    for (std::size_t i = 0; i < own.bodies.size(); ++i) {
      const BodySample& body = own.bodies[i];
      of_world[own.frame.world].push_back(body.body + 1);
      Place& place = now.own[body.body + 1];
      std::copy_n(body.position, 3, place.position_m.begin());
      std::copy_n(body.quaternion, 4, place.quaternion.begin());
      now.limit[body.body + 1] = limit_of(moments, i, records.refinements, degree);
    }
    now.t_s = own.frame.t;
    while (scenes.size() < times.size() && now.t_s >= times[scenes.size()] - rounding) scenes.push_back(now);
  }
  return scenes;
}

std::vector<ShapeSample> shapes_of(const std::filesystem::path& record) {
  return read_rows<ShapeSample>(record.string() + shapes_ending);
}

Vec3 up_of(const std::filesystem::path& record) {
  const Recording run(record);
  if (run.head() == nullptr) return {0, 0, 1};
  const double* g = run.head()->gravity;
  const double size = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  return size > 0 && std::isfinite(size) ? Vec3{-g[0] / size, -g[1] / size, -g[2] / size} : Vec3{0, 0, 1};
}

}  // namespace odeval::audit
