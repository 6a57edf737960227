#pragma once
// Chains of revolute joints from Denavit-Hartenberg parameters, moved by recursive Newton-Euler (Orocos KDL).
//
// Report, Appendix A. Frame i is fixed to link i; from frame i-1 to frame i one turns and slides
//
//   standard   Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha)   frame i lies on the axis of joint i+1: a and alpha are
//                                                                those of link i
//   modified   Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)   frame i lies on the axis of joint i (Craig 1989): a
//   and
//                                                                alpha are those of link i-1
//
// with theta = q + offset. Joint i turns about z of frame i-1 (standard) or of frame i (modified).
#include <array>
#include <memory>
#include <vector>

#include "odeval/scenario.hpp"

namespace odeval::reference {

enum class DhConvention { standard, modified };

struct DhLink {
  double a_m = 0;
  double alpha_rad = 0;
  double d_m = 0;
  double offset_rad = 0;
  double mass_kg = 0;
  Vec3 centre_m{};                       // centre of mass, in the link's frame
  std::array<double, 6> inertia_kgm2{};  // about the centre of mass, axes of the link's frame: xx, yy, zz, xy, xz, yz
};

/// n joints. After the constructor nothing is allocated any more.
class DhChain {
 public:
  /// `gravity` is the acceleration of free fall in the base frame, m/s².
  DhChain(DhConvention convention, const std::vector<DhLink>& links, const Vec3& gravity);
  DhChain(DhChain&&) noexcept;
  DhChain& operator=(DhChain&&) noexcept;
  ~DhChain();

  std::size_t joints() const;

  /// M(q), n x n by rows, kg m² (composite rigid bodies).
  void mass_matrix(const double* q, double* mass);
  /// C(q, qd) qd + g(q): the joint torques that keep the rates as they are, N m (recursive Newton-Euler).
  void bias_forces(const double* q, const double* qd, double* bias);
  /// M qdd = -bias, rad/s². The joints are free.
  void accelerations(const double* q, const double* qd, double* qdd);

 private:
  struct Solvers;
  std::unique_ptr<Solvers> solvers_;
};

/// A planar pendulum of boxes as such a chain: a = length, alpha = d = 0. Base frame: x along the plane's `horizontal`,
/// y along its `up`, z along its axis, so that joint angles are the scenario's own.
std::vector<DhLink> pendulum_links(const PlanarView& view, DhConvention convention);
Vec3 pendulum_gravity(const Scenario& scenario);

}  // namespace odeval::reference
