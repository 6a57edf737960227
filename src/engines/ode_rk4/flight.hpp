#pragma once
// From one end of a step to the other: free motion, impacts where they fall, and rest at its end.
#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engines/ode_rk4/accurate_step.hpp"
#include "engines/ode_rk4/collider.hpp"
#include "engines/ode_rk4/footholds.hpp"
#include "engines/ode_rk4/motion.hpp"

namespace odeval::engine_rk4 {

/// Steps without a bounce after which a crowd is at rest, and an impact of many bodies at once no crowd.
constexpr int calm_steps = 10;

constexpr double mendable = 1e-9;  // m, rad: smaller joint errors are left to the projection at the end of the step

inline double deepest_of(const std::vector<Contact>& contacts) {
  double deepest = 0;
  for (const Contact& contact : contacts) deepest = std::max(deepest, contact.depth);
  return deepest;
}

class Flight {
 public:
  Flight(Motion& motion, Collider& collider, const AccurateStepOptions& options)
      : motion_(motion), collider_(collider), options_(options) {}

  /// Advances a state by h; `fresh`: one that may not keep its joints yet. Throws AccurateStepError where no sound
  /// state can be reached; the state, and what is remembered, are then as before.
  void advance(State& state, Forces& forces, double h, bool fresh);

  /// Impacts of the last step, in order.
  const std::vector<Touch>& touches() const { return touches_; }
  /// Steps so far that a crowd of contacts ended.
  std::size_t crowded_steps() const { return crowded_steps_; }
  /// What moved the mechanism last: its joints come first, and it knows what they do.
  const Motion& mover() const { return footholds_ ? footholds_->motion() : motion_; }
  /// Forgets what rests.
  void start_anew() {
    resting_.clear();
    gave_.clear();
    left_.clear();
    footholds_.reset();
    crowded_ = 0;
    taken_ = 0;
  }

 private:
  /// What a time that is gone through again begins with.
  struct Memory {
    std::vector<Contact> resting;
    std::vector<double> gave;
    double taken;
  };
  Memory memory() const { return {resting_, gave_, taken_}; }
  void go_back(const Memory& memory) {
    resting_ = memory.resting;
    gave_ = memory.gave;
    taken_ = memory.taken;
  }

