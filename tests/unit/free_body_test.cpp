// A free body's rotation in closed form, against Euler's equations integrated in quad precision, against CVODE and
// against what it has to conserve.
#include "reference/closed_form/free_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "reference/closed_form/body_motion.hpp"
#include "reference/maximal/orientation.hpp"
#include "reference/planar/extrapolation.hpp"
#include "reference/planar/quad.hpp"
#include "tests/check.hpp"
#include "tests/oracle/body_reference.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;

/// Euler's equations in the body's frame, and its attitude as a quaternion. State: w1..w3, q0..q3.
struct EulersEquations {
  std::array<Quad, 3> moments;

  void operator()(const std::array<Quad, 7>& y, std::array<Quad, 7>& slope) const {
    const auto& [w1, w2, w3, q0, q1, q2, q3] = y;
    slope[0] = (moments[1] - moments[2]) / moments[0] * w2 * w3;
    slope[1] = (moments[2] - moments[0]) / moments[1] * w3 * w1;
    slope[2] = (moments[0] - moments[1]) / moments[2] * w1 * w2;
    slope[3] = (-q1 * w1 - q2 * w2 - q3 * w3) / 2;
    slope[4] = (q0 * w1 + q2 * w3 - q3 * w2) / 2;
    slope[5] = (q0 * w2 + q3 * w1 - q1 * w3) / 2;
    slope[6] = (q0 * w3 + q1 * w2 - q2 * w1) / 2;
  }
};

/// Attitude (nine numbers, by rows) and spin (in the world), started at rest in the world's axes.
struct Pose {
  std::array<double, 9> attitude;
  std::array<double, 3> spin;
};

