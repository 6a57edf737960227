#include "reference/tree/simbody_system.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <set>
#include <variant>

#include "reference/tree/simbody_numbers.hpp"

namespace odeval::reference {
namespace {

/// One of so many equal parts of a body, or the whole.
SimTK::Body::Rigid rigid(const Body& body, double parts) {
  const Vec3 moments = body.uniform_moments_kgm2();
  const std::array<double, 9> i =
      body.inertia_kgm2.value_or(std::array{moments[0], 0.0, 0.0, 0.0, moments[1], 0.0, 0.0, 0.0, moments[2]});
  const SimTK::Inertia whole(i[0], i[4], i[8], i[1], i[2], i[5]);
  if (parts == 1) return SimTK::Body::Rigid({body.mass_kg, SimTK::Vec3(0), whole});
  return SimTK::Body::Rigid({body.mass_kg / parts, SimTK::Vec3(0), whole / parts});
}

/// Of the weld that closes a loop.
constexpr int equations_of_a_loop = 6;

/// A constraint that others imply up to this, of the largest, is one of them.
constexpr double implied = 1e-9;

}  // namespace

Eigen::VectorXd Loops::least(const Eigen::VectorXd& change) const {
  const Eigen::VectorXd ordered = factors.colsPermutation().transpose() * change;
  Eigen::VectorXd speeds = Eigen::VectorXd::Zero(factors.rows());
  speeds.head(rank) = factors.matrixR()
                          .topLeftCorner(rank, rank)
                          .template triangularView<Eigen::Upper>()
                          .transpose()
                          .solve(ordered.head(rank));
  speeds.applyOnTheLeft(factors.householderQ());
  return speeds;
}

SimbodySystem::SimbodySystem(Mechanism of, std::vector<Branch> order, double pull)
    : mechanism(std::move(of)), tree(std::move(order)), gravity(pull), bodies(mechanism.bodies.size()) {
  if (gravity != 0) SimTK::Force::Gravity(loads, matter, SimTK::Vec3(0, 0, -gravity));
  for (const Branch& branch : tree) add(branch);
  for (const Joint& joint : mechanism.joints) {
    if (joint.driven() && !pushes) pushes.emplace(loads, matter);
  }
  for (const Strut& strut : mechanism.struts) add(strut);
  all.realizeTopology();
  state = all.getDefaultState();
  for (const Branch& branch : tree) {
    if (!branch.joint) bodies[branch.body].setQToFitTransform(state, place_of(mechanism.bodies[branch.body]));
  }
  all.realize(state, SimTK::Stage::Position);
  for (std::size_t i = 0; i < tree.size(); ++i) set_speed(tree[i], hung[i]);
  for (SimTK::MobilizedBodyIndex i(1); i < matter.getNumBodies(); ++i) {
    const SimTK::MobilizedBody& body = matter.getMobilizedBody(i);
    for (SimTK::MobilizerUIndex u(0); u < body.getNumU(state); ++u) moved_by.emplace_back(body, u);
  }
  sort_speeds_by_loops();
}

void SimbodySystem::sort_speeds_by_loops() {
  std::vector<LoopsOfSpeed> speeds;
  for (int speed = 0; speed < matter.getNumMobilities(); ++speed) speeds.push_back({speed, {}});
  for (std::size_t loop = 0; loop < loops.welded.size(); ++loop) {
    const int first = static_cast<int>(loop) * equations_of_a_loop;
    for (SimTK::MobilizedBody body : loops.welded[loop]) {
      for (; !body.isGround(); body = body.getParentMobilizedBody()) {
        const int from = int(body.getFirstUIndex(state));
        for (int k = 0; k < body.getNumU(state); ++k) {
          std::vector<int>& of = speeds[static_cast<std::size_t>(from + k)].first_equations;
          if (of.empty() || of.back() != first) of.push_back(first);
        }
      }
    }
  }
  std::vector<std::set<int>> taken;  // loops of each group
  for (LoopsOfSpeed& speed : speeds) {
    const std::vector<int>& of = speed.first_equations;
    if (of.empty()) continue;
    const auto meets = [&](const std::set<int>& group) {
      return std::any_of(of.begin(), of.end(), [&](int loop) { return group.count(loop) > 0; });
    };
    std::size_t group = 0;
    while (group < taken.size() && meets(taken[group])) ++group;
    if (group == taken.size()) {
      taken.emplace_back();
      loops.apart.emplace_back();
    }
    taken[group].insert(of.begin(), of.end());
    loops.apart[group].push_back(std::move(speed));
  }
}

Eigen::MatrixXd SimbodySystem::jacobian_of_loops() const {
  Eigen::MatrixXd by_speeds = Eigen::MatrixXd::Zero(matter.getNumMobilities(), loops.equations);
  SimTK::Vector bias;
  matter.calcBiasForMultiplyByG(state, bias);
  for (const std::vector<LoopsOfSpeed>& group : loops.apart) {
    SimTK::Vector speeds(matter.getNumMobilities(), 0.0);
    for (const LoopsOfSpeed& one : group) speeds[one.speed] = 1;
    SimTK::Vector opening;
    matter.multiplyByG(state, speeds, bias, opening);
    for (const LoopsOfSpeed& one : group) {
      for (const int first : one.first_equations) {
        for (int k = first; k < first + equations_of_a_loop; ++k) by_speeds(one.speed, k) = opening[k];
      }
    }
  }
  return by_speeds;
}

void SimbodySystem::realize(const double* y, SimTK::Stage stage) {
  SimTK::Vector& numbers = state.updY();
  for (int i = 0; i < numbers.size(); ++i) numbers[i] = y[i];
  all.realize(state, stage);
}

void SimbodySystem::find_loops() {
  const std::vector<double> now = numbers(state.getQ());
  if (loops.equations == 0 || now == loops.coordinates) return;
  loops.coordinates = now;
  loops.factors.setThreshold(implied);
  loops.factors.compute(jacobian_of_loops());
  if (loops.rank < 0) loops.rank = loops.factors.rank();
  const Eigen::Index rank = loops.rank;
  loops.closure.free = Eigen::MatrixXd::Zero(loops.factors.rows(), loops.factors.rows() - rank);
  loops.closure.free.bottomRows(loops.factors.rows() - rank).setIdentity();
  loops.closure.free.applyOnTheLeft(loops.factors.householderQ());
  const Eigen::VectorXd open = eigen(state.getQErr()).head(loops.equations);
  loops.closure.error = open.cwiseAbs().maxCoeff();
  loops.closure.mend = loops.least(-open);
  loops.closure.implied = rank < loops.equations;
  const auto holds = loops.factors.matrixR().diagonal().head(rank).cwiseAbs();
  loops.closure.margin = holds.minCoeff() / holds.maxCoeff();
  loops.closure.gain = 1 / holds.minCoeff();
}

SimTK::Vector SimbodySystem::accelerate(const Eigen::VectorXd& least, const SimTK::Vector& along,
                                        const SimTK::Vector_<SimTK::SpatialVec>& on_bodies) const {
  SimTK::Vector left_over;
  matter.calcResidualForceIgnoringConstraints(state, along, on_bodies, simbody(least), left_over);
  return simbody(least - freely(eigen(left_over)));
}

Eigen::VectorXd SimbodySystem::freely(const Eigen::VectorXd& forces) const {
  const Eigen::MatrixXd& free = loops.closure.free;
  Eigen::MatrixXd mass(free.rows(), free.cols());
  for (Eigen::Index j = 0; j < free.cols(); ++j) {
    SimTK::Vector column;
    matter.multiplyByM(state, simbody(free.col(j)), column);
    mass.col(j) = eigen(column);
  }
  return free * (free.transpose() * mass).llt().solve(free.transpose() * forces);
}

SimTK::Vector SimbodySystem::gained_by(const SimTK::Vector& impulse) {
  find_loops();
  if (loops.equations > 0) return simbody(freely(eigen(impulse)));
  SimTK::Vector gained;
  matter.multiplyByMInv(state, impulse, gained);
  return gained;
}

SimTK::Transform SimbodySystem::place_of_parent(const Branch& branch) const {
  return branch.parent ? place_of(mechanism.bodies[*branch.parent]) : SimTK::Transform();
}

double SimbodySystem::parts_of(std::size_t body) const {
  double parts = 0;
  for (const Branch& branch : tree) parts += branch.body == body ? 1 : 0;
  return parts;
}

void SimbodySystem::add(const Branch& branch) {
  const Body& what = mechanism.bodies[branch.body];
  const SimTK::Body::Rigid body = rigid(what, parts_of(branch.body));
  SimTK::MobilizedBody ground = matter.updGround();
  if (!branch.joint) {
    bodies[branch.body] = SimTK::MobilizedBody::Free(ground, body);
    hung.push_back({{bodies[branch.body]}, {SimTK::Rotation()}});
    return;
  }
  const Joint& joint = mechanism.joints[*branch.joint];
  SimTK::MobilizedBody& parent = branch.parent ? bodies[*branch.parent] : ground;
  hung.push_back(
      hang({parent, place_of_parent(branch), joint.first == branch.body}, body, place_of(what), joint.kind, loads));
  SimTK::MobilizedBody& made = hung.back().bodies.back();
  if (branch.again) {
    SimTK::Constraint::Weld(bodies[branch.body], made);
    loops.welded.push_back({bodies[branch.body], made});
    loops.equations += equations_of_a_loop;
  } else {
    bodies[branch.body] = made;
  }
}

void SimbodySystem::add(const Strut& strut) {
  const SimTK::MobilizedBody& first = bodies[strut.first];
  const SimTK::MobilizedBody& ground = matter.updGround();
  const SimTK::MobilizedBody& second = strut.second ? bodies[*strut.second] : ground;
  const SimTK::Vec3 first_end = ~place_of(mechanism.bodies[strut.first]) * simbody(strut.first_end_m);
  const SimTK::Transform second_place = strut.second ? place_of(mechanism.bodies[*strut.second]) : SimTK::Transform();
  const SimTK::Vec3 second_end = ~second_place * simbody(strut.second_end_m);
  SimTK::Force::TwoPointLinearSpring(loads, first, first_end, second, second_end, strut.stiffness_N_m, strut.rest_m);
  SimTK::Force::TwoPointLinearDamper(loads, first, first_end, second, second_end, strut.damping_Ns_m);
}

/// What the joint leaves of the body's velocity against that of its parent.
void SimbodySystem::set_speed(const Branch& branch, const Chain& chain) {
  const Body& what = mechanism.bodies[branch.body];
  const Body world{};
  const Body& parent = branch.parent ? mechanism.bodies[*branch.parent] : world;
  const JointKind* const kind = branch.joint ? &mechanism.joints[*branch.joint].kind : nullptr;
  const bool by_centre = kind == nullptr || std::holds_alternative<PlaneJoint>(*kind);
  const Vec3 anchor = by_centre ? what.position_m : anchor_m(*kind);
  const auto velocity = [&](const Body& of) { return of.velocity_m_s + cross(of.spin_rad_s, anchor - of.position_m); };
  const SimTK::SpatialVec relative(simbody(what.spin_rad_s - parent.spin_rad_s),
                                   simbody(velocity(what) - velocity(parent)));
  for (std::size_t i = 0; i < chain.bodies.size(); ++i) {
    const SimTK::Rotation frame = chain.turned[i] * chain.bodies[i].getInboardFrame(state).R();
    chain.bodies[i].setUToFitVelocity(state, ~frame * relative);
  }
}

}  // namespace odeval::reference
