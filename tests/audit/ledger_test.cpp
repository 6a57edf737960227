// The ledger of the audit, of programs (of plain/) whose works are known.
#include <cmath>
#include <cstdlib>

#include "audit/judge.hpp"
#include "audit/recording.hpp"
#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using namespace odeval;

constexpr double g = 9.81;
constexpr double h = 1e-3;

/// The program as it is, for some seconds.
void record_to(const std::string& record, const std::string& scenario, const std::string& seconds) {
  const std::string command =
      "env LD_PRELOAD=" ODEVAL_AUDIT_LIBRARY " ODEVAL_AUDIT_LEDGER=1 ODEVAL_AUDIT_RECORD=" + record +
      " " ODEVAL_PLAIN " " + scenario + " 0.001 " + seconds;
  CHECK_EQUAL(std::system(command.c_str()), 0);
}

audit::Answer recorded(const std::string& scenario, const std::string& seconds) {
  const test::TemporaryFolder folder;
  const std::string record = (folder.path() / "record").string();
  record_to(record, scenario, seconds);
  audit::Answer answer;
  audit::describe(record, answer);
  return answer;
}

double of_step(const audit::Answer& answer) { return answer.energy.end_J - answer.energy.begin_J - answer.work.sum(); }

// 2 kg at 2 m/s slide to rest on friction of 0.3: all of 4 J, in 2 / (0.3 g) s. What the box sinks by is 1e-11 m.
void friction_takes_it_all() {
  const audit::Answer answer = recorded("friction_slide", "1");
  CHECK_NEAR(answer.work.contacts, -4.0, 1e-9);
  CHECK_EQUAL(answer.work.program, 0.0);  // the same sum before a step as after the one before
  CHECK_NEAR(of_step(answer), 0.0, 1e-9);
  CHECK_EQUAL(answer.joint_summaries.size(), 1U);
  const audit::JointSummary& contact = answer.joint_summaries.at(0);
  CHECK_EQUAL(contact.kind, "contact");
  CHECK_EQUAL(contact.bodies[0], 1U);
  CHECK_EQUAL(contact.bodies[1], 0U);
  CHECK_BETWEEN(static_cast<double>(contact.sliding), 2 / (0.3 * g * h) - 1, 2 / (0.3 * g * h) + 1);
  CHECK_NEAR(contact.friction_share, 1.0, 1e-6);
  CHECK_NEAR(contact.work_J, answer.work.contacts, 1e-12);
}

// 2 kg at (2, 1) m/s slide to rest on friction of 0.3 along the one direction and of 0.1 along the other: ODE's own, y
// and x, or (0.6, 0.8) and (-0.8, 0.6) where the program says so. All of what there may be is used along both, whatever
// is sampled along others: three times as much where they are taken for each other.
void friction_is_of_its_directions() {
  for (const auto& [scenario, speed] : {std::pair{"two_frictions", 2.0}, {"directed_frictions", 0.8 * 2 - 0.6 * 1}}) {
    const audit::Answer answer = recorded(scenario, "3");
    CHECK_NEAR(answer.work.contacts, -5.0, 1e-6);
    const audit::JointSummary& contact = answer.joint_summaries.at(0);
    CHECK_NEAR(contact.friction_share, 1.0, 1e-6);
    CHECK_BETWEEN(static_cast<double>(contact.sliding), speed / (0.1 * g * h) - 2, speed / (0.1 * g * h) + 2);
  }
}

// 2 kg at (2, 1) m/s, with a coefficient of 0.3 along y, and 4 contacts of half a newton, which are no coefficients,
// along x: 1 m/s^2, and 2 s. Five times as much of it where the two are taken for each other.
void friction_is_a_force_or_a_coefficient() {
  const audit::Answer answer = recorded("mixed_frictions", "3");
  CHECK_NEAR(answer.work.contacts, -5.0, 1e-6);
  const audit::JointSummary& contact = answer.joint_summaries.at(0);
  CHECK_NEAR(contact.friction_share, 1.0, 1e-6);
  CHECK_BETWEEN(static_cast<double>(contact.sliding), 2 / (1 * h) - 2, 2 / (1 * h) + 2);
}

