#include "model/mend_start.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace odeval {
namespace {

using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Vector3d vector(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// Unit directions at right angles to these, which are so to each other.
std::vector<Vec3> across(const std::vector<Vec3>& free) {
  std::vector<Vec3> all = free;
  while (all.size() < 3) {
    Vec3 best{};
    for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      Vec3 left = axis;
      for (int twice = 0; twice < 2; ++twice) {
        for (const Vec3& other : all) left = left - dot(left, other) * other;
      }
      if (dot(left, left) > dot(best, best)) best = left;
    }
    all.push_back(unit(best));
  }
  all.erase(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(free.size()));
  return all;
}

Matrix3 inertia_in_world(const Body& body) {
  Matrix3 own = Matrix3::Zero();
  if (body.inertia_kgm2) {
    own = Eigen::Map<const Matrix3>(body.inertia_kgm2->data());
  } else {
    own.diagonal() = vector(body.uniform_moments_kgm2());
  }
  const Rotation turn = rotation_of_vector(rotation_vector(body.attitude));
  const Eigen::Map<const Matrix3> r(turn.data());
  return r * own * r.transpose();
}

/// What shall be 0, or a rate, by rows of velocity and spin of each body in turn, scaled by the roots of mass and
/// inertia: a change of length 1 then has the same kinetic energy whatever it is of.
class Rows {
 public:
  explicit Rows(const Mechanism& mechanism) : mechanism_(mechanism) {
    for (const Body& body : mechanism.bodies) roots_.push_back(inertia_in_world(body).llt().matrixL());
  }

  void add(const Joint& joint, bool slides, const Vec3& axis, const Vec3& at_m, double wanted) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(size());
    double is = add_body(row, joint.carried(), 1, slides, axis, at_m);
    if (joint.second) is += add_body(row, joint.first, -1, slides, axis, at_m);
    const double norm = row.norm();
    rows_.push_back(row / norm);
    lacks_.push_back((wanted - is) / norm);
  }

  /// The least change, velocity and spin of each body in turn.
  Eigen::VectorXd change() const {
    Eigen::MatrixXd a(static_cast<Eigen::Index>(rows_.size()), size());
    for (std::size_t i = 0; i < rows_.size(); ++i) a.row(static_cast<Eigen::Index>(i)) = rows_[i].transpose();
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(1e-10);  // what loops hold twice is a row to rounding
    solver.compute(a);
    Eigen::VectorXd change =
        solver.solve(Eigen::Map<const Eigen::VectorXd>(lacks_.data(), static_cast<Eigen::Index>(lacks_.size())));
    for (std::size_t i = 0; i < roots_.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(6 * i);
      change.segment<3>(at) /= std::sqrt(mechanism_.bodies[i].mass_kg);
      change.segment<3>(at + 3) = roots_[i].transpose().template triangularView<Eigen::Upper>().solve(
          Eigen::Vector3d(change.segment<3>(at + 3)));
    }
    return change;
  }

 private:
  Eigen::Index size() const { return static_cast<Eigen::Index>(6 * mechanism_.bodies.size()); }

  /// What the row is of the body as it moves.
  double add_body(Eigen::VectorXd& row, std::size_t number, double sign, bool slides, const Vec3& axis,
                  const Vec3& at_m) const {
    const Body& body = mechanism_.bodies[number];
    const Vec3 of_velocity = slides ? sign * axis : Vec3{};
    const Vec3 of_spin = sign * (slides ? cross(at_m - body.position_m, axis) : axis);
    const auto at = static_cast<Eigen::Index>(6 * number);
    row.segment<3>(at) += vector(of_velocity) / std::sqrt(body.mass_kg);
    row.segment<3>(at + 3) +=
        roots_[number].template triangularView<Eigen::Lower>().solve(Eigen::Vector3d(vector(of_spin)));
    return dot(of_velocity, body.velocity_m_s) + dot(of_spin, body.spin_rad_s);
  }

  const Mechanism& mechanism_;
  std::vector<Matrix3> roots_;  // lower, of the inertia about the centre of mass along the world's axes
  std::vector<Eigen::VectorXd> rows_;
  std::vector<double> lacks_;
};

}  // namespace

double rate_of(const Mechanism& mechanism, const HeldRate& of) {
  const Joint& joint = mechanism.joints[of.joint];
  const auto along = [&](const Body& body) {
    const Vec3 velocity = body.velocity_m_s + cross(body.spin_rad_s, of.at_m - body.position_m);
    return dot(of.axis, of.slides ? velocity : body.spin_rad_s);
  };
  return along(mechanism.bodies[joint.carried()]) - (joint.second ? along(mechanism.bodies[joint.first]) : 0);
}

ChangedVelocities mend_velocities(Mechanism& mechanism, std::span<const HeldRate> held) {
  Rows rows(mechanism);
  for (const Joint& joint : mechanism.joints) {
    const Freedom free = freedom_of(joint.kind);
    const Vec3& anchor = anchor_m(joint.kind);
    for (const Vec3& axis : across(free.ways)) rows.add(joint, true, axis, anchor, 0);
    for (const Vec3& axis : across(free.turns)) rows.add(joint, false, axis, anchor, 0);
  }
  for (const HeldRate& one : held) {
    rows.add(mechanism.joints[one.joint], one.slides, one.axis, one.at_m, one.rate);
  }
  const Eigen::VectorXd change = rows.change();
  ChangedVelocities told;
  double most_energy = 0;
  for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
    Body& body = mechanism.bodies[i];
    const auto at = static_cast<Eigen::Index>(6 * i);
    const Vec3 velocity{change[at], change[at + 1], change[at + 2]};
    const Vec3 spin{change[at + 3], change[at + 4], change[at + 5]};
    const double energy =
        (body.mass_kg * dot(velocity, velocity) + vector(spin).dot(inertia_in_world(body) * vector(spin))) / 2;
    body.velocity_m_s = body.velocity_m_s + velocity;
    body.spin_rad_s = body.spin_rad_s + spin;
    told.speed_m_s = std::fmax(told.speed_m_s, length(velocity));
    told.spin_rad_s = std::fmax(told.spin_rad_s, length(spin));
    if (energy > most_energy) {
      most_energy = energy;
      told.body = i;
    }
  }
  return told;
}

void mend_drawn_velocities(Mechanism& mechanism, MendedStart& mended) {
  double fastest = 0;
  for (const Body& body : mechanism.bodies) {
    fastest = std::max({fastest, length(body.velocity_m_s), length(body.spin_rad_s)});
  }
  bool parts = false;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    const Misfit misfit = misfit_of(mechanism, joint);
    const double most = std::fmax(misfit.speed_m_s, misfit.spin_rad_s);
    if (most <= allowed_misfit(mechanism)) continue;
    parts = true;
    if (most <= mended_share * fastest && mechanism.bodies.size() <= most_mended) continue;
    const std::string parent = joint.second ? mechanism.bodies[joint.first].name : "world";
    throw BadStart(
        j, "",
        fmt::format("does not allow the velocity and spin with which bodies.{} '{}' starts beside '{}': they part by "
                    "{:.3g} m/s and {:.3g} rad/s",
                    joint.carried(), mechanism.bodies[joint.carried()].name, parent, misfit.speed_m_s,
                    misfit.spin_rad_s));
  }
  if (!parts) return;
  const ChangedVelocities changed = mend_velocities(mechanism);
  mended.speed_m_s = changed.speed_m_s;
  mended.spin_rad_s = changed.spin_rad_s;
  mended.body = mechanism.bodies[changed.body].name;
  mend_velocities(mechanism);  // rounding of the first
}

}  // namespace odeval
