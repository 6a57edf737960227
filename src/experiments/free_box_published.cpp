#include "experiments/free_box_published.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "report/text.hpp"

namespace odeval::experiments::free_box_published {
namespace {

using report::shown;

/// The benchmark's own results: S. Peters' repository scpeters/benchmark,
/// benchmark_gazebo/test_results/BENCHMARK_boxes_dt.csv, of Gazebo 6 in 2015.
struct Row {
  std::string_view method;  // of ours that is theirs
  bool tumbles;
  double step_s;
  Errors errors;
};
// clang-format off
constexpr Row rows[] = {
    {"ode-quickstep-double",  false, 1e-4, {1.32316e-11, 0, 0, 1.04167e-09}},
    {"ode-quickstep-double",  false, 4e-4, {3.11725e-12, 0, 0, 1.66673e-08}},
    {"ode-quickstep-double",  false, 1e-3, {1.65532e-12, 0, 0, 1.04177e-07}},
    {"bullet-hinge-double",   false, 1e-4, {1.32316e-11, 1.69995e-12, 6.85531e-14, 3.40528e-12}},
    {"bullet-hinge-double",   false, 4e-4, {3.11725e-12, 1.72371e-13, 7.10395e-15, 4.50751e-13}},
    {"bullet-hinge-double",   false, 1e-3, {1.65532e-12, 5.28787e-14, 2.13118e-15, 1.58096e-13}},
    {"simbody-semi-explicit", false, 1e-4, {1.9222e-11, 0, 0, 2.60406e-10}},
    {"simbody-semi-explicit", false, 4e-4, {5.03797e-12, 0, 0, 4.16683e-09}},
    {"simbody-semi-explicit", false, 1e-3, {2.29424e-12, 0, 0, 2.60443e-08}},
    {"dart-step",             false, 1e-4, {1.32316e-11, 9.15335e-16, 3.46317e-14, 2.30683e-06}},
    {"dart-step",             false, 4e-4, {3.11725e-12, 1.23444e-15, 1.74047e-14, 6.28318}},
    {"dart-step",             false, 1e-3, {1.65532e-12, 8.48948e-16, 2.48638e-15, 3.1082e-06}},
    {"ode-quickstep-double",  true,  1e-4, {0.0049, 0.0012715, 0.00124711}},
    {"ode-quickstep-double",  true,  4e-4, {0.0196008, 0.00513309, 0.00498742}},
    {"ode-quickstep-double",  true,  1e-3, {0.0490049, 0.0130775, 0.0124631}},
    {"bullet-hinge-double",   true,  1e-4, {0.0049, 0.00125827, 0.0013586}},
    {"bullet-hinge-double",   true,  4e-4, {0.0196008, 0.00501544, 0.00543344}},
    {"bullet-hinge-double",   true,  1e-3, {0.0490049, 0.0124515, 0.0135785}},
    {"simbody-semi-explicit", true,  1e-4, {0.00245, 0.000634808, 0.00062358}},
    {"simbody-semi-explicit", true,  4e-4, {0.00980039, 0.00255109, 0.00249411}},
    {"simbody-semi-explicit", true,  1e-3, {0.0245024, 0.00643788, 0.00623412}},
    {"dart-step",             true,  1e-4, {0.0049, 2.22942, 0.0269129}},
    {"dart-step",             true,  4e-4, {0.0196008, 2.23344, 0.0289518}},
    {"dart-step",             true,  1e-3, {0.0490049, 2.18611, 0.0376207}},
};
// clang-format on

constexpr std::array all{Engine{"ODE", "ode-quickstep-double"}, Engine{"Bullet", "bullet-hinge-double"},
                         Engine{"Simbody", "simbody-semi-explicit"}, Engine{"DART", "dart-step"}};

std::string percent(double part) { return shown(100 * part) + " %"; }

/// Of methods that are one motion, which rounding alone tells apart, the first is named.
constexpr double clearly = 0.9;

/// Who comes nearest, and how near.
struct Nearest {
  std::string method;
  double part = 1;
  double off = INFINITY;
};

Nearest nearest_of(const Engine& engine, const Measured& measured) {
  Nearest nearest;
  const auto look = [&](const std::string& method, double part) {
    const std::optional<double> off = difference(engine, method, part, measured);
    if (off && *off < clearly * nearest.off) nearest = {method, part, *off};
  };
  look(std::string(engine.method), 0.5);
  std::set<std::string> methods;
  for (const auto& [key, errors] : measured) methods.insert(key.first);
  for (const std::string& method : methods) look(method, 1);
  return nearest;
}

std::string about(const Engine& engine, double own, const Measured& measured) {
  const std::string numbers = fmt::format("{}'s numbers", engine.name);
  if (own < same) return fmt::format("{} are those of {}, within {}.", numbers, engine.method, percent(own));
  const std::string off = fmt::format("{} are up to {} off those of {}", numbers, percent(own), engine.method);
  const Nearest nearest = nearest_of(engine, measured);
  if (!(nearest.off < same)) return off + ", and no method's here.";
  return fmt::format("{}; they are those of {}{}, within {}.", off, nearest.method,
                     nearest.part < 1 ? " at half the step" : "", percent(nearest.off));
}

}  // namespace

std::span<const Engine> engines() { return all; }

const Errors* of(std::string_view method, bool tumbles, double step_s) {
  const auto* const found = std::ranges::find_if(
      rows, [&](const Row& row) { return row.method == method && row.tumbles == tumbles && row.step_s == step_s; });
  return found != std::end(rows) ? &found->errors : nullptr;
}

std::optional<double> difference(const Engine& engine, std::string_view method, double part, const Measured& measured) {
  std::optional<double> most;
  for (const Row& row : rows) {
    if (row.method != engine.method || !row.tumbles) continue;
    const auto found = measured.find({std::string(method), part * row.step_s});
    if (found == measured.end()) continue;
    const Errors& here = found->second;
    for (const auto& [theirs, ours] :
         {std::pair{row.errors.distance_m, here.distance_m}, std::pair{row.errors.momentum, here.momentum},
          std::pair{row.errors.energy, here.energy}}) {
      most = std::fmax(most.value_or(0), std::fabs(theirs / ours - 1));
    }
  }
  return most;
}

std::string about(const Measured& measured) {
  std::string text;
  for (const Engine& engine : all) {
    const std::optional<double> own = difference(engine, engine.method, 1, measured);
    if (own) text += (text.empty() ? "" : " ") + about(engine, *own, measured);
  }
  return text;
}

}  // namespace odeval::experiments::free_box_published