// Motors that press on soft stops: what they do there is no force of joints to ODE. The bodies come to rest, so that
// what has been lifted is all of the work, by 0.1 m and what 1000 N/m give way. The hinges take 6e-4 J, measured.
void motors_press_on_stops() {
  const audit::Answer answer = recorded("pressed", "4");
  CHECK_NEAR(answer.work.motors + answer.work.stops + answer.work.joints, g * (0.1 + (15 - g) / 1000), 1e-9);
  CHECK_NEAR(answer.work.joints, 0.0, 2e-3);
  CHECK_NEAR(of_step(answer), 0.0, 1e-9);
  for (std::size_t i = 0; i < 3; ++i) {
    const audit::JointSummary& joint = answer.joint_summaries.at(i);
    CHECK(joint.at_stop > 3700 && joint.at_limit >= joint.at_stop);
  }
}

// At a low stop a motor of 5 N that would leave it pushes with what the fudge factor leaves of it, 1 N, and is not at
// its limit; one that is to stand still presses on either stop. At rest all have gone as far as 1000 N/m give way. The
// high stop takes as much as the motor gives, so that the sum there is none: of the wrong sign it would be 0.05 J.
void motors_at_stops_push_as_odes_do() {
  const audit::Answer answer = recorded("at_stops", "4");
  const double low = -g * ((g - 1) + (g + 5)) / 1000;
  CHECK_NEAR(answer.work.motors + answer.work.stops + answer.work.joints, low, 1e-9);
  CHECK_NEAR(of_step(answer), 0.0, 1e-9);
  const auto joint = [&](std::size_t i) { return answer.joint_summaries.at(i); };
  // Each motor's is its force times how far the stop gives way: what the stop takes again is told by itself.
  const double motors[] = {-(g - 1) / 1000, 5 * (g + 5) / 1000, 5 * 5.0 / 1000};
  for (std::size_t i = 0; i < 3; ++i) CHECK_NEAR(joint(i).motor_work_J, motors[i], 1e-9);
  CHECK_NEAR(joint(2).stop_work_J, -motors[2], 1e-9);
  CHECK_NEAR(answer.work.motors, motors[0] + motors[1] + motors[2], 1e-9);
  CHECK_EQUAL(joint(0).at_limit.value_or(1), 0U);
  for (std::size_t i = 0; i < 3; ++i) CHECK_EQUAL(joint(i).at_stop.value_or(0), 4000U);
  for (std::size_t i = 1; i < 3; ++i) CHECK_EQUAL(joint(i).at_limit.value_or(0), 4000U);
}

// 2 N on a kilogram from rest do 2 J in a second. A lift at 0.5 m/s bears a kilogram, 0.3 m beside it: the joint's work
// is on the weight alone, since what moves the lift is the program's, whose pushes it does not feel. CFM of 1e-10 and
// the weight's speed, which is off by 1e-9 m/s, leave less than 1e-7.
void what_moves_by_itself_takes_no_work() {
  const audit::Answer answer = recorded("lifted", "1");
  CHECK_NEAR(answer.work.added, 2.0, 1e-9);
  CHECK_NEAR(answer.work.joints, g * 0.5, 1e-6);
  CHECK_NEAR(answer.energy.begin_J, 0.5 * 0.5 * 0.5, 1e-12);
  CHECK_NEAR(answer.energy.end_J, 0.5 * 0.5 * 0.5 + g * 0.5 + 2, 1e-6);
  CHECK_NEAR(answer.joint_summaries.at(0).force_N, g, 1e-6);
  CHECK_NEAR(answer.joint_summaries.at(0).torque_Nm, 0.3 * g, 1e-6);
}

// Of a ball that slides the normal force is the weight: with friction it would be 4 % more.
void the_force_of_a_contact_is_normal() { CHECK_NEAR(recorded("skid", "0.5").joint_summaries.at(0).force_N, g, 1e-5); }

// A contact stops the mass that both bodies have against each other, with ODE's own CFM and ERP.
void contacts_stop_both_bodies() {
  CHECK_NEAR(recorded("second_touch", "0.1").contact_s, 1e-10 / ((1 + 1e-3) * (1 - 0.2)), 1e-15);
}

