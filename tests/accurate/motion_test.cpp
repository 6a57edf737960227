// The accurate step against motions known otherwise: order of convergence at least 3.9.
#include <array>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <complex>
#include <cstdio>
#include <functional>
#include <numbers>

#include "engines/ode_rk4/accurate_step.hpp"
#include "reference/cvode_solver.hpp"
#include "reference/planar/dual.hpp"
#include "tests/accurate/spatial_chain.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;

/// Checks that halving the step divides the error of `run` by 2^3.9 at least, twice, and that the finest is below
/// `at_most`.
void check_order(const char* what, const std::function<double(double h)>& error, double h, double at_most) {
  const std::array<double, 3> errors{error(h), error(h / 2), error(h / 4)};
  const double first = order(errors[0], errors[1], 2);
  const double second = order(errors[1], errors[2], 2);
  std::printf("%-28s %.3g %.3g %.3g: order %.2f, %.2f\n", what, errors[0], errors[1], errors[2], first, second);
  CHECK_BETWEEN(first, 3.9, 5.5);
  CHECK_BETWEEN(second, 3.9, 5.5);
  CHECK_BETWEEN(errors[2], 0, at_most);
}

/// Moves a world to t.
void run(World& world, double t, double h) {
  AccurateStep step(world.id, world.space);
  for (long k = 0; k < std::lround(t / h); ++k) step(h);
}

// Euler's equations of a free body in Jacobi elliptic functions (Landau & Lifshitz, Mechanics, 37): I1 < I2 < I3,
// L^2 > 2 E I2, w2(0) = 0.
double free_body(double h) {
  constexpr double t = 4;
  World world(Vector3d::Zero());
  const Vector3d spin(0.4, 0, 3);
  const dBodyID body =
      world.box(2, {1, 0.3, 0.1}, {0, 0, 1}, Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized())));
  dMass m;
  dBodyGetMass(body, &m);
  const double i1 = m.I[0], i2 = m.I[5], i3 = m.I[10];
  World::move(body, {0.1, 0.2, 0.3}, World::turn(body) * spin);
  const Vector3d angular = World::inertia(body) * vec(dBodyGetAngularVel(body));
  run(world, t, h);

  const double twice_e = i1 * spin[0] * spin[0] + i3 * spin[2] * spin[2];
  const double l2 = i1 * i1 * spin[0] * spin[0] + i3 * i3 * spin[2] * spin[2];
  CHECK(l2 > twice_e * i2 && i1 < i2 && i2 < i3);
  const double rate = std::sqrt((i3 - i2) * (l2 - twice_e * i1) / (i1 * i2 * i3));
  const double k = std::sqrt((i2 - i1) * (twice_e * i3 - l2) / ((i3 - i2) * (l2 - twice_e * i1)));
  double cn, dn;
  const double sn = boost::math::jacobi_elliptic(k, rate * t, &cn, &dn);
  const Vector3d wanted(spin[0] * cn, std::sqrt((twice_e * i3 - l2) / (i2 * (i3 - i2))) * sn, spin[2] * dn);
  const Vector3d w = World::turn(body).conjugate() * vec(dBodyGetAngularVel(body));
  // The body turns as its angular momentum keeps its direction in the world.
  const Vector3d kept = World::turn(body) * Vector3d(i1 * wanted[0], i2 * wanted[1], i3 * wanted[2]);
  return std::max((w - wanted).norm(), (kept - angular).norm());
}

/// A planar four-bar linkage: crank, coupler, rocker; three of its twenty joint equations repeat others.
struct FourBar {
  static constexpr double ground = 1.0, crank = 0.4, coupler = 1.1, rocker = 0.8, width = 0.1, g = 9.81;
  using Dual = odeval::reference::Dual<double, 1>;

  /// Angles of coupler and rocker at a crank angle.
  static std::array<double, 2> angles(double theta) {
    const std::complex<double> b = std::polar(crank, theta);
    const std::complex<double> to_d = ground - b;
    const double r = std::abs(to_d);
    const double at_b = std::acos((coupler * coupler + r * r - rocker * rocker) / (2 * coupler * r));
    const double phi = std::arg(to_d) + at_b;
    return {phi, std::arg(b + std::polar(coupler, phi) - ground)};
  }

