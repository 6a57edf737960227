#include "sweep/sweep.hpp"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <deque>
#include <list>
#include <map>
#include <memory>

#include "odeval/error.hpp"

namespace odeval::sweep {
namespace {

// What leaks when a run ends badly ends with the worker: a process that grows is replaced in time.
constexpr long most_tasks = 500;

// Of one run, by ends that are not the run's own: so many are no accident (no memory, say).
constexpr int most_ends_from_outside = 20;

constexpr double longest_wait_s = 0.5;

// Who has not looked for so long was stopped (Ctrl-Z, a scheduler), and the workers with it.
constexpr double longest_turn_s = 2 * longest_wait_s;

// What a worker has at hand, so that it need not wait until this process gets its turn: no more, since what stands
// behind a task is kept from the other workers.
constexpr double at_hand_s = 0.05;
constexpr std::size_t most_at_hand = 8;

/// SIGINT, SIGTERM and SIGHUP as something to read, while it lives.
class Signals {
 public:
  Signals() {
    sigset_t wanted;
    ::sigemptyset(&wanted);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&wanted, signal);
    ::sigprocmask(SIG_BLOCK, &wanted, &before_);
    descriptor_ = ::signalfd(-1, &wanted, SFD_CLOEXEC | SFD_NONBLOCK);
    if (descriptor_ < 0) throw MachineError(std::string("sweep: no signals: ") + std::strerror(errno));
  }
  ~Signals() {
    ::close(descriptor_);
    ::sigprocmask(SIG_SETMASK, &before_, nullptr);
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  int descriptor() const { return descriptor_; }

  /// The signal that came, or 0.
  int take() const {
    signalfd_siginfo info{};
    return ::read(descriptor_, &info, sizeof info) == static_cast<ssize_t>(sizeof info)
               ? static_cast<int>(info.ssi_signo)
               : 0;
  }

 private:
  sigset_t before_{};
  int descriptor_ = -1;
};

/// A group whose runs are under way.
struct Open {
  enum class Phase { preparing, ready };
  long group;
  std::size_t next;  // in the plan
  std::size_t end;
  int place;
  Phase phase = Phase::preparing;
  long running = 0;
};

class Sweep {
 public:
  Sweep(const Work& work, std::span<const std::uint32_t> groups, Journal& journal, const SweepOptions& options)
      : work_(work),
        groups_(groups),
        journal_(journal),
        options_(options),
        shared_(static_cast<std::size_t>(options.jobs) + 1) {
    for (int place = 0; place <= options.jobs; ++place) free_places_.push_back(place);
    for (long run = 0; run < journal.runs(); ++run) {
      if (journal.head().shard.holds(run) && !journal.settled(run, options.timeout_s))
        plan_.push_back(static_cast<std::uint32_t>(run));
    }
    std::stable_sort(plan_.begin(), plan_.end(), [&](auto a, auto b) { return groups[a] < groups[b]; });
  }

  int run() {
    const std::size_t wanted = std::min(static_cast<std::size_t>(options_.jobs), plan_.size());
    for (std::size_t i = 0; i < wanted; ++i) workers_.push_back(new_worker());
    for (;;) {
      for (auto& worker : workers_) employ(worker);
      if (std::none_of(workers_.begin(), workers_.end(), [](const auto& worker) { return worker->busy(); })) return 0;
      wait();
      if (const int signal = signals_.take()) return signal;
      excuse_a_stop();
      for (auto& worker : workers_) {
        if (ready(*worker)) answer(worker);
      }
      end_the_late();
    }
  }

 private:
  using WorkerPlace = std::unique_ptr<Worker>;

  WorkerPlace new_worker() const { return std::make_unique<Worker>(work_, shared_); }

  /// The worker's next tasks, if there are any for it now.
  void employ(WorkerPlace& worker) {
    if (!worker->busy()) {
      const std::optional<Task> task = next_task(worker->group());
      if (!task) return;
      if (worker->given() >= most_tasks) worker = new_worker();
      worker->give(*task);
    }
    if (worker->tasks().front().kind == Task::Kind::prepare) return;
    const double most = std::min(at_hand_s / worker->pace_s(), static_cast<double>(most_at_hand));
    while (static_cast<double>(worker->tasks().size()) < most && worker->given() < most_tasks &&
           plan_.size() - handed_ >= workers_.size()) {
      const std::optional<Task> task = next_run(worker->group());
      if (!task) return;
      worker->give(*task);
    }
  }

  /// A run of a group that is ready, of `own` before any other.
  std::optional<Task> next_run(long own) {
    Open* chosen = nullptr;
    for (Open& open : open_) {
      if (open.phase != Open::Phase::ready || open.next == open.end) continue;
      if (chosen == nullptr || open.group == own) chosen = &open;
    }
    if (chosen == nullptr) return std::nullopt;
    ++chosen->running;
    ++handed_;
    return Task{Task::Kind::run, plan_[chosen->next++], chosen->group, chosen->place};
  }

  /// A run that can be done at once; else a group is begun.
  std::optional<Task> next_task(long own) {
    if (const auto run = next_run(own)) return run;
    if (begun_ == plan_.size() || free_places_.empty()) return std::nullopt;
    const std::uint32_t group = groups_[plan_[begun_]];
    const std::size_t first = begun_;
    while (begun_ < plan_.size() && groups_[plan_[begun_]] == group) ++begun_;
    open_.push_back({group, first, begun_, free_places_.back()});
    free_places_.pop_back();
    return Task{Task::Kind::prepare, plan_[first], group, open_.back().place};
  }