// One of a kilogram by a spring of 1000 N/m and 20 N s/m: in 1/sqrt(1000) s by the spring, in 1/20 s by the damper,
// whether the contact has both its numbers or the world one of them.
void contacts_stop_by_their_own_numbers() {
  for (const char* scenario : {"soft_contact", "soft_erp_contact", "soft_cfm_contact"}) {
    CHECK_NEAR(recorded(scenario, "0.3").contact_s, std::sqrt(1.0 / 1000), 1e-12);
  }
}

// A stop is one within the turn that ODE tells of: a box gets to it in 0.7 s and stays there, or passes by.
void stops_beyond_a_turn_are_none() {
  const audit::Answer answer = recorded("far_stops", "2");
  for (std::size_t i = 0; i < 4; ++i) {
    const auto steps = static_cast<double>(answer.joint_summaries.at(i).at_stop.value_or(0));
    CHECK_BETWEEN(steps, i == 1 ? 0 : 1000, i == 1 ? 0 : 1500);
  }
}

// Links on hinges are one island, of five rows each, whichever is added last.
void rows_of_an_island_stand_together() {
  const audit::Answer answer = recorded("chain", "0.01");
  constexpr double steps = 10;
  constexpr double rows = 50;
  CHECK_NEAR(answer.solver.iteration, steps * 10 * rows, 1e-6);
  CHECK_NEAR(answer.solver.direct, steps * rows * rows * (1 + rows / 40), 1e-6);
}

// A kilogram at up to 15 N until it goes at 0.5 m/s. Gravity's own error, m g h v / 2, is the step's. The motor's CFM
// of 1e-10 is 1e-9 m/s of its speed.
void a_motor_lifts() {
  const audit::Answer answer = recorded("motor", "1");
  CHECK_NEAR(of_step(answer), g * h * 0.5 / 2, 1e-8);
  CHECK_BETWEEN(answer.work.motors, 4, 5);
  CHECK_NEAR(answer.work.joints, 0.0, 1e-12);
  const audit::JointSummary& slider = answer.joint_summaries.at(0);
  CHECK_EQUAL(slider.kind, "slider");
  CHECK_EQUAL(slider.at_limit.value_or(0), static_cast<std::uint64_t>(0.5 / ((15 - g) * h)));
  CHECK_NEAR(slider.force_N, 15.0, 1e-9);
  CHECK(std::isnan(slider.largest_m));  // to the world: not followed
  CHECK_NEAR(slider.motor_work_J, answer.work.motors, 1e-12);
}

// A spring of 1000 N/m that is 0.1 m open pulls a kilogram in, and rests where it bears its weight: of the energy there
// is as much less as that is lower, and what was in the spring went into its damper.
void a_joint_takes_what_is_gone() {
  const audit::Answer answer = recorded("spring", "1");
  CHECK_NEAR(answer.work.joints, -g * g / 1000, 1e-5);
  CHECK_NEAR(of_step(answer), 0.0, 1e-5);
}

// A motor turns a mast, whose arm is off its hinge, another pushes out a boom that is off to the side of it, and a
// third turns back a hook on the boom: all at their limits all the time, and all of the work is theirs. What is left to
// the joints is of the order of h: 1.7e-4 of it measured, and 0.02 where the bodies' motion is counted wrongly.
void motors_that_turn_with_their_bodies() {
  const audit::Answer answer = recorded("crane", "0.5");
  for (std::size_t i = 0; i < 3; ++i) CHECK_EQUAL(answer.joint_summaries.at(i).at_limit.value_or(0), 500U);
  CHECK_BETWEEN(answer.work.motors, 1, 100);
  CHECK_BETWEEN(std::fabs(answer.work.joints) / answer.work.motors, 0, 1e-3);
  CHECK_BETWEEN(std::fabs(of_step(answer)) / answer.work.motors, 0, 0.01);
}

