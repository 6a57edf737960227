#include "engines/ode_rk4/friction.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "engines/ode_rk4/complementarity.hpp"

namespace odeval::engine_rk4 {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double rounding = 1e-12;  // of the fastest speed, of the largest impulse
// Of the contacts, against their own response; made up for from round to round.
constexpr double softness = 1e-6, least_softness = 1e-11;
constexpr double agreement = 1e-10;  // of the largest impulse: soft shares are rounded to that
// Of Newton's method, and of the rounds that make up for softness; it has failed by then.
constexpr int most_newtons = 20, most_softs = 4;
constexpr double the_same = 1e-9;  // of what was left a round before: it goes round in circles
constexpr Index most_rows = 150;
constexpr int most_looks = 50;  // sweeps that bring it near enough, where where it was is not
// Of friction and normal impulses in turn: what is left after them is left to the next step, which goes on from there.
constexpr int most_rounds = 6, most_sweeps_in_turn = 20;
// Of friction alone, after a bounce.
constexpr int most_sweeps = 1000, most_sweeps_of_many = 20;
constexpr Index many = 24;  // rows of friction
// Change of a contact's speed by one impulse, of the fastest speed: what is left of such that cancel each other is
// rounded to 1e-12 of it then.
constexpr double largest = 1e4;

/// As good as it gets: `last` is what was left a round before.
bool done(double left, double last, double scale) {
  return left <= rounding * scale && (left <= rounding / 1000 * scale || left > last / 2);
}

/// The equations of Alart and Curnier (Comput. Methods Appl. Mech. Eng. 92, 1991), solved by Newton's method on
/// the pieces of which they are smooth: a contact is open, sticks or slides, a motor has its speed or is at its limit.
class Newton {
 public:
  /// `work` that is left.
  Newton(const MatrixXd& a, const Rubbing& rubbing, double& work) : a_(a), rubbing_(rubbing), work_(work) {}

  /// From p; nothing where it fails.
  std::optional<VectorXd> solve(const VectorXd& v, VectorXd p) {
    double scale = p.cwiseAbs().maxCoeff();
    for (Index i = 0; i < v.size(); ++i) scale = std::max(scale, stiffness(i) * std::fabs(v[i]));
    double last = INFINITY;
    for (int round = 0; round < most_newtons; ++round) {
      choose(v, p);
      const double off = residual_.cwiseAbs().maxCoeff();
      if (done(off, last, scale)) return p;
      if (std::fabs(off - last) <= the_same * off) return std::nullopt;
      last = off;
      const auto k = static_cast<Index>(rows_.size());
      work_ -= static_cast<double>(k * k * k);
      if (work_ < 0) return std::nullopt;
      for (Index i = 0; i < p.size(); ++i) p[i] = open_[static_cast<std::size_t>(i)] != 0 ? limit_[i] : p[i];
      assemble(v, p);
      if (k > 0) p(rows_) -= matrix_.partialPivLu().solve(right_);
      if (!p.allFinite()) return std::nullopt;
    }
    return std::nullopt;
  }

 private:
  static Index row_of(std::size_t pair, Index normals) { return normals + static_cast<Index>(2 * pair); }
  Index normals() const { return a_.rows() - rubbing_.rows(); }
  double stiffness(Index i) const { return a_(i, i) > 0 ? 1 / a_(i, i) : 0; }
  double stiffness_across(Index i) const {
    const double steepest = std::max(a_(i, i), a_(i + 1, i + 1));
    return steepest > 0 ? 1 / steepest : 0;
  }

