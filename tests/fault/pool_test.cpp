// Jobs in a pool of workers: each ends in one result, whatever it returns, throws or does to its process.
// tests/fault/sweep_test.cpp does the same, and kills, to a sweep.
#include "run/pool.hpp"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "odeval/error.hpp"
#include "tests/check.hpp"
#include "tests/fault/at_hand.hpp"

namespace {

using namespace odeval;
using namespace odeval::run;

void pause(long milliseconds) {
  const timespec time{milliseconds / 1000, milliseconds % 1000 * 1000000};
  ::nanosleep(&time, nullptr);
}

void no_worker_is_left() {
  CHECK(::waitpid(-1, nullptr, WNOHANG) < 0);
  CHECK_EQUAL(errno, ECHILD);
}

std::vector<Job> jobs(std::uint32_t count) {
  std::vector<Job> plan;
  for (std::uint32_t number = 0; number < count; ++number) plan.push_back({number});
  return plan;
}

/// By number of job. Each comes once.
std::vector<Result> results_of(const Work& work, const std::vector<Job>& plan, const PoolOptions& options) {
  std::vector<std::vector<Result>> results(plan.size());
  const auto take = [&](long job, const Result& result) {
    results.at(static_cast<std::size_t>(job)).push_back(result);
  };
  CHECK_EQUAL(run_pool(work, plan, take, options), 0);
  no_worker_is_left();
  std::vector<Result> whole;
  for (const auto& of_job : results) {
    CHECK_EQUAL(of_job.size(), 1U);
    whole.push_back(of_job.empty() ? Result{Result::Kind::failed, "never came"} : of_job.front());
  }
  return whole;
}

// A message holds 64 KiB, a socket about 200: shorter, longer, to the byte at the edges, by workers side by side.
void answers_of_any_length() {
  const std::vector<std::size_t> sizes{0, 1, 65519, 65520, 65521, 131056, 131057, 5'000'000, 3};
  const auto text = [&](std::size_t job) {
    std::string bytes(sizes[job], '\0');
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7 / 5 + job);
    return bytes;
  };
  const Work work{{}, [&](long job, long, std::string_view) { return text(static_cast<std::size_t>(job)); }};
  for (const int processes : {1, 2, 3}) {
    PoolOptions options;
    options.processes = processes;
    options.at_hand_s = 0.05;
    const auto results = results_of(work, jobs(static_cast<std::uint32_t>(sizes.size())), options);
    for (std::size_t job = 0; job < sizes.size(); ++job) {
      CHECK(results[job].kind == Result::Kind::done && results[job].text == text(job));
    }
  }
}

// An answer of which a part has come is none.
void killed_in_its_answer() {
  const Work work{{}, [](long, long, std::string_view) { return std::string(5'000'000, 'x'); }};
  const std::vector<Shared> shared(1);
  Worker worker(work, shared);
  worker.give({});
  CHECK(!worker.take() && !worker.ended());
  worker.kill();
  for (int part = 0; part < 100 && !worker.ended(); ++part) CHECK(!worker.take());
  CHECK(worker.ended());
  CHECK(worker.busy());
  CHECK(worker.end().from_outside);
}

// A worker's pace, by which it gets tasks at hand, counts no time that is excused, and never time to come.
void excused_time_is_no_pace() {
  const Work work{{}, [](long, long, std::string_view) { return std::string(); }};
  const std::vector<Shared> shared(1);
  Worker worker(work, shared);
  worker.give({});
  pause(300);  // stopped, say
  worker.excuse(3600);
  CHECK(worker.take().has_value());
  CHECK(worker.pace_s() >= 0 && worker.pace_s() < 0.1);
}

std::string behave(long job, long, std::string_view) {
  switch (job) {
    case 1:
      throw MachineError("CVODE gave up");
    case 2:
      throw UserError("no such thing");
    case 3:
      throw std::bad_alloc();
    case 4:
      ::signal(SIGABRT, SIG_DFL);  // whatever a sanitizer made of it
      std::abort();
    case 5:
      ::_exit(9);
    case 6:
      ::raise(SIGKILL);
      break;
    case 7:
      for (;;) pause(1000);
    default:
      break;
  }
  return std::to_string(job);
}

