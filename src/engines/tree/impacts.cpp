#include "engines/tree/impacts.hpp"

#include <algorithm>

namespace odeval::engine_tree {

Impacts::Impacts(const Scenario& scenario) : planar_(scenario.planar) {
  for (const ImpactView& view : scenario.impact_views) watched_.push_back({view});
}

double Impacts::rate(const ImpactView& view, const std::vector<Placed>& bodies) const {
  const Placed& body = bodies[view.body];
  return view.as_rate ? dot(body.spin_rad_s, planar_->frame.axis()) : dot(view.normal, body.velocity_m_s);
}

void Impacts::look(double from_s, const Touched& touched, const std::vector<Placed>& before,
                   const std::vector<Placed>& after, const std::vector<double>& angles) {
  for (Watched& one : watched_) {
    const ImpactView& view = one.view;
    const double height = dot(view.normal, after[view.body].position_m);
    // Engines that bounce within a step may have it clear of what it struck at the end: then it touched at the
    // beginning.
    const double lowest = std::min(height, dot(view.normal, before[view.body].position_m));
    const double depth = view.touches_at ? *view.touches_at - lowest : touched.depth;
    const bool touching = touched.contacts > 0 && (!view.touches_at || depth >= 0 || one.touching);
    const double approach = rate(view, before);
    const bool lies = from_s == 0 && approach >= 0;
    if (touching && !one.touching && !lies) {
      one.impact = impacts_.size();
      impacts_.push_back({from_s, view.as_angle ? angles.front() : height, approach, 0, 0, view.link});
    }
    if (!touching) one.impact.reset();
    if (one.impact) {
      Impact& impact = impacts_[*one.impact];
      impact.qd_after = rate(view, after);
      impact.depth = std::max(impact.depth, depth);
    }
    one.touching = touching;
  }
}

}  // namespace odeval::engine_tree
