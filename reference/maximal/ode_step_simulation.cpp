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
  if (scenario.wall) settings.bounce = scenario.ode.bounce.value_or(scenario.wall->restitution);
  settings.bounce_vel = scenario.ode.bounce_vel;
  settings.max_correcting_vel = scenario.ode.max_correcting_vel;
  settings.surface_layer = scenario.ode.surface_layer;
  settings.gyroscopic = scenario.ode.gyroscopic ? Gyroscopic::implicit_linear : Gyroscopic::none;
  return settings;
}

Body body_of(const PlaneInWorld& plane, const Link& link, const LinkInPlane& at) {
  Body body =
      link.shape == Shape::box ? box(link.mass_kg, plane.box_sides(link)) : ball(link.mass_kg, link.width_m / 2);
  body.position = plane.point(at.x, at.y);
  body.rotation = plane.rotation(at.angle);
  body.orientation = Eigen::Quaterniond(body.rotation);
  body.velocity = plane.direction(at.vx, at.vy);
  body.spin = at.rate * plane.axis();
  return body;
}

/// The links as bodies, by number, with `hinges` equal hinges at each joint.
void add_links(OdeStep& step, const PlaneInWorld& plane, const Scenario& scenario, int hinges) {
  const Eigen::Vector3d axis = eigen(scenario.problem->frame.hinge_axis);
  int parent = world;
  LinkInPlane before{};
  double beyond = 0;
  std::size_t i = 0;
  for (const LinkInPlane& link : links_at_start(scenario)) {
    // The joint is the far end of the link before; the first hinge is the plane's origin.
    const Eigen::Vector3d anchor =
        plane.point(before.x + beyond * std::cos(before.angle), before.y + beyond * std::sin(before.angle));
    const int number = step.add_body(body_of(plane, scenario.links[i], link));
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
    beyond = scenario.links[i++].beyond_centre_m();
  }
}

class OdeStepSimulation final : public Simulation {
 public:
  OdeStepSimulation(const Scenario& scenario, const SampleGrid& grid)
      : grid_(grid), plane_(scenario.problem->frame), step_(step_settings(scenario)) {
    add_links(step_, plane_, scenario, 1);
    for (const LinkInPlane& link : links_at_start(scenario)) angles_.push_back(link.angle);
    if (scenario.wall) wall_.emplace(0, plane_.box_sides(scenario.links[0]), scenario.wall->face_m);
    impacts_.reserve(1024);
  }

  Outcome run(Rows* rows) override {
    Outcome outcome;
    if (rows != nullptr) record(*rows);
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
        if (rows != nullptr && outcome.steps == 1) give_start_its_forces(*rows);
      }
      if (outcome.diverged) break;
      if (rows != nullptr) record(*rows);
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

  void record(Rows& rows) const {
    double* row = rows.append();
    for (int i = 0; i < links(); ++i) {
      const Body& body = step_.body(i);
      const auto link = static_cast<std::size_t>(i);
      put(row, link,
          body_state(body.position, body.rotation, body.velocity, body.spin, joint_force(i, rows.count() > 1),
                     angles_[link]));
    }
    row[angles_.size() * body_numbers] = static_cast<double>(contacts_);
  }

  // On the link itself, which is body 0 of its hinge if it is the first and body 1 otherwise.
  Eigen::Vector3d joint_force(int link, bool stepped) const {
    if (!stepped) return Eigen::Vector3d::Zero();
    return link == 0 ? step_.hinge_force(link) : Eigen::Vector3d(-step_.hinge_force(link));
  }

  // No step led to t = 0: its row shows the force of the first step instead of a zero nobody measured.
  void give_start_its_forces(Rows& rows) const {
    for (int i = 0; i < links(); ++i) {
      double* start = rows.row(0) + static_cast<std::size_t>(i) * body_numbers;
      Eigen::Vector3d::Map(start + offsetof(BodyState, joint_force) / sizeof(double)) = joint_force(i, true);
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
  add_links(step, PlaneInWorld(scenario.problem->frame), scenario, hinges);
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