  /// Angular acceleration by Lagrange's equation in the crank angle: m(t) t'' + m'(t) t'^2 / 2 + V'(t) = 0.
  static double acceleration(double theta, double rate) {
    const auto [phi_value, psi_value] = angles(theta);
    const Dual t(theta, 0);
    const double phi_rate = -crank * std::sin(theta - psi_value) / (coupler * std::sin(phi_value - psi_value));
    const double psi_rate = crank * std::sin(theta - phi_value) / (rocker * std::sin(psi_value - phi_value));
    const Dual phi = t.chain(phi_value, phi_rate);
    const Dual psi = t.chain(psi_value, psi_rate);
    // Rates by t, again as functions of t.
    const Dual phi1 = -(crank * sin(t - psi)) / (coupler * sin(phi - psi));
    const Dual psi1 = crank * sin(t - phi) / (rocker * sin(psi - phi));
    const auto inertia = [](double l) { return (l * l + width * width) / 12; };  // of 1 kg
    const Dual one(1.0);
    Dual mass = one * (inertia(crank) + crank * crank / 4) + psi1 * psi1 * (inertia(rocker) + rocker * rocker / 4) +
                phi1 * phi1 * inertia(coupler);
    // Centre of the coupler: crank e^it + coupler/2 e^i phi.
    const Dual y1 = -(crank * sin(t)) - coupler / 2 * phi1 * sin(phi);
    const Dual z1 = crank * cos(t) + coupler / 2 * phi1 * cos(phi);
    mass += y1 * y1 + z1 * z1;
    const Dual height = crank / 2 * sin(t) + (crank * sin(t) + coupler / 2 * sin(phi)) + rocker / 2 * sin(psi);
    return -(mass.slope[0] * rate * rate / 2 + g * height.slope[0]) / mass.value;
  }

  static double reference(double theta, double t) {
    odeval::reference::CvodeSolver solver(
        2, [](double, const double* y, double* f) { f[0] = y[1], f[1] = acceleration(y[0], y[1]); }, {1e-13, 1e-14},
        "four-bar", t);
    const std::array<double, 2> start{theta, 0};
    solver.start(0, start.data());
    while (solver.end() < t) solver.step();
    std::array<double, 2> y;
    solver.interpolate(t, y.data());
    return y[0];
  }

  /// In the y-z plane.
  static double error(double h) { return error_turned(h, Quaterniond::Identity()); }
  /// In a plane of space, where the equations that repeat others do so to rounding only.
  static double oblique_error(double h) {
    return error_turned(h, Quaterniond(Eigen::AngleAxisd(0.8, Vector3d(1, -2, 0.5).normalized())));
  }
  /// With a hinge built 0.1 mm ajar along the axes: what repeats contradicts. In its plane it moves as the closed one.
  static double ajar_error(double h) { return error_turned(h, Quaterniond::Identity(), 1e-4); }

  static double error_turned(double h, const Quaterniond& turn, double ajar = 0) {
    constexpr double start = 0.9, t = 1;
    World world(turn * Vector3d(0, 0, -g));
    const auto [phi, psi] = angles(start);
    const auto link = [&](double y, double z, double angle, double length) {
      const Vector3d along(0, std::cos(angle), std::sin(angle));
      return world.box(1, {0.1, length, width}, turn * (Vector3d(0, y, z) + length / 2 * along),
                       turn * Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitX())));
    };
    const auto hinge = [&](dBodyID a, dBodyID b, const Vector3d& at) {
      return world.hinge(a, b, turn * at, turn * Vector3d::UnitX());
    };
    const Vector3d b(0, crank * std::cos(start), crank * std::sin(start));
    const Vector3d c = b + coupler * Vector3d(0, std::cos(phi), std::sin(phi));
    const dBodyID one = link(0, 0, start, crank);
    const dBodyID two = link(b[1], b[2], phi, coupler);
    const dBodyID three = link(ground, 0, psi, rocker);
    const std::array<dJointID, 4> hinges{hinge(one, nullptr, {0, 0, 0}), hinge(one, two, b), hinge(two, three, c),
                                         hinge(three, nullptr, {0, ground, 0})};
    // The anchors are set on a body that is off by `ajar`: no pose brings those of all four hinges together.
    const Vector3d place = vec(dBodyGetPosition(three)), off = place + turn * Vector3d(ajar, 0, 0);
    const Vector3d d = turn * Vector3d(0, ground, 0);
    dBodySetPosition(three, off[0], off[1], off[2]);
    dJointSetHingeAnchor(hinges[3], d[0], d[1], d[2]);
    dBodySetPosition(three, place[0], place[1], place[2]);
    std::array<dJointFeedback, 4> forces{};
    for (std::size_t i = 0; i < 4; ++i) dJointSetFeedback(hinges[i], &forces[i]);
    run(world, t, h);
    for (const dJointFeedback& force : forces) {
      // What equations that say the same would share is undecided, but of the size of the others: 3 kg, some g.
      CHECK_BETWEEN(vec(force.f1).norm(), 1, 200);
    }
    double gap = 0;
    for (const dJointID joint : hinges) {
      dVector3 on_a, on_b;
      dJointGetHingeAnchor(joint, on_a);
      dJointGetHingeAnchor2(joint, on_b);
      gap += (vec(on_a) - vec(on_b)).norm();
    }
    CHECK_NEAR(gap, ajar, 1e-12);  // all of it across the plane, where equations were left out; rounding: 1e-15
    const Vector3d along = turn.conjugate() * (World::turn(one) * Vector3d::UnitY());
    static const double wanted = reference(start, t);
    const double angle = std::atan2(along[2], along[1]);
    return std::fabs(std::remainder(angle - wanted, 2 * std::numbers::pi));
  }
};

