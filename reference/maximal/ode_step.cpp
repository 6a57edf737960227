#include "reference/maximal/ode_step.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace odeval::reference::maximal {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d matrix;
  matrix << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return matrix;
}

constexpr double unlimited = std::numeric_limits<double>::infinity();

}  // namespace

void Body::set_orientation(const Quaterniond& unit) {
  orientation = unit;
  rotation = unit.toRotationMatrix();
}

Body box(double mass, const Vector3d& sides) {
  const Vector3d squares = sides.cwiseProduct(sides);
  Body body;
  body.mass = mass;
  body.inertia = (mass / 12 * (Vector3d::Constant(squares.sum()) - squares)).asDiagonal();
  return body;
}

Body ball(double mass, double radius) {
  Body body;
  body.mass = mass;
  body.inertia = 0.4 * mass * radius * radius * Matrix3d::Identity();
  return body;
}

void plane_space(const Vector3d& n, Vector3d& p, Vector3d& q) {
  constexpr double sqrt_half = 0.70710678118654752440;
  if (std::fabs(n.z()) > sqrt_half) {
    const double r = std::sqrt(n.y() * n.y() + n.z() * n.z());
    p = Vector3d(0, -n.z(), n.y()) / r;
    q = Vector3d(r, -n.x() * p.z(), n.x() * p.y());
  } else {
    const double r = std::sqrt(n.x() * n.x() + n.y() * n.y());
    p = Vector3d(-n.y(), n.x(), 0) / r;
    q = Vector3d(-n.z() * p.y(), n.z() * p.x(), r);
  }
}

int OdeStep::add_body(const Body& body) {
  bodies_.push_back({body, body.inertia.inverse(), Matrix3d::Zero(), Vector3d::Zero(), Vector3d::Zero()});
  return static_cast<int>(bodies_.size()) - 1;
}

int OdeStep::add_hinge(int body0, int body1, const Vector3d& anchor, const Vector3d& axis) {
  const auto local_point = [&](int number) -> Vector3d {
    if (number == world) return anchor;
    return body(number).rotation.transpose() * (anchor - body(number).position);
  };
  const auto local_axis = [&](int number) -> Vector3d {
    if (number == world) return axis;
    return body(number).rotation.transpose() * axis;
  };
  hinges_.push_back({body0, body1, local_point(body0), local_axis(body0), local_point(body1), local_axis(body1)});
  return static_cast<int>(hinges_.size()) - 1;
}

void OdeStep::step(double h, std::span<const Contact> contacts) {
  const auto hinge_rows = rows_of_hinge * static_cast<Index>(hinges_.size());
  rows_ = hinge_rows + static_cast<Index>(contacts.size());
  if (system_.rows() < rows_) {
    row_.resize(static_cast<std::size_t>(rows_));
    system_.resize(rows_, rows_);
    right_.resize(rows_);
    force_.resize(rows_);
    least_.resize(rows_);
    greatest_.setConstant(rows_, unlimited);
    lcp_.reserve(rows_);
  }
  gather_forces(h);
  const double erp_over_h = settings_.erp / h;
  Row* row = row_.data();
  for (const Hinge& hinge : hinges_) {
    set_hinge_rows(hinge, row, erp_over_h);
    row += rows_of_hinge;
  }
  for (const Contact& contact : contacts) set_contact_row(contact, *row++, erp_over_h);
  least_.head(hinge_rows).setConstant(-unlimited);
  least_.segment(hinge_rows, rows_ - hinge_rows).setZero();
  set_system(h);
  if (!lcp_.solve(rows_, system_, right_, least_, greatest_, force_)) ++unsolved_;
  move(h);
}

void OdeStep::gather_forces(double h) {
  for (Moving& body : bodies_) {
    const Matrix3d& rotation = body.now.rotation;
    body.inverse_inertia_world = rotation * body.inverse_inertia * rotation.transpose();
    body.force = body.now.mass * settings_.gravity;
    body.torque.setZero();
    add_gyroscopic_torque(body, h);
  }
}

// Implicit: w* of  I (w* - w)/h + w* x L = 0  with the angular momentum L of the step's start; the torque is the one
// that takes w to w* (C. Lacoursiere, Stabilizing gyroscopic forces in rigid multibody simulations, 2006).
void OdeStep::add_gyroscopic_torque(Moving& body, double h) const {
  const Vector3d& spin = body.now.spin;
  const Matrix3d inertia = body.now.rotation * body.now.inertia * body.now.rotation.transpose();
  const Vector3d momentum = inertia * spin;
  if (settings_.gyroscopic == Gyroscopic::explicit_torque) body.torque -= spin.cross(momentum);
  if (settings_.gyroscopic != Gyroscopic::implicit_linear) return;
  Matrix3d inverse;
  bool invertible = false;
  (inertia - h * cross_matrix(momentum)).eval().computeInverseWithCheck(inverse, invertible, 0.0);
  if (invertible) body.torque += (inertia * (inverse * momentum) - momentum) / h;
}

