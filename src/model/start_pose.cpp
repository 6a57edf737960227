#include "model/start_pose.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "model/joint_motions.hpp"
#include "model/rotation_vector.hpp"
#include "odeval/ways.hpp"

namespace odeval {
namespace {

bool says(const JointTable& joint) { return !joint.q.empty() || !joint.qd.empty(); }

/// The motions of one joint, and where each of them is.
struct Across {
  std::vector<Elementary> motions;
  std::vector<double> q;
  bool follows = false;  // found, not said

  Frame moved() const {
    Frame all;
    for (std::size_t k = 0; k < motions.size(); ++k) all = all * motions[k].by(q[k]);
    return all;
  }
};

/// What a mechanism is moved by, body by body, from what carries it to what it carries.
class Mover {
 public:
  Mover(Mechanism& mechanism, const std::vector<JointTable>& tables)
      : mechanism_(mechanism), tables_(tables), moved_(mechanism.bodies.size()), in_tree_(tables.size()) {
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      const Body& body = mechanism.bodies[i];
      moved_[i].drawn = {body.spin_rad_s, body.velocity_m_s + cross(body.position_m, body.spin_rad_s)};
      moved_[i].twist = moved_[i].drawn;
    }
    for (std::size_t j = 0; j < tables.size(); ++j) {
      const Joint& joint = mechanism.joints[j];
      Across& across = across_.emplace_back();
      across.motions = motions_of(tables[j], joint.kind, mechanism.bodies[joint.carried()].position_m);
      across.q.resize(across.motions.size());
    }
    choose_tree();
    order();
  }

  MendedStart run() {
    MendedStart mended;
    if (closing_.empty()) {
      set_said(1);
      place();
    } else {
      close(mended);
    }
    speed_up();
    write();
    if (!closing_.empty()) hold_rates();
    return mended;
  }

 private:
  struct Moved {
    Frame by;     // from as it is drawn
    Twist drawn;  // as it is drawn
    Twist twist;  // at the start
    bool reached = false;
    bool touched = false;
  };
  /// A body, and the joint through which it is reached; none for the first of what flies.
  struct Step {
    std::size_t body;
    std::optional<std::size_t> joint;
    bool from_parent = true;
  };
  /// What keeps a loop open.
  struct Opening {
    Vec3 gap_m{};
    Vec3 turn_rad{};
  };
  struct Unknown {
    std::size_t joint;
    std::size_t motion;
  };

  std::size_t child_of(std::size_t joint) const { return mechanism_.joints[joint].carried(); }
  std::optional<std::size_t> parent_of(std::size_t joint) const {
    const Joint& what = mechanism_.joints[joint];
    return what.second ? std::optional(what.first) : std::nullopt;
  }

  /// Those that say where they start before the others: what closes a loop then is one that says nothing.
  void choose_tree() {
    const std::size_t world = moved_.size();
    std::vector<std::size_t> leader(world + 1);
    std::iota(leader.begin(), leader.end(), std::size_t{0});
    const auto leader_of = [&](std::size_t member) {
      while (leader[member] != member) member = leader[member];
      return member;
    };
    for (const bool saying : {true, false}) {
      for (std::size_t j = 0; j < tables_.size(); ++j) {
        if (says(tables_[j]) != saying) continue;
        const std::size_t from = leader_of(parent_of(j).value_or(world));
        const std::size_t to = leader_of(child_of(j));
        in_tree_[j] = from != to;
        leader[from] = to;
        if (from == to) closing_.push_back(j);
      }
    }
    for (const std::size_t j : closing_) {
      if (!says(tables_[j])) continue;
      throw BadStart(j, tables_[j].q.empty() ? "qd" : "q",
                     "is one too many: all other joints of a loop say theirs, and it follows from them; remove it");
    }
  }

