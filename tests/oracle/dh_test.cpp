// Recursive Newton-Euler from Denavit-Hartenberg parameters (DhChain) is Lagrange's equations: on random chains in
// space, in both conventions, and on the planar pendulums of the scenarios.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "reference/dh/dh_chain.hpp"
#include "reference/dh/dh_ode45.hpp"
#include "reference/planar/equations.hpp"
#include "reference/planar/generalized_trace.hpp"
#include "reference/planar/ode45.hpp"
#include "reference/planar/ode45_simulation.hpp"
#include "tests/check.hpp"
#include "tests/oracle/lagrangian_chain.hpp"
#include "tests/recorded.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;
using test::LagrangianChain;

constexpr DhConvention conventions[] = {DhConvention::standard, DhConvention::modified};

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  /// About the centre of mass, of points, so that it is one a body can have, with all products of inertia.
  std::array<double, 6> inertia(double mass) {
    std::array<double, 6> sum{};
    for (int point = 0; point < 4; ++point) {
      const double x = between(-0.3, 0.3), y = between(-0.3, 0.3), z = between(-0.3, 0.3);
      const double part = mass / 4;
      const std::array<double, 6> of_point{y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z};
      for (std::size_t k = 0; k < 6; ++k) sum[k] += part * of_point[k];
    }
    return sum;
  }

  DhLink link() {
    DhLink link;
    link.a_m = between(-0.6, 0.6);
    link.alpha_rad = between(-3, 3);
    link.d_m = between(-0.6, 0.6);
    link.offset_rad = between(-3, 3);
    link.mass_kg = between(0.5, 3);
    link.centre_m = {between(-0.4, 0.4), between(-0.4, 0.4), between(-0.4, 0.4)};
    link.inertia_kgm2 = inertia(link.mass_kg);
    return link;
  }

 private:
  std::mt19937 random_;
};

template <std::size_t N>
struct RandomChain {
  RandomChain(DhConvention convention, unsigned seed) : convention_(convention) {
    Draw draw(seed);
    for (std::size_t i = 0; i < N; ++i) links_.push_back(draw.link());
    gravity_ = {draw.between(-10, 10), draw.between(-10, 10), draw.between(-10, 10)};
    for (std::size_t i = 0; i < N; ++i) {
      start_[i] = draw.between(-3, 3);
      start_[N + i] = draw.between(-1, 1);
    }
  }
  DhChain recursive() const { return DhChain(convention_, links_, gravity_); }
  LagrangianChain<N> lagrangian() const { return {convention_, links_, gravity_}; }

  DhConvention convention_;
  std::vector<DhLink> links_;
  Vec3 gravity_;
  std::array<double, 2 * N> start_;
};

template <std::size_t Size>
double largest(const std::array<double, Size>& values) {
  double most = 0;
  for (const double value : values) most = std::max(most, std::fabs(value));
  return most;
}

template <std::size_t N>
void check_coefficients(const RandomChain<N>& random) {
  DhChain chain = random.recursive();
  const LagrangianChain<N> lagrangian = random.lagrangian();
  std::array<double, N> q, qd;
  std::copy_n(random.start_.begin(), N, q.begin());
  std::copy_n(random.start_.begin() + N, N, qd.begin());

  std::array<double, N * N> mass;
  chain.mass_matrix(q.data(), mass.data());
  const auto wanted_mass = lagrangian.mass_matrix(q);
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; j < N; ++j) {
      // Rounding of sums of some tens of terms as large as the largest entry; measured 2.7e-15.
      CHECK_NEAR(mass[i * N + j] / largest(mass), wanted_mass[i][j] / largest(mass), 1e-12);
    }
  }
  std::array<double, N> bias;
  chain.bias_forces(q.data(), qd.data(), bias.data());
  const auto wanted_bias = lagrangian.bias_forces(random.start_);
  for (std::size_t i = 0; i < N; ++i) {
    CHECK_NEAR(bias[i] / largest(wanted_bias), wanted_bias[i] / largest(wanted_bias), 1e-12);
  }
  std::array<double, N> acceleration;
  chain.accelerations(q.data(), qd.data(), acceleration.data());
  std::array<double, 2 * N> slope;
  lagrangian(random.start_, slope);
  for (std::size_t i = 0; i < N; ++i) {
    // As above, times the condition of the mass matrix, up to some tens here; measured 1.1e-14.
    CHECK_NEAR(acceleration[i] / largest(slope), slope[N + i] / largest(slope), 1e-12);
  }
}

template <class Equations>
test::Recorded moved(Equations equations, const typename Equations::State& start, double duration, double rtol,
                     double atol) {
  const SampleGrid grid{0.01, 1, std::lround(duration / 0.01) + 1};
  Ode45<Equations> simulation(std::move(equations), grid, start, rtol, atol);
  test::Recorded run = test::recorded(simulation, grid);
  CHECK(!run.outcome.diverged);
  CHECK_EQUAL(run.motion.size(), static_cast<std::size_t>(grid.rows));
  return run;
}

