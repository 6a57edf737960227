#pragma once
// Angles of links in a plane, followed from step to step in an ODE world.
#include <memory>
#include <vector>

#include "engines/ode/scene.hpp"

namespace odeval::engine_ode {

class LinkAngles {
 public:
  /// Of a scenario without a planar view it follows nothing.
  LinkAngles(const Scenario& scenario, const Scene& scene);

  /// After each step that will be recorded.
  void follow();
  /// Absolute, as the steps have turned the link, rad; 0 without a planar view.
  double of(std::size_t link) const { return angles_.empty() ? 0 : angles_[link]; }
  /// q1 of a link that strikes something, which keeps it within half a turn of the direction away from it.
  double of_first() const;
  /// rad/s about the axis of the plane.
  double rate_of(std::size_t link) const;

 private:
  double direction(std::size_t link) const;

  std::shared_ptr<const PlanarView> view_;
  const Scene& scene_;
  std::vector<double> angles_;
};

}  // namespace odeval::engine_ode