  void order() {
    const auto reach = [&](std::size_t body, std::optional<std::size_t> joint, bool from_parent) {
      if (moved_[body].reached) return;
      moved_[body].reached = true;
      order_.push_back({body, joint, from_parent});
    };
    std::vector<bool> is_child(moved_.size());
    for (std::size_t j = 0; j < tables_.size(); ++j) {
      is_child[child_of(j)] = true;
      if (in_tree_[j] && !parent_of(j)) reach(child_of(j), j, true);
    }
    std::size_t next = 0;
    const auto walk = [&] {
      for (; next < order_.size(); ++next) {
        const std::size_t body = order_[next].body;
        for (std::size_t j = 0; j < tables_.size(); ++j) {
          const std::optional<std::size_t> parent = parent_of(j);
          if (!in_tree_[j] || !parent) continue;
          if (*parent == body) reach(child_of(j), j, true);
          if (child_of(j) == body) reach(*parent, j, false);
        }
      }
    };
    walk();
    // What flies hangs on the first body of it that is no joint's child.
    for (const bool children_too : {false, true}) {
      for (std::size_t i = 0; i < moved_.size(); ++i) {
        if (!children_too && is_child[i]) continue;
        reach(i, std::nullopt, true);
        walk();
      }
    }
  }

  /// Of the joints that say it, a part of their q.
  void set_said(double part) {
    for (std::size_t j = 0; j < tables_.size(); ++j) {
      Across& across = across_[j];
      for (std::size_t k = 0; k < across.motions.size(); ++k) {
        const std::size_t number = across.motions[k].number;
        if (!tables_[j].q.empty() && number != Elementary::in_no_list) across.q[k] = part * tables_[j].q[number];
      }
    }
  }

  const Moved& other_of(const Step& step) const {
    static const Moved world;
    const std::optional<std::size_t> other = step.from_parent ? parent_of(*step.joint) : child_of(*step.joint);
    return other ? moved_[*other] : world;
  }

  void place() {
    for (const Step& step : order_) {
      if (!step.joint) continue;
      const Frame across = across_[*step.joint].moved();
      moved_[step.body].by = other_of(step).by * (step.from_parent ? across : inverse(across));
    }
  }

  // ---- Loops

  /// The joints of the tree between two bodies.
  std::vector<std::size_t> way_between(std::optional<std::size_t> from, std::optional<std::size_t> to) const {
    const auto up = [&](std::optional<std::size_t> body) {
      std::vector<std::size_t> joints;
      while (body) {
        const Step& step = *std::ranges::find(order_, *body, &Step::body);
        if (!step.joint) break;
        joints.push_back(*step.joint);
        body = step.from_parent ? parent_of(*step.joint) : child_of(*step.joint);
      }
      return joints;
    };
    std::vector<std::size_t> one = up(from);
    std::vector<std::size_t> two = up(to);
    while (!one.empty() && !two.empty() && one.back() == two.back()) {
      one.pop_back();
      two.pop_back();
    }
    one.insert(one.end(), two.begin(), two.end());
    return one;
  }

  /// How the child stands against where the joint's motions put it: not at all where the loop is closed.
  Opening opening(std::size_t joint) const {
    const std::optional<std::size_t> parent = parent_of(joint);
    const Frame wanted = (parent ? moved_[*parent].by : Frame{}) * across_[joint].moved();
    const Frame off = inverse(wanted) * moved_[child_of(joint)].by;
    const Vec3& anchor = tables_[joint].anchor_m;
    return {moved(off, anchor) - anchor, rotation_vector_of(off.rotation)};
  }

  Eigen::VectorXd openings() {
    place();
    Eigen::VectorXd all(static_cast<Eigen::Index>(6 * closing_.size()));
    Eigen::Index at = 0;
    for (const std::size_t j : closing_) {
      const Opening open = opening(j);
      for (const Vec3& part : {open.gap_m, open.turn_rad}) {
        for (const double x : part) all[at++] = x;
      }
    }
    return all;
  }

