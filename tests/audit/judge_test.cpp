// Records of motions that are known, as the runs of a program would leave them: does the judge say what they come to?
#include "audit/judge.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>

#include "audit/preload/record_format.hpp"
#include "audit/scene.hpp"
#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using namespace odeval::audit;
namespace fs = std::filesystem;

/// A body at a time.
struct Seen {
  std::uint32_t body;  // from 1
  double x = 0;        // m
  double angle = 0;    // rad, about x
  double energy = 0;   // J
};
/// Of a run with steps of `h` whose starts are moved by `moved`, at the end of a step of the program.
using Motion = std::function<std::vector<Seen>(double t, double h, double moved)>;

template <class Row>
void put(std::string& bytes, const Row& row) {
  bytes.append(reinterpret_cast<const char*>(&row), sizeof row);
}

/// One step of the program a frame, h long, until `end_s`.
void write_record(const fs::path& file, const Motion& motion, double h, double end_s, int refinement, double moved) {
  std::string frames;
  const auto steps = std::lround(end_s / h);
  for (long step = 0; step <= steps; ++step) {
    const double t = h * static_cast<double>(step);
    const std::vector<Seen> bodies = motion(t, h / refinement, moved);
    Frame frame{};
    frame.bytes =
        static_cast<std::uint32_t>(sizeof frame + bodies.size() * (sizeof(BodySample) + sizeof(MotionSample)));
    frame.step = static_cast<std::uint64_t>(step);
    frame.t = t;
    frame.h = h;
    frame.bodies = static_cast<std::uint32_t>(bodies.size());
    frame.has_motions = 1;
    for (const Seen& body : bodies) frame.kinetic += body.energy;
    put(frames, frame);
    for (const Seen& body : bodies) {
      put(frames, BodySample{body.body - 1, 1, {body.x, 0, 0}, {std::cos(body.angle / 2), std::sin(body.angle / 2)}});
    }
    for (std::size_t i = 0; i < bodies.size(); ++i) put(frames, MotionSample{});
  }
  Head head{};
  head.magic = record_magic;
  head.committed = frames.size();
  head.behind = (frames.size() + window_bytes - 1) / window_bytes * window_bytes;
  std::string whole;
  put(whole, head);
  whole.resize(head_bytes + window_bytes);
  whole += frames;
  whole.resize(head_bytes + window_bytes + head.behind);
  std::ofstream(file, std::ios::binary) << whole;
}

constexpr double moved_by_m = 1e-10;

/// Runs at h, h/2, h/4 and h/8, one with starts moved, and one with another setting, which moves as the first.
Records recorded(const fs::path& folder, const Motion& motion, double h, double end_s) {
  Records records;
  records.refinements = {1, 2, 4, 8};
  for (const int k : records.refinements) {
    records.refined.push_back(folder / std::to_string(k));
    write_record(records.refined.back(), motion, h, end_s, k, 0);
  }
  records.unchanged_again = records.refined.front();
  records.moved = folder / "moved";
  records.moved_by_m = moved_by_m;
  write_record(*records.moved, motion, h, end_s, 1, moved_by_m);
  records.tried = {records.refined.front()};
  records.tried_sets = {"erp=0.5"};
  records.asked = 1;
  return records;
}

Answer judged(const Motion& motion, double h, double end_s) {
  const odeval::test::TemporaryFolder folder;
  const Records records = recorded(folder.path(), motion, h, end_s);
  Answer answer;
  describe(records.refined.front(), answer);
  const std::vector<LimitOf> limits = judge(records, answer);
  judge_tried(records, limits, answer);
  return answer;
}

double lost(const Answer& answer) { return answer.lost_at_s.value_or(HUGE_VAL); }

/// Swings to a metre on each side, ever more behind.
double swing(double t, double h) { return std::sin(3 * t - 5 * h * t * t); }
/// What a step of first order leaves of a fall: g h t / 2.
double fall(double t, double h) { return 9.81 * t * (t + h) / 2; }