Pose pose_of(const std::array<Quad, 7>& y) {
  const auto& [w1, w2, w3, a, b, c, d] = y;
  const std::array<Quad, 9> r{
      a * a + b * b - c * c - d * d, 2 * (b * c - a * d),           2 * (b * d + a * c),
      2 * (b * c + a * d),           a * a - b * b + c * c - d * d, 2 * (c * d - a * b),
      2 * (b * d - a * c),           2 * (c * d + a * b),           a * a - b * b - c * c + d * d};
  Pose pose;
  for (std::size_t k = 0; k < 9; ++k) pose.attitude[k] = static_cast<double>(r[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    pose.spin[k] = static_cast<double>(r[3 * k] * w1 + r[3 * k + 1] * w2 + r[3 * k + 2] * w3);
  }
  return pose;
}

struct Case {
  const char* name;
  Vec3 size;
  Vec3 spin;
};

double difference(const Pose& wanted, const FreeBody::Turning& turning) {
  double worst = 0;
  for (std::size_t k = 0; k < 9; ++k) worst = std::fmax(worst, std::fabs(turning.attitude[k] - wanted.attitude[k]));
  return worst;
}

double spin_difference(const Pose& wanted, const FreeBody::Turning& turning) {
  double worst = 0;
  for (std::size_t k = 0; k < 3; ++k) worst = std::fmax(worst, std::fabs(turning.spin_rad_s[k] - wanted.spin[k]));
  return worst;
}

void against_quad(const Case& given, test::Coverage& of_turns, test::Coverage& of_spins) {
  Scenario scenario;
  scenario.gravity = 0;
  scenario.mechanism.bodies = {Body{.shape = Box{given.size}, .mass_kg = 2, .spin_rad_s = given.spin}};
  const Vec3 moments = scenario.mechanism.bodies[0].uniform_moments_kgm2();
  const FreeBody body(moments, rotation_of({}), given.spin);
  const EulersEquations equations{{Quad(moments[0]), Quad(moments[1]), Quad(moments[2])}};

  // 20 digits with a margin: order 14, and spins of at most 12 rad/s.
  constexpr double h = 1.0 / 128;
  Extrapolation<Quad, 7> integrator(14);
  std::array<Quad, 7> y{given.spin[0], given.spin[1], given.spin[2], 1, 0, 0, 0};
  double worst = 0;
  constexpr int stride = 16;
  const Reference reference = solve_body_reference(scenario, {h, stride, 1280 / stride + 1});
  for (int k = 0; k <= 1280; ++k) {
    if (k > 0) integrator.advance(equations, y, Quad(h));
    if (k % stride != 0) continue;
    const FreeBody::Turning turning = body.at(k * h);
    const double off = difference(pose_of(y), turning);
    const std::size_t row = static_cast<std::size_t>(k / stride);
    worst = std::fmax(worst, off);
    of_turns.add(off, reference.uncertainty_turn[row]);
    of_spins.add(spin_difference(pose_of(y), turning), reference.uncertainty_spin[row]);
  }
  std::printf("%-40s off by %.2g (stated: %.2g rad at 10 s)\n", given.name, worst, reference.uncertainty_turn.back());
  CHECK_BETWEEN(worst, 0, 1e-13);  // 2.7e-14 measured at most: what two hundred turns leave of 2.2e-16
}

/// The centre, on a parabola.
void flight() {
  Scenario scenario;
  const Body body{
      .shape = Box{{0.1, 0.4, 0.9}}, .mass_kg = 2, .position_m = {0.3, -0.7, 1.1}, .velocity_m_s = {-2.1, 1.7, 8.3}};
  scenario.mechanism.bodies = {body};
  test::Coverage coverage("bodies in flight");
  for (long double t = 0.137L; t < 20; t += 0.37L) {
    const double rounded = static_cast<double>(t);
    std::array<long double, 3> centre;
    for (std::size_t k = 0; k < 3; ++k) {
      const long double rate = body.velocity_m_s[k];
      const long double pull = k == 2 ? scenario.gravity : 0;
      centre[k] = body.position_m[k] + rounded * (rate - pull * rounded / 2);
    }
    test::add_position(coverage, scenario, rounded, 0, centre);
  }
  coverage.check(0.25);
}

/// Exactly on the separatrix, and beside it by the last bits: the spin comes close to the middle axis and stays for
/// long. The moments are such that I3 (I3 - I2) w3^2 = I1 (I2 - I1) w1^2 holds in double precision.
void on_the_separatrix() {
  constexpr Vec3 moments{7, 8, 14};            // 84 w3^2 = 7 w1^2 has no solution in doubles
  constexpr Vec3 exact_moments{2, 20, 20.25};  // 81/16 w3^2 = 36 w1^2: w1 = 3/8 w3
  struct Near {
    Vec3 moments;
    Vec3 spin;
    double at_most = 1e-13;
  };
  // Beside it by 1e-6: L^2 - 2 E I2 is 2e-4 of terms of 324, so that rounding moves the next flip by 324/2e-4 bits,
  // 4e-10.
  for (const auto& [i, spin, at_most] :
       {Near{exact_moments, {3, 1, 8}}, Near{exact_moments, {-3, 1, 8}}, Near{exact_moments, {3, 0, -8}},
        Near{exact_moments, {3 + 1e-6, 1, 8}, 4e-10}, Near{moments, {std::sqrt(12.0), -0.5, 1}},
        Near{moments, {std::sqrt(12.0) * (1 - 1e-12), 0.5, 1}}}) {
    const FreeBody body(i, rotation_of({}), spin);
    const EulersEquations equations{{Quad(i[0]), Quad(i[1]), Quad(i[2])}};
    Extrapolation<Quad, 7> integrator(14);
    std::array<Quad, 7> y{spin[0], spin[1], spin[2], 1, 0, 0, 0};
    double worst = 0;
    for (int k = 1; k <= 1280; ++k) {
      integrator.advance(equations, y, Quad(1.0 / 256));
      worst = std::fmax(worst, difference(pose_of(y), body.at(k / 256.0)));
    }
    std::printf("on or beside the separatrix: off by %.2g\n", worst);
    CHECK_BETWEEN(worst, 0, at_most);
  }
}

/// Nothing drifts, however long: angular momentum in the world and energy, and the attitude stays a rotation.
void conserves() {
  constexpr Vec3 moments{0.8, 0.7, 0.15};
  constexpr Vec3 spin{0.1, 5, 0.1};
  const Rotation start = rotation_of({0.4, -1.1, 0.3});
  const FreeBody body(moments, start, turned(start, spin));
  for (const double t : {-0.5e-3, 0.0, 1.0, 100.0, 1e4, 1e5}) {
    const auto [attitude, world_spin] = body.at(t);
    const Vec3 own = turned_back(attitude, world_spin);
    const Vec3 angular = turned(attitude, {moments[0] * own[0], moments[1] * own[1], moments[2] * own[2]});
    const Vec3 wanted = turned(start, {moments[0] * spin[0], moments[1] * spin[1], moments[2] * spin[2]});
    double energy = 0;
    double start_energy = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK_NEAR(angular[k], wanted[k], 1e-14 * 3.5);  // |L| = 3.5
      CHECK_NEAR(dot(axis_of(attitude, k), axis_of(attitude, k)), 1, 1e-14);
      CHECK_NEAR(dot(axis_of(attitude, k), axis_of(attitude, (k + 1) % 3)), 0, 1e-14);
      energy += moments[k] * own[k] * own[k];
      start_energy += moments[k] * spin[k] * spin[k];
    }
    CHECK_NEAR(energy / start_energy, 1, 1e-14);
  }
}