  double& at(const Unknown& unknown) { return across_[unknown.joint].q[unknown.motion]; }

  /// By differences, which are good to ten digits: enough for a step of Newton's method.
  Eigen::MatrixXd slopes(const std::vector<Unknown>& unknowns) {
    constexpr double small = 1e-5;
    Eigen::MatrixXd all(static_cast<Eigen::Index>(6 * closing_.size()), static_cast<Eigen::Index>(unknowns.size()));
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      double& q = at(unknowns[i]);
      const double here = q;
      q = here + small;
      const Eigen::VectorXd after = openings();
      q = here - small;
      all.col(static_cast<Eigen::Index>(i)) = (after - openings()) / (2 * small);
      q = here;
    }
    return all;
  }

  /// The joints' motions that close the loops, from where they are. Returns how well the loops decide
  /// them: what is near 0 in a line, where they may branch off.
  double newton(const std::vector<Unknown>& unknowns) {
    constexpr int most = 30;  // it doubles its digits each time, or does not get there
    double decided = 0;
    for (int i = 0; i < most && !unknowns.empty(); ++i) {
      const Eigen::VectorXd open = openings();
      Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
      solver.setThreshold(1e-7);  // what a planar loop does not decide is 0 but for the differences' rounding
      solver.compute(slopes(unknowns));
      const Eigen::Index last = solver.rank() - 1;
      decided = last < 0 ? 0 : std::fabs(solver.matrixT()(last, last));
      const Eigen::VectorXd step = -solver.solve(open);
      for (std::size_t k = 0; k < unknowns.size(); ++k) at(unknowns[k]) += step[static_cast<Eigen::Index>(k)];
      if (!step.allFinite() || step.norm() < 1e-13) break;
    }
    place();
    return decided;
  }

  void close(MendedStart& mended) {
    std::vector<Unknown> unknowns;
    double farthest = 0;
    for (const std::size_t j : closing_) {
      across_[j].follows = true;
      for (const std::size_t between : way_between(parent_of(j), child_of(j))) across_[between].follows = true;
    }
    for (std::size_t j = 0; j < tables_.size(); ++j) {
      Across& across = across_[j];
      for (std::size_t k = 0; across.follows && k < across.motions.size(); ++k) {
        const std::size_t number = across.motions[k].number;
        if (tables_[j].q.empty() || number == Elementary::in_no_list) {
          unknowns.push_back({j, k});
        } else {
          farthest = std::fmax(farthest, std::fabs(tables_[j].q[number]));
        }
      }
    }
    // So short that Newton's method stays on the side on which the loop is drawn, and that no line is stepped over
    // unseen: from 0.01 rad beside it the loop is decided a hundredth as well as across.
    const int steps = static_cast<int>(std::clamp(std::ceil(farthest / 0.02), 1.0, 1000.0));
    constexpr double branching = 0.03;
    double at_first = 0;
    for (int i = 1; i <= steps; ++i) {
      set_said(static_cast<double>(i) / steps);
      if (farthest == 0) {
        place();
        break;
      }
      const double decided = newton(unknowns);
      check_closed();
      if (i == 1) at_first = decided;
      if (decided >= branching * at_first) continue;
      throw BadStart(closing_.front(), "",
                     "closes a loop that q leads through a line, or nearly, where it may branch off; draw it beyond");
    }
    tell(unknowns, mended);
    for (const Unknown& unknown : unknowns) count_from_found(unknown);
  }

  void check_closed() const {
    constexpr double closed = 1e-10;  // m and rad: a hundred times what Newton's method leaves
    for (const std::size_t j : closing_) {
      const Opening open = opening(j);
      const double gap_m = length(open.gap_m);
      const double turn_rad = length(open.turn_rad);
      if (gap_m < closed && turn_rad < closed) continue;
      throw BadStart(j, "",
                     fmt::format("closes a loop that can not be closed with q as they are given: its halves stay "
                                 "{:.3g} m and {:.3g} rad apart",
                                 gap_m, turn_rad));
    }
  }

