#include "reference/maximal/ode_step_simulation.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "reference/maximal/links_in_plane.hpp"
#include "reference/maximal/ode_step.hpp"
#include "reference/maximal/wall_overlap.hpp"

namespace odeval::reference {
namespace {

using namespace maximal;

OdeStepSettings step_settings(const Scenario& scenario) {
  OdeStepSettings settings;
  const Softness softness = scenario.ode.softness(scenario.step_s);
  settings.erp = softness.erp;
  settings.cfm = softness.cfm;
  settings.gravity = Eigen::Vector3d(0, 0, -scenario.gravity);
  const std::optional<Wall>& wall = scenario.planar->wall;
  if (wall) settings.bounce = scenario.ode.bounce.value_or(wall->restitution);
  settings.bounce_vel = scenario.ode.bounce_vel;
  settings.max_correcting_vel = scenario.ode.max_correcting_vel;
  settings.surface_layer = scenario.ode.surface_layer;
  settings.gyroscopic = scenario.ode.gyroscopic ? Gyroscopic::implicit_linear : Gyroscopic::none;
  return settings;
}

Body body_of(const PlaneInWorld& plane, const Link& link, const LinkInPlane& at) {
  Body body =
      link.shape == LinkShape::box ? box(link.mass_kg, plane.box_sides(link)) : ball(link.mass_kg, link.width_m / 2);
  body.position = plane.point(at.x, at.y);
  body.rotation = plane.rotation(at.angle);
  body.orientation = Eigen::Quaterniond(body.rotation);
  body.velocity = plane.direction(at.vx, at.vy);
  body.spin = at.rate * plane.axis();
  return body;
}

/// The links as bodies, by number, with `hinges` equal hinges at each joint.
void add_links(OdeStep& step, const PlaneInWorld& plane, const PlanarView& view, int hinges) {
  const Eigen::Vector3d axis = eigen(view.frame.hinge_axis);
  int parent = world;
  LinkInPlane before{};
  double beyond = 0;
  std::size_t i = 0;
  for (const LinkInPlane& link : links_at_start(view)) {
    // The joint is the far end of the link before; the first hinge is the plane's origin.
    const LinkInPlane end = before.along(beyond);
    const Eigen::Vector3d anchor = plane.point(end.x, end.y);
    const int number = step.add_body(body_of(plane, view.links[i], link));
    for (int copy = 0; copy < hinges; ++copy) {
      // As in ODE's scene: the first link is body 0 of its hinge, every other link is body 1, after its parent.
      if (parent == world) {
        step.add_hinge(number, world, anchor, axis);
      } else {
        step.add_hinge(parent, number, anchor, axis);
      }
    }
    parent = number;
    before = link;
    beyond = view.links[i++].beyond_centre_m();
  }
}

class OdeStepSimulation final : public Simulation {
 public:
  OdeStepSimulation(const Scenario& scenario, const SampleGrid& grid)
      : grid_(grid), plane_(scenario.planar->frame), step_(step_settings(scenario)) {
    const PlanarView& view = *scenario.planar;
    add_links(step_, plane_, view, 1);
    for (const LinkInPlane& link : links_at_start(view)) angles_.push_back(link.angle);
    if (view.wall) wall_.emplace(0, plane_.box_sides(view.links[0]), view.wall->face_m);
    impacts_.reserve(1024);
  }

  SampleShape shape() const override { return {.bodies = angles_.size(), .joints = angles_.size()}; }

  Outcome run(Recorder recorder) override {
    Outcome outcome;
    record(recorder, outcome);
    for (long row = 1; row < grid_.rows; ++row) {
      for (long k = 0; k < grid_.stride; ++k) {
        take_step(outcome.steps++);
        if (!finite()) {
          outcome.diverged = true;
          outcome.reason = fmt::format("a velocity or its square left the finite numbers in the step from t = {:g} s",
                                       static_cast<double>(outcome.steps - 1) * grid_.step_s);
          break;
        }
        follow_angles();
        if (recorder && outcome.steps == 1) record_forces(recorder.at(0));
      }
      if (outcome.diverged) break;
      record(recorder, outcome);
    }
    outcome.messages = step_.unsolved();
    outcome.impacts = std::move(impacts_);
    return outcome;
  }