// At a step of a hundredth it is off by 0.05 t² |cos 3t|, which is first more than a tenth of a metre at 1.80 s:
// whatever else there is, and however long it goes on.
void a_body_is_held_against_itself() {
  const Motion alone = [](double t, double h, double) { return std::vector{Seen{1, swing(t, h)}}; };
  const Motion beside = [](double t, double h, double) {
    return std::vector{Seen{1, swing(t, h)}, Seen{2, fall(t, h), 40 * t}};
  };
  const Answer its = judged(alone, 0.01, 4);
  CHECK_BETWEEN(lost(its), 1.75, 1.85);
  CHECK_EQUAL(its.lost_body, 1U);
  CHECK(!its.lost_turned);
  for (const double end : {2.0, 8.0}) CHECK_EQUAL(lost(judged(alone, 0.01, end)), lost(its));
  CHECK_EQUAL(lost(judged(beside, 0.01, 4)), lost(its));
}

// What begins to move is off by much of its way and is not lost; nor is what is hit a step late, or hardly moves.
void beginnings_are_no_loss() {
  CHECK(!judged([](double t, double h, double) { return std::vector{Seen{1, fall(t, h)}}; }, 0.05, 3).lost_at_s);
  CHECK(!judged(
             [](double t, double h, double) {
               return std::vector{Seen{1, std::max(0.0, t - 1 - h)}};
             },
             0.01, 3)
             .lost_at_s);
  CHECK(!judged([](double t, double h, double) { return std::vector{Seen{1, 0.05 * h * t}}; }, 0.01, 1.5).lost_at_s);
  const Answer rests = judged(
      [](double t, double h, double) {
        return std::vector{Seen{1, 10 * t}, Seen{2, 0.2 * h * t}};
      },
      0.01, 1.5);
  CHECK_BETWEEN(lost(rests), 0.5, 0.52);  // a millimetre
  CHECK_EQUAL(rests.lost_body, 2U);
}

void turns_are_lost_likewise() {
  const Answer slow = judged(
      [](double t, double h, double) {
        return std::vector{Seen{1, t, std::sin(t) + 2 * h * t}, Seen{2, 0, 3 * t}};
      },
      0.01, 10);
  CHECK_BETWEEN(lost(slow), 5, 5.2);  // 0.1 rad, where it has turned by 1, and a little more for what it is off by
  CHECK_EQUAL(slow.lost_body, 1U);
  CHECK(slow.lost_turned);
}

/// Off by h t until 0.3 s, and anywhere after that.
double breaks(double t, double h) { return t + h * t + (t > 0.3 ? std::sin(1e3 / h) : 0); }

// All that is known of it is told of the time before: rows from the decade on in which the last is that settles.
void what_breaks_early_is_told_until_then() {
  const Answer answer = judged([](double t, double h, double) { return std::vector{Seen{1, breaks(t, h)}}; }, 0.001, 3);
  CHECK_BETWEEN(lost(answer), 0.3, 0.302);
  const ErrorUntil& first = answer.error_at.front();
  CHECK_NEAR(first.t_s, 0.1, 1e-9);
  CHECK(first.convergence() == Convergence::settled);
  CHECK_NEAR(first.distance_m.value, 1e-4, 1e-6);
  CHECK_NEAR(answer.error_at[answer.told_at].t_s, 0.2, 1e-9);
  CHECK_NEAR(answer.steps_for_t_s, 0.2, 1e-9);
  CHECK_NEAR(answer.error_at.back().t_s, 3, 1e-9);
  for (const ErrorUntil& row : answer.error_at) {
    if (row.t_s > 0.4) CHECK(row.convergence() != Convergence::settled);
  }
  CHECK_EQUAL(answer.tried.front().error.size(), answer.tried_at + 1);
  CHECK(answer.tried.front().error.back().convergence == Convergence::settled);
}