  void fall_freely(const State& start, const Memory& before, double h);
  void begin();
  bool put_elsewhere(const State& state) const;
  void allow_lift();
  void fly(double h);
  /// Of what came to stick in a step.
  struct Slowing {
    int splits = 0;
    double slip = 0, last_part = 0;
  };
  bool touches_once_held(double left);
  bool hold_or_stick(double& t, double h, Slowing& slowing);
  void go_on();
  void find_footholds(double after, bool struck);
  bool slips(double after, double& passed);
  bool held_fast(const Contact& contact) const { return footholds_ && footholds_->have(contact); }
  Motion& mover() { return footholds_ ? footholds_->motion() : motion_; }
  void move(double after, double h, State& to);
  void move_by_motors(double after, double h, State& to);
  void drive(const State& from, double after, std::span<const std::size_t> broken = {});
  std::vector<char> pushed_late() const;
  bool disturbed() const;
  void go(State& from, double after, double h, State& to);
  void settle(State& state, double most);
  [[noreturn]] void refuse_apart(const JointError& error, const std::string& when) const;
  void look(const State& state) {
    collider_.look(motion_.mechanism(), state, contacts_);
    count_in(contacts_);
  }
  void count_in(const std::vector<Contact>& contacts);
  std::vector<char> reached(std::vector<char> bodies) const;
  std::vector<char> unsteady() const;
  bool pushes_on(const Contact& contact) const {
    return contact.steady && contact.restitution < 1 && !held_fast(contact);
  }
  std::size_t struck_at_once() const;
  void crowd_on() {
    renewed_ = true;
    crowded_ = calm_steps;
  }
  void push_on(double after);
  static void place(Contact& contact, const State& at);
  Contact at_start(Contact contact) const;
  void arrive(const State& at, double passed);
  void remember(const State& at, double passed);
  double work_of_pushes(const State& at, double passed) const;
  bool stopped(const Contact& contact) const;
  const Contact* nearest_resting(const Contact& contact) const;
  void recall(const State& at, double h);
  void note(const Impact& impact, const Eigen::VectorXd& impulses, double h);
  bool rests(const Contact& contact, const State& at) const;
  const Contact* deepest(const State& at) const;
  double locate(double after, double longest);
  void impact(double t, bool at_once, bool last);
  void strike(State& state);
  bool add_closed_by(State struck);
  bool add_to_contacts(const std::vector<Contact>& more);
  void tell(const std::function<void(const Touch&)>& observer, const Touch& touch) const;
  bool hold(State& state, double h);
  struct Out {
    bool moved, well;  // it moved, and lies well
  };
  Out stop_and_push_out(State& state, double h, bool again, std::vector<LateMotor>& motors, std::vector<Contact>& rest);
  void leave_what_is_deep();
  bool lies_well(std::span<const Twist> way) const;
  bool found_again(const Contact& contact) const;
  void look_deeper(std::vector<Contact>& rest);
  Eigen::VectorXd put_too_deep(const std::vector<Contact>& rest) const;
  void tell_joints(const Impact& impact, const Eigen::VectorXd& impulses, const State& state, double h);
  void tell_joint(const Contact& contact, const State& state, double h);
  std::vector<Twist> follow(const State& free, const State& held, double h);
  void settle_crowd(State& state, double h);
  bool judge_bounces(const State& state, const State& bare, std::vector<Contact>& contacts) const;
  void add_still(const State& free);
  bool missed_on_way(const State& free, const State& end, std::vector<double>& depths);
  struct Group;
  Group group_of(std::size_t first, const State& state) const;
  void move_rigidly(const Group& group, State& state) const;
  std::vector<char> pay(const State& before, double work, State& state) const;
  bool stay(const State& start, const std::vector<char>& poor, State& state) const;
  double follow_crowd(const Impact& impact, const Eigen::VectorXd& impulses, std::vector<Contact>& contacts,
                      const std::vector<char>& poor, const State& free, State struck, double h, double work,
                      State& state);
  State unforced(Motion& motion, const State& state, double h);
  bool passive() const;
  bool conservative() const;
  bool keep_energy(const State& start, const std::vector<Contact>& rested, double lift);
  double rounding_of_energy(const State& state) const;
  double gained(const State& from, const State& to) const;
  double gained(const State& from, const State& to, std::span<const Twist> by) const;
  State slowed(const State& still, const State& struck, double by) const;
  bool move_out(Motion& motion, const State& free, std::span<const Twist> way, double most, State& state);
  void bounce_elastic(Motion& motion, const Impact& impact, std::vector<Contact>& contacts, double h, State& state);

  Motion& motion_;
  Collider& collider_;
  const AccurateStepOptions& options_;
  Forces* forces_ = nullptr;
  State here_;                                // the start of what is left of the step
  State there_, trial_;                       // and where it leads
  State left_;                                // the end of the last step
  std::vector<double> ground_, ground_then_;  // Collider::survey_ground, now and in the last step
  std::vector<Contact> contacts_;             // of the state last looked at
  std::vector<Contact> resting_;              // at the end of the last step, and what came to rest since
  std::vector<Contact> pushing_;              // of those, since `here_`, as they were there
  std::vector<double> gave_;                  // N or N m, by late motors on average in the time held last
  std::vector<Contact> stopped_;              // their geoms do not bounce any more in this step
  std::vector<Contact> struck_;               // at `here_`
  std::vector<Contact> bounced_;              // in this step
  std::vector<Twist> halted_;                 // of velocities, at the end of this part of the step
  std::vector<char> in_touch_;                // bodies that these and joints reach
  bool all_stopped_ = false;
  std::optional<Footholds> footholds_;  // of what rests and sticks
  bool slipped_ = false;                // it does so no more in this step
  int finds_ = 0;                       // in this step
  double step_ = 0;                     // s, of the user's
  double let_go_ = 0;                   // s, since `here_`, at the touch located last
  Sticks sticks_;                       // in the time held last
  double work_ = 0;                     // that friction may take yet in this step
  bool renewed_ = false;                // the crowd, in this step
  int crowded_ = 0;                     // steps that are left to the crowd's scheme if nothing bounces
  // J, by contacts in this step, and while motors and the like act before it, less what ways out of overlaps gave.
  double taken_ = 0;
  int quiet_ = calm_steps;  // steps since the last impact, or that many
  bool first_ = true;       // step since the mechanism was read
  std::size_t crowded_steps_ = 0;
  std::vector<Touch> touches_;
};

}  // namespace odeval::engine_rk4
