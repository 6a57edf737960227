#pragma once
// Vectors and rotations of ours as Simbody's, and the other way round. C++17, as simbody_tree.hpp.
#include <Simbody.h>

#include <Eigen/Core>
#include <vector>

#include "odeval/mechanism.hpp"
#include "reference/closed_form/rotation.hpp"

namespace odeval::reference {

inline SimTK::Vec3 simbody(const Vec3& v) { return {v[0], v[1], v[2]}; }
inline Vec3 ours(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

inline Rotation ours(const SimTK::Rotation& r) {
  const SimTK::Vec3 x = r.getAxisUnitVec(SimTK::XAxis);
  const SimTK::Vec3 y = r.getAxisUnitVec(SimTK::YAxis);
  const SimTK::Vec3 z = r.getAxisUnitVec(SimTK::ZAxis);
  return {x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]};
}

inline SimTK::Rotation simbody(const Rotation& r) {
  return {SimTK::Mat33(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]), true};  // true: as it is
}

/// Where a body stands at t = 0.
inline SimTK::Transform place_of(const Body& body) {
  return {simbody(rotation_of(rotation_vector(body.attitude))), simbody(body.position_m)};
}

inline std::vector<double> numbers(const SimTK::Vector& vector) {
  std::vector<double> all;
  for (int i = 0; i < vector.size(); ++i) all.push_back(vector[i]);
  return all;
}

inline Eigen::VectorXd eigen(const SimTK::Vector& vector) {
  Eigen::VectorXd all(vector.size());
  for (int i = 0; i < vector.size(); ++i) all[i] = vector[i];
  return all;
}

inline SimTK::Vector simbody(const Eigen::VectorXd& vector) {
  SimTK::Vector all(static_cast<int>(vector.size()));
  for (int i = 0; i < all.size(); ++i) all[i] = vector[i];
  return all;
}

}  // namespace odeval::reference
