#include "engines/tree/touching.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace odeval::engine_tree {

Touching::Touching(const Mechanism& mechanism)
    : count_(mechanism.bodies.size() + mechanism.obstacles.size()), contacts_(mechanism.contacts) {
  if (contacts_.empty()) return;
  std::vector<std::string_view> names;
  for (const Body& body : mechanism.bodies) names.emplace_back(body.name);
  for (const Obstacle& obstacle : mechanism.obstacles) names.emplace_back(obstacle.name);
  of_pair_.resize(count_ * count_);
  for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
    for (std::size_t j = 0; j < count_; ++j) {
      const auto found = std::ranges::find_if(
          contacts_, [&](const Contact& contact) { return contact.is_between(names[i], names[j]); });
      if (i == j || found == contacts_.end()) continue;
      of_pair_[i * count_ + j] = of_pair_[j * count_ + i] = &*found;
    }
  }
  for (const Joint& joint : mechanism.joints) {
    if (!joint.second) continue;
    of_pair_[joint.first * count_ + *joint.second] = of_pair_[*joint.second * count_ + joint.first] = nullptr;
  }
}

const Contact* Touching::between(std::size_t first, std::size_t second) const {
  return empty() ? nullptr : of_pair_[first * count_ + second];
}

namespace {

/// The other way round: a spring and damper let go when together they would pull (T. Schwager and T. Pöschel,
/// Coefficient of restitution and linear-dashpot model revisited, Granular Matter 9, 2007).
double restitution_of(double ratio) {
  if (ratio >= 1) return std::exp(-2);
  const double swing = std::sqrt(1 - ratio * ratio);
  // The phase at which force and damping cancel, between 0 and pi.
  const double phase = std::atan2(2 * ratio * swing, 2 * ratio * ratio - 1);
  return std::exp(-ratio / swing * phase);
}

}  // namespace

double damping_ratio(double restitution) {
  if (restitution <= 0) return 1;
  double low = 0;
  double high = 1;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (restitution_of(middle) > restitution ? low : high) = middle;
  }
  return low;
}

}  // namespace odeval::engine_tree
