#include "engines/ode_rk4/restitution.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>

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
// Change of a contact's speed by its own impulse, of the fastest speed: rounding of it is 1e-12 then; or 1e-11, which
// no impulse adds to energy that takes far more than that away.
constexpr double largest = 1e4, largest_of_lossy = 1e5, lossy = 1e-9;
// What bears a million times its own mass may change so much, as long as that clearly takes energy.
constexpr double largest_of_heavy = 1e9;
// Elastic rows end after as many rounds as they have contacts, light balls between heavy ones after pi times the root
// of the ratio of masses; lossy ones that never end are as good as at rest by then.
constexpr int most_rounds = 1000;
// What is left once nothing bounces is rounding, or nothing can give way to it.
constexpr int most_idle = 4;
// One by one: of contacts that say nearly the opposite that takes so many that they close yet by what is left.
constexpr int most_alone = 4000, longest = 16;

std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

/// Contacts that say nearly the same, or nearly the opposite, may leave a solution of large impulses that cancel each
/// other to rounding only.
bool sound(const MatrixXd& a, const VectorXd& now, const VectorXd& p) {
  const double own_change = p.cwiseProduct(a.diagonal()).maxCoeff(), fastest = now.cwiseAbs().maxCoeff();
  const VectorXd change = a * p;
  if (own_change <= largest_of_heavy * fastest && takes_energy(a, now, p)) return true;
  if (own_change > largest_of_lossy * fastest) return false;
  const auto own = a.diagonal().array();                                               // 0: what joints lock
  const double energy = (own > 0).select(now.array().square() / own, 0.0).maxCoeff();  // at least, twice
  const double most = own_change > largest * fastest ? -lossy : rounding / 10;
  return p.dot(2 * now + change) <= most * energy;
}

/// Contacts that close at these speeds, which change by what they are given.
class Strikes {
 public:
  Strikes(const MatrixXd& a, const VectorXd& v, const Restitution& restitution)
      : a_(a),
        restitution_(restitution),
        now_(v),
        p_(VectorXd::Zero(v.size())),
        enough_(rounding * v.cwiseAbs().maxCoeff()) {}

  /// By Newton's law, then, where that has not ended, without restitution.
  VectorXd strike() {
    int idle = 0;  // rounds that should have been the last
    for (int round = 0; idle < most_idle && alone_ < most_alone && closes(); ++round) {
      const bool bounces = round < most_rounds && alone_ < most_alone / 2;
      const VectorXd e = bounces ? bounce() : VectorXd::Zero(now_.size());
      const VectorXd more = at_once(e, round == 0 ? restitution_.guess : VectorXd());
      if (sound(a_, now_, more)) {
        const VectorXd change = a_ * more;
        if ((e.array() == 0).all() || change.cwiseAbs().maxCoeff() <= enough_) ++idle;
        p_ += more;
        now_ += change;
      } else {  // one by one for a while, longer each time; what that leaves is asked again
        for (int strike = 0; strike < patience_ && alone_ < most_alone && closes(); ++strike) alone(bounces);
        patience_ = std::min(2 * patience_, longest);
      }
    }
    return p_;
  }

 private:
  bool closes() const { return now_.minCoeff() < -enough_; }
  // What closes by rounding does not: whether anything bounces decides what the others do.
  double bouncing_speed() const { return std::max(restitution_.rest_speed, enough_); }
  VectorXd bounce() const { return (now_.array() <= -bouncing_speed()).select(restitution_.of, 0); }

  VectorXd at_once(const VectorXd& e, const VectorXd& guess) const {
    // Where nothing bounces what opens may stay, and what is struck first strikes nothing else.
    const VectorXd above_least =
        (e.array() == 0).all() ? now_
                               : VectorXd((now_.array() < 0).select((1 + e.array()) * now_.array(), 2 * now_.array()));
    return complementary(a_, above_least, guess);
  }

  /// The fastest alone, by Newton's law: what can not be wrong.
  void alone(bool bounces) {
    ++alone_;
    Eigen::Index fastest = 0;
    const double speed = now_.minCoeff(&fastest);
    if (a_(fastest, fastest) <= 0) return;
    const double e = bounces && speed <= -bouncing_speed() ? restitution_.of[fastest] : 0;
    const double more = -(1 + e) * speed / a_(fastest, fastest);
    p_[fastest] += more;
    now_ += more * a_.col(fastest);
  }

  const MatrixXd& a_;
  const Restitution& restitution_;
  VectorXd now_, p_;
  double enough_;
  int patience_ = 1, alone_ = 0;
};

/// By speed, then by mass and restitution: what rounding decides does not hang on the order in which contacts come.
void put_in_order(Indices& contacts, const MatrixXd& a, const VectorXd& v, const VectorXd& restitution) {
  std::ranges::stable_sort(contacts, {}, [&](Eigen::Index i) { return std::tuple(v[i], a(i, i), restitution[i]); });
}

VectorXd in_turn(const MatrixXd& a, const VectorXd& v, const Restitution& restitution,
                 const std::vector<std::size_t>& pair) {
  VectorXd p = VectorXd::Zero(v.size());
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
    if (now(members).minCoeff() < fastest / 2) break;  // it can not give way alone
  }
  return now.minCoeff() < -enough ? VectorXd(p + strike_together(a, now, restitution)) : p;
}

}  // namespace

VectorXd strike_together(const MatrixXd& a, const VectorXd& v, const Restitution& restitution) {
  VectorXd p = VectorXd::Zero(v.size());
  const auto& guess = restitution.guess;
  for (Indices group : coupled(a)) {
    put_in_order(group, a, v, restitution.of);
    const VectorXd of_group = guess.size() > 0 ? VectorXd(guess(group)) : VectorXd();
    const Restitution of{restitution.of(group), restitution.rest_speed, of_group};
    const MatrixXd own = a(group, group);
    p(group) = Strikes(own, v(group), of).strike();
  }
  return p;
}

VectorXd strike_in_turn(const MatrixXd& a, const VectorXd& v, const Restitution& restitution,
                        const std::vector<std::size_t>& pair) {
  VectorXd p = VectorXd::Zero(v.size());
  if (v.size() == 0) return p;
  Indices order(index(v.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  put_in_order(order, a, v, restitution.of);
  std::vector<std::size_t> pairs;
  for (const Eigen::Index i : order) pairs.push_back(pair[index(i)]);
  p(order) = in_turn(a(order, order), v(order), {restitution.of(order), restitution.rest_speed}, pairs);
  return p;
}

}  // namespace odeval::engine_rk4
