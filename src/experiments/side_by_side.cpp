#include "experiments/side_by_side.hpp"

#include <poll.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <optional>

#include "odeval/error.hpp"

namespace odeval::experiments {
namespace {

report::Outcome failure(const Experiment& experiment, const std::string& why) {
  report::Outcome outcome;
  outcome.failures.push_back(std::string(experiment.name) + ": " + why);
  outcome.section = {std::string(experiment.name),
                     report::title_of(experiment.prose),
                     {report::Text{"This experiment failed, and its numbers are missing: " + why}}};
  return outcome;
}

report::Outcome outcome_of(const Experiment& experiment, Laboratory& laboratory) try {
  report::Outcome outcome;
  report::Findings findings;
  outcome.section = section_of(experiment, laboratory, findings);
  for (const auto& finding : findings.all()) outcome.findings.emplace_back(finding);
  return outcome;
} catch (const MachineError& error) {
  return failure(experiment, error.what());
}

/// The number of the next experiment that nobody has begun, in memory that all processes share.
class Counter {
 public:
  Counter()
      : memory_(mmap(nullptr, sizeof(std::atomic<std::size_t>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1,
                     0)) {
    if (memory_ == MAP_FAILED) throw MachineError(std::string("no memory for processes: ") + std::strerror(errno));
    next_ = new (memory_) std::atomic<std::size_t>(0);
  }
  ~Counter() { munmap(memory_, sizeof(std::atomic<std::size_t>)); }
  Counter(const Counter&) = delete;
  Counter& operator=(const Counter&) = delete;

  std::size_t take() { return (*next_)++; }

 private:
  void* memory_;
  std::atomic<std::size_t>* next_;
};

struct Message {
  std::size_t number;  // of the experiment
  std::size_t size;    // of the outcome's bytes, which follow; 0: it has begun
};

bool write_all(int descriptor, const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = write(descriptor, from, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    from += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

[[noreturn]] void work(std::span<const Experiment> all, Laboratory& laboratory, Counter& counter, int descriptor) {
  for (std::size_t number = counter.take(); number < all.size(); number = counter.take()) {
    const Message begun{number, 0};
    if (!write_all(descriptor, &begun, sizeof begun)) break;
    const std::string bytes = report::outcome_bytes(outcome_of(all[number], laboratory));
    const Message done{number, bytes.size()};
    if (!write_all(descriptor, &done, sizeof done) || !write_all(descriptor, bytes.data(), bytes.size())) break;
  }
  _exit(0);
}

/// A process that works, and what has come from it so far.
struct Helper {
  pid_t process = -1;
  int descriptor = -1;
  std::string bytes;
  std::optional<std::size_t> at;  // the experiment it has begun

  /// The next whole outcome among the bytes.
  std::optional<std::pair<std::size_t, report::Outcome>> next() {
    while (bytes.size() >= sizeof(Message)) {
      Message message;
      std::memcpy(&message, bytes.data(), sizeof message);
      if (message.size == 0) {
        at = message.number;
        bytes.erase(0, sizeof message);
        continue;
      }
      if (bytes.size() < sizeof message + message.size) break;
      std::pair outcome{message.number,
                        report::outcome_of(std::string_view(bytes).substr(sizeof message, message.size))};
      bytes.erase(0, sizeof message + message.size);
      at.reset();
      return outcome;
    }
    return std::nullopt;
  }
};

Helper start(std::span<const Experiment> all, Laboratory& laboratory, Counter& counter,
             const std::vector<Helper>& others) {
  int ends[2];
  if (pipe(ends) != 0) throw MachineError(std::string("no pipe for a process: ") + std::strerror(errno));
  const pid_t process = fork();
  if (process < 0) throw MachineError(std::string("no process for experiments: ") + std::strerror(errno));
  if (process == 0) {
    close(ends[0]);
    for (const Helper& other : others) close(other.descriptor);
    try {
      work(all, laboratory, counter, ends[1]);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "odeval: experiments: %s\n", error.what());
      _exit(1);
    }
  }
  close(ends[1]);
  return {process, ends[0], {}, {}};
}

}  // namespace

std::vector<report::Outcome> run_side_by_side(std::span<const Experiment> all, Laboratory& laboratory,
                                              unsigned processes,
                                              const std::function<void(const Experiment&)>& finished) {
  std::vector<std::optional<report::Outcome>> outcomes(all.size());
  const auto take = [&](std::size_t number, report::Outcome outcome) {
    outcomes[number] = std::move(outcome);
    finished(all[number]);
  };

  Counter counter;
  std::vector<Helper> helpers;
  for (unsigned i = 0; i < std::max(processes, 1U); ++i) helpers.push_back(start(all, laboratory, counter, helpers));
  while (!helpers.empty()) {
    std::vector<pollfd> waits;
    for (const Helper& helper : helpers) waits.push_back({helper.descriptor, POLLIN, 0});
    if (poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR) {
      throw MachineError(std::string("waiting for experiments: ") + std::strerror(errno));
    }
    for (std::size_t i = helpers.size(); i-- > 0;) {
      if (waits[i].revents == 0) continue;
      Helper& helper = helpers[i];
      char some[65536];
      const ssize_t size = read(helper.descriptor, some, sizeof some);
      if (size < 0 && errno == EINTR) continue;
      if (size > 0) {
        helper.bytes.append(some, static_cast<std::size_t>(size));
        while (auto outcome = helper.next()) take(outcome->first, std::move(outcome->second));
        continue;
      }
      close(helper.descriptor);
      waitpid(helper.process, nullptr, 0);
      if (helper.at) take(*helper.at, failure(all[*helper.at], "its process ended early"));
      helpers.erase(helpers.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  std::vector<report::Outcome> whole;
  for (std::size_t number = 0; number < all.size(); ++number) {
    whole.push_back(outcomes[number] ? std::move(*outcomes[number])
                                     : failure(all[number], "every process ended before it"));
  }
  return whole;
}

}  // namespace odeval::experiments