// A box of 10 kg that tumbles in flight keeps its energy, but for what gravity's own error, m g h v / 2, takes, and for
// 0.013 J of the 8.5 J of its spin, measured. With its inertia in a wrong frame it would be joules.
void a_free_box_keeps_its_energy() {
  const audit::Answer answer = recorded("free_box", "1");
  for (const audit::EnergyPoint& point : answer.energy_over_time) {
    const double by_gravity = -10 * 9.8 * h * 9.8 * point.t_s / 2;
    CHECK_BETWEEN(point.kinetic_J + point.potential_J - answer.energy.begin_J - by_gravity, -0.03, 0.03);
  }
}

// What a kilogram that keeps exp(-h) of its velocity and the square of it of its spin in each step, and falls, loses by
// that, step by step. Its moment of inertia is 0.004 kg m^2.
void damping_takes_its_part() {
  const audit::Answer answer = recorded("damped", "1");
  const double keeps = std::exp(-h);
  double across = 1;
  double down = 0;
  double spin = 5;
  double lost = 0;
  for (int step = 0; step < 1000; ++step) {
    down += g * h;
    lost += 0.5 * (1 - keeps * keeps) * (across * across + down * down);
    lost += 0.5 * 0.004 * (1 - std::pow(keeps, 4)) * spin * spin;
    across *= keeps;
    down *= keeps;
    spin *= keeps * keeps;
  }
  CHECK_NEAR(answer.work.damping, -lost, 1e-9);
  CHECK_NEAR(answer.work.contacts + answer.work.joints + answer.work.added, 0.0, 1e-12);
}

// A kilogram from 1 m/s, pulled by 2 N, whose callback then keeps 1 - h of its velocity, and ODE's damping 1 - h/2:
// each has its own. It keeps 1 - 2 h of its spin of 3 rad/s, of a moment of inertia of 1/600 kg m^2. Sums of a thousand
// terms round by 1e-13.
void what_its_callback_does_is_the_programs() {
  const audit::Answer answer = recorded("braked_and_pulled", "1");
  double velocity = 1;
  double spin = 3;
  double added = 0;
  double program = 0;
  double damping = 0;
  for (int step = 0; step < 1000; ++step) {
    const double pulled = velocity + 2 * h;
    const double braked = (1 - h) * pulled;
    added += 2 * h * (velocity + pulled) / 2;
    program += 0.5 * (braked * braked - pulled * pulled);
    velocity = (1 - h / 2) * braked;
    damping += 0.5 * (velocity * velocity - braked * braked);
    program += 0.5 / 600 * spin * spin * ((1 - 2 * h) * (1 - 2 * h) - 1);
    spin *= 1 - 2 * h;
  }
  CHECK_NEAR(answer.work.added, added, 1e-11);
  CHECK_NEAR(answer.work.program, program, 1e-11);
  CHECK_NEAR(answer.work.damping, damping, 1e-11);
  CHECK_NEAR(of_step(answer), 0.0, 1e-11);
}

// The step that takes a velocity below what damping asks for is the last, of each by its own, the 106th and, of the
// spin, the 112th. All that is gone is damping's. The sum of so many terms of a joule rounds by 1e-15 each.
void what_is_slow_is_not_damped() {
  CHECK_EQUAL(recorded("too_slow", "0.1").work.damping, 0.0);
  const audit::Answer answer = recorded("slows_down", "0.3");
  CHECK_NEAR(answer.work.damping, answer.energy.end_J - answer.energy.begin_J, 1e-12);
  const double of_velocity = 0.5 * (1 - std::exp(-2 * h * 106));         // ln(1/0.9) = 0.10536
  const double of_spin = 0.5 / 600 * 25 * (1 - std::exp(-4 * h * 112));  // ln(5/4) / 2 = 0.11157
  CHECK_NEAR(answer.work.damping, -of_velocity - of_spin, 1e-12);
}

// What a joint lets its bodies do is no gap, nor that they turn together; bodies without weight have no energy of
// gravity.
void gaps_are_across() {
  const audit::Answer answer = recorded("apart", "0.01");
  CHECK_EQUAL(answer.energy.begin_J, 0.0);
  for (std::size_t i = 0; i < 5; ++i) {
    const audit::JointSummary& joint = answer.joint_summaries.at(i);
    CHECK_NEAR(joint.largest_m, 0.1 + 0.01 * static_cast<double>(i), 1e-9);
    CHECK_NEAR(joint.largest_t_s, 5 * h, 1e-9);
  }
  CHECK_EQUAL(answer.gap.joint, 5U);  // the widest
  CHECK_NEAR(answer.gap.largest_m, 0.14, 1e-9);
  CHECK_NEAR(answer.gap.t_s, 5 * h, 1e-9);
}

