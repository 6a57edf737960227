#include "engines/ode/impacts.hpp"

namespace odeval::engine_ode {

Impacts::Impacts(const Scenario& scenario, const Scene& scene, const LinkAngles& angles)
    : views_(scenario.impact_views), scene_(scene), angles_(angles), touching_(views_.size()) {
  impacts_.reserve(1024);
  begun_.reserve(views_.size());
}

void Impacts::before_step(double t) {
  begun_.clear();
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const double depth = scene_.contacts() > 0 ? depth_of(views_[i]) : -1;
    if (depth >= 0 && touching_[i] == 0 && !lies(t, views_[i])) add(t, i, depth);
    touching_[i] = depth >= 0;
  }
}

bool Impacts::lies(double t, const ImpactView& view) const { return t == 0 && rate_of(view) >= 0; }

void Impacts::after_step() {
  Impact* impact = impacts_.data() + impacts_.size() - begun_.size();
  for (const std::size_t view : begun_) (impact++)->qd_after = rate_of(views_[view]);
}

void Impacts::begin(double t) {
  begun_.clear();
  if (views_.empty()) return;
  std::size_t deepest = 0;
  for (std::size_t i = 1; i < views_.size(); ++i) {
    if (depth_of(views_[i]) > depth_of(views_[deepest])) deepest = i;
  }
  add(t, deepest, 0);
}

void Impacts::add(double t, std::size_t number, double depth) {
  const ImpactView& view = views_[number];
  const double coordinate =
      view.as_angle ? angles_.of_first() : along_normal(view, scene_.bodies()[view.body].position);
  impacts_.push_back({t, coordinate, rate_of(view), 0, depth, view.link});
  begun_.push_back(number);
}

double Impacts::along_normal(const ImpactView& view, const dReal* v) const {
  return dot(view.normal, {v[0], v[1], v[2]});
}

double Impacts::depth_of(const ImpactView& view) const {
  if (!view.touches_at) return scene_.depth();
  return *view.touches_at - along_normal(view, scene_.bodies()[view.body].position);
}

double Impacts::rate_of(const ImpactView& view) const {
  const BodyView& body = scene_.bodies()[view.body];
  return view.as_rate ? angles_.rate_of(view.body) : along_normal(view, body.velocity);
}

}  // namespace odeval::engine_ode
