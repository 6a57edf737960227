#pragma once
// What an audit says of a running ODE program: how far its simulation is from the one that it would be at a step of 0.
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace odeval::audit {

/// How the errors of the refined runs fall, the best first.
enum class Convergence {
  settled,  // by the order's own factor: the error is known to a tenth
  rough,    // they fall, but the error is known to its size only
  none,     // they do not: there is no limit in sight
};

/// A difference from the limit, what the limit itself may be off by, and whether there is one.
/// In the unit of what it stands for. A value that is not finite: a run blew up.
struct Estimate {
  double value = 0;        // >= 0, the distance from the limit
  double uncertainty = 0;  // >= 0, half the width of the interval that holds the value
  Convergence convergence = Convergence::none;

  static constexpr double nothing = 1e-9;  // m or rad: nobody's concern, and near rounding
};

/// The largest until a time, over bodies and over all steps of the program.
struct ErrorUntil {
  double t_s = 0;                 // simulated
  Estimate distance_m;            // of centres of mass
  Estimate turn_rad;              // of attitudes
  std::optional<double> order;    // of the larger part; nothing where there is no error
  std::uint32_t body = 0;         // with the largest distance, from 1 in order of creation
  std::vector<double> of_runs{};  // of each refined run, in the order of its refinements; m, or rad where turned()

  /// Share of the one below which the other says nothing, a metre counted as a radian.
  static constexpr double little = 1e-3;
  /// Whether next to nothing of the error is a distance: steps and settings are told by the turn then.
  bool turned() const { return turn_rad.value > Estimate::nothing && distance_m.value < little * turn_rad.value; }
  /// The part that they are told by.
  const Estimate& by(bool turn) const { return turn ? turn_rad : distance_m; }
  /// Of the worse part; one of which there is next to nothing, a metre counted as a radian, says nothing.
  Convergence convergence() const {
    const double distance = distance_m.value + distance_m.uncertainty;
    const double turn = turn_rad.value + turn_rad.uncertainty;
    if (turn < little * distance) return distance_m.convergence;
    if (distance < little * turn) return turn_rad.convergence;
    return std::max(distance_m.convergence, turn_rad.convergence);
  }
};

/// The same of one body.
struct BodyError {
  double t_s = 0;          // simulated
  std::uint32_t body = 0;  // from 1 in order of creation
  Estimate distance_m;     // of its centre of mass
  Estimate turn_rad;       // of its attitude
};

/// The largest step, up to the program's own, that keeps an error.
struct StepFor {
  double error = 0;           // that it keeps, uncertainty and all; m, or rad where Answer::by_turn
  std::optional<double> h_s;  // nothing: smaller than the finest that was tried, and how much can not be told
};

/// A run of the program, as it ended.
struct ProgramRun {
  int refinement = 1;                // k, of steps of h/k
  std::string what;                  // "unchanged", "steps of h/2", "starts moved by 1e-10 m"
  std::string end;                   // "exit status 0", "ended by --until 10"
  std::optional<int> exit_status{};  // where it ended by itself, and by no signal
  std::uint64_t steps = 0;           // that the program asked for, in the world of most
  double simulated_s = 0;            // of the world that went farthest
  double cpu_s = 0;                  // of the whole process, user and system
};

/// The program with another setting, at its own step.
struct Tried {
  std::string set;                // "erp=0.8"
  std::vector<Estimate> error{};  // m, or rad where Answer::by_turn; at the times of Answer::error_at until tried_at;
                                  // no number: ended by then
  double cpu = 0;                 // time of a step within ODE, over that of the unchanged run: as it was measured
  double work = 0;                // of the solver over that of the unchanged run, as it was counted; NaN: not known
  bool is_own = false;            // the run is the unchanged one to the bit
  bool asked = false;             // for by the user
};

/// What the solvers have to do in the unchanged run: rows of joints and contacts, weighted by what they were measured
/// to take, in ns. The machine's time is another each time; this is not.
struct SolverWork {
  double direct = 0;     // of dWorldStep: by the rows of each island of bodies that are joined
  double iteration = 0;  // of one of dWorldQuickStep's
  double besides = 0;    // of both
  std::uint32_t iterations = 0;
};

/// Kinetic energy and that of gravity, of all bodies; nothing of springs and motors.
struct Energy {
  double begin_J = 0;  // before the first step
  double end_J = 0;    // after the last one
  Estimate error_J;    // at the end, from the limit's
};

/// Work on the bodies since the start, J: what acts in a step, times the mean of the velocities before and after it.
/// What the energy has changed by besides is the step's own doing.
struct Work {
  double added = 0;     // by forces and torques that the program added
  double motors = 0;    // along the axes of joints
  double stops = 0;     // likewise
  double joints = 0;    // by what holds their bodies together
  double contacts = 0;  // friction and all
  double damping = 0;   // of dWorldSetLinearDamping and the like
  double program = 0;   // what the energy changes by between steps: bodies that it makes, removes, moves, speeds up

  double sum() const { return added + motors + stops + joints + contacts + damping + program; }
};

/// How far the halves of a joint were apart at most.
struct Gap {
  double largest_m = 0;
  double t_s = 0;           // when
  std::uint32_t joint = 0;  // from 1 in order of creation; 0: none
};

/// A step of the program, of the world made `world`-th, from 1.
struct StepRow {
  std::uint32_t world = 1;
  double t_s = 0;              // at its end
  double kinetic_J = 0;        // of all bodies
  double potential_J = 0;      // of gravity, 0 at the origin
  Work work{};                 // until then
  double gap_m = 0;            // the largest of a joint
  std::uint32_t contacts = 0;  // joints
  double depth_m = 0;          // of the deepest contact
  std::uint32_t messages = 0;  // of ODE, in the step
};

/// A joint of the unchanged run, or all contacts between two bodies: what it came to at most.
struct JointSummary {
  std::string kind;                         // "hinge", "contact"
  std::uint32_t number = 0;                 // of a joint, from 1 in order of creation; 0: contacts
  std::uint32_t bodies[2]{};                // from 1; 0: the world
  std::uint64_t steps = 0;                  // that it was there
  double largest_m = 0;                     // gap, or depth of a contact; NaN: not followed, of this kind of joint
  double largest_t_s = 0;                   // when
  double force_N = 0;                       // the largest on a body, of a contact the normal one
  double torque_Nm = 0;                     // likewise, about the body's centre
  double work_J = 0;                        // of all of it on both bodies
  double motor_work_J = 0;                  // of its motors alone; NaN: not followed
  double stop_work_J = 0;                   // of its stops, likewise
  std::optional<std::uint64_t> at_limit{};  // steps in which a motor's force was what it may be at most; none: likewise
  std::optional<std::uint64_t> at_stop{};   // steps that began at a stop or beyond; none: likewise
  double friction_share = 0;  // the largest of what friction may be, of all contacts between the two in a step
  std::uint64_t sliding = 0;  // steps with all of it
  std::uint64_t rough = 0;    // steps with a limit to friction
};

/// Errors of the refined runs until a time.
struct ErrorPoint {
  double t_s = 0;
  std::vector<double> distance_m;  // of each refined run, from the limit
  double uncertainty_m = 0;        // of the limit

  void take(const ErrorPoint& next) { *this = next; }  // they only grow
};

/// Of all worlds, at the end of a step.
struct EnergyPoint {
  double t_s = 0;
  double kinetic_J = 0;
  double potential_J = 0;
  Work work{};
  double gap_m = 0;    // the largest since the point before
  double depth_m = 0;  // likewise

  void take(const EnergyPoint& next) {
    const double gap = std::max(gap_m, next.gap_m);
    const double depth = std::max(depth_m, next.depth_m);
    *this = next;
    gap_m = gap;
    depth_m = depth;
  }
};

/// Where two runs of the same program part, or where it is no number any more.
struct Parting {
  std::uint64_t step = 0;  // of the program, from 1; 0: the start
  double t_s = 0;
  std::uint32_t body = 0;  // from 1; 0: the runs differ in bodies or in steps
};

/// All that an audit has to say: what `odeval audit` prints and writes to answer.json.
struct Answer {
  std::string program;  // its command line
  std::string stepper;  // "dWorldStep", "dWorldQuickStep" or both
  double h_s = 0;       // of the first step
  bool h_varies = false;
  bool springs_held = true;  // ERP, CFM and damping converted; else the numbers
  bool contacts_held = false;
  std::uint32_t worlds = 0;  // that step
  std::uint32_t bodies = 0;  // the most at a time of each world, of all together, as the two after them
  std::uint32_t joints = 0;
  std::uint32_t contacts = 0;
  std::uint32_t bodies_made = 0;                    // in all
  bool adds_forces = false;                         // the program, to bodies that move
  double depth_m = 0;                               // the largest
  double contact_s = 0;                             // the shortest in which a contact stops what it holds
  std::uint64_t messages = 0;                       // of ODE, in the unchanged run
  std::string first_message;                        // empty: none
  double first_message_t_s = 0;                     // end of its step
  std::map<std::uint32_t, std::string> body_names;  // from 1, those that the program named
  std::map<std::uint32_t, std::string> joint_names;
  SolverWork solver;

  std::vector<ProgramRun> runs;     // the unchanged first
  std::optional<Parting> parting;   // of the two unchanged runs: nothing: they are the same to the bit
  std::optional<Parting> diverged;  // where the unchanged run is no number any more: what is told is of the time before
  bool unrecorded = false;          // there was no room for all of the unchanged run
  std::string reason;               // why there is no error; empty: there is

  double until_s = 0;                    // up to which all runs go
  std::vector<ErrorUntil> error_at;      // at 1, 2, 5, 10, … s and at the end
  std::vector<BodyError> error_of_body;  // at the same times, by time and body
  std::optional<double> lost_at_s;       // where a body is off by more than a tenth of how far it has gone until then
  std::uint32_t lost_body = 0;           // that one, from 1
  bool lost_turned = false;              // it is its turn, and how far it has turned
  std::optional<double> growth;          // of a distance of starts, the most
  std::optional<double> chaos_from_s;    // where starts that were moved are apart by as much as the error
  bool flies_apart = false;              // starts that were moved, far beyond where a finer step takes them
  bool by_turn = false;                  // steps_for, tried and the worst body: next to nothing is a distance
  std::uint32_t worst_body = 0;          // that is farthest off until the time of steps_for
  double worst_t_s = 0;                  // when it was
  std::size_t limit_degree = 0;          // of the polynomial in the step that the limit is from, until then
  std::size_t told_at = 0;               // of error_at, the last time before the motion is lost that has a limit
  double steps_for_t_s = 0;              // that time, which the steps keep the error until
  std::vector<StepFor> steps_for;
  std::vector<Tried> tried;
  std::size_t tried_at = 0;          // of error_at: told_at, or the last before it that a long run has early
  std::optional<double> softness_m;  // how far a run that holds numbers in the place of springs is from the limit, at
                                     // the refinement of which the same run with springs is `softness_of_step_m` off;
                                     // nothing where by_turn
  double softness_of_step_m = 0;
  Energy energy;
  Work work{};  // until the end of the unchanged run
  Gap gap;
  std::vector<JointSummary> joint_summaries;  // joints by number, then contacts, the deepest first
  std::vector<ErrorPoint> error_over_time;    // a thousand at most, of all steps, as the next
  std::vector<EnergyPoint> energy_over_time;
  std::vector<std::string> limits;  // of this answer, a sentence each
};

}  // namespace odeval::audit
