#pragma once
// A forked process that does one task after another and sends each result back whole. ODE's globals allow nothing else,
// and what a run does to the process (an abort, a leak) ends with it.
#include <sys/types.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "odeval/error.hpp"
#include "sweep/journal.hpp"

namespace odeval::sweep {

/// What is swept. The functions are called in workers only.
struct Work {
  /// What the runs of a group share, as bytes: made once, by one of the workers.
  std::function<std::string(long group)> prepare;

  /// One run. A MachineError makes a row `crashed`, a UserError ends the sweep.
  std::function<Row(long run, long group, std::string_view prepared)> run;
};

/// Memory that outlives the worker that fills it and that all workers see. Throws SharedError.
class Shared {
 public:
  Shared();
  ~Shared();
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;

  void fill(std::string_view bytes) const;
  void clear() const;

  /// Calls `use` with the bytes, which are gone afterwards.
  void with(const std::function<void(std::string_view bytes)>& use) const;

 private:
  int descriptor_;
};

class SharedError : public MachineError {
 public:
  using MachineError::MachineError;
};

struct Task {
  enum class Kind : int { prepare, run };
  Kind kind = Kind::run;
  long run = 0;  // of the grid
  long group = 0;
  int place = 0;  // of the group's Shared
};

/// What came of a task.
struct Answer {
  enum class Kind : char {
    done,
    failed,   // the run or the preparation is to blame
    refused,  // bad input
    broken,   // the machine cannot do sweeps
  };
  Kind kind = Kind::done;
  Row row;           // of a run that was done
  std::string text;  // why not
};

class Worker {
 public:
  /// Forks. `shared` stays where it is. Throws MachineError.
  Worker(const Work& work, const std::vector<Shared>& shared);
  ~Worker();  // ends the process
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  int descriptor() const { return descriptor_; }  // readable when there is an answer or an end
  bool busy() const { return !tasks_.empty(); }
  /// Given and not answered, in the order in which they are done: the first is under way.
  const std::deque<Task>& tasks() const { return tasks_; }
  long given() const { return given_; }
  long group() const { return group_; }  // of the last given
  long done() const { return done_; }
  double begun_at_s() const { return begun_at_s_; }  // the first of the tasks
  /// Time in which nobody could work does not count.
  void excuse(double seconds) { begun_at_s_ = std::min(begun_at_s_ + seconds, steady_seconds()); }
  /// Mean time of what it has done, s.
  double pace_s() const;

  /// Gives one more task. A worker that has died in the meantime will show it.
  void give(const Task& task);

  /// The answer to the first of its tasks; empty when the process has ended instead.
  std::optional<Answer> take();

  void kill() const;

  /// Waits for a process that has ended.
  struct End {
    bool from_outside = false;  // a signal that no run raises by itself
    std::string reason;
  };
  End end();

 private:
  pid_t process_ = -1;
  int descriptor_ = -1;
  std::deque<Task> tasks_;
  long given_ = 0;
  long group_ = -1;
  long done_ = 0;
  double busy_s_ = 0;  // with what is done
  double begun_at_s_ = 0;
};

}  // namespace odeval::sweep
