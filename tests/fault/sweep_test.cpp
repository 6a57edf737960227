// A sweep whose processes are killed, crash, hang or run into a full disk ends with the rows of an undisturbed one.
//
// The runs are a few hundred microseconds of nothing, so that many deaths fit into seconds; tests/fault/odeval does
// some of this to the program.
#include "run/sweep.hpp"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <random>

#include "odeval/error.hpp"
#include "run/worker.hpp"
#include "tests/check.hpp"
#include "tests/fault/at_hand.hpp"
#include "tests/temporary_folder.hpp"

// In the place of the C library's.
static int syncs = 0;
extern "C" int fdatasync(int descriptor) {
  ++syncs;
  return ::fsync(descriptor);
}

namespace {

using namespace odeval;
using namespace odeval::sweep;
namespace fs = std::filesystem;

Head head_of_runs(long count) {
  Axis axis{"x", {}};
  for (long i = 0; i < count; ++i) axis.values.push_back(std::to_string(i));
  return {"test", {}, {axis, {"method", {"m"}}}, {"square"}, "", ""};
}

std::vector<std::uint32_t> groups_of(long count) {
  std::vector<std::uint32_t> groups;
  for (long run = 0; run < count; ++run) groups.push_back(static_cast<std::uint32_t>(run % 7));
  return groups;
}

void pause(long microseconds) {
  const timespec time{microseconds / 1000000, microseconds % 1000000 * 1000};
  ::nanosleep(&time, nullptr);
}

/// What a run leaves, from its number and what its group prepared.
Row undisturbed(long run) {
  if (run % 97 == 13) return {Status::diverged, "left the finite numbers", 1, "-1"};
  return {Status::ok, "", 1, std::to_string(run * run) + " of " + std::to_string(run % 7)};
}

Row good_run(long run, long, std::string_view prepared) {
  pause(300);
  Row row = undisturbed(run);
  if (row.status == Status::ok) row.cells = std::to_string(run * run) + " of " + std::string(prepared);
  return row;
}

std::string good_preparation(long group) { return std::to_string(group); }

Work good_work() { return {good_preparation, good_run}; }

void check_rows(const fs::path& file, long count, Row (*wanted)(long)) {
  const Journal journal(file);
  CHECK_EQUAL(journal.rows(), count);
  CHECK_EQUAL(journal.damaged(), 0);
  for (long run = 0; run < count && journal.has(run); ++run) {
    const Row row = journal.row(run);
    CHECK(row.same_as(wanted(run)));
    if (!row.same_as(wanted(run))) {
      std::printf("  run %ld: %s '%s' '%s'\n", run, std::string(status_name(row.status)).c_str(), row.reason.c_str(),
                  row.cells.c_str());
    }
  }
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::uintmax_t size_of(const fs::path& file) {
  std::error_code absent;
  const auto size = fs::file_size(file, absent);
  return absent ? 0 : size;
}

/// A sweep in a process of its own; its exit status is that of the program.
pid_t start_sweep(const fs::path& file, long count, const Work& work, int jobs = 2, double timeout_s = 60) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  try {
    Journal journal(file, head_of_runs(count));
    const auto groups = groups_of(count);
    const int signal = run_sweep(work, groups, journal, {jobs, timeout_s, {}});
    ::_exit(signal == 0 ? 0 : 128 + signal);
  } catch (const std::exception&) {
    ::_exit(3);
  }
}

/// The exit status, or the signal's number below 0.
int wait_for(pid_t process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

/// Every process that came from this one ends, and there is none left. Hangs, and so fails by its time, if one stays.
void all_are_gone() {
  while (::waitpid(-1, nullptr, 0) > 0 || errno == EINTR) {
  }
  CHECK_EQUAL(errno, ECHILD);
}

/// Once the journal has grown by so many bytes, or the process has ended.
void wait_for_growth(const fs::path& file, std::uintmax_t by, pid_t process) {
  const std::uintmax_t wanted = size_of(file) + by;
  siginfo_t ended{};
  while (size_of(file) < wanted && ended.si_pid == 0) {
    pause(100);
    ::waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOHANG | WNOWAIT);
  }
}

// At random instants: in start-up, between rows, wherever. What was there stays there.
void parent_killed(const fs::path& file) {
  constexpr long count = 1500;
  std::mt19937 random(std::random_device{}());
  const Work work = good_work();
  int kills = 0;
  while (kills < 55) {
    const std::string before = text_of(file);
    const pid_t parent = start_sweep(file, count, work);
    if (random() % 4 == 0) {
      pause(static_cast<long>(random() % 20000));
    } else {
      wait_for_growth(file, random() % 700, parent);
    }
    ::kill(parent, SIGKILL);
    const int status = wait_for(parent);
    all_are_gone();
    CHECK(text_of(file).starts_with(before.substr(0, before.rfind('\n') + 1)));
    if (status == -SIGKILL) {
      ++kills;
      continue;
    }
    CHECK_EQUAL(status, 0);  // was faster than the kill: once more from the beginning
    check_rows(file, count, undisturbed);
    fs::remove(file);
  }
  CHECK_EQUAL(wait_for(start_sweep(file, count, work)), 0);
  check_rows(file, count, undisturbed);
}

std::vector<pid_t> children_of(pid_t parent) {
  std::ifstream list("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children");
  return {std::istream_iterator<pid_t>(list), {}};
}

// Whoever kills a worker (the kernel that runs out of memory, say): its run is not to blame and is done again.
void workers_killed(const fs::path& file) {
  constexpr long count = 1500;
  const pid_t parent = start_sweep(file, count, good_work());
  std::mt19937 random(1);
  int kills = 0;
  siginfo_t ended{};
  while (kills < 40 && ended.si_pid == 0) {
    wait_for_growth(file, 60 + random() % 100, parent);
    const std::vector<pid_t> workers = children_of(parent);
    if (!workers.empty() && ::kill(workers[random() % workers.size()], SIGKILL) == 0) ++kills;
    ::waitid(P_PID, static_cast<id_t>(parent), &ended, WEXITED | WNOHANG | WNOWAIT);
  }
  CHECK_EQUAL(wait_for(parent), 0);
  CHECK(kills >= 10);
  all_are_gone();
  check_rows(file, count, undisturbed);
}

// Told to ignore a signal (nohup), a sweep and its workers do.
void ignored(const fs::path& file) {
  constexpr long count = 1500;
  const auto before = std::signal(SIGHUP, SIG_IGN);
  const pid_t parent = start_sweep(file, count, good_work());
  std::signal(SIGHUP, before);
  wait_for_growth(file, head_line(head_of_runs(count)).size() + 500, parent);
  const std::vector<pid_t> workers = children_of(parent);
  for (const pid_t worker : workers) ::kill(worker, SIGHUP);
  ::kill(parent, SIGHUP);
  pause(20000);
  CHECK(children_of(parent) == workers);
  CHECK_EQUAL(wait_for(parent), 0);
  check_rows(file, count, undisturbed);
}

// Children gone, journal whole, the status that tells the signal; then it goes on.
void stopped(const fs::path& file, int signal) {
  constexpr long count = 1500;
  const pid_t parent = start_sweep(file, count, good_work());
  wait_for_growth(file, head_line(head_of_runs(count)).size() + 500, parent);
  ::kill(parent, signal);
  CHECK_EQUAL(wait_for(parent), 128 + signal);
  all_are_gone();
  {
    const Journal journal(file);
    CHECK(journal.rows() > 0 && journal.rows() < count);
    CHECK_EQUAL(journal.damaged(), 0);
    CHECK(text_of(file).ends_with('\n'));
  }
  CHECK_EQUAL(wait_for(start_sweep(file, count, good_work())), 0);
  check_rows(file, count, undisturbed);
}

void work_for(double cpu_s) {
  const std::clock_t begin = std::clock();
  while (static_cast<double>(std::clock() - begin) < cpu_s * CLOCKS_PER_SEC) {
  }
}

// All of a sweep stopped (Ctrl-Z) for longer than the timeout: none of its runs took that long.
void stopped_and_continued(const fs::path& file) {
  const Work work{good_preparation, [](long run, long group, std::string_view prepared) {
                    work_for(0.2);
                    return good_run(run, group, prepared);
                  }};
  const pid_t parent = start_sweep(file, 3, work, 1, 2);
  wait_for_growth(file, head_line(head_of_runs(3)).size() + 1, parent);
  pause(100000);  // the next run is under way
  const std::vector<pid_t> workers = children_of(parent);
  ::kill(parent, SIGSTOP);
  for (const pid_t worker : workers) ::kill(worker, SIGSTOP);
  pause(2500000);
  ::kill(parent, SIGCONT);
  pause(700000);  // it looks, after half a second at the latest, before the worker can answer
  for (const pid_t worker : workers) ::kill(worker, SIGCONT);
  CHECK_EQUAL(wait_for(parent), 0);
  check_rows(file, 3, undisturbed);
}

// Answers that lay there while the sweep was stopped are no slow runs: the last runs still come to hand before their
// turn. Were the stop counted, the mean run would take 2.5 s / 47 tasks or more, and no task be given ahead.
void at_hand_after_a_stop(const fs::path& file) {
  constexpr long count = 40;
  const Work work{good_preparation, [](long, long, std::string_view) {
                    const bool more = test::more_at_hand();
                    work_for(0.003);
                    return Row{Status::ok, "", 1, more ? "more" : "none"};
                  }};
  const pid_t parent = start_sweep(file, count, work, 1);
  wait_for_growth(file, head_line(head_of_runs(count)).size() + 1, parent);
  const std::vector<pid_t> workers = children_of(parent);
  ::kill(parent, SIGSTOP);
  for (const pid_t worker : workers) ::kill(worker, SIGSTOP);
  pause(2500000);
  for (const pid_t worker : workers) ::kill(worker, SIGCONT);
  pause(100000);  // its answers come first
  ::kill(parent, SIGCONT);
  CHECK_EQUAL(wait_for(parent), 0);
  const Journal journal(file);
  bool more = false;
  for (long run = 6; run < count; run += 7) more |= journal.row(run).cells == "more";  // of the last group
  CHECK(more);
}

constexpr long faulty_runs = 60;

Row faulty(long run, long group, std::string_view prepared) {
  switch (run) {
    case 5:
      ::signal(SIGSEGV, SIG_DFL);  // whatever a sanitizer made of it
      ::raise(SIGSEGV);
      break;
    case 11:
      ::signal(SIGABRT, SIG_DFL);
      std::abort();
    case 17:
      for (;;) pause(1000000);
    case 24:
      ::_exit(9);
    case 29:
      throw MachineError("CVODE gave up");
    case 31:
      throw std::bad_alloc();
    default:
      break;
  }
  return good_run(run, group, prepared);
}

std::string faulty_preparation(long group) {
  if (group == 2) throw MachineError("no reference");
  return good_preparation(group);
}

Row wanted_of_faulty(long run) {
  if (run % 7 == 2) return {Status::crashed, "what its runs share: no reference", 0, ""};
  switch (run) {
    case 5:
      return {Status::crashed, "ended by signal 11 (Segmentation fault)", 0, ""};
    case 11:
      return {Status::crashed, "ended by signal 6 (Aborted)", 0, ""};
    case 17:
      return {Status::timeout, "took longer than 0.5 s", 0, ""};
    case 24:
      return {Status::crashed, "ended with exit status 9", 0, ""};
    case 29:
      return {Status::crashed, "CVODE gave up", 0, ""};
    case 31:
      return {Status::crashed, "out of memory", 0, ""};
    default:
      return undisturbed(run);
  }
}

// Each is one row with its reason, whoever runs beside it; the rest goes on.
void bad_runs(const fs::path& folder) {
  for (const int jobs : {1, 2, 3}) {
    const fs::path file = folder / ("jobs" + std::to_string(jobs)) / "test.journal";
    {
      Journal journal(file, head_of_runs(faulty_runs));
      const auto groups = groups_of(faulty_runs);
      CHECK_EQUAL(run_sweep({faulty_preparation, faulty}, groups, journal, {jobs, 0.5, {}}), 0);
    }
    all_are_gone();
    check_rows(file, faulty_runs, wanted_of_faulty);
  }
}

// A preparation that takes its worker down, and one that hangs.
void bad_preparations(const fs::path& file) {
  const Work work{[](long group) -> std::string {
                    if (group == 1) {
                      ::signal(SIGABRT, SIG_DFL);
                      std::abort();
                    }
                    if (group == 3) {
                      for (;;) pause(1000000);
                    }
                    return good_preparation(group);
                  },
                  good_run};
  {
    Journal journal(file, head_of_runs(50));
    const auto groups = groups_of(50);
    CHECK_EQUAL(run_sweep(work, groups, journal, {2, 0.5, {}}), 0);
  }
  check_rows(file, 50, [](long run) {
    if (run % 7 == 1) return Row{Status::crashed, "what its runs share: ended by signal 6 (Aborted)", 0, ""};
    if (run % 7 == 3) return Row{Status::timeout, "what its runs share: took longer than 0.5 s", 0, ""};
    return undisturbed(run);
  });
}

// A run that was given up is done again when it gets more time, and only then; what went well is not.
void more_time(const fs::path& file) {
  constexpr long count = 12;
  const auto sweep_with = [&](double timeout_s, double run_s) {
    const Work work{good_preparation, [run_s](long run, long group, std::string_view prepared) {
                      if (run == 5) work_for(run_s);
                      return good_run(run, group, prepared);
                    }};
    Journal journal(file, head_of_runs(count));
    const auto groups = groups_of(count);
    CHECK_EQUAL(run_sweep(work, groups, journal, {2, timeout_s, {}}), 0);
    return journal.rows(Status::timeout);
  };
  CHECK_EQUAL(sweep_with(0.3, 20), 1);
  CHECK_EQUAL(sweep_with(0.3, 0), 1);
  CHECK_EQUAL(sweep_with(0.2, 0), 1);
  CHECK_EQUAL(sweep_with(0.5, 20), 1);
  CHECK(Journal(file).row(5).same_as({Status::timeout, "took longer than 0.5 s", 0, ""}));
  CHECK_EQUAL(sweep_with(60, 0), 0);
  check_rows(file, count, undisturbed);
}

// What an earlier run did to its worker is not the next one's fault.
void poisoned_worker(const fs::path& file) {
  static bool poisoned = false;  // of the worker
  const Work work{good_preparation, [](long run, long group, std::string_view prepared) {
                    if (poisoned) {
                      ::signal(SIGSEGV, SIG_DFL);
                      ::raise(SIGSEGV);
                    }
                    poisoned = run % 5 == 0;
                    return good_run(run, group, prepared);
                  }};
  {
    Journal journal(file, head_of_runs(40));
    const auto groups = groups_of(40);
    CHECK_EQUAL(run_sweep(work, groups, journal, {2, 60, {}}), 0);
  }
  check_rows(file, 40, undisturbed);
}

// Bad input that shows only in a run ends the sweep.
void refused(const fs::path& file) {
  const Work work{good_preparation, [](long run, long group, std::string_view prepared) {
                    if (run == 20) throw UserError("--grid x: cannot be");
                    return good_run(run, group, prepared);
                  }};
  Journal journal(file, head_of_runs(40));
  const auto groups = groups_of(40);
  CHECK_THROWS(run_sweep(work, groups, journal, {2, 60, {}}), UserError, "--grid x: cannot be");
  all_are_gone();
}

// What a power failure may cost is a second or so, however long the next row takes.
void synced_in_time(const fs::path& file) {
  const Work work{good_preparation, [](long run, long group, std::string_view prepared) {
                    if (run == 1) pause(2500000);
                    return good_run(run, group, prepared);
                  }};
  Journal journal(file, head_of_runs(2));
  const auto groups = groups_of(2);
  syncs = 0;
  int syncs_of_first = 0;
  const auto passed = [&](const Journal& now) {
    if (now.rows() == 1) syncs_of_first = syncs;
  };
  CHECK_EQUAL(run_sweep(work, groups, journal, {1, 60, passed}), 0);
  CHECK_EQUAL(syncs_of_first, 1);
}

// A limit on the size of files stands for a full disk: at every size the journal ends with a whole line, and then goes
// on.
void disk_full(const fs::path& file) {
  constexpr long count = 60;
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit before = limit;
  std::signal(SIGXFSZ, SIG_IGN);
  for (rlim_t size = 10; size < 1500; size += 93) {
    limit.rlim_cur = size;
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::string said;
    try {
      Journal journal(file, head_of_runs(count));
      const auto groups = groups_of(count);
      run_sweep(good_work(), groups, journal, {2, 60, {}});
    } catch (const MachineError& error) {
      said = error.what();
    }
    CHECK(said.find("test.journal: cannot be written: File too large") != std::string::npos);
    all_are_gone();
    const std::string text = text_of(file);
    CHECK(text.empty() || text.ends_with('\n'));
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  CHECK_EQUAL(wait_for(start_sweep(file, count, good_work())), 0);
  check_rows(file, count, undisturbed);
}

// The first goes on undisturbed.
void two_at_once(const fs::path& file) {
  constexpr long count = 1500;
  const pid_t first = start_sweep(file, count, good_work());
  wait_for_growth(file, head_line(head_of_runs(count)).size() + 500, first);
  CHECK_THROWS(Journal(file, head_of_runs(count)), MachineError,
               "another sweep (process " + std::to_string(first) + ") is at work");
  CHECK_THROWS(Journal{file}, MachineError, "is at work");
  CHECK_EQUAL(wait_for(first), 0);
  check_rows(file, count, undisturbed);
}

}  // namespace

int main() {
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);  // orphans come here, so that none is overlooked
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);  // whoever started this
  const test::TemporaryFolder own;
  const fs::path& folder = own.path();
  const auto file = [&](const char* part) { return folder / part / "test.journal"; };
  bad_runs(folder);
  bad_preparations(file("preparations"));
  more_time(file("more_time"));
  poisoned_worker(file("poisoned"));
  refused(file("refused"));
  workers_killed(file("workers"));
  stopped(file("interrupted"), SIGINT);
  stopped(file("terminated"), SIGTERM);
  ignored(file("ignored"));
  stopped_and_continued(file("continued"));
  at_hand_after_a_stop(file("at hand"));
  synced_in_time(file("synced"));
  disk_full(file("full"));
  two_at_once(file("twice"));
  parent_killed(file("parent"));
  return odeval::test::verdict();
}