  /// Which contacts are open and which motors at their limit, and how far impulses are from what they should be.
  void choose(const VectorXd& v, const VectorXd& p) {
    const VectorXd u = v + a_ * p;
    open_.assign(static_cast<std::size_t>(p.size()), 0);
    rows_.clear();
    slides_.assign(rubbing_.contact.size(), 0);
    residual_ = limit_ = VectorXd::Zero(p.size());
    for (Index i = 0; i < normals(); ++i) {
      const double pushes = p[i] - stiffness(i) * u[i];
      open_[static_cast<std::size_t>(i)] = pushes > 0 && a_(i, i) > 0 ? 0 : 1;
      residual_[i] = p[i] - (open_[static_cast<std::size_t>(i)] != 0 ? 0 : pushes);
      if (open_[static_cast<std::size_t>(i)] == 0) rows_.push_back(i);
    }
    for (std::size_t k = 0; k < slides_.size(); ++k) {
      const Index row = row_of(k, normals());
      const Vector2d wanted = p.segment<2>(row) - stiffness_across(row) * u.segment<2>(row);
      const bool open = open_[static_cast<std::size_t>(rubbing_.contact[k])] != 0 || stiffness_across(row) == 0;
      const double most = open ? 0 : rubbing_.coefficient[k] * std::max(0.0, p[rubbing_.contact[k]]);
      slides_[k] = wanted.norm() > most ? 1 : 0;
      residual_.segment<2>(row) = p.segment<2>(row) - (slides_[k] != 0 ? Vector2d(most * wanted.normalized()) : wanted);
      for (Index i = row; i < row + 2; ++i) {
        open_[static_cast<std::size_t>(i)] = open ? 1 : 0;
        if (!open) rows_.push_back(i);
      }
    }
    for (std::size_t k = 0; k < rubbing_.limits.size(); ++k) {
      const Index i = normals() + rubbing_.motors_at() + static_cast<Index>(k);
      const double wanted = p[i] - stiffness(i) * u[i];
      const bool moves = stiffness(i) > 0;
      limit_[i] = moves ? std::clamp(wanted, rubbing_.limits[k].least, rubbing_.limits[k].most) : 0;
      residual_[i] = p[i] - limit_[i];
      open_[static_cast<std::size_t>(i)] = moves && limit_[i] == wanted ? 0 : 1;
      if (open_[static_cast<std::size_t>(i)] == 0) rows_.push_back(i);
    }
  }

  /// Of those that are not open.
  void assemble(const VectorXd& v, const VectorXd& p) {
    const VectorXd u = v + a_ * p;
    matrix_ = a_(rows_, rows_);
    right_ = u(rows_);
    const auto place = [this](Index row) {
      return static_cast<Index>(std::ranges::lower_bound(rows_, row) - rows_.begin());
    };
    for (std::size_t k = 0; k < slides_.size(); ++k) {
      const Index row = row_of(k, normals());
      if (slides_[k] == 0 || open_[static_cast<std::size_t>(row)] != 0) continue;
      const Index at = place(row), normal = place(rubbing_.contact[k]);
      const double stiff = stiffness_across(row);
      const Vector2d wanted = p.segment<2>(row) - stiff * u.segment<2>(row);
      const double size = std::max(wanted.norm(), 1e-300);
      const Vector2d along = wanted / size;
      const double most = rubbing_.coefficient[k] * std::max(0.0, p[rubbing_.contact[k]]);
      const Matrix2d turn = most / size * (Matrix2d::Identity() - along * along.transpose());
      const MatrixXd across = stiff * turn * matrix_.middleRows<2>(at);
      matrix_.middleRows<2>(at) = across;
      matrix_.block<2, 2>(at, at) += Matrix2d::Identity() - turn;
      matrix_.block<2, 1>(at, normal) -= rubbing_.coefficient[k] * along;
      right_.segment<2>(at) = p.segment<2>(row) - most * along;
    }
  }

  const MatrixXd& a_;
  const Rubbing& rubbing_;
  double& work_;
  std::vector<char> open_, slides_;
  std::vector<Index> rows_;
  VectorXd residual_, right_, limit_;  // that of those that are at one: 0 of an open contact
  MatrixXd matrix_;
};

/// By Newton's method, softened contacts pushing on from what they pushed in the round before. Where contacts say
/// nearly the same, that takes too many rounds of softer ones, and harder ones go on.
class AtOnce {
 public:
  AtOnce(const MatrixXd& a, const VectorXd& v, const Rubbing& rubbing, double& work)
      : a_(a), v_(v), rubbing_(rubbing), work_(work) {}

