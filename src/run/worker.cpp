#include "run/worker.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <limits>
#include <new>

#include "odeval/error.hpp"

namespace odeval::run {
namespace {

// An answer is a Head and the text, in as many messages as that needs. Messages keep their bounds, so that no two
// answers are in one.
constexpr std::size_t longest_message = 1 << 16;

struct Head {
  Answer::Kind kind;
  std::size_t size;  // of the text
};

[[noreturn]] void fail(const std::string& what) { throw MachineError(what + ": " + std::strerror(errno)); }

bool send_whole(int descriptor, std::string_view message) {
  while (::send(descriptor, message.data(), message.size(), MSG_NOSIGNAL) < 0) {
    if (errno != EINTR) return false;
  }
  return true;
}

bool send_answer(int descriptor, const Answer& answer) {
  Head head{};
  head.kind = answer.kind;
  head.size = answer.text.size();
  std::string bytes(reinterpret_cast<const char*>(&head), sizeof head);
  bytes += answer.text;
  for (std::string_view rest = bytes; !rest.empty(); rest.remove_prefix(std::min(rest.size(), longest_message))) {
    if (!send_whole(descriptor, rest.substr(0, longest_message))) return false;
  }
  return true;
}

/// Once it has arrived whole.
std::optional<Answer> answer_of(std::string_view arrived) {
  Head head;
  if (arrived.size() < sizeof head) return std::nullopt;
  std::memcpy(&head, arrived.data(), sizeof head);
  if (arrived.size() < sizeof head + head.size) return std::nullopt;
  return Answer{head.kind, std::string(arrived.substr(sizeof head))};
}

Answer do_task(const Work& work, const std::vector<Shared>& shared, const Task& task) {
  Answer answer;
  const Shared& place = shared[static_cast<std::size_t>(task.place)];
  try {
    if (task.kind == Task::Kind::prepare) {
      place.fill(work.prepare(task.group));
    } else {
      place.with([&](std::string_view prepared) { answer.text = work.job(task.job, task.group, prepared); });
    }
  } catch (const SharedError& error) {
    answer.kind = Answer::Kind::broken;
    answer.text = error.what();
  } catch (const UserError& error) {
    answer.kind = Answer::Kind::refused;
    answer.text = error.what();
  } catch (const std::bad_alloc&) {
    answer.kind = Answer::Kind::failed;
    answer.text = "out of memory";
  } catch (const std::exception& error) {
    answer.kind = Answer::Kind::failed;
    answer.text = error.what();
  }
  return answer;
}

/// A worker's life: tasks until the other end is closed.
[[noreturn]] void serve(int descriptor, const Work& work, const std::vector<Shared>& shared) {
  for (;;) {
    Task task;
    const ssize_t got = ::recv(descriptor, &task, sizeof task, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got != static_cast<ssize_t>(sizeof task)) ::_exit(0);
    if (!send_answer(descriptor, do_task(work, shared, task))) ::_exit(0);
  }
}

/// The parent blocks signals to read them; here they act. An interrupt at the terminal goes to all processes at once,
/// and the parent answers it.
void reset_signals() {
  ::signal(SIGINT, SIG_IGN);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

/// What a job prints would stand among the program's own output, and its core would be one of thousands.
void silence() {
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) ::dup2(nowhere, STDOUT_FILENO);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
}

/// A job needs the memory of the one before: given back to the system and asked for again, page by page, it costs
/// 4 ms of a run of 20 ms and 10,001 rows.
void keep_memory() {
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the most there is
  ::mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

bool raised_by_itself(int signal) {
  constexpr std::array own{SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS, SIGXCPU, SIGXFSZ};
  return std::find(own.begin(), own.end(), signal) != own.end();
}

}  // namespace

Worker::Worker(const Work& work, const std::vector<Shared>& shared) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) fail("no pipe to a worker");
  const pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ < 0) {
    const int cause = errno;
    ::close(ends[0]);
    ::close(ends[1]);
    errno = cause;
    fail("no process for a worker");
  }
  if (process_ == 0) {
    // Gone when the parent is, even in the middle of a job that never ends.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(0);
    reset_signals();
    silence();
    keep_memory();
    serve(ends[1], work, shared);
  }
  ::close(ends[1]);
  descriptor_ = ends[0];
}

Worker::~Worker() {
  if (process_ > 0) {
    kill();
    end();
  }
  ::close(descriptor_);
}

double Worker::pace_s() const {
  return done_ > 0 ? busy_s_ / static_cast<double>(done_) : std::numeric_limits<double>::infinity();
}

void Worker::give(const Task& task) {
  if (!busy()) begun_at_s_ = steady_seconds();
  tasks_.push_back(task);
  group_ = task.group;
  ++given_;
  send_whole(descriptor_, {reinterpret_cast<const char*>(&task), sizeof task});
}

// A worker that ends with tasks unread resets the connection; what it had answered can be read after that.
std::optional<Answer> Worker::take() {
  std::array<char, longest_message> message;
  ssize_t got = 0;
  do {
    got = ::recv(descriptor_, message.data(), message.size(), 0);
  } while (got < 0 && (errno == EINTR || errno == ECONNRESET));
  ended_ = got <= 0;
  if (ended_) return std::nullopt;
  arrived_.append(message.data(), static_cast<std::size_t>(got));
  std::optional<Answer> answer = answer_of(arrived_);
  if (!answer) return std::nullopt;
  arrived_.clear();
  tasks_.pop_front();
  ++done_;
  const double now = steady_seconds();
  busy_s_ += now - begun_at_s_;
  begun_at_s_ = now;  // of the next, if there is one
  return answer;
}

void Worker::kill() const { ::kill(process_, SIGKILL); }

Worker::End Worker::end() {
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0) {
    if (errno != EINTR) break;
  }
  process_ = -1;
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return {!raised_by_itself(signal), "ended by signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")"};
  }
  return {false, "ended with exit status " + std::to_string(WEXITSTATUS(status))};
}

}  // namespace odeval::run
