#include "reference/maximal/gyroscopic_rounding.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace odeval::reference {
namespace {

using Eigen::Matrix3f;
using Eigen::Quaternionf;
using Eigen::Vector3d;
using Eigen::Vector3f;

Vector3d vector_of(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// I - h [L]x
Matrix3f leaning(const Matrix3f& inertia, const Vector3f& momentum, float h) {
  Matrix3f cross;
  cross << 0, -momentum.z(), momentum.y(), momentum.z(), 0, -momentum.x(), -momentum.y(), momentum.x(), 0;
  return inertia - h * cross;
}

/// The spin after a step, world frame.
Vector3f stepped(const Vector3f& spin, const Matrix3f& rotation, const Vector3f& moments, float h,
                 GyroscopicForm form) {
  const Matrix3f own = moments.asDiagonal();
  if (form == GyroscopicForm::in_body_frame) {
    const Vector3f momentum = moments.cwiseProduct(rotation.transpose() * spin);
    return rotation * (leaning(own, momentum, h).inverse() * momentum);
  }
  const Matrix3f inverse_own = moments.cwiseInverse().asDiagonal();
  const Matrix3f inertia = rotation * own * rotation.transpose();
  const Matrix3f inverse_inertia = rotation * inverse_own * rotation.transpose();
  const Vector3f momentum = inertia * spin;
  const Matrix3f inverse = leaning(inertia, momentum, h).inverse();  // adjugate over determinant, as in ODE
  Vector3f torque;
  if (form == GyroscopicForm::as_ode) {
    Matrix3f change = inertia * inverse;
    change -= Matrix3f::Identity();
    torque = change * (momentum / h);
  } else {
    const Vector3f after = inverse * momentum;
    torque = (inertia * after - momentum) / h;
  }
  return spin + inverse_inertia * (h * torque).eval();
}

}  // namespace

double long_axis_spin_in_single(const Body& body, double step_s, long steps, GyroscopicForm form) {
  const Vector3d turn = vector_of(rotation_vector(body.attitude));
  const double angle = turn.norm();
  Quaternionf attitude = Quaternionf::Identity();
  if (angle != 0) attitude = Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)).cast<float>();
  const Vector3f moments = vector_of(body.uniform_moments_kgm2()).cast<float>();
  const auto axis = static_cast<Eigen::Index>(body.long_axis());
  const auto h = static_cast<float>(step_s);
  Vector3f spin = vector_of(body.spin_rad_s).cast<float>();

  double most = 0;
  for (long k = 0; k < steps; ++k) {
    spin = stepped(spin, attitude.toRotationMatrix(), moments, h, form);
    if (!spin.allFinite()) return std::numeric_limits<double>::infinity();
    const Quaternionf rate = Quaternionf(0, spin.x(), spin.y(), spin.z()) * attitude;
    attitude.coeffs() += h / 2 * rate.coeffs();
    attitude.normalize();
    most = std::max(most, std::fabs(static_cast<double>(spin.dot(attitude.toRotationMatrix().col(axis)))));
  }
  return most;
}

}  // namespace odeval::reference
