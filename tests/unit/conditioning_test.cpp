// Condition numbers and manipulability, against dense matrices built another way and against numbers worked by hand.
#include "measure/conditioning.hpp"

#include <Eigen/Dense>
#include <array>
#include <numbers>
#include <random>

#include "measure/planar_chain.hpp"
#include "model/generate.hpp"
#include "model/problems.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

Vector3d vector(const Vec3& v) { return {v[0], v[1], v[2]}; }

double condition_1(const MatrixXd& matrix) {
  const auto norm = [](const MatrixXd& m) { return m.cwiseAbs().colwise().sum().maxCoeff(); };
  return norm(matrix) * norm(matrix.fullPivLu().inverse());
}

Scenario uneven(const Problem& problem, std::size_t links) {
  Scenario scenario;
  const Link all[] = {{1.7, 0.8, 0.25, 0.06}, {0.6, 1.3, 0.05, 0.4}, {2.2, 0.5, 0.3, 0.2}};
  put_planar(scenario,
             {problem.frame, std::vector(all, all + links), std::vector(links, 0.0), std::vector(links, 0.0), {}});
  scenario.step_s = 2e-3;
  scenario.ode.cfm = 3e-4;
  return scenario;
}

/// The report's links in their place.
void put_equal_links(Scenario& scenario, std::size_t links) {
  const std::vector<double> zeros(links);
  put_planar(scenario, {scenario.planar->frame, std::vector(links, Link{1, 1, 0.1, 0.1}), zeros, zeros, {}});
}

/// A trace of one row.
struct Pose {
  std::vector<double> q;
  std::vector<Matrix3d> turns;  // body to world
};

Trace trace_of(const Pose& pose) {
  Trace trace;
  trace.t = {0};
  for (const double q : pose.q) trace.q.push_back({q});
  for (const Matrix3d& turn : pose.turns) {
    BodyColumns& body = trace.bodies.emplace_back();
    for (std::size_t d = 0; d < 9; ++d) body.rotation[d] = {turn(Eigen::Index(d / 3), Eigen::Index(d % 3))};
  }
  return trace;
}

double condition(const Pose& pose, const Scenario& scenario, SystemMatrix matrix) {
  Trace trace = trace_of(pose);
  add_conditioning(trace, scenario, matrix);
  return trace.condition.at(0);
}

// Columns along, across and third axis of the links. In the plane the third is the axis without a rounding, as ODE
// leaves it.
Pose planar_pose(const Scenario& scenario, std::mt19937& random) {
  const PlanarFrame& frame = scenario.planar->frame;
  Matrix3d body;
  body << vector(frame.along_body), vector(frame.across_body), vector(cross(frame.along_body, frame.across_body));
  std::uniform_real_distribution<double> any(-std::numbers::pi, std::numbers::pi);
  Pose pose;
  double angle = 0;
  for (std::size_t i = 0; i < scenario.planar->links.size(); ++i) {
    pose.q.push_back(any(random));
    angle += pose.q.back();
    Matrix3d world;
    world << std::cos(angle) * vector(frame.horizontal) + std::sin(angle) * vector(frame.up),
        std::cos(angle) * vector(frame.up) - std::sin(angle) * vector(frame.horizontal), vector(frame.axis());
    pose.turns.push_back(world * body.transpose());
  }
  return pose;
}

Pose spatial_pose(const Scenario& scenario, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Pose pose = planar_pose(scenario, random);
  for (Matrix3d& turn : pose.turns) {
    turn = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
  }
  return pose;
}

// ode-0.16-internals.md, A3: the two directions across the axis, as printed there.
std::array<Vector3d, 2> across(const Vector3d& n) {
  if (std::fabs(n.z()) > std::sqrt(0.5)) {
    const double r = std::hypot(n.y(), n.z());
    const Vector3d p(0, -n.z() / r, n.y() / r);
    return {p, Vector3d(r, -n.x() * p.z(), n.x() * p.y())};
  }
  const double r = std::hypot(n.x(), n.y());
  const Vector3d p(-n.y() / r, n.x() / r, 0);
  return {p, Vector3d(-n.z() * p.y(), n.z() * p.x(), r)};
}

