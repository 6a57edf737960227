#include "reference/maximal/orientation.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

namespace odeval::reference {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Matrix3d exact(const Precession& motion, double t) {
  return (AngleAxisd(motion.precession * t, Vector3d::UnitZ()) * AngleAxisd(motion.tilt, Vector3d::UnitX()) *
          AngleAxisd(motion.spin * t, Vector3d::UnitZ()))
      .toRotationMatrix();
}

Vector3d spin_of(const Precession& motion, double t) {
  const Vector3d axis = AngleAxisd(motion.precession * t, Vector3d::UnitZ()) *
                        (AngleAxisd(motion.tilt, Vector3d::UnitX()) * Vector3d::UnitZ());
  return motion.precession * Vector3d::UnitZ() + motion.spin * axis;
}

class Matrix {
 public:
  explicit Matrix(const Matrix3d& start) : r_(start) {}
  void turn(const Vector3d& spin, double h) {
    for (int k = 0; k < 3; ++k) r_.col(k) += h * spin.cross(r_.col(k));
  }
  Matrix3d rotation() const { return r_; }

 protected:
  Matrix3d r_;
};

class OrthonormalMatrix : public Matrix {
 public:
  using Matrix::Matrix;
  void turn(const Vector3d& spin, double h) {
    Matrix::turn(spin, h);
    r_.col(0).normalize();
    r_.col(1) = (r_.col(1) - r_.col(0).dot(r_.col(1)) * r_.col(0)).normalized();
    r_.col(2) = r_.col(0).cross(r_.col(1));
  }
};

class Quaternion {
 public:
  explicit Quaternion(const Matrix3d& start) : q_(start) {}
  void turn(const Vector3d& spin, double h) {
    q_.coeffs() += h / 2 * (Quaterniond(0, spin.x(), spin.y(), spin.z()) * q_).coeffs();
  }
  /// As if q were a unit.
  Matrix3d rotation() const { return q_.toRotationMatrix(); }

 protected:
  Quaterniond q_;
};

class UnitQuaternion : public Quaternion {
 public:
  using Quaternion::Quaternion;
  void turn(const Vector3d& spin, double h) {
    Quaternion::turn(spin, h);
    q_.normalize();
  }
};

/// The one place that turns the name of a way into its type.
template <class Do>
auto with(Keeps keeps, const Matrix3d& start, const Do& act) {
  switch (keeps) {
    case Keeps::matrix:
      return act(Matrix(start));
    case Keeps::matrix_orthonormal:
      return act(OrthonormalMatrix(start));
    case Keeps::quaternion:
      return act(Quaternion(start));
    case Keeps::quaternion_normalised:
      break;
  }
  return act(UnitQuaternion(start));
}

double squeeze_of(const Matrix3d& r) { return (r.transpose() * r - Matrix3d::Identity()).cwiseAbs().maxCoeff(); }

/// From the sine of the angle, which keeps its digits where the angle is small.
double angle_between(const Matrix3d& r, const Matrix3d& truth) {
  const Eigen::JacobiSVD<Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d apart = svd.matrixU() * svd.matrixV().transpose() * truth.transpose();
  const Vector3d twice_sine(apart(2, 1) - apart(1, 2), apart(0, 2) - apart(2, 0), apart(1, 0) - apart(0, 1));
  return std::atan2(twice_sine.norm(), apart.trace() - 1);
}

}  // namespace

Kept keep_orientation(Keeps keeps, const Precession& motion, double step_s, double duration_s, int rows) {
  const long stride = std::lround(duration_s / step_s) / rows;
  return with(keeps, exact(motion, 0), [&](auto way) {
    Kept kept;
    long steps = 0;
    for (int row = 0; row < rows; ++row) {
      for (long k = 0; k < stride; ++k) {
        way.turn(spin_of(motion, (static_cast<double>(steps) + 0.5) * step_s), step_s);
        ++steps;
      }
      const double t = static_cast<double>(steps) * step_s;
      const Matrix3d r = way.rotation();
      kept.t.push_back(t);
      kept.squeeze.push_back(squeeze_of(r));
      kept.error.push_back(angle_between(r, exact(motion, t)));
    }
    return kept;
  });
}

double turn(Keeps keeps, double step_s, long steps) {
  const Vector3d spin = spin_of({}, 0);
  return with(keeps, Matrix3d::Identity(), [&](auto way) {
    double entries = 0;
    for (long k = 0; k < steps; ++k) {
      way.turn(spin, step_s);
      entries += way.rotation()(0, 1);  // a body's matrix is wanted in each step: for its inertia, its joints
    }
    return entries;
  });
}

}  // namespace odeval::reference