 private:
  // An impact is a run of steps with contacts; its first step carries the bounce.
  void take_step(long steps_done) {
    if (!wall_) {
      step_.step(grid_.step_s);
      return;
    }
    const Body& link = step_.body(0);
    const std::span<const Contact> contacts = wall_->contacts(link);
    contacts_ = contacts.size();
    const bool first_touch = contacts_ > 0 && !touching_;
    touching_ = contacts_ > 0;
    if (first_touch) {
      impacts_.push_back({static_cast<double>(steps_done) * grid_.step_s, angles_[0], rate(), 0, wall_->depth()});
    }
    step_.step(grid_.step_s, contacts);
    if (first_touch) impacts_.back().qd_after = rate();
  }

  double rate() const { return step_.body(0).spin.dot(plane_.axis()); }

  // Positions follow velocities, so these are enough. The squares must stay finite as well: energies hold them.
  bool finite() const {
    double sum = 0;
    for (int i = 0; i < links(); ++i) sum += step_.body(i).velocity.squaredNorm() + step_.body(i).spin.squaredNorm();
    return sum < 1e290;
  }

  // One step turns a link by 2 atan(h |w| / 2), less than half a turn, so the nearest branch is the right one.
  void follow_angles() {
    for (int i = 0; i < links(); ++i) {
      double& angle = angles_[static_cast<std::size_t>(i)];
      angle = plane_.angle(step_.body(i).rotation, angle);
    }
  }

  void record(Recorder recorder, const Outcome& outcome) const {
    if (!recorder) return;
    const Sample sample = recorder.next();
    for (int i = 0; i < links(); ++i) {
      const Body& body = step_.body(i);
      const auto link = static_cast<std::size_t>(i);
      sample.bodies[link] = body_state(body.position, body.rotation, body.velocity, body.spin, angles_[link]);
    }
    sample.contacts = static_cast<double>(contacts_);
    // No step led to t = 0: its sample gets the forces of the first step.
    if (outcome.steps > 0) record_forces(sample);
  }

  // On the link itself, which is body 0 of its hinge if it is the first and body 1 otherwise.
  void record_forces(const Sample& sample) const {
    for (int i = 0; i < links(); ++i) {
      const Eigen::Vector3d force = step_.hinge_force(i);
      sample.joints[static_cast<std::size_t>(i)].force = vec3(i == 0 ? force : Eigen::Vector3d(-force));
    }
  }

  int links() const { return static_cast<int>(angles_.size()); }

  SampleGrid grid_;
  PlaneInWorld plane_;
  OdeStep step_;
  std::optional<WallOverlap> wall_;
  std::vector<double> angles_;  // absolute, of each link, as the steps have turned it
  std::vector<Impact> impacts_;
  std::size_t contacts_ = 0;
  bool touching_ = false;
};

}  // namespace

std::unique_ptr<Simulation> make_maximal_ode_step(const Scenario& scenario, const SampleGrid& grid) {
  return std::make_unique<OdeStepSimulation>(scenario, grid);
}

SystemSpectrum system_spectrum(const Scenario& scenario, int hinges) {
  OdeStep step(step_settings(scenario));
  add_links(step, PlaneInWorld(scenario.planar->frame), *scenario.planar, hinges);
  step.step(scenario.step_s);  // which leaves the system of the pose it started from
  const Eigen::MatrixXd system = step.system_matrix();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(system, Eigen::EigenvaluesOnly).eigenvalues();
  const double greatest = values.maxCoeff();
  // What a symmetric solver may be off by (Golub and Van Loan, Matrix Computations, 8.1.2): rows times epsilon times
  // the norm.
  const double rounding = static_cast<double>(values.size()) * std::numeric_limits<double>::epsilon() * greatest;
  return {values.minCoeff() > rounding ? values.minCoeff() : 0, greatest};
}

}  // namespace odeval::reference