Eigen::Matrix3d box_inertia(double mass, const Vector3d& sides) {
  const Vector3d s = sides.cwiseProduct(sides);
  return (mass / 12 * Vector3d(s[1] + s[2], s[0] + s[2], s[0] + s[1])).asDiagonal();
}

/// Boxes in a row, each on a hinge (1 per joint), universal joint (2) or ball (3); axes differ from link to link; at
/// rest at first.
template <std::size_t Links, std::size_t PerJoint>
struct RowOfBoxes {
  static constexpr std::size_t n = Links * PerJoint;
  using Chain = SpatialChain<n>;
  static constexpr double mass = 1.2, g = 9.81;
  static inline const Vector3d sides{0.1, 0.3, 0.5};
  static inline const Vector3d near{0.02, -0.1, 0.25};  // of a box's hinge from its centre

  static Chain chain() {
    std::array<typename Chain::Hinge, n> hinges;
    for (std::size_t i = 0; i < n; ++i) {
      const bool first = i % PerJoint == 0;
      const bool last = i % PerJoint == PerJoint - 1;
      const auto d = static_cast<double>(i);
      hinges[i].axis = PerJoint == 3 ? Vector3d::Unit(static_cast<Eigen::Index>(i % 3))
                                     : Vector3d(std::cos(d), std::sin(2 * d), 0.7 - 0.3 * d).normalized();
      if (PerJoint == 2 && last) hinges[i].axis = hinges[i - 1].axis.unitOrthogonal();
      hinges[i].offset = i == 0 || !first ? Vector3d::Zero() : Vector3d(-2 * near);
      if (!last) continue;
      hinges[i].mass = mass;
      hinges[i].centre = -near;
      hinges[i].inertia = box_inertia(mass, sides);
    }
    return Chain(hinges, g);
  }

  /// Largest distance of a box's centre from where it should be, m, and of its axes.
  static double error(double h) {
    constexpr double t = 1;
    static const Chain lagrange = chain();
    typename Chain::Vector start = Chain::Vector::Zero();
    for (std::size_t i = 0; i < n; ++i) start[static_cast<Eigen::Index>(i)] = 0.9 - 0.3 * static_cast<double>(i % 4);
    static const auto wanted = lagrange.frames(lagrange.at(t, start, Chain::Vector::Zero()));

    World world({0, 0, -g});
    const auto frames = lagrange.frames(start);
    dBodyID before = nullptr;
    for (std::size_t link = 0; link < Links; ++link) {
      const auto& frame = frames[link * PerJoint + PerJoint - 1];
      const dBodyID body = world.box(mass, sides, frame.centre, Quaterniond(frame.turn));
      // Either order of the two bodies, and either place of the world.
      const bool child_first = (link + PerJoint) % 2 == 1;
      const dBodyID a = child_first ? body : before;
      const dBodyID b = child_first ? before : body;
      if (PerJoint == 3) {
        world.ball(a, b, frame.hinge);
      } else if (PerJoint == 2) {  // the parent keeps the first axis, the child the second
        const Vector3d parents = frames[link * PerJoint].axis;
        world.universal(a, b, frame.hinge, child_first ? frame.axis : parents, child_first ? parents : frame.axis);
      } else {
        world.hinge(a, b, frame.hinge, frame.axis);
      }
      before = body;
    }
    run(world, t, h);
    double worst = 0;
    for (std::size_t link = 0; link < Links; ++link) {
      const auto& frame = wanted[link * PerJoint + PerJoint - 1];
      const dBodyID body = world.bodies[link];
      worst = std::max(worst, (vec(dBodyGetPosition(body)) - frame.centre).norm());
      worst = std::max(worst, (World::turn(body).toRotationMatrix() - frame.turn).norm());
    }
    return worst;
  }
};

