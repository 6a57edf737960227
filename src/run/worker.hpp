#pragma once
// A forked process that does one task after another and sends each answer back whole. ODE's globals allow nothing else,
// and what a task does to the process (an abort, a leak) ends with it.
#include <sys/types.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "run/clock.hpp"
#include "run/shared.hpp"

namespace odeval::run {

/// What there is to do, in numbered jobs. The functions are called in workers only; what they throw is the job's
/// answer.
struct Work {
  /// What the jobs of a group share, as bytes: made once, by one of the workers. Empty: they share nothing.
  std::function<std::string(long group)> prepare;

  /// One job; its result as bytes, as many as it likes.
  std::function<std::string(long job, long group, std::string_view prepared)> job;
};

struct Task {
  enum class Kind : int { prepare, job };
  Kind kind = Kind::job;
  long job = 0;
  long group = 0;
  int place = 0;  // of the group's Shared
};

/// What came of a task.
struct Answer {
  enum class Kind : char {
    done,
    failed,   // the job or the preparation is to blame
    refused,  // bad input (UserError)
    broken,   // the machine cannot do what workers need
  };
  Kind kind = Kind::done;
  std::string text;  // of a job that was done its result; else why not
};

class Worker {
 public:
  /// Forks. `work` and `shared` stay where they are. Throws MachineError.
  Worker(const Work& work, const std::vector<Shared>& shared);
  ~Worker();  // ends the process
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  int descriptor() const { return descriptor_; }  // readable when there is part of an answer, or an end
  bool busy() const { return !tasks_.empty(); }
  /// Given and not answered, in the order in which they are done: the first is under way.
  const std::deque<Task>& tasks() const { return tasks_; }
  long given() const { return given_; }
  long group() const { return group_; }  // of the last given
  long done() const { return done_; }
  double begun_at_s() const { return begun_at_s_; }  // the first of the tasks
  /// Time in which no worker could run does not count.
  void excuse(double seconds) { begun_at_s_ = std::min(begun_at_s_ + seconds, steady_seconds()); }
  /// Mean time of what it has done, s.
  double pace_s() const;

  /// Gives one more task. A worker that has died in the meantime will show it.
  void give(const Task& task);

  /// The answer to the first of its tasks; empty when it is not whole yet, or the process has ended instead.
  std::optional<Answer> take();
  bool ended() const { return ended_; }

  void kill() const;

  /// Waits for a process that has ended.
  struct End {
    bool from_outside = false;  // a signal that no task raises by itself
    std::string reason;
  };
  End end();

 private:
  pid_t process_ = -1;
  int descriptor_ = -1;
  bool ended_ = false;
  std::string arrived_;  // of the answer to the first of the tasks
  std::deque<Task> tasks_;
  long given_ = 0;
  long group_ = -1;
  long done_ = 0;
  double busy_s_ = 0;  // with what is done
  double begun_at_s_ = 0;
};

}  // namespace odeval::run
