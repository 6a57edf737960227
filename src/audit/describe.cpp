// What one run of the program was, and where two of them part.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "audit/judge.hpp"
#include "audit/recording.hpp"
#include "audit/thinned.hpp"

namespace odeval::audit {
namespace {

Work work_of(const Account& account) {
  return {account.work_added,    account.work_motors,  account.work_stops,  account.work_joints,
          account.work_contacts, account.work_damping, account.work_program};
}

/// Of joints, and what the ledger tells of them.
struct Kind {
  const char* name;
  bool gap = true;
  bool motor_work = true;
  bool limits = true;        // of its motors and stops
  bool gap_to_world = true;  // false where it would be a small turn, far from the world's origin
};
/// ODE's, in their order.
Kind kind_of(std::uint32_t type) {
  constexpr std::array kinds{Kind{"none"},
                             Kind{"ball"},
                             Kind{"hinge"},
                             Kind{"slider", true, true, true, false},
                             Kind{"contact"},
                             Kind{"universal"},
                             Kind{"hinge2", false},
                             Kind{"fixed", true, true, true, false},
                             Kind{"null"},
                             Kind{"amotor", false, true, false},
                             Kind{"lmotor", false, true, false},
                             Kind{"plane2d", false, false, false},
                             Kind{"pr", false, false, false},
                             Kind{"pu", false, false, false},
                             Kind{"piston", false, false, false},
                             Kind{"double ball", false},
                             Kind{"double hinge", false},
                             Kind{"transmission", false}};
  return type < kinds.size() ? kinds[type] : Kind{"joint", false, false, false};
}
constexpr std::uint32_t contact_type = 4;

JointSummary summary_of(const PartSample& part) {
  const Kind kind = kind_of(part.type);
  const bool has_gap = kind.gap && (kind.gap_to_world || (part.bodies[0] != 0 && part.bodies[1] != 0));
  const auto steps = [&kind](std::uint64_t number) { return kind.limits ? std::optional(number) : std::nullopt; };
  return {.kind = kind.name,
          .number = part.type == contact_type ? 0 : part.number + 1,
          .bodies = {part.bodies[0], part.bodies[1]},
          .steps = part.steps,
          .largest_m = has_gap ? part.largest_m : NAN,
          .largest_t_s = has_gap ? part.largest_t : NAN,
          .force_N = part.force,
          .torque_Nm = part.torque,
          .work_J = part.work,
          .motor_work_J = kind.motor_work ? part.motor_work : NAN,
          .stop_work_J = kind.motor_work && kind.limits ? part.stop_work : NAN,
          .at_limit = steps(part.steps_at_limit),
          .at_stop = steps(part.steps_at_stop),
          .friction_share = part.friction_share,
          .sliding = part.steps_sliding,
          .rough = part.steps_rough};
}

/// Joints by number, then contacts, the deepest first.
std::vector<JointSummary> read_summaries(const std::filesystem::path& record) {
  std::vector<JointSummary> all;
  for (const PartSample& part : read_rows<PartSample>(record.string() + parts_ending)) all.push_back(summary_of(part));
  std::ranges::stable_sort(all, [](const JointSummary& a, const JointSummary& b) {
    if ((a.number == 0) != (b.number == 0)) return a.number != 0;
    return a.number != 0 ? a.number < b.number : a.largest_m > b.largest_m;
  });
  return all;
}

/// How much there is of what, in all worlds together.
class Counts {
 public:
  /// Raises the most at a time to what there is now.
  void add(const Recording::Moment& moment, Answer& answer) {
    worlds_[moment.frame.world] = {moment.frame.bodies, moment.account->joints, moment.account->contacts};
    std::array<std::uint32_t, 3> sum{};
    for (const auto& [world, counts] : worlds_) {
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += counts[i];
    }
    answer.worlds = static_cast<std::uint32_t>(worlds_.size());
    answer.bodies = std::max(answer.bodies, sum[0]);
    answer.joints = std::max(answer.joints, sum[1]);
    answer.contacts = std::max(answer.contacts, sum[2]);
  }