  /// Until something comes, a run is late, or for a while.
  void wait() {
    waits_.clear();
    waits_.push_back({signals_.descriptor(), POLLIN, 0});
    double until = steady_seconds() + longest_wait_s;
    for (const auto& worker : workers_) {
      waits_.push_back({worker->descriptor(), POLLIN, 0});
      if (worker->busy()) until = std::min(until, worker->begun_at_s() + options_.timeout_s);
    }
    const double left_ms = std::ceil(1e3 * std::max(0.0, until - steady_seconds()));
    if (::poll(waits_.data(), waits_.size(), static_cast<int>(left_ms)) < 0 && errno != EINTR) {
      throw MachineError(std::string("sweep: cannot wait: ") + std::strerror(errno));
    }
    journal_.sync_in_time();
    if (options_.passed) options_.passed(journal_);
  }

  bool ready(const Worker& worker) const {
    return std::any_of(waits_.begin(), waits_.end(),
                       [&](const pollfd& wait) { return wait.fd == worker.descriptor() && wait.revents != 0; });
  }

  void answer(WorkerPlace& worker) {
    const Task task = worker->busy() ? worker->tasks().front() : Task{};
    const std::optional<Answer> answer = worker->take();
    if (!answer) {
      mend(worker);
    } else if (answer->kind == Answer::Kind::refused) {
      throw UserError(answer->text);
    } else if (answer->kind == Answer::Kind::broken) {
      throw MachineError(answer->text);
    } else if (answer->kind == Answer::Kind::failed) {
      settle(task, failure(Status::crashed, task, answer->text));
    } else {
      settle(task, answer->row);
    }
  }

  /// In the place of a worker that has ended comes a new one with its tasks. The one that was under way is tried again
  /// unless it is to blame.
  void mend(WorkerPlace& worker) {
    const bool first = worker->done() == 0;
    const Worker::End end = worker->end();
    std::deque<Task> tasks = worker->tasks();
    worker = new_worker();
    if (tasks.empty()) return;
    const Task task = tasks.front();
    const bool again = end.from_outside ? ++ends_from_outside_[task.run] < most_ends_from_outside : !first;
    if (!again) {
      tasks.pop_front();
      settle(task, failure(Status::crashed, task, end.reason));
    }
    for (const Task& left : tasks) worker->give(left);
  }

  /// Before the answers, which would count it as time of their runs.
  void excuse_a_stop() {
    const double now = steady_seconds();
    const double turn = now - looked_at_s_;
    looked_at_s_ = now;
    if (turn <= longest_turn_s) return;
    for (auto& worker : workers_) worker->excuse(turn);
  }

  void end_the_late() {
    const double now = steady_seconds();
    for (auto& worker : workers_) {
      if (!worker->busy() || now < worker->begun_at_s() + options_.timeout_s) continue;
      std::deque<Task> tasks = worker->tasks();
      const Task task = tasks.front();
      tasks.pop_front();
      worker = new_worker();  // the old one ends with its place
      Row row = failure(Status::timeout, task, "took longer than " + seconds_text(options_.timeout_s) + " s");
      row.cpu_us = std::lround(1e6 * options_.timeout_s);
      settle(task, row);
      for (const Task& left : tasks) worker->give(left);
    }
  }

  static Row failure(Status status, const Task& task, const std::string& reason) {
    return {status, (task.kind == Task::Kind::prepare ? "what its runs share: " : "") + reason, 0, ""};
  }

  static std::string seconds_text(double seconds) {
    std::string text = std::to_string(seconds);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
    return text;
  }

  /// A task has come to its end.
  void settle(const Task& task, const Row& row) {
    const auto open = std::find_if(open_.begin(), open_.end(), [&](const Open& o) { return o.group == task.group; });
    if (task.kind == Task::Kind::prepare && row.status == Status::ok) {
      open->phase = Open::Phase::ready;
      return;
    }
    if (task.kind == Task::Kind::prepare) {
      // Without what they share none of its runs can be.
      for (; open->next < open->end; ++handed_) journal_.append(plan_[open->next++], row);
    } else {
      journal_.append(task.run, row);
      --open->running;
      ends_from_outside_.erase(task.run);
    }
    if (open->next == open->end && open->running == 0) {
      shared_[static_cast<std::size_t>(open->place)].clear();
      free_places_.push_back(open->place);
      open_.erase(open);
    }
  }

  const Work& work_;
  std::span<const std::uint32_t> groups_;
  Journal& journal_;
  const SweepOptions& options_;
  Signals signals_;
  std::vector<Shared> shared_;
  std::vector<std::uint32_t> plan_;  // runs to do, group by group
  std::size_t begun_ = 0;            // of the plan: up to here groups have been opened
  std::size_t handed_ = 0;           // of the plan: so many are settled or with a worker
  std::list<Open> open_;
  std::vector<int> free_places_;
  std::map<long, int> ends_from_outside_;
  std::vector<pollfd> waits_;
  double looked_at_s_ = steady_seconds();  // for a stop
  std::vector<WorkerPlace> workers_;
};

}  // namespace

int run_sweep(const Work& work, std::span<const std::uint32_t> groups, Journal& journal, const SweepOptions& options) {
  const int signal = Sweep(work, groups, journal, options).run();
  journal.sync();
  return signal;
}

}  // namespace odeval::sweep