// Without a limit, nothing has one: no later time, no setting, no picture.
void without_a_limit_nothing_has_one() {
  const auto apart = [](double t, double h, double) {
    const double grows = t < 1.5 ? 1e-5 / h * t : 20 * h;  // apart from each other, and then nearer
    return std::vector{Seen{1, t + grows}};
  };
  const Answer answer = judged(apart, 0.01, 5);
  for (const ErrorUntil& row : answer.error_at) CHECK(row.distance_m.convergence == Convergence::none);
  CHECK(answer.error_at.size() >= 3);
  for (const BodyError& row : answer.error_of_body) CHECK(row.distance_m.convergence == Convergence::none);
  CHECK(answer.tried.front().error.back().convergence == Convergence::none);
  CHECK_EQUAL(answer.limit_degree, 0U);
  // Where a turn has none, a setting is not held against the place alone, as the program's own is not.
  const Answer turns = judged(
      [](double t, double h, double) {
        return std::vector{Seen{1, t + h * t, std::sin(1e3 / h)}};
      },
      0.01, 3);
  CHECK(turns.error_at.front().distance_m.convergence != Convergence::none);
  CHECK(turns.error_at.front().convergence() == Convergence::none);
  CHECK(turns.tried.front().error.front().convergence == Convergence::none);
}

// Where all of the error is a turn, steps, settings and the worst moment are of it.
void what_only_turns_is_told_by_its_turn() {
  const Answer turns = judged(
      [](double t, double h, double) {
        return std::vector{Seen{1, 5}, Seen{2, 0, t + h * t}};
      },
      0.01, 3);
  CHECK(turns.by_turn);
  CHECK_EQUAL(turns.worst_body, 2U);
  CHECK_BETWEEN(turns.worst_t_s, 2.95, 3);  // grown by a hundredth for the last time
  CHECK(turns.limit_degree >= 1);
  const auto step = [&](std::size_t which) { return turns.steps_for[which].h_s.value_or(NAN); };
  CHECK_NEAR(step(0), 1e-3 / 3, 1e-6);  // h t of a radian until 3 s
  CHECK_NEAR(step(1), 1e-2 / 3, 1e-5);
  CHECK_NEAR(step(2), 0.01, 1e-12);  // its own
  const Estimate& tried = turns.tried.front().error.back();
  CHECK_NEAR(tried.value, 0.03, 1e-6);
  CHECK(tried.convergence == Convergence::settled);
  CHECK(!turns.softness_m);
  // A place that is off by more than a thousandth of it is what counts.
  const Answer moves = judged(
      [](double t, double h, double) {
        return std::vector{Seen{1, 1e-2 * h * t, t + h * t}};
      },
      0.01, 3);
  CHECK(!moves.by_turn);
  CHECK_NEAR(moves.tried.front().error.back().value, 3e-4, 1e-8);
}

// Balls that are thrown one after the other: each is farthest off at 0.38 s of its own, the later ones by rounding
// more.
void of_equals_the_first_is_the_worst() {
  const auto thrown = [](double t, double h, double) {
    const auto number = static_cast<std::uint32_t>(std::floor(t / 0.5 + 1e-9));
    const double its_t = t - 0.5 * number;
    const double off = its_t <= 0.38 + 1e-9 ? its_t : 0.76 - its_t;
    return std::vector{Seen{1 + number, its_t + h * off * (1 + 1e-12 * number)}};
  };
  const Answer answer = judged(thrown, 0.01, 2.99);
  CHECK_EQUAL(answer.worst_body, 1U);
  CHECK_NEAR(answer.worst_t_s, 0.38, 0.005);
  CHECK_EQUAL(answer.bodies, 1U);
  CHECK_EQUAL(answer.bodies_made, 6U);
  // Nor is one drawn that is gone.
  const odeval::test::TemporaryFolder folder;
  const std::vector<Scene> scenes = scenes_at(recorded(folder.path(), thrown, 0.01, 2), 0, {0.4, 1.4});
  CHECK_EQUAL(scenes.size(), 2U);
  for (const Scene& scene : scenes) {
    CHECK_EQUAL(scene.own.size(), 1U);
    CHECK_EQUAL(scene.limit.size(), 1U);
  }
}