/// A wrong rate of the quaternion would leave it a unit, and pointing anywhere.
void a_quaternion_keeps_its_way_to_second_order() {
  const auto error = [](double step_s) {
    const auto keeps = odeval::reference::Keeps::quaternion_normalised;
    return std::ranges::max(odeval::reference::keep_orientation(keeps, {}, step_s, 1, 10).error);
  };
  CHECK_BETWEEN(error(1e-3), 0, 1e-3);
  CHECK_BETWEEN(error(1e-3) / error(5e-4), 3.9, 4.1);
}

}  // namespace

int main() {
  const double rod = 1e-3;
  test::Coverage of_turns("attitudes");
  test::Coverage of_spins("spins");
  for (const Case& given : {
           Case{"tumbling box of the boxes benchmark", {0.1, 0.4, 0.9}, {0.1, 5.0, 0.1}},
           Case{"round the largest moment", {0.1, 0.4, 0.9}, {5, 0.3, -0.2}},
           Case{"round the largest moment, backwards", {0.1, 0.4, 0.9}, {-5, 0.3, -0.2}},
           Case{"round the least moment", {0.1, 0.4, 0.9}, {0.4, -0.3, 6}},
           Case{"round the least moment, backwards", {0.1, 0.4, 0.9}, {0.4, 0.3, -6}},
           Case{"other order of axes", {0.9, 0.1, 0.4}, {0.3, 4, -2}},
           Case{"yet another order", {0.4, 0.9, 0.1}, {2, -1, 3}},
           Case{"symmetric top, flat", {0.5, 0.5, 0.1}, {1, 2, 3}},
           Case{"symmetric top, long", {0.1, 0.1, 0.5}, {1, 2, 3}},
           Case{"sphere-like", {0.5, 0.5, 0.5}, {1, 2, 3}},
           Case{"along a principal axis", {0.1, 0.4, 0.9}, {0, 0, 5}},
           Case{"exactly along the middle axis", {0.1, 0.4, 0.9}, {0, 5, 0}},
           Case{"almost a symmetric top", {0.1, 0.1 + 1e-9, 0.5}, {1, 2, 3}},
           Case{"rod 1:1000", {rod, rod, 1}, {5, 0, 1}},
           Case{"rod 1:1000, sides 1:2, long axis small", {rod, 2 * rod, 1}, {5, 3, 0.1}},
           Case{"rod 1:1000, sides 1:2, across", {rod, 2 * rod, 1}, {5, 0.1, 0.01}},
           Case{"rod 1:1000, sides 1:2, spinning", {rod, 2 * rod, 1}, {0.1, 0.2, 10}},
           Case{"rod 1:1000, sides almost equal", {rod, rod * (1 + 1e-6), 1}, {5, 3, 0.1}},
           Case{"plate 1:1000", {rod, 0.5, 1}, {1, 4, 2}},
       }) {
    against_quad(given, of_turns, of_spins);
  }
  of_turns.check(0.49);
  of_spins.check(0.26);
  flight();
  on_the_separatrix();
  conserves();
  a_quaternion_keeps_its_way_to_second_order();
  return test::verdict();
}