  /// From p, on top of which shares are even; looked for near `guess`. Nothing where it fails.
  std::optional<VectorXd> solve(VectorXd p, VectorXd guess) {
    for (const double how : {softness, least_softness}) {
      const VectorXd soft = how * a_.diagonal();
      MatrixXd softened = a_;
      softened.diagonal() += soft;
      Newton newton(softened, rubbing_, work_);
      double last = INFINITY;
      for (int round = 0; round < most_softs; ++round) {
        const auto now = newton.solve(v_ - soft.cwiseProduct(p), guess);
        if (!now) return std::nullopt;
        const double given = soft.cwiseProduct(*now - p).cwiseAbs().maxCoeff();
        p = guess = *now;
        if (done(given, last, v_.cwiseAbs().maxCoeff())) return p;
        last = given;
      }
    }
    return std::nullopt;
  }

 private:
  const MatrixXd& a_;
  const VectorXd& v_;
  const Rubbing& rubbing_;
  double& work_;
};

/// One motor.
void sweep_motor(const MatrixXd& a, const VectorXd& v, const Rubbing::Limits& limits, Index row, VectorXd& p) {
  if (a(row, row) <= 0) return;
  p[row] = std::clamp(p[row] - (v[row] + a.row(row).dot(p)) / a(row, row), limits.least, limits.most);
}

/// Contact after contact, its normal and its friction, then motors: near the solution in most cases.
VectorXd swept(const MatrixXd& a, const VectorXd& v, const Rubbing& rubbing, VectorXd p) {
  const Index n = v.size() - rubbing.rows();
  for (int sweep = 0; sweep < most_looks; ++sweep) {
    for (Index i = 0; i < n; ++i) {
      if (a(i, i) > 0) p[i] = std::max(0.0, p[i] - (v[i] + a.row(i).dot(p)) / a(i, i));
    }
    for (std::size_t k = 0; k < rubbing.contact.size(); ++k) {
      const Index row = n + static_cast<Index>(2 * k);
      const double steepest = std::max(a(row, row), a(row + 1, row + 1));
      if (steepest <= 0) continue;
      Vector2d now = p.segment<2>(row) - (v.segment<2>(row) + a.middleRows<2>(row) * p) / steepest;
      const double most = rubbing.coefficient[k] * p[rubbing.contact[k]];
      if (now.norm() > most) now *= most / now.norm();
      p.segment<2>(row) = now;
    }
    for (std::size_t k = 0; k < rubbing.limits.size(); ++k) {
      sweep_motor(a, v, rubbing.limits[k], n + rubbing.motors_at() + static_cast<Index>(k), p);
    }
  }
  return p;
}

/// What would push if nothing slid.
VectorXd sticking(const MatrixXd& a, const VectorXd& v, const Rubbing& rubbing) {
  const Index m = rubbing.rows(), n = v.size() - m;
  MatrixXd across = a.bottomRightCorner(m, m);
  across.diagonal() *= 1 + softness;
  across.diagonal().array() += 1e-300;
  const Eigen::LDLT<MatrixXd> stuck(across);
  const MatrixXd follow = stuck.solve(a.bottomLeftCorner(m, n));
  VectorXd p = VectorXd::Zero(v.size());
  p.tail(m) = stuck.solve(v.tail(m));
  MatrixXd left = a.topLeftCorner(n, n) - a.topRightCorner(n, m) * follow;
  left.diagonal() += softness * a.diagonal().head(n);
  p.head(n) = complementary(left, v.head(n) - a.topRightCorner(n, m) * p.tail(m), p.head(n));
  p.tail(m) = -p.tail(m) - follow * p.head(n);
  return p;
}

/// Friction at contacts that push so much, and motors, by projected gradients, one after the other.
VectorXd sweep(const MatrixXd& a, const VectorXd& speeds, const Rubbing& rubbing, const VectorXd& normal, VectorXd p,
               int sweeps) {
  VectorXd v = speeds + a * p;
  const double enough = rounding / 100 * speeds.cwiseAbs().maxCoeff();
  for (; sweeps > 0; --sweeps) {
    double moved = 0;
    for (std::size_t k = 0; k < rubbing.contact.size(); ++k) {
      const auto row = static_cast<Index>(2 * k);
      const Matrix2d own = a.block<2, 2>(row, row);
      const double steepest = own.trace() / 2 + std::hypot((own(0, 0) - own(1, 1)) / 2, own(0, 1));
      if (steepest <= 0) continue;
      const Vector2d was = p.segment<2>(row);
      Vector2d now = was - v.segment<2>(row) / steepest;
      const double most = rubbing.coefficient[k] * normal[rubbing.contact[k]];
      if (now.norm() > most) now *= most / now.norm();
      const Vector2d change = now - was;
      v += a.middleCols<2>(row) * change;
      p.segment<2>(row) = now;
      moved = std::max(moved, steepest * change.norm());
    }
    for (std::size_t k = 0; k < rubbing.limits.size(); ++k) {
      const Index row = rubbing.motors_at() + static_cast<Index>(k);
      const double was = p[row];
      sweep_motor(a, speeds, rubbing.limits[k], row, p);
      v += a.col(row) * (p[row] - was);
      moved = std::max(moved, a(row, row) * std::fabs(p[row] - was));
    }
    if (moved <= enough) break;
  }
  return p;
}

/// Normal impulses for given friction and friction for given normal impulses in turn, until they agree.
VectorXd hold_in_turn(const MatrixXd& a, const VectorXd& v, const Rubbing& rubbing, VectorXd p) {
  const Index m = rubbing.rows(), n = v.size() - m;
  const MatrixXd normal = a.topLeftCorner(n, n);
  const double soft = n > 0 ? softness * a.diagonal().head(n).maxCoeff() : 0;
  const MatrixXd softened = normal + soft * MatrixXd::Identity(n, n);
  for (int round = 0; round < most_rounds; ++round) {
    const VectorXd was = p;
    const VectorXd closing = v.head(n) + a.topRightCorner(n, m) * p.tail(m);
    p.head(n) = complementary(softened, closing - soft * was.head(n), was.head(n));
    p.tail(m) = sweep(a.bottomRightCorner(m, m), v.tail(m) + a.bottomLeftCorner(m, n) * p.head(n), rubbing, p.head(n),
                      p.tail(m), most_sweeps_in_turn);
    if ((p - was).cwiseAbs().maxCoeff() <= agreement * p.cwiseAbs().maxCoeff()) break;
  }
  return p;
}

/// Do impulses cancel each other so nearly that what is left of them is rounding?
bool cancel(const MatrixXd& a, const VectorXd& v, const VectorXd& p) {
  if (p.size() == 0) return false;
  return !((a * p.asDiagonal()).cwiseAbs().maxCoeff() <= largest * v.cwiseAbs().maxCoeff());
}

}  // namespace

