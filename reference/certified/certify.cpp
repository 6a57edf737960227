// Writes the certified trajectories of this folder: odeval-certify NAME OUT.csv
//
// Each is integrated three times: by lagrange-quad at two step sizes in quad precision (34 digits), and at another
// order and step in 50 digits. The largest differences stand in the head of the file; digits beyond them are noise.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <fstream>
#include <iostream>
#include <string>
#include <string_view>

#include "odeval/error.hpp"
#include "reference/certified/motions.hpp"
#include "reference/planar/equations.hpp"
#include "reference/planar/extrapolation.hpp"
#include "reference/planar/quad.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;
using Fifty = boost::multiprecision::cpp_bin_float_50;

constexpr const SampleGrid& grid = certified_grid;
constexpr int fifty_order = 20;
constexpr int fifty_substeps = 4;
constexpr int digits_after_point = 26;

/// Largest angle difference of a run in 50 digits, rad.
double difference_to_fifty_digits(const Scenario& scenario, const QuadRun& run) {
  const ChainEquations<Fifty, 2> equations(scenario);
  Extrapolation<Fifty, 4> extrapolation(fifty_order);
  const PlanarView& view = *scenario.planar;
  std::array<Fifty, 4> y{view.q0[0], view.q0[1], view.qd0[0], view.qd0[1]};
  double largest = 0;
  for (long row = 1; row < grid.rows; ++row) {
    const Fifty step = (Fifty(grid.time(row)) - Fifty(grid.time(row - 1))) / fifty_substeps;
    for (int k = 0; k < fifty_substeps; ++k) extrapolation.advance(equations, y, step);
    for (std::size_t i = 0; i < 2; ++i) {
      const Fifty quad(run.rows[static_cast<std::size_t>(row)][i]);
      largest = std::max(largest, static_cast<double>(abs(y[i] - quad)));
    }
  }
  return largest;
}

std::string head(const CertifiedMotion& motion, const QuadRun& run) {
  std::string text = fmt::format(
      "# Certified trajectory of a double pendulum: {}.\n"
      "# Made by: odeval-certify {} reference/certified/{}.csv\n"
      "# The parameters are exactly the doubles next to these decimals: gravity {} m/s^2\n",
      motion.why, motion.name, motion.name, motion.gravity);
  for (const Link& link : motion.links) {
    text += fmt::format("# link: mass {} kg, length {} m, width {} m (in the plane of swing), depth {} m\n",
                        link.mass_kg, link.length_m, link.width_m, link.depth_m);
  }
  text += fmt::format("# q0 = [{}, {}] rad, qd0 = [{}, {}] rad/s; the times are the doubles k * 0.01 s\n", motion.q0[0],
                      motion.q0[1], motion.qd0[0], motion.qd0[1]);
  text += fmt::format(
      "# Extrapolated midpoint rule of order {} in quad precision, steps of {:.4g} ms; with steps twice as long the "
      "angles differ by at most {:.1e} rad.\n",
      quad_order, 1e3 * run.step_s, run.largest_difference);
  text +=
      fmt::format("# From a run of order {} in 50 digits, steps of {:.4g} ms, they differ by at most {:.1e} rad.\n",
                  fifty_order, 1e3 * grid.step_s / fifty_substeps, difference_to_fifty_digits(motion.scenario(), run));
  return text;
}

void certify(std::string_view name, const std::string& path) {
  const auto motion = std::find_if(certified_motions.begin(), certified_motions.end(),
                                   [&](const CertifiedMotion& m) { return m.name == name; });
  if (motion == certified_motions.end()) {
    std::string names;
    for (const CertifiedMotion& m : certified_motions) names += fmt::format(" {}", m.name);
    throw UserError(fmt::format("no motion named '{}'; there are:{}", name, names));
  }
  const QuadRun run = solve_quad(motion->scenario(), grid);
  std::string text = head(*motion, run) + "t,q1,q2,qd1,qd2\n";
  for (long row = 0; row < grid.rows; ++row) {
    text += fmt::format("{}", grid.time(row));
    for (const Quad& value : run.rows[static_cast<std::size_t>(row)]) {
      text += ',' + value.str(digits_after_point, std::ios_base::scientific);
    }
    text += '\n';
  }
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) throw MachineError(fmt::format("could not write '{}'", path));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw UserError("usage: odeval-certify NAME OUT.csv");
  certify(argv[1], argv[2]);
} catch (const UserError& error) {
  std::cerr << "odeval-certify: " << error.what() << '\n';
  return 2;
} catch (const std::exception& error) {
  std::cerr << "odeval-certify: " << error.what() << '\n';
  return 3;
}