template <std::size_t N>
void check_motion(const RandomChain<N>& random) {
  for (const auto& [rtol, atol] : {std::pair(ode45_rtol, ode45_atol), std::pair(1e-9, 1e-12)}) {
    const auto recursive = moved(DhEquations<N>(random.recursive()), random.start_, 2.0, rtol, atol);
    const auto lagrangian = moved(random.lagrangian(), random.start_, 2.0, rtol, atol);
    const double difference = test::largest_difference(recursive.motion, lagrangian.motion, recursive.motion.size());
    std::printf("%zu links, %s, rtol %g: %ld steps, %.2g rad\n", N,
                random.convention_ == DhConvention::standard ? "standard" : "modified", rtol, recursive.outcome.steps,
                difference);
    // The same steps, so that what is left is rounding and its growth within two seconds.
    CHECK_EQUAL(recursive.outcome.steps, lagrangian.outcome.steps);
    CHECK_EQUAL(recursive.outcome.evaluations, lagrangian.outcome.evaluations);
    CHECK(difference <= 1e-9);
  }
}

template <std::size_t N>
void check_random_chains() {
  for (const DhConvention convention : conventions) {
    for (unsigned seed = 1; seed <= 20; ++seed) check_coefficients(RandomChain<N>(convention, seed));
    for (unsigned seed = 1; seed <= 2; ++seed) check_motion(RandomChain<N>(convention, seed));
  }
}

// The planar pendulum as a chain, in both conventions, has the coefficients of the hand-derived equations. Unequal
// links in a state of motion, in both planes of the scenarios.
void check_pendulums() {
  for (const char* name : {"single_pendulum", "double_pendulum", "wall_pendulum"}) {
    Scenario scenario = test::report_scenario(name, 1.0, 1e-3);
    const std::size_t n = scenario.planar->links.size();
    change_planar(scenario, [n](PlanarView& view) {
      view.links[0] = {1.3, 0.8, 0.12, 0.05};
      if (n == 2) view.links[1] = {0.7, 1.4, 0.07, 0.2};
    });
    std::vector<double> q{0.4, -1.9}, qd{2.1, -3.3}, acceleration(2);
    q.resize(n);
    qd.resize(n);
    const double inertia = with_equations(scenario, [&]<class Equations>(const Equations& equations) {
      typename Equations::State y{};
      y[Equations::dof] = 1;  // the kinetic energy of a unit rate of joint 1 is M_11 / 2
      std::copy_n(q.begin(), n, y.begin());
      return 2 * equations.kinetic(y);
    });
    const std::vector<double> wanted = joint_accelerations(scenario, q, qd);
    for (const DhConvention convention : conventions) {
      DhChain chain(convention, pendulum_links(*scenario.planar, convention), pendulum_gravity(scenario));
      std::vector<double> mass(n * n);
      chain.mass_matrix(q.data(), mass.data());
      chain.accelerations(q.data(), qd.data(), acceleration.data());
      CHECK_NEAR(mass[0] / inertia, 1.0, 1e-12);
      for (std::size_t i = 0; i < n; ++i) CHECK_NEAR(acceleration[i], wanted[i], 1e-12 * (1 + std::fabs(wanted[i])));
    }
  }
}

// The two formulations differ by rounding of about 1e-16 a step, which the motion makes grow: at the report's
// tolerances, whose run is another and a wilder motion than the true one, by 1e7 in 5 s. Durations are such that the
// difference stays below 1e-9: measured 6.0e-10, 3.4e-10 and 5.6e-10 rad.
void check_double_pendulum() {
  struct Case {
    double rtol, atol, duration;
  };
  for (const Case& at : {Case{1e-3, 1e-6, 5}, Case{1e-9, 1e-12, 8}, Case{1e-12, 1e-14, 10}}) {
    Scenario scenario = test::report_scenario("double_pendulum", 10.0, 1e-2);
    scenario.rtol = at.rtol;
    scenario.atol = at.atol;
    const auto lagrange = test::recorded(make_ode45, scenario, sample_grid(scenario));
    const auto dh = test::recorded(make_dh_ode45, scenario, sample_grid(scenario));
    CHECK_EQUAL(dh.outcome.steps, lagrange.outcome.steps);
    const auto samples = static_cast<std::size_t>(std::lround(at.duration / 0.01)) + 1;
    const double difference = test::largest_difference(dh.motion, lagrange.motion, samples);
    std::printf("double pendulum, rtol %g until %g s: %ld steps, %.2g rad\n", at.rtol, at.duration, dh.outcome.steps,
                difference);
    CHECK(difference <= 1e-9);
  }
}

}  // namespace

int main() {
  check_random_chains<3>();
  check_random_chains<4>();
  check_random_chains<5>();
  check_random_chains<6>();
  check_pendulums();
  check_double_pendulum();
  return test::verdict();
}
