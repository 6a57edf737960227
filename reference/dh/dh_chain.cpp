#include "reference/dh/dh_chain.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>

namespace odeval::reference {
namespace {

KDL::Vector kdl(const Vec3& v) { return {v[0], v[1], v[2]}; }

KDL::RigidBodyInertia inertia_of(const DhLink& link) {
  const auto& i = link.inertia_kgm2;
  return KDL::RigidBodyInertia(link.mass_kg, kdl(link.centre_m),
                               KDL::RotationalInertia(i[0], i[1], i[2], i[3], i[4], i[5]));
}

// A segment turns about its joint and then ends in its tip frame, in which KDL has the inertia. With the modified
// convention the turn comes last, which is the same as a turn about the z of the tip frame before it.
KDL::Segment segment_of(DhConvention convention, const DhLink& link) {
  const bool standard = convention == DhConvention::standard;
  const KDL::Frame frame = standard ? KDL::Frame::DH(link.a_m, link.alpha_rad, link.d_m, link.offset_rad)
                                    : KDL::Frame::DH_Craig1989(link.a_m, link.alpha_rad, link.d_m, link.offset_rad);
  const KDL::Joint joint =
      standard ? KDL::Joint(KDL::Joint::RotZ) : KDL::Joint(frame.p, frame.M.UnitZ(), KDL::Joint::RotAxis);
  return KDL::Segment(joint, frame, inertia_of(link));
}

KDL::Chain chain_of(DhConvention convention, const std::vector<DhLink>& links) {
  KDL::Chain chain;
  for (const DhLink& link : links) chain.addSegment(segment_of(convention, link));
  return chain;
}

}  // namespace

// The solvers refer to the chain, so all of it stays in one place.
struct DhChain::Solvers {
  Solvers(DhConvention convention, const std::vector<DhLink>& links, const Vec3& gravity)
      : chain(chain_of(convention, links)),
        composite(chain, kdl(gravity)),
        newton_euler(chain, kdl(gravity)),
        q(chain.getNrOfJoints()),
        qd(chain.getNrOfJoints()),
        no_acceleration(chain.getNrOfJoints()),
        torque(chain.getNrOfJoints()),
        mass(chain.getNrOfJoints()),
        no_force(chain.getNrOfSegments()),
        factors(static_cast<Eigen::Index>(chain.getNrOfJoints())) {}

  std::size_t size() const { return chain.getNrOfJoints(); }

  void find_mass(const double* at) {
    std::copy_n(at, size(), q.data.data());
    composite.JntToMass(q, mass);
  }
  void find_bias(const double* at, const double* rate) {
    std::copy_n(at, size(), q.data.data());
    std::copy_n(rate, size(), qd.data.data());
    newton_euler.CartToJnt(q, qd, no_acceleration, no_force, torque);
  }

  KDL::Chain chain;
  KDL::ChainDynParam composite;
  KDL::ChainIdSolver_RNE newton_euler;
  KDL::JntArray q, qd, no_acceleration, torque;
  KDL::JntSpaceInertiaMatrix mass;
  KDL::Wrenches no_force;
  Eigen::LLT<Eigen::MatrixXd> factors;
};

DhChain::DhChain(DhConvention convention, const std::vector<DhLink>& links, const Vec3& gravity)
    : solvers_(std::make_unique<Solvers>(convention, links, gravity)) {}
DhChain::DhChain(DhChain&&) noexcept = default;
DhChain& DhChain::operator=(DhChain&&) noexcept = default;
DhChain::~DhChain() = default;

std::size_t DhChain::joints() const { return solvers_->size(); }

void DhChain::mass_matrix(const double* q, double* mass) {
  solvers_->find_mass(q);
  std::copy_n(solvers_->mass.data.data(), joints() * joints(), mass);  // symmetric: by columns is by rows
}

void DhChain::bias_forces(const double* q, const double* qd, double* bias) {
  solvers_->find_bias(q, qd);
  std::copy_n(solvers_->torque.data.data(), joints(), bias);
}

void DhChain::accelerations(const double* q, const double* qd, double* qdd) {
  solvers_->find_mass(q);
  solvers_->find_bias(q, qd);
  solvers_->factors.compute(solvers_->mass.data);
  Eigen::Map<Eigen::VectorXd> result(qdd, static_cast<Eigen::Index>(joints()));
  result = -solvers_->torque.data;
  solvers_->factors.solveInPlace(result);
}

std::vector<DhLink> pendulum_links(const PlanarView& view, DhConvention convention) {
  const bool standard = convention == DhConvention::standard;
  std::vector<DhLink> links;
  double length_before = 0;
  for (const Link& body : view.links) {
    DhLink link;
    link.mass_kg = body.mass_kg;
    // Frame i lies at the far end of link i, or at its hinge.
    link.a_m = standard ? body.length_m : length_before;
    link.centre_m = {standard ? -body.beyond_centre_m() : body.centre_m(), 0, 0};
    link.inertia_kgm2 = {body.inertia_along_kgm2(), body.inertia_across_kgm2(), body.inertia_kgm2(), 0, 0, 0};
    links.push_back(link);
    length_before = body.length_m;
  }
  return links;
}

Vec3 pendulum_gravity(const Scenario& scenario) {
  const PlanarFrame& frame = scenario.planar->frame;
  const Vec3 fall{0, 0, -scenario.gravity};
  return {dot(frame.horizontal, fall), dot(frame.up, fall), dot(frame.axis(), fall)};
}

}  // namespace odeval::reference