/// The hinges' system column by column: a unit velocity or spin of one body at a time, and the relative motion of
/// anchors and axes that it makes; M^-1 by a dense inverse.
MatrixXd dense_system(const Scenario& scenario, const Pose& pose, bool plane_only) {
  const PlanarFrame& frame = scenario.planar->frame;
  const auto n = static_cast<Eigen::Index>(scenario.planar->links.size());
  const Eigen::Index each = plane_only ? 2 : 5;
  MatrixXd jacobian(each * n, 6 * n);
  MatrixXd mass = MatrixXd::Zero(6 * n, 6 * n);
  const Vector3d hinge_body = vector(frame.along_body).cross(vector(frame.across_body)) *
                              vector(frame.hinge_axis).dot(vector(frame.horizontal).cross(vector(frame.up)));
  for (Eigen::Index b = 0; b < n; ++b) {
    const Link& link = scenario.planar->links[static_cast<std::size_t>(b)];
    const Vector3d sides = (link.length_m * vector(frame.along_body) + link.width_m * vector(frame.across_body) +
                            link.depth_m * vector(frame.along_body).cross(vector(frame.across_body)))
                               .cwiseAbs();
    const Vector3d squares = sides.cwiseAbs2();
    const Vector3d inertia = link.mass_kg / 12 * (Vector3d::Constant(squares.sum()) - squares);
    const Matrix3d& turn = pose.turns[static_cast<std::size_t>(b)];
    mass.block<3, 3>(6 * b, 6 * b) = link.mass_kg * Matrix3d::Identity();
    mass.block<3, 3>(6 * b + 3, 6 * b + 3) = turn * inertia.asDiagonal() * turn.transpose();
  }
  for (Eigen::Index column = 0; column < 6 * n; ++column) {
    std::vector<Vector3d> v(static_cast<std::size_t>(n), Vector3d::Zero());
    std::vector<Vector3d> w = v;
    (column % 6 < 3 ? v : w)[static_cast<std::size_t>(column / 6)] = Vector3d::Unit(column % 3);
    const auto end_velocity = [&](std::size_t link, double side) -> Vector3d {
      const Vector3d arm =
          pose.turns[link] * vector(frame.along_body) * (side * scenario.planar->links[link].length_m / 2);
      return v[link] + w[link].cross(arm);
    };
    for (std::size_t hinge = 0; hinge < static_cast<std::size_t>(n); ++hinge) {
      Vector3d apart = end_velocity(hinge, -1);
      Vector3d turning = w[hinge];
      if (hinge > 0) {
        apart = end_velocity(hinge - 1, +1) - apart;  // the parent is ODE's first body
        turning = w[hinge - 1] - turning;
      }
      const auto row = each * static_cast<Eigen::Index>(hinge);
      if (plane_only) {
        jacobian(row, column) = apart.dot(vector(frame.horizontal));
        jacobian(row + 1, column) = apart.dot(vector(frame.up));
        continue;
      }
      jacobian.block<3, 1>(row, column) = apart;
      const auto directions = across(pose.turns[hinge == 0 ? 0 : hinge - 1] * hinge_body);
      jacobian(row + 3, column) = turning.dot(directions[0]);
      jacobian(row + 4, column) = turning.dot(directions[1]);
    }
  }
  MatrixXd system = jacobian * mass.inverse() * jacobian.transpose();
  if (!plane_only) system.diagonal().array() += scenario.ode.cfm / scenario.step_s;
  return system;
}

// Both sides round; a condition number of 1e4 makes 1e-16 into 1e-12.
constexpr double rounding = 1e-11;