// Sums stand in ODE's order: ERP/h turns an ulp of a coordinate into 1e-13 m/s. Rows 0 to 2 hold the anchors together,
// rows 3 and 4 the axes.
void OdeStep::set_hinge_rows(const Hinge& hinge, Row* rows, double erp_over_h) const {
  const Body& body0 = body(hinge.body0);
  const Vector3d arm0 = body0.rotation * hinge.anchor0;
  const Vector3d axis0 = body0.rotation * hinge.axis0;
  Vector3d arm1 = Vector3d::Zero();
  Vector3d anchor1 = hinge.anchor1;
  Vector3d axis1 = hinge.axis1;
  if (hinge.body1 != world) {
    const Body& body1 = body(hinge.body1);
    arm1 = body1.rotation * hinge.anchor1;
    anchor1 = arm1 + body1.position;
    axis1 = body1.rotation * hinge.axis1;
  }
  const Matrix3d lever0 = -cross_matrix(arm0);
  const Matrix3d lever1 = cross_matrix(arm1);
  const Vector3d apart = anchor1 - arm0 - body0.position;
  for (Index k = 0; k < 3; ++k) {
    Row& row = rows[k];
    row.j0 << Eigen::RowVector3d::Unit(k), lever0.row(k);
    row.j1 << -Eigen::RowVector3d::Unit(k), lever1.row(k);
    row.velocity = erp_over_h * apart[k];
  }
  Vector3d across[2];
  plane_space(axis0, across[0], across[1]);
  const Vector3d askew = axis0.cross(axis1);
  for (Index k = 0; k < 2; ++k) {
    Row& row = rows[3 + k];
    row.j0 << Eigen::RowVector3d::Zero(), across[k].transpose();
    row.j1 = -row.j0;
    row.velocity = erp_over_h * across[k].dot(askew);
  }
  for (Index k = 0; k < rows_of_hinge; ++k) {
    rows[k].body0 = hinge.body0;
    rows[k].body1 = hinge.body1;
  }
}

void OdeStep::set_contact_row(const Contact& contact, Row& row, double erp_over_h) const {
  const Vector3d& normal = contact.normal;
  row.body0 = contact.body0;
  row.body1 = contact.body1;
  const Vector3d arm0 = contact.position - body(contact.body0).position;
  row.j0 << normal.transpose(), arm0.cross(normal).transpose();
  row.j1.setZero();
  if (contact.body1 != world) {
    const Vector3d arm1 = contact.position - body(contact.body1).position;
    row.j1 << -normal.transpose(), normal.cross(arm1).transpose();
  }
  row.velocity =
      std::min(erp_over_h * std::max(0.0, contact.depth - settings_.surface_layer), settings_.max_correcting_vel);
  const double approach = -velocity_along(row);
  if (approach > settings_.bounce_vel) row.velocity = std::max(row.velocity, settings_.bounce * approach);
}

double OdeStep::velocity_along(const Row& row) const {
  const Body& body0 = body(row.body0);
  double along = row.j0.head<3>().dot(body0.velocity) + row.j0.tail<3>().dot(body0.spin);
  if (row.body1 != world) {
    const Body& body1 = body(row.body1);
    along += row.j1.head<3>().dot(body1.velocity) + row.j1.tail<3>().dot(body1.spin);
  }
  return along;
}

void OdeStep::set_system(double h) {
  const auto over_mass = [](const Row6& j, const Moving* body) -> Row6 {
    Row6 divided = Row6::Zero();
    if (body != nullptr) divided << j.head<3>() / body->now.mass, j.tail<3>() * body->inverse_inertia_world;
    return divided;
  };
  // J (v/h + M^-1 f) of one body.
  const auto pushed = [h](const Row6& j, const Moving* body) {
    if (body == nullptr) return 0.0;
    return j.head<3>().dot(body->now.velocity / h + body->force / body->now.mass) +
           j.tail<3>().dot(body->now.spin / h + body->inverse_inertia_world * body->torque);
  };
  for (Index i = 0; i < rows_; ++i) {
    Row& row = row_[static_cast<std::size_t>(i)];
    row.j0_over_mass = over_mass(row.j0, moving(row.body0));
    row.j1_over_mass = over_mass(row.j1, moving(row.body1));
    right_[i] = row.velocity / h - pushed(row.j0, moving(row.body0)) - pushed(row.j1, moving(row.body1));
    for (Index j = 0; j <= i; ++j) {
      const Row& other = row_[static_cast<std::size_t>(j)];
      double sum = 0;
      if (row.body0 == other.body0) sum += row.j0_over_mass.dot(other.j0);
      if (row.body0 == other.body1) sum += row.j0_over_mass.dot(other.j1);
      if (row.body1 != world && row.body1 == other.body0) sum += row.j1_over_mass.dot(other.j0);
      if (row.body1 != world && row.body1 == other.body1) sum += row.j1_over_mass.dot(other.j1);
      system_(i, j) = system_(j, i) = sum;
    }
    system_(i, i) += settings_.cfm / h;
  }
}

void OdeStep::move(double h) {
  for (Index i = 0; i < rows_; ++i) {
    const Row& row = row_[static_cast<std::size_t>(i)];
    Moving& body0 = bodies_[static_cast<std::size_t>(row.body0)];
    body0.force += row.j0.head<3>().transpose() * force_[i];
    body0.torque += row.j0.tail<3>().transpose() * force_[i];
    if (row.body1 == world) continue;
    Moving& body1 = bodies_[static_cast<std::size_t>(row.body1)];
    body1.force += row.j1.head<3>().transpose() * force_[i];
    body1.torque += row.j1.tail<3>().transpose() * force_[i];
  }
  for (Moving& moving : bodies_) {
    Body& body = moving.now;
    body.velocity += h / body.mass * moving.force;
    body.spin += h * (moving.inverse_inertia_world * moving.torque);
    body.position += h * body.velocity;
    const Quaterniond turning(0, body.spin.x(), body.spin.y(), body.spin.z());
    Quaterniond turned = body.orientation;
    turned.coeffs() += h / 2 * (turning * body.orientation).coeffs();
    turned.normalize();
    body.set_orientation(turned);
  }
}

}  // namespace odeval::reference::maximal