// Each ends in its own way, and the others go on. Those that a signal from outside ends are tried 20 times.
void bad_jobs() {
  using Kind = Result::Kind;
  const std::vector<Result> wanted{{Kind::done, "0"},
                                   {Kind::failed, "CVODE gave up"},
                                   {Kind::refused, "no such thing"},
                                   {Kind::failed, "out of memory"},
                                   {Kind::crashed, "ended by signal 6 (Aborted)"},
                                   {Kind::crashed, "ended with exit status 9"},
                                   {Kind::crashed, "ended by signal 9 (Killed)"},
                                   {Kind::late, "took longer than 0.5 s"},
                                   {Kind::done, "8"}};
  for (const int processes : {1, 2, 3}) {
    PoolOptions options;
    options.processes = processes;
    options.timeout_s = 0.5;
    const auto results = results_of({{}, behave}, jobs(9), options);
    for (std::size_t job = 0; job < wanted.size(); ++job) {
      CHECK(results[job].kind == wanted[job].kind);
      CHECK_EQUAL(results[job].text, wanted[job].text);
      CHECK(!results[job].of_preparation);
    }
  }
}

// What a group shares is made once; where it cannot be, each of the group's jobs says so.
void preparations() {
  const Work work{[](long group) {
                    if (group == 1) throw MachineError("no reference");
                    return std::to_string(group) + " by " + std::to_string(::getpid());
                  },
                  [](long job, long group, std::string_view prepared) {
                    return std::to_string(job) + " of " + std::to_string(group) + ": " + std::string(prepared);
                  }};
  const std::vector<Job> plan{{0, 0}, {2, 0}, {4, 0}, {1, 1}, {3, 1}, {5, 2}};
  PoolOptions options;
  options.processes = 2;
  const auto results = results_of(work, plan, options);
  const std::string shared = results[0].text.substr(std::string("0 of ").size());
  CHECK(shared.starts_with("0: 0 by "));
  CHECK_EQUAL(results[2].text, "2 of " + shared);
  CHECK_EQUAL(results[4].text, "4 of " + shared);
  CHECK(results[5].text.starts_with("5 of 2: 2 by "));
  for (const std::size_t job : {1U, 3U}) {
    CHECK(results[job].kind == Result::Kind::failed && results[job].of_preparation);
    CHECK_EQUAL(results[job].text, "no reference");
  }
}

// Jobs of any length wait for the next free worker, and none behind another, unless the user says so.
void at_hand() {
  const Work work{{}, [](long, long, std::string_view) {
                    pause(2);
                    return std::string(test::more_at_hand() ? "more" : "none");
                  }};
  const auto any_more = [&](double at_hand_s) {
    PoolOptions options;
    options.at_hand_s = at_hand_s;
    bool more = false;
    for (const Result& result : results_of(work, jobs(40), options)) more |= result.text == "more";
    return more;
  };
  CHECK(any_more(60));
  CHECK(!any_more(0));
}

// What the user of the pool throws at a result ends it, workers that never would included.
void ended_by_its_user() {
  const auto take = [](long, const Result& result) {
    if (result.kind == Result::Kind::refused) throw UserError("--x: " + result.text);
  };
  const std::vector<Job> plan{{7}, {2}, {0}};
  PoolOptions options;
  options.processes = 2;
  CHECK_THROWS(run_pool({{}, behave}, plan, take, options), UserError, "--x: no such thing");
  no_worker_is_left();
}

// The number comes back, workers that never would end included; and nothing is left blocked.
void ended_by_a_signal() {
  std::signal(SIGTERM, SIG_DFL);  // whoever started this
  PoolOptions options;
  options.passed = [] { ::raise(SIGTERM); };
  CHECK_EQUAL(run_pool(
                  {{}, behave}, std::vector<Job>{{7}}, [](long, const Result&) {}, options),
              SIGTERM);
  no_worker_is_left();
  sigset_t blocked;
  ::sigprocmask(SIG_BLOCK, nullptr, &blocked);
  CHECK_EQUAL(::sigismember(&blocked, SIGTERM), 0);
}

}  // namespace

int main() {
  answers_of_any_length();
  killed_in_its_answer();
  excused_time_is_no_pace();
  bad_jobs();
  preparations();
  at_hand();
  ended_by_its_user();
  ended_by_a_signal();
  return odeval::test::verdict();
}