  void tell(const std::vector<Unknown>& unknowns, MendedStart& mended) const {
    double most = 0;
    for (const Unknown& unknown : unknowns) {
      const bool slides = across_[unknown.joint].motions[unknown.motion].slides;
      const double gone = std::fabs(across_[unknown.joint].q[unknown.motion]);
      double& largest = slides ? mended.moved_m : mended.turned_rad;
      largest = std::fmax(largest, gone);
      if (gone <= most) continue;
      most = gone;
      mended.joint = tables_[unknown.joint].name;
    }
    if (mended.joint.empty()) return;
    for (const Across& across : across_) mended.q.push_back(across.motions.size() == 1 ? across.q.front() : 0);
  }

  /// Stops, springs and targets count from as a joint is drawn also where its q was found.
  void count_from_found(const Unknown& unknown) {
    const std::size_t number = across_[unknown.joint].motions[unknown.motion].number;
    Joint& joint = mechanism_.joints[unknown.joint];
    const double in_file = across_[unknown.joint].q[unknown.motion];
    const double q = sign_in_files(joint) * in_file;
    const auto count = [&](auto& driven) {
      count_from(driven, q);
      const auto& stop = driven.stop;
      const bool turns = !across_[unknown.joint].motions[unknown.motion].slides;
      const double most = turns ? std::numbers::pi : std::numeric_limits<double>::infinity();  // as ODE has it
      if (!stop || (stop->low <= 0 && stop->high >= 0 && stop->low > -most && stop->high < most)) return;
      throw BadStart(unknown.joint, stop_keys[number],
                     fmt::format("must have {:.6g}, where the joint stands once its loop is closed, between its ends{}",
                                 in_file, turns ? ", and these within half a turn from there" : ""));
    };
    if (number == 0 && joint.drives.empty()) count(joint);
    for (AxisDrive& drive : joint.drives) {
      if (drive.number == number + 1) count(drive);
    }
  }

  // ---- Velocities

  void speed_up() {
    for (const Step& step : order_) {
      if (!step.joint) continue;
      Moved& here = moved_[step.body];
      const Moved& other = other_of(step);
      here.touched = other.touched || says(tables_[*step.joint]) || here.by.rotation != Frame{}.rotation ||
                     here.by.position_m != Vec3{};
      if (!here.touched) continue;
      const Twist drawn = step.from_parent ? here.drawn - other.drawn : other.drawn - here.drawn;
      const Twist between = rates_kept(*step.joint, drawn, step.from_parent ? other.by : here.by);
      here.twist = step.from_parent ? other.twist + between : other.twist - between;
    }
  }

  /// The velocity of a child against its parent, which stands moved.
  Twist rates_kept(std::size_t joint, const Twist& drawn, const Frame& parent) const {
    const Across& across = across_[joint];
    Twist left = drawn;
    Twist between;
    Frame carries = parent;
    for (std::size_t k = 0; k < across.motions.size(); ++k) {
      const Elementary& one = across.motions[k];
      const double rate = one.rate_in(drawn);
      left = left - rate * one.twist();
      between = between + (rate + said_rate(joint, one)) * moved(carries, one.twist());
      carries = carries * one.by(across.q[k]);
    }
    return between + moved(parent, left);
  }

  double said_rate(std::size_t joint, const Elementary& one) const {
    const std::vector<double>& qd = tables_[joint].qd;
    return qd.empty() || one.number == Elementary::in_no_list ? 0 : qd[one.number];
  }