/// A difference at the start that grows by e twenty times a second, and is half a metre at most.
double grows(double t, double at_start) { return 0.5 * std::sin(at_start * std::exp(20 * t)); }

// Starts that are moved come to what steps come to at 1.1 s, where 1e-10 m have grown to a third of a metre.
void chaos_is_told_from_steps() {
  const auto chaotic = [](double t, double h, double moved) {
    return std::vector{Seen{1, std::sin(5 * t) + grows(t, std::sin(1e5 * h) * 1e-6 + moved)}};
  };
  const Answer chaos = judged(chaotic, 0.01, 3);
  CHECK_BETWEEN(chaos.chaos_from_s.value_or(0), 1.0, 1.2);
  CHECK(!judged(chaotic, 0.01, 0.9).chaos_from_s);
  // Of a step that is too long for the springs, which a smaller one is not, no start is close to any other.
  const Answer long_step = judged(
      [](double t, double h, double moved) {
        return std::vector{Seen{1, t + (h > 0.005 ? std::exp(15 * t) * (1e-3 + moved) : 0)}};
      },
      0.01, 3);
  CHECK(!long_step.chaos_from_s);
  CHECK(long_step.flies_apart);
  // At first both are nothing.
  const Answer still = judged(
      [](double t, double h, double moved) {
        return std::vector{Seen{1, 3e3 * moved + h * t}};
      },
      0.01, 3);
  CHECK(!still.chaos_from_s && !still.flies_apart);
}

// Energies that halve, by chance, of a motion that is known to a half of its error, or has no limit, or is lost: they
// are known no better.
void energies_are_known_as_their_motion_is() {
  const auto its = [](const std::function<double(double t, double h)>& off) {
    return judged(
               [off](double t, double h, double) {
                 return std::vector{Seen{1, 10 * t + off(t, h), 0, 5 + h}};
               },
               0.01, 2)
        .energy.error_J;
  };
  const Estimate settled = its([](double t, double h) { return h * t; });
  CHECK(settled.convergence == Convergence::settled);
  CHECK_NEAR(settled.value, 0.01, 1e-9);
  CHECK_BETWEEN(settled.uncertainty, 0, 1e-4);
  const Estimate rough = its([](double t, double h) { return h * t + 2e-3 * t * std::sin(1e3 * h); });
  CHECK(rough.convergence == Convergence::rough);
  CHECK_BETWEEN(rough.uncertainty / rough.value, 0.1, 1);
  CHECK(its([](double t, double h) { return 1e-5 / h * t; }).convergence == Convergence::none);
}

// 2.02 s and 2 s are one row, of the end; 2.2 s are two.
void the_end_is_told_once() {
  const Motion motion = [](double t, double h, double) { return std::vector{Seen{1, t + h * t}}; };
  const Answer close = judged(motion, 0.01, 2.02);
  CHECK_EQUAL(close.error_at.size(), 2U);
  CHECK_NEAR(close.error_at.back().t_s, 2.02, 1e-9);
  CHECK_EQUAL(close.error_of_body.size(), 2U);
  CHECK_EQUAL(judged(motion, 0.01, 2.2).error_at.size(), 3U);
}

}  // namespace

int main() {
  a_body_is_held_against_itself();
  beginnings_are_no_loss();
  turns_are_lost_likewise();
  what_breaks_early_is_told_until_then();
  without_a_limit_nothing_has_one();
  what_only_turns_is_told_by_its_turn();
  of_equals_the_first_is_the_worst();
  chaos_is_told_from_steps();
  energies_are_known_as_their_motion_is();
  the_end_is_told_once();
  return odeval::test::verdict();
}