// A controller's torque takes the arm from rest to rest 0.12 rad lower: the gravity that is gone, m g dz.
void a_controller_takes_what_is_gone() {
  const audit::Answer answer = recorded("arm", "3");
  CHECK(answer.work.added < -0.5);
  CHECK_NEAR(answer.work.added, answer.energy.end_J - answer.energy.begin_J, 1e-5);
}

// A ball that falls 1 m and comes to rest leaves all of it to its contacts.
void a_ball_comes_to_rest() {
  const audit::Answer answer = recorded("bouncing_ball", "5");
  CHECK_NEAR(answer.work.contacts, -g, 1e-6);
  const double fastest = std::sqrt(2 * g);
  CHECK_BETWEEN(answer.joint_summaries.at(0).largest_m, 0.01 * fastest * h, fastest * h);  // what it falls in a step
  const double first = std::sqrt(2 / g);  // when it is fastest; of step and contact, told at the end of it
  CHECK_BETWEEN(answer.joint_summaries.at(0).largest_t_s, first - 2 * h, first + 2 * h);
}

// What the program sets by hand is its own, and what is left to the step is gravity's error, m g^2 h t / 2, of the one
// that falls. Sums of a few joules round by 1e-15 of them, 500 times.
void what_is_set_by_hand_is_the_programs() {
  const audit::Answer answer = recorded("by_hand", "0.5");
  const double sped_up = 0.5 * 3 * 3;
  const double comes = 0.5 * 2 * 2;
  const double goes = 0.5;
  CHECK_NEAR(answer.work.program, sped_up + comes - goes + g * 2, 1e-11);
  CHECK_NEAR(of_step(answer), -g * g * h * 0.5 / 2, 1e-11);
}

// Runs of two worlds, the one longer than the other: told is the step of the world, not of both together.
void two_worlds_part_at_a_step_of_one() {
  const test::TemporaryFolder folder;
  const std::string first = (folder.path() / "first").string();
  const std::string second = (folder.path() / "second").string();
  record_to(first, "two_worlds", "0.2");
  record_to(second, "two_worlds", "0.3");
  const std::optional<audit::Parting> parting = audit::parting(first, second);
  CHECK(parting.has_value());
  CHECK_EQUAL(parting.value_or(audit::Parting{}).step, 201U);
  CHECK_NEAR(parting.value_or(audit::Parting{}).t_s, 0.201, 1e-9);
}

// A universal from the world to a body: what its motor does is the motor's, about the axis that the parameters are of.
// All of it is in the boxes that turn but for what the joints take, which is of the order of h.
void motors_of_universals_turn_either_way() {
  const audit::Answer answer = recorded("crossed", "1");
  for (std::size_t i = 0; i < 3; ++i) {
    const audit::JointSummary& joint = answer.joint_summaries.at(i);
    CHECK_EQUAL(joint.at_limit.value_or(0), 1000U);  // a step at most counts once
    CHECK_NEAR(joint.motor_work_J + joint.stop_work_J, joint.work_J, 0.01 * std::fabs(joint.work_J) + 1e-4);
  }
  CHECK_NEAR(answer.joint_summaries[0].work_J, answer.joint_summaries[1].work_J, 1e-9);
  CHECK(answer.joint_summaries[0].work_J > 0.1);
  CHECK(answer.joint_summaries[2].at_stop.value_or(0) > 300);
  CHECK_EQUAL(answer.joint_summaries.at(3).at_limit.value_or(0), 1000U);  // one of two axes, or both
}