  void write() {
    static const Frame still;
    const auto frame = [&](const std::optional<std::size_t>& body) -> const Frame& {
      return body ? moved_[*body].by : still;
    };
    for (Joint& joint : mechanism_.joints)
      joint.kind = carried(joint.kind, moved_[joint.first].by, frame(joint.second));
    for (Strut& strut : mechanism_.struts) {
      strut.first_end_m = moved(moved_[strut.first].by, strut.first_end_m);
      strut.second_end_m = moved(frame(strut.second), strut.second_end_m);
    }
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      const Moved& to = moved_[i];
      if (!to.touched) continue;
      Body& body = mechanism_.bodies[i];
      body.position_m = moved(to.by, body.position_m);
      if (to.by.rotation != Frame{}.rotation) {
        body.attitude = rotation_vector_of(to.by.rotation * rotation_of_vector(rotation_vector(body.attitude)));
      }
      body.spin_rad_s = to.twist.spin;
      body.velocity_m_s = to.twist.origin + cross(to.twist.spin, body.position_m);
    }
  }

  /// In loops the rest of the velocities follows from the rates that are said.
  void hold_rates() {
    std::vector<HeldRate> held;
    for (std::size_t j = 0; j < tables_.size(); ++j) {
      if (tables_[j].qd.empty()) continue;
      const std::optional<std::size_t> parent = parent_of(j);
      const Twist drawn = moved_[child_of(j)].drawn - (parent ? moved_[*parent].drawn : Twist{});
      Frame carries = parent ? moved_[*parent].by : Frame{};
      for (std::size_t k = 0; k < across_[j].motions.size(); ++k) {
        const Elementary& one = across_[j].motions[k];
        if (one.number != Elementary::in_no_list) {
          held.push_back({j, one.slides, turned(carries.rotation, one.axis), moved(carries, one.at_m),
                          one.rate_in(drawn) + said_rate(j, one)});
        }
        carries = carries * one.by(across_[j].q[k]);
      }
    }
    const auto left = [&](std::size_t j) {
      const Misfit misfit = misfit_of(mechanism_, mechanism_.joints[j]);
      return std::fmax(misfit.speed_m_s, misfit.spin_rad_s);
    };
    const auto parts = [&] {
      for (std::size_t j = 0; j < tables_.size(); ++j) {
        if (left(j) > 1e-3 * allowed_misfit(mechanism_)) return true;
      }
      return false;
    };
    if (parts() && moved_.size() > most_mended) {
      throw BadStart(
          closing_.front(), "",
          fmt::format("closes a loop among {} bodies; rates that loops have to follow are found of at most {}",
                      moved_.size(), most_mended));
    }
    for (int twice = 0; twice < 2 && parts(); ++twice) mend_velocities(mechanism_, held);
    for (const HeldRate& one : held) {
      const double off = std::fabs(rate_of(mechanism_, one) - one.rate);
      if (off > allowed_misfit(mechanism_)) {
        throw BadStart(
            one.joint, "qd",
            fmt::format("can not be had beside the other rates of its loop: {:.3g} of it is left over", off));
      }
    }
    for (const std::size_t j : closing_) {
      if (left(j) <= allowed_misfit(mechanism_)) continue;
      throw BadStart(
          j, "",
          fmt::format("closes a loop that does not move with qd as they are given: its halves part by {:.3g}",
                      left(j)));
    }
  }

  Mechanism& mechanism_;
  const std::vector<JointTable>& tables_;
  std::vector<Moved> moved_;
  std::vector<bool> in_tree_;  // of each joint
  std::vector<std::size_t> closing_;
  std::vector<Across> across_;
  std::vector<Step> order_;
};

}  // namespace

MendedStart bring_to_start(Mechanism& mechanism, const Description& said) {
  MendedStart mended;
  mend_drawn_velocities(mechanism, mended);
  if (!std::ranges::any_of(said.joints, says)) return mended;
  const MendedStart closed = Mover(mechanism, said.joints).run();
  mended.turned_rad = closed.turned_rad;
  mended.moved_m = closed.moved_m;
  mended.joint = closed.joint;
  mended.q = closed.q;
  return mended;
}

}  // namespace odeval
