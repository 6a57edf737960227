#include "engines/ode_rk4/restitution.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "engines/ode_rk4/complementarity.hpp"

namespace odeval::engine_rk4 {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Indices = std::vector<Eigen::Index>;

// Of the fastest speed: a contact that closes more slowly does so by rounding.
constexpr double rounding = 1e-12;
// Of the fastest: contacts whose speeds differ by less close equally fast.
constexpr double tie = 1e-9;
// Change of a contact's speed by its own impulse, of the fastest speed: rounding of it is 1e-12 then.
constexpr double largest = 1e4;
// Elastic rows end after as many rounds as they have contacts, light balls between heavy ones after pi times the root
// of the ratio of masses; lossy ones that never end are as good as at rest by then.
constexpr int most_rounds = 1000;

std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

/// At these speeds.
VectorXd bounce(const Restitution& restitution, const VectorXd& now) {
  return (now.array() <= -restitution.rest_speed).select(restitution.of, 0);
}

/// Contacts that say nearly the same, or nearly the opposite, may leave a solution of large impulses that cancel each
/// other to rounding only.
bool sound(const MatrixXd& a, const VectorXd& now, const VectorXd& p) {
  if (p.cwiseProduct(a.diagonal()).maxCoeff() > largest * now.cwiseAbs().maxCoeff()) return false;
  const VectorXd change = a * p;
  const auto own = a.diagonal().array();                                               // 0: what joints lock
  const double energy = (own > 0).select(now.array().square() / own, 0.0).maxCoeff();  // at least, twice
  return p.dot(2 * now + change) <= rounding / 10 * energy;
}

/// The fastest contact alone, by Newton's law: what can not be wrong.
VectorXd strike_fastest(const MatrixXd& a, const VectorXd& now, const VectorXd& e) {
  VectorXd p = VectorXd::Zero(now.size());
  Eigen::Index fastest = 0;
  const double speed = now.minCoeff(&fastest);
  if (a(fastest, fastest) > 0) p[fastest] = -(1 + e[fastest]) * speed / a(fastest, fastest);
  return p;
}

VectorXd strike_group(const MatrixXd& a, const VectorXd& v, const Restitution& restitution) {
  VectorXd p = VectorXd::Zero(v.size());
  const double enough = rounding * v.cwiseAbs().maxCoeff();
  VectorXd now = v;
  for (int round = 0; round < 2 * most_rounds && now.minCoeff() < -enough; ++round) {
    const VectorXd e = round < most_rounds ? bounce(restitution, now) : VectorXd::Zero(v.size());
    // Where nothing bounces what opens may stay, and what is struck first strikes nothing else.
    const VectorXd above_least =
        (e.array() == 0).all() ? now
                               : VectorXd((now.array() < 0).select((1 + e.array()) * now.array(), 2 * now.array()));
    VectorXd more = complementary(a, above_least, round == 0 ? restitution.guess : VectorXd());
    if (!sound(a, now, more)) more = strike_fastest(a, now, e);
    p += more;
    now += a * more;
  }
  return p;
}

}  // namespace

VectorXd strike_together(const MatrixXd& a, const VectorXd& v, const Restitution& restitution) {
  VectorXd p = VectorXd::Zero(v.size());
  const auto& guess = restitution.guess;
  for (const Indices& group : coupled(a)) {
    const VectorXd of_group = guess.size() > 0 ? VectorXd(guess(group)) : VectorXd();
    p(group) = strike_group(a(group, group), v(group), {restitution.of(group), restitution.rest_speed, of_group});
  }
  return p;
}

VectorXd strike_in_turn(const MatrixXd& a, const VectorXd& v, const Restitution& restitution,
                        const std::vector<std::size_t>& pair) {
  VectorXd p = VectorXd::Zero(v.size());
  if (v.size() == 0) return p;
  const double enough = rounding * v.cwiseAbs().maxCoeff();
  VectorXd now = v;
  for (int round = 0; round < most_rounds && now.minCoeff() < -enough; ++round) {
    const double fastest = now.minCoeff();
    std::set<std::size_t> struck;
    for (Eigen::Index i = 0; i < now.size(); ++i) {
      if (now[i] <= (1 - tie) * fastest) struck.insert(pair[index(i)]);
    }
    Indices members;
    for (Eigen::Index i = 0; i < now.size(); ++i) {
      if (struck.contains(pair[index(i)])) members.push_back(i);
    }
    p(members) += strike_together(a(members, members), now(members), {restitution.of(members), restitution.rest_speed});
    now = v + a * p;
  }
  return now.minCoeff() < -enough ? VectorXd(p + strike_together(a, now, restitution)) : p;
}

}  // namespace odeval::engine_rk4
