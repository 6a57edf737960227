#include "engines/ode/link_angles.hpp"

#include <cmath>
#include <numbers>

namespace odeval::engine_ode {
namespace {

constexpr double full_turn = 2 * std::numbers::pi;

double nearest_branch(double angle, double near) { return angle + full_turn * std::round((near - angle) / full_turn); }

}  // namespace

LinkAngles::LinkAngles(const Scenario& scenario, const Scene& scene) : view_(scenario.planar), scene_(scene) {
  if (!view_) return;
  double angle = 0;
  for (const double q : view_->q0) angles_.push_back(angle += q);
  follow();
}

// One step turns a link by 2 atan(h |w| / 2), less than half a turn, so the nearest branch is the right one.
void LinkAngles::follow() {
  for (std::size_t i = 0; i < angles_.size(); ++i) angles_[i] = nearest_branch(direction(i), angles_[i]);
}

/// Absolute angle of a link's direction, within half a turn of 0.
double LinkAngles::direction(std::size_t link) const {
  const PlanarFrame& frame = view_->frame;
  const dReal* r = scene_.bodies()[link].rotation;
  Vec3 along{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) along[i] += static_cast<double>(r[4 * i + j]) * frame.along_body[j];
  }
  return std::atan2(dot(along, frame.up), dot(along, frame.horizontal));
}

double LinkAngles::of_first() const { return direction(0) + full_turn * std::round(view_->q0[0] / full_turn); }

double LinkAngles::rate_of(std::size_t link) const {
  const dReal* spin = scene_.bodies()[link].spin;
  return dot({spin[0], spin[1], spin[2]}, view_->frame.axis());
}

}  // namespace odeval::engine_ode