/// A box that slides along a rod on a hinge, beside it: Lagrange in the rod's angle from the horizontal y and the way
/// r.
///
///   T = (I + m (r^2 + d^2)) t'^2 / 2 + m r'^2 / 2 - m d t' r',  V = g (rod c + m r) sin t + g m d cos t
struct SlidingBox {
  static constexpr double rod = 2, half = 0.5, box = 0.7, beside = 0.3, g = 9.81;
  static constexpr double start_angle = 0.4, start_way = 0.6;
  static constexpr double inertia_of(double mass, double a, double b) { return mass * (a * a + b * b) / 12; }

  static void accelerations(double, const double* y, double* f) {
    const double t = y[0], r = y[1], t1 = y[2], r1 = y[3];
    const double inertia = inertia_of(rod, 2 * half, 0.1) + rod * half * half + inertia_of(box, 0.2, 0.1);
    const double m11 = inertia + box * (r * r + beside * beside), m12 = -box * beside, m22 = box;
    const double turning =
        -2 * box * r * r1 * t1 - g * (rod * half + box * r) * std::cos(t) + g * box * beside * std::sin(t);
    const double sliding = box * r * t1 * t1 - g * box * std::sin(t);
    const double det = m11 * m22 - m12 * m12;
    f[0] = t1, f[1] = r1;
    f[2] = (m22 * turning - m12 * sliding) / det;
    f[3] = (m11 * sliding - m12 * turning) / det;
  }

  /// The rod's angle and the way at the end.
  static std::array<double, 4> reference(double until) {
    odeval::reference::CvodeSolver solver(4, accelerations, {1e-13, 1e-14}, "sliding box", until);
    std::array<double, 4> y{start_angle, start_way, 0, 0};
    solver.start(0, y.data());
    while (solver.end() < until) solver.step();
    solver.interpolate(until, y.data());
    return y;
  }

  static Vector3d in_plane(double angle, double along, double across) {
    return {0, along * std::cos(angle) - across * std::sin(angle), along * std::sin(angle) + across * std::cos(angle)};
  }

  template <bool RodFirst>
  static double error(double h) {
    constexpr double until = 1;
    static const auto wanted = reference(until);
    World world({0, 0, -g});
    const Quaterniond turn(Eigen::AngleAxisd(start_angle, Vector3d::UnitX()));
    const dBodyID one = world.box(rod, {0.1, 2 * half, 0.1}, in_plane(start_angle, half, 0), turn);
    const dBodyID two = world.box(box, {0.1, 0.2, 0.1}, in_plane(start_angle, start_way, beside), turn);
    world.hinge(one, nullptr, {0, 0, 0}, Vector3d::UnitX());
    world.slider(RodFirst ? one : two, RodFirst ? two : one, turn * Vector3d::UnitY());
    run(world, until, h);
    return std::max((vec(dBodyGetPosition(one)) - in_plane(wanted[0], half, 0)).norm(),
                    (vec(dBodyGetPosition(two)) - in_plane(wanted[0], wanted[1], beside)).norm());
  }
};

}  // namespace

int main() {
  check_order("free asymmetric body", free_body, 8e-3, 1e-7);
  check_order("5 boxes, oblique hinges", RowOfBoxes<5, 1>::error, 4e-3, 1e-6);
  check_order("2 boxes, universal joints", RowOfBoxes<2, 2>::error, 4e-3, 1e-6);
  check_order("2 boxes, ball joints", RowOfBoxes<2, 3>::error, 4e-3, 1e-6);
  check_order("four-bar, a closed loop", FourBar::error, 8e-3, 1e-7);
  check_order("four-bar, oblique in space", FourBar::oblique_error, 8e-3, 1e-7);
  check_order("four-bar, built ajar", FourBar::ajar_error, 8e-3, 1e-7);
  check_order("a box slides on a rod", SlidingBox::error<true>, 8e-3, 1e-7);
  check_order("a rod slides on a box", SlidingBox::error<false>, 8e-3, 1e-7);
  return odeval::test::verdict();
}
