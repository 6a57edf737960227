#pragma once
// The laws of impact, on numbers alone: what impulses contacts give that close at speeds v, where impulses p change the
// speeds by A p (A symmetric, positive semidefinite). Kinetic energy changes by p (v + v+) / 2.
#include <Eigen/Core>
#include <vector>

namespace odeval::engine_rk4 {

struct Restitution {
  Eigen::VectorXd of;          // each contact, 0..1
  double rest_speed = 0;       // what closes more slowly does not bounce
  Eigen::VectorXd guess = {};  // positive: of contacts that are likely to push, where the search begins
};

/// All at once, by Newton's law with complementarity: p >= 0, v+ >= t, p (v+ - t) = 0, where t = -e v for a contact
/// that closes (v < 0) and t = -v for one that opens. The energy changes by the sum of p (1 - e) v / 2 over those that
/// close: never more than nothing, and nothing where all restitutions are 1; v+ = -v is always a way out. What this
/// makes to close, an opening contact at most as fast as it opened, is struck in the same way, until nothing closes;
/// after many rounds, without restitution. Contacts are taken by speed, then by their own response and restitution,
/// whatever order they come in. Of those that say nearly the opposite, which are struck one by one, what is left after
/// many times is left.
Eigen::VectorXd strike_together(const Eigen::MatrixXd& a, const Eigen::VectorXd& v, const Restitution& restitution);

/// One pair of bodies after the other, the fastest first, as if there were a little time between: each is struck
/// together, as are pairs that close equally fast. After many rounds, or where one can not give way alone, what is left
/// is struck together. `pair` numbers the pair of each contact.
Eigen::VectorXd strike_in_turn(const Eigen::MatrixXd& a, const Eigen::VectorXd& v, const Restitution& restitution,
                               const std::vector<std::size_t>& pair);

}  // namespace odeval::engine_rk4