// A hundredth of a newton metre about either axis of a hinge2 is all of what its ball has, of 0.004 kg m^2, after a
// second: 0.01 h / 0.004 rad/s more in each step. The third gets to its stop at 0.1 rad, and does not go on.
void motors_of_wheels_drive_and_steer() {
  const audit::Answer answer = recorded("wheels", "1");
  const double inertia = 0.4 * 0.1 * 0.1;
  for (std::size_t i = 0; i < 2; ++i) {
    const audit::JointSummary& joint = answer.joint_summaries.at(i);
    CHECK_NEAR(joint.motor_work_J, 0.5 * inertia * std::pow(0.01 / inertia, 2), 1e-9);
    CHECK_EQUAL(joint.at_limit.value_or(0), 1000U);
    CHECK_EQUAL(joint.at_stop.value_or(1), 0U);
  }
  CHECK(answer.joint_summaries.at(2).at_stop.value_or(0) > 500);
}

// What presses on the lift that goes up with it does no work: the stop takes what the motor gives, 5 N at 0.5 m/s. What
// the stop gives way by, at first, is below 1e-8 m.
void a_motor_that_presses_on_a_lift_does_no_work() {
  const audit::Answer answer = recorded("pressed_on_a_lift", "1");
  CHECK_NEAR(answer.work.motors, 0.0, 1e-6);
  CHECK_NEAR(answer.work.stops, 0.0, 1e-6);
  CHECK_NEAR(answer.work.joints, 0.0, 1e-6);
  CHECK_NEAR(of_step(answer), 0.0, 1e-6);
  CHECK_EQUAL(answer.joint_summaries.at(0).at_stop.value_or(0), 1000U);
}

// Of kinds whose motors and gaps are not followed nothing is told, rather than 0.
void what_is_not_followed_is_not_told() {
  const audit::Answer answer = recorded("soft_stops", "0.1");
  for (const audit::JointSummary& joint : answer.joint_summaries) {
    const bool is_motor = joint.kind == "amotor";
    const bool is_other = joint.kind == "piston" || joint.kind == "pr" || joint.kind == "pu";
    CHECK_EQUAL(joint.at_limit.has_value(), !is_motor && !is_other);
    CHECK_EQUAL(joint.at_stop.has_value(), !is_motor && !is_other);
    CHECK_EQUAL(std::isnan(joint.motor_work_J), is_other);
    CHECK_EQUAL(std::isnan(joint.largest_m), is_motor || is_other || joint.kind == "hinge2");
  }
}

// What a record begins with is of the world that steps, not of one that was made before.
void the_head_is_of_the_world_that_steps() {
  const test::TemporaryFolder folder;
  const std::string record = (folder.path() / "record").string();
  record_to(record, "second_only", "0.1");
  const audit::Recording recording(record);
  CHECK(recording.head() != nullptr);
  if (recording.head() == nullptr) return;
  CHECK_EQUAL(recording.head()->erp, 0.3);
  CHECK_EQUAL(recording.head()->gravity[2], -3.0);
  CHECK_EQUAL(recording.head()->refinement, 1U);
}

}  // namespace

int main() {
  friction_takes_it_all();
  friction_is_of_its_directions();
  friction_is_a_force_or_a_coefficient();
  motors_press_on_stops();
  stops_beyond_a_turn_are_none();
  motors_at_stops_push_as_odes_do();
  what_moves_by_itself_takes_no_work();
  the_force_of_a_contact_is_normal();
  contacts_stop_both_bodies();
  contacts_stop_by_their_own_numbers();
  rows_of_an_island_stand_together();
  a_motor_lifts();
  a_joint_takes_what_is_gone();
  motors_that_turn_with_their_bodies();
  motors_of_universals_turn_either_way();
  motors_of_wheels_drive_and_steer();
  a_motor_that_presses_on_a_lift_does_no_work();
  what_is_not_followed_is_not_told();
  the_head_is_of_the_world_that_steps();
  a_free_box_keeps_its_energy();
  damping_takes_its_part();
  what_its_callback_does_is_the_programs();
  what_is_slow_is_not_damped();
  gaps_are_across();
  a_controller_takes_what_is_gone();
  a_ball_comes_to_rest();
  what_is_set_by_hand_is_the_programs();
  two_worlds_part_at_a_step_of_one();
  return test::verdict();
}