 private:
  std::map<std::uint32_t, std::array<std::uint32_t, 3>> worlds_;
};

/// Of all worlds, at the time of the moment, and its gap.
EnergyPoint sum_of(const std::map<std::uint32_t, EnergyPoint>& worlds, const Recording::Moment& moment) {
  EnergyPoint sum{.t_s = moment.frame.t, .gap_m = moment.account->gap, .depth_m = moment.account->depth};
  for (const auto& [number, world] : worlds) {
    sum.kinetic_J += world.kinetic_J;
    sum.potential_J += world.potential_J;
    sum.work.added += world.work.added;
    sum.work.motors += world.work.motors;
    sum.work.stops += world.work.stops;
    sum.work.joints += world.work.joints;
    sum.work.contacts += world.work.contacts;
    sum.work.damping += world.work.damping;
    sum.work.program += world.work.program;
  }
  return sum;
}

void read_names(const std::string& file, Answer& answer) {
  std::ifstream in(file);
  for (std::string text; std::getline(in, text);) {
    std::istringstream line(text);
    std::string kind;
    std::uint32_t number = 0;
    if (!(line >> kind >> number)) continue;
    auto& names = kind == "body" ? answer.body_names : answer.joint_names;
    std::string name;
    if (std::getline(line >> std::ws, name)) {
      names[number + 1] = name;
    } else {
      names.erase(number + 1);  // an empty name is none
    }
  }
}

}  // namespace

std::optional<Parting> parting(const std::filesystem::path& one, const std::filesystem::path& other) {
  Recording a(one);
  Recording b(other);
  for (;;) {
    const auto ours = a.next();
    const auto theirs = b.next();
    if (!ours && !theirs) return std::nullopt;
    if (!ours || !theirs) {
      const Frame& last = (ours ? ours : theirs)->frame;
      return Parting{last.step, last.t, 0};
    }
    if (!same_bodies(*ours, *theirs)) return Parting{ours->frame.step, ours->frame.t, 0};
    for (std::size_t i = 0; i < ours->bodies.size(); ++i) {
      const bool same = std::memcmp(&ours->bodies[i], &theirs->bodies[i], sizeof(BodySample)) == 0 &&
                        std::memcmp(&ours->motions[i], &theirs->motions[i], sizeof(MotionSample)) == 0;
      if (same) continue;
      return Parting{ours->frame.step, ours->frame.t, ours->bodies[i].body + 1};
    }
  }
}

void describe(const std::filesystem::path& unchanged, Answer& answer) {
  Recording run(unchanged);
  read_names(unchanged.string() + names_ending, answer);
  answer.joint_summaries = read_summaries(unchanged);
  if (const Head* head = run.head()) {
    answer.messages = head->messages;
    answer.first_message = head->first_message;
    answer.contact_s = head->contact_s;
    answer.solver = {head->direct, head->iteration, head->besides, head->iterations};
  }
  bool quick = false;
  bool plain = false;
  Counts counts;
  std::vector<bool> seen;                       // bodies
  std::map<std::uint32_t, EnergyPoint> worlds;  // as they were last
  Thinned<EnergyPoint> curve;
  for (auto moment = run.next(); moment; moment = run.next()) {
    const Frame& frame = moment->frame;
    const Account& account = *moment->account;
    if (const std::uint32_t body = not_finite(*moment)) {
      answer.diverged = Parting{frame.step, frame.t, body};
      break;
    }
    EnergyPoint& world = worlds[frame.world];
    world = {frame.t, frame.kinetic, frame.potential, work_of(account), account.gap, account.depth};
    curve.add(sum_of(worlds, *moment));
    if (frame.step == 0) {
      answer.energy.begin_J += world.kinetic_J + world.potential_J;
      continue;
    }
    if (answer.messages > 0 && answer.first_message_t_s == 0 && account.messages > 0)
      answer.first_message_t_s = frame.t;
    if (answer.h_s == 0) answer.h_s = frame.h;
    answer.h_varies = answer.h_varies || frame.h != answer.h_s;
    (account.quick != 0 ? quick : plain) = true;
    counts.add(*moment, answer);
    for (const BodySample& body : moment->bodies) {
      if (body.body >= seen.size()) seen.resize(body.body + 1);
      if (!seen[body.body]) ++answer.bodies_made;
      seen[body.body] = true;
    }
    answer.adds_forces = answer.adds_forces || account.work_added != 0;
    answer.depth_m = std::max(answer.depth_m, account.depth);
    if (account.gap > answer.gap.largest_m) answer.gap = {account.gap, frame.t, account.gap_joint};
  }
  const EnergyPoint end = sum_of(worlds, {});
  answer.energy.end_J = end.kinetic_J + end.potential_J;
  answer.work = end.work;
  answer.energy_over_time = curve.points();
  answer.stepper = quick && plain ? "dWorldStep and dWorldQuickStep" : quick ? "dWorldQuickStep" : "dWorldStep";
}

void each_step(const std::filesystem::path& record, const std::function<void(const StepRow&)>& take) {
  Recording run(record);
  for (auto moment = run.next(); moment; moment = run.next()) {
    const Frame& frame = moment->frame;
    const Account& account = *moment->account;
    take({frame.world + 1, frame.t, frame.kinetic, frame.potential, work_of(account), account.gap, account.contacts,
          account.depth, account.messages});
  }
}

}  // namespace odeval::audit
