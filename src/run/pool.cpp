#include "run/pool.hpp"

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
#include <utility>

#include "odeval/error.hpp"

namespace odeval::run {
namespace {

// What leaks when a job ends badly ends with the worker: a process that grows is replaced in time.
constexpr long most_tasks = 500;

// Of one job, by ends that are not the job's own: so many are no accident (no memory, say).
constexpr int most_ends_from_outside = 20;

constexpr double longest_wait_s = 0.5;

// Who has not looked for so long was stopped (Ctrl-Z, a scheduler), and the workers with it.
constexpr double longest_turn_s = 2 * longest_wait_s;

constexpr std::size_t most_at_hand = 8;

bool ignored(int signal) {
  struct sigaction action {};
  return ::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// SIGINT, SIGTERM and SIGHUP as something to read, while it lives. One that the program was told to ignore (nohup)
/// would be read as well if it were blocked.
class Signals {
 public:
  Signals() {
    sigset_t wanted;
    ::sigemptyset(&wanted);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
      if (!ignored(signal)) ::sigaddset(&wanted, signal);
    }
    ::sigprocmask(SIG_BLOCK, &wanted, &before_);
    descriptor_ = ::signalfd(-1, &wanted, SFD_CLOEXEC | SFD_NONBLOCK);
    if (descriptor_ < 0) throw MachineError(std::string("no signals: ") + std::strerror(errno));
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

/// A group whose jobs are under way.
struct Open {
  enum class Phase { preparing, ready };
  long group;
  std::size_t next;  // in the plan
  std::size_t end;
  int place;
  Phase phase = Phase::preparing;
  long running = 0;
};

class Pool {
 public:
  Pool(const Work& work, std::span<const Job> plan, const TakeResult& take, const PoolOptions& options)
      : work_(work),
        plan_(plan),
        take_(take),
        options_(options),
        shared_(static_cast<std::size_t>(options.processes) + 1) {
    for (int place = 0; place <= options.processes; ++place) free_places_.push_back(place);
  }

  int run() {
    const std::size_t wanted = std::min(static_cast<std::size_t>(options_.processes), plan_.size());
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
    const double most = std::min(options_.at_hand_s / worker->pace_s(), static_cast<double>(most_at_hand));
    while (static_cast<double>(worker->tasks().size()) < most && worker->given() < most_tasks &&
           plan_.size() - handed_ >= workers_.size()) {
      const std::optional<Task> task = next_job(worker->group());
      if (!task) return;
      worker->give(*task);
    }
  }

  /// A job of a group that is ready, of `own` before any other.
  std::optional<Task> next_job(long own) {
    Open* chosen = nullptr;
    for (Open& open : open_) {
      if (open.phase != Open::Phase::ready || open.next == open.end) continue;
      if (chosen == nullptr || open.group == own) chosen = &open;
    }
    if (chosen == nullptr) return std::nullopt;
    ++chosen->running;
    ++handed_;
    return Task{Task::Kind::job, plan_[chosen->next++].number, chosen->group, chosen->place};
  }

  /// A job that can be done at once; else a group is begun.
  std::optional<Task> next_task(long own) {
    if (const auto job = next_job(own)) return job;
    if (begun_ == plan_.size() || free_places_.empty()) return std::nullopt;
    const std::uint32_t group = plan_[begun_].group;
    const std::size_t first = begun_;
    while (begun_ < plan_.size() && plan_[begun_].group == group) ++begun_;
    open_.push_back({group, first, begun_, free_places_.back()});
    free_places_.pop_back();
    if (work_.prepare) return Task{Task::Kind::prepare, plan_[first].number, group, open_.back().place};
    open_.back().phase = Open::Phase::ready;
    return next_job(group);
  }

  /// Until something comes, a job is late, or for a while.
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
      throw MachineError(std::string("cannot wait for workers: ") + std::strerror(errno));
    }
    if (options_.passed) options_.passed();
  }

  bool ready(const Worker& worker) const {
    return std::any_of(waits_.begin(), waits_.end(),
                       [&](const pollfd& wait) { return wait.fd == worker.descriptor() && wait.revents != 0; });
  }

  void answer(WorkerPlace& worker) {
    const Task task = worker->busy() ? worker->tasks().front() : Task{};
    std::optional<Answer> answer = worker->take();
    if (!answer) {
      if (worker->ended()) mend(worker);
      return;
    }
    switch (answer->kind) {
      case Answer::Kind::done:
        return settle(task, {Result::Kind::done, std::move(answer->text)});
      case Answer::Kind::failed:
        return settle(task, {Result::Kind::failed, std::move(answer->text)});
      case Answer::Kind::refused:
        return settle(task, {Result::Kind::refused, std::move(answer->text)});
      case Answer::Kind::broken:
        throw MachineError(answer->text);
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
    const bool again = end.from_outside ? ++ends_from_outside_[task.job] < most_ends_from_outside : !first;
    if (!again) {
      tasks.pop_front();
      settle(task, {Result::Kind::crashed, end.reason});
    }
    for (const Task& left : tasks) worker->give(left);
  }

  /// Before the answers, which would count it as time of their jobs.
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
      settle(task, {Result::Kind::late, "took longer than " + seconds_text(options_.timeout_s) + " s"});
      for (const Task& left : tasks) worker->give(left);
    }
  }

  static std::string seconds_text(double seconds) {
    std::string text = std::to_string(seconds);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
    return text;
  }

  /// A task has come to its end.
  void settle(const Task& task, Result result) {
    const auto open = std::find_if(open_.begin(), open_.end(), [&](const Open& o) { return o.group == task.group; });
    if (task.kind == Task::Kind::job) {
      take_(task.job, result);
      --open->running;
      ends_from_outside_.erase(task.job);
    } else if (result.kind == Result::Kind::done) {
      open->phase = Open::Phase::ready;
      return;
    } else {
      // Without what they share none of its jobs can be.
      result.of_preparation = true;
      for (; open->next < open->end; ++handed_) take_(plan_[open->next++].number, result);
    }
    if (open->next == open->end && open->running == 0) {
      shared_[static_cast<std::size_t>(open->place)].clear();
      free_places_.push_back(open->place);
      open_.erase(open);
    }
  }

  const Work& work_;
  std::span<const Job> plan_;
  const TakeResult& take_;
  const PoolOptions& options_;
  Signals signals_;
  std::vector<Shared> shared_;
  std::size_t begun_ = 0;   // of the plan: up to here groups have been opened
  std::size_t handed_ = 0;  // of the plan: so many are settled or with a worker
  std::list<Open> open_;
  std::vector<int> free_places_;
  std::map<long, int> ends_from_outside_;
  std::vector<pollfd> waits_;
  double looked_at_s_ = steady_seconds();  // for a stop
  std::vector<WorkerPlace> workers_;
};

}  // namespace

int run_pool(const Work& work, std::span<const Job> plan, const TakeResult& take, const PoolOptions& options) {
  return Pool(work, plan, take, options).run();
}

}  // namespace odeval::run
