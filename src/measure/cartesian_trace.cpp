#include "measure/cartesian_trace.hpp"

#include <algorithm>
#include <cmath>

#include "measure/body_columns.hpp"
#include "measure/greater.hpp"
#include "measure/unwrap.hpp"

namespace odeval {

namespace {

/// What one link does in one row.
struct LinkState {
  double angle;  // absolute, in (-pi, pi]
  double rate;
  double kinetic;
  double potential;
  double out_of_plane;
  double long_axis_spin;
  Vec3 near_end;
  Vec3 far_end;
};

/// Evaluates one link; holds what stays the same over the rows.
class LinkMeter {
 public:
  LinkMeter(const PlanarFrame& frame, const Link& link, double gravity)
      : frame_(frame),
        axis_(frame.axis()),
        third_body_(cross(frame.along_body, frame.across_body)),
        mass_(link.mass_kg),
        weight_(link.mass_kg * gravity),
        to_near_(link.centre_m()),
        to_far_(link.beyond_centre_m()),
        inertia_along_(link.inertia_along_kgm2()),
        inertia_across_(link.inertia_across_kgm2()),
        inertia_hinge_(link.inertia_kgm2()) {}

  LinkState operator()(const BodyState& body) const {
    const Vec3& x = body.position;
    const Vec3& v = body.velocity;
    const Vec3& w = body.spin;
    const Vec3 along = turned(body.rotation, frame_.along_body);
    const double w_along = dot(w, along);
    const double w_across = dot(w, turned(body.rotation, frame_.across_body));
    const double w_hinge = dot(w, turned(body.rotation, third_body_));
    const Vec3 from_hinge = x - frame_.hinge_m;

    LinkState state;
    state.angle = std::atan2(dot(along, frame_.up), dot(along, frame_.horizontal));
    state.rate = dot(w, axis_);
    state.kinetic = 0.5 * (mass_ * dot(v, v) + inertia_along_ * w_along * w_along +
                           inertia_across_ * w_across * w_across + inertia_hinge_ * w_hinge * w_hinge);
    state.potential = weight_ * from_hinge[2];
    state.out_of_plane = std::fabs(dot(from_hinge, axis_));
    state.long_axis_spin = w_along;
    state.near_end = x + -to_near_ * along;
    state.far_end = x + to_far_ * along;
    return state;
  }

 private:
  const PlanarFrame& frame_;
  Vec3 axis_;
  Vec3 third_body_;
  double mass_;
  double weight_;
  double to_near_;
  double to_far_;
  double inertia_along_;
  double inertia_across_;
  double inertia_hinge_;
};

Trace sized_trace(std::size_t links, std::size_t rows) {
  Trace trace;
  trace.q.assign(links, Column(rows));
  trace.qd.assign(links, Column(rows));
  for (Column* column :
       {&trace.t, &trace.kinetic, &trace.potential, &trace.gap, &trace.out_of_plane, &trace.contacts}) {
    column->resize(rows);
  }
  trace.long_axis_spin.assign(links, Column(rows));
  resize_bodies(trace, links, rows);
  return trace;
}

}  // namespace

Trace cartesian_trace(const Scenario& scenario, const SampleGrid& grid, const Motion& motion) {
  const PlanarFrame& frame = scenario.planar->frame;
  const std::size_t links = scenario.planar->links.size();
  Trace trace = sized_trace(links, motion.size());
  const ForcesOfBodies force_of(scenario.mechanism);

  std::vector<LinkMeter> meters;
  for (std::size_t i = 0; i < links; ++i) {
    meters.emplace_back(frame, scenario.planar->links[i], scenario.gravity);
  }

  for (std::size_t k = 0; k < motion.size(); ++k) {
    const ConstSample sample = motion[k];
    trace.t[k] = grid.time(static_cast<long>(k));
    double angle_inside = 0;  // of the link before
    double rate_inside = 0;
    Vec3 anchor = frame.hinge_m;
    for (std::size_t i = 0; i < links; ++i) {
      const BodyState& body = sample.bodies[i];
      const LinkState state = meters[i](body);

      const double angle = unwrap(state.angle, body.angle);
      trace.q[i][k] = angle - angle_inside;
      trace.qd[i][k] = state.rate - rate_inside;
      angle_inside = angle;
      rate_inside = state.rate;

      trace.kinetic[k] += state.kinetic;
      trace.potential[k] += state.potential;
      trace.out_of_plane[k] = greater(trace.out_of_plane[k], state.out_of_plane);
      trace.gap[k] = greater(trace.gap[k], distance(state.near_end, anchor));
      anchor = state.far_end;

      trace.long_axis_spin[i][k] = state.long_axis_spin;
      store_body(trace.bodies[i], k, body, force_of(i, sample.joints));
    }
    trace.contacts[k] = sample.contacts;
  }
  return trace;
}

}  // namespace odeval