VectorXd hold(const MatrixXd& a, const VectorXd& v, const Rubbing& rubbing, VectorXd p, double& work) {
  // Where joints hold what contacts push, jammed impulses do not move anything: begun with what they were before, they
  // would grow from step to step.
  if (cancel(a, v, p)) p.setZero();
  if (v.size() <= most_rows && work > 0) {
    AtOnce solver(a, v, rubbing, work);
    auto at_once = solver.solve(p, p);
    if (!at_once) {
      const VectorXd near = swept(a, v, rubbing, p);
      at_once = solver.solve(p, near);
      if (!at_once) at_once = solver.solve(near, near);  // with its shares, which may be uneven
    }
    if (!at_once) {
      const VectorXd stuck = sticking(a, v, rubbing);
      at_once = solver.solve(stuck, stuck);
    }
    if (at_once && !adds_energy(a, v, *at_once)) return *at_once;
  }
  return hold_in_turn(a, v, rubbing, std::move(p));
}

VectorXd rub(const MatrixXd& a, const VectorXd& speeds, const Rubbing& rubbing, const VectorXd& normal, VectorXd p) {
  return sweep(a, speeds, rubbing, normal, std::move(p), rubbing.rows() > many ? most_sweeps_of_many : most_sweeps);
}

bool adds_energy(const MatrixXd& a, const VectorXd& v, const VectorXd& p) {
  if (cancel(a, v, p) && !takes_energy(a, v, p)) return true;
  const auto own = a.diagonal().array();                                      // 0: what joints lock
  const double energy = (own > 0).select(v.array().square() / own, 0).sum();  // twice
  return !(p.dot(2 * v + a * p) <= rounding / 10 * energy);
}

}  // namespace odeval::engine_rk4