void hinge_rows_are_those_of_a_dense_system() {
  std::mt19937 random(1);
  for (const Problem& problem : {problems[0], problems[2]}) {  // both frames
    for (const std::size_t links : {1u, 2u, 3u}) {
      const Scenario scenario = uneven(problem, links);
      for (int k = 0; k < 50; ++k) {
        const Pose planar = planar_pose(scenario, random);
        const double wanted = condition_1(dense_system(scenario, planar, false));
        CHECK_NEAR(condition(planar, scenario, SystemMatrix::hinge_rows_cfm) / wanted, 1, rounding);
        Scenario hard = scenario;
        hard.ode.cfm = 0;
        CHECK_EQUAL(condition(planar, scenario, SystemMatrix::hinge_rows),
                    condition(planar, hard, SystemMatrix::hinge_rows_cfm));
        const double in_plane = condition_1(dense_system(scenario, planar, true));
        CHECK_NEAR(condition(planar, scenario, SystemMatrix::planar_joints) / in_plane, 1, rounding);

        const Pose spatial = spatial_pose(scenario, random);
        CHECK_NEAR(condition(spatial, scenario, SystemMatrix::hinge_rows_cfm) /
                       condition_1(dense_system(scenario, spatial, false)),
                   1, rounding);
      }
    }
  }
}

// The blocks of a pose in the plane and the whole matrix say the same: 1e-13 off the plane is not "in it", and changes
// the condition by about that much times the condition itself.
void planar_and_spatial_agree() {
  std::mt19937 random(2);
  for (const std::size_t links : {1u, 2u, 3u}) {
    const Scenario scenario = uneven(problems[1], links);
    Pose pose = planar_pose(scenario, random);
    const double planar = condition(pose, scenario, SystemMatrix::hinge_rows_cfm);
    pose.turns[0] = Eigen::AngleAxisd(1e-13, Vector3d::UnitY()) * pose.turns[0];
    const double spatial = condition(pose, scenario, SystemMatrix::hinge_rows_cfm);
    CHECK_NEAR(spatial / planar, 1, 1e-8);
  }
}

// The 2-norm, by singular values, bounds the 1-norm from both sides.
void the_norms_bound_each_other() {
  std::mt19937 random(3);
  const Scenario scenario = uneven(problems[1], 2);
  for (int k = 0; k < 50; ++k) {
    const Pose pose = spatial_pose(scenario, random);
    const Eigen::VectorXd values = dense_system(scenario, pose, false).jacobiSvd().singularValues();
    const double two = values(0) / values(values.size() - 1);
    CHECK_BETWEEN(condition(pose, scenario, SystemMatrix::hinge_rows_cfm), two * (1 - rounding), 10 * two);
  }
}

// The report's D.2: its numbers, not ours.
void mass_matrix_is_the_reports() {
  Scenario scenario = uneven(problems[1], 2);
  put_equal_links(scenario, 2);
  for (const double q2 : {-3.0, -std::numbers::pi / 4, 0.0, 1.0, std::numbers::pi / 2, 3.1}) {
    MatrixXd d(2, 2);
    d << 1001.0 / 600 + std::cos(q2), std::cos(q2) / 2 + 401.0 / 1200,  //
        std::cos(q2) / 2 + 401.0 / 1200, 401.0 / 1200;
    CHECK_NEAR(condition({{0.7, q2}, {}}, scenario, SystemMatrix::mass_matrix) / condition_1(d), 1, rounding);
  }
  const Scenario one = uneven(problems[0], 1);
  CHECK_EQUAL(condition({{0.7}, {}}, one, SystemMatrix::mass_matrix), 1.0);
}

/// Columns of the geometric Jacobian of a point of link `link`, at `share` of its length, in space.
MatrixXd geometric_jacobian(const Scenario& scenario, const std::vector<double>& q, std::size_t link, double share) {
  const auto n = static_cast<Eigen::Index>(q.size());
  std::vector<Vector3d> hinges{Vector3d::Zero()};
  double angle = 0;
  Vector3d point;
  for (std::size_t i = 0; i <= link; ++i) {
    angle += q[i];
    const Vector3d along(std::cos(angle), std::sin(angle), 0);
    point = hinges[i] + (i == link ? share : 1) * scenario.planar->links[i].length_m * along;
    hinges.push_back(point);
  }
  MatrixXd jacobian = MatrixXd::Zero(6, n);
  for (Eigen::Index i = 0; i <= static_cast<Eigen::Index>(link); ++i) {
    jacobian.block<3, 1>(0, i) = Vector3d::UnitZ().cross(point - hinges[static_cast<std::size_t>(i)]);
    jacobian(5, i) = 1;
  }
  return jacobian;
}

void generalized_matrices_are_those_of_a_dense_jacobian() {
  std::mt19937 random(4);
  for (const std::size_t links : {2u, 3u}) {
    const Scenario scenario = uneven(problems[1], links);
    for (int k = 0; k < 50; ++k) {
      const std::vector<double> q = planar_pose(scenario, random).q;
      const auto n = static_cast<Eigen::Index>(links);
      MatrixXd mass = MatrixXd::Zero(n, n);
      for (std::size_t i = 0; i < links; ++i) {
        const MatrixXd j = geometric_jacobian(scenario, q, i, 0.5);
        mass += scenario.planar->links[i].mass_kg * j.topRows(3).transpose() * j.topRows(3) +
                scenario.planar->links[i].inertia_kgm2() * j.bottomRows(3).transpose() * j.bottomRows(3);
      }
      CHECK_NEAR(condition({q, {}}, scenario, SystemMatrix::mass_matrix) / condition_1(mass), 1, rounding);

      Trace trace = trace_of({q, {}});
      add_conditioning(trace, scenario, SystemMatrix::none);
      CHECK(trace.condition.empty());
      const Eigen::VectorXd values = geometric_jacobian(scenario, q, links - 1, 1).jacobiSvd().singularValues();
      const double ratio = values(n - 1) / values(0);
      CHECK_NEAR(trace.manipulability.at(0), ratio * ratio, 1e-13);
    }
  }
}

double manipulability(const std::vector<double>& q) {
  Scenario scenario = uneven(problems[1], 2);
  put_equal_links(scenario, q.size());
  Trace trace = trace_of({q, {}});
  add_conditioning(trace, scenario, SystemMatrix::mass_matrix);
  return trace.manipulability.at(0);
}

// By hand, links of 1 m: J^T J = [3 + 2 cos q2, 2 + cos q2; 2 + cos q2, 2].
// Straight: [5 3; 3 2], eigenvalues (7 +- sqrt 45) / 2. The position rows alone, [4 2; 2 1], would be singular; the
// angular rows keep the least eigenvalue from 0. Folded: [1 1; 1 2], (3 +- sqrt 5) / 2. A single link has one
// eigenvalue.
void manipulability_at_known_poses() {
  CHECK_NEAR(manipulability({0.3, 0}), (7 - std::sqrt(45.0)) / (7 + std::sqrt(45.0)), 1e-15);
  CHECK_NEAR(manipulability({-2, std::numbers::pi}), (3 - std::sqrt(5.0)) / (3 + std::sqrt(5.0)), 1e-15);
  CHECK_NEAR(manipulability({9, std::numbers::pi / 2}), (5 - std::sqrt(17.0)) / (5 + std::sqrt(17.0)), 1e-15);
  CHECK_EQUAL(manipulability({0.3}), 1.0);
}

}  // namespace

int main() {
  hinge_rows_are_those_of_a_dense_system();
  planar_and_spatial_agree();
  the_norms_bound_each_other();
  mass_matrix_is_the_reports();
  generalized_matrices_are_those_of_a_dense_jacobian();
  manipulability_at_known_poses();
  return odeval::test::verdict();
}
