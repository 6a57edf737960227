#include "sweep/worker.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>

#include "odeval/error.hpp"

namespace odeval::sweep {
namespace {

// Messages keep their bounds, so an answer is there whole or not at all.
constexpr std::size_t longest_message = 1 << 16;
constexpr std::size_t longest_reason = 1000;

[[noreturn]] void fail(const std::string& what) { throw MachineError("sweep: " + what + ": " + std::strerror(errno)); }

[[noreturn]] void fail_shared() {
  throw SharedError(std::string("sweep: no memory for what workers share: ") + std::strerror(errno));
}

void put(std::string& message, const std::string& text) {
  const std::size_t size = text.size();
  message.append(reinterpret_cast<const char*>(&size), sizeof size);
  message += text;
}

std::string message_of(const Answer& answer) {
  std::string message;
  message += static_cast<char>(answer.kind);
  message += static_cast<char>(answer.row.status);
  message.append(reinterpret_cast<const char*>(&answer.row.cpu_us), sizeof answer.row.cpu_us);
  put(message, answer.row.reason.substr(0, longest_reason));
  put(message, answer.row.cells);
  put(message, answer.text.substr(0, longest_reason));
  return message;
}

class Reader {
 public:
  explicit Reader(std::string_view message) : rest_(message) {}

  template <class Value>
  Value value() {
    Value value{};
    std::memcpy(&value, bytes(sizeof value).data(), sizeof value);
    return value;
  }
  std::string text() { return std::string(bytes(value<std::size_t>())); }

 private:
  std::string_view bytes(std::size_t count) {
    if (count > rest_.size()) throw MachineError("sweep: a worker's answer cannot be read");
    const std::string_view piece = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return piece;
  }

  std::string_view rest_;
};

Answer answer_of(std::string_view message) {
  Reader reader(message);
  Answer answer;
  answer.kind = reader.value<Answer::Kind>();
  answer.row.status = static_cast<Status>(reader.value<char>());
  answer.row.cpu_us = reader.value<long>();
  answer.row.reason = reader.text();
  answer.row.cells = reader.text();
  answer.text = reader.text();
  return answer;
}

Answer do_task(const Work& work, const std::vector<Shared>& shared, const Task& task) {
  Answer answer;
  const Shared& place = shared[static_cast<std::size_t>(task.place)];
  try {
    if (task.kind == Task::Kind::prepare) {
      place.fill(work.prepare(task.group));
    } else {
      place.with([&](std::string_view prepared) { answer.row = work.run(task.run, task.group, prepared); });
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
    const std::string message = message_of(do_task(work, shared, task));
    if (message.size() > longest_message) ::abort();
    while (::send(descriptor, message.data(), message.size(), MSG_NOSIGNAL) < 0) {
      if (errno != EINTR) ::_exit(0);
    }
  }
}

/// Signals as a program finds them when it starts. An interrupt at the terminal goes to all its processes at once and
/// is the parent's to answer.
void reset_signals() {
  for (const int signal : {SIGTERM, SIGHUP, SIGQUIT}) ::signal(signal, SIG_DFL);
  ::signal(SIGINT, SIG_IGN);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

/// A run's words on standard output are nobody's, and its core would be one of thousands.
void silence() {
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) ::dup2(nowhere, STDOUT_FILENO);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
}

/// A run needs the memory of the one before: given back to the system and asked for again, page by page, it costs
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

Shared::Shared() : descriptor_(::memfd_create("sweep", MFD_CLOEXEC)) {
  if (descriptor_ < 0) fail_shared();
}

Shared::~Shared() { ::close(descriptor_); }

void Shared::fill(std::string_view bytes) const {
  clear();
  ::lseek(descriptor_, 0, SEEK_SET);
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail_shared();
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void Shared::clear() const {
  if (::ftruncate(descriptor_, 0) != 0) fail_shared();
}

void Shared::with(const std::function<void(std::string_view bytes)>& use) const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail_shared();
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return use({});
  void* const bytes = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor_, 0);
  if (bytes == MAP_FAILED) fail_shared();
  struct Unmap {
    void* bytes;
    std::size_t size;
    ~Unmap() { ::munmap(bytes, size); }
  } const unmap{bytes, size};
  use({static_cast<const char*>(bytes), size});
}

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
    // Gone when the parent is, even in the middle of a run that never ends.
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
  while (::send(descriptor_, &task, sizeof task, MSG_NOSIGNAL) < 0) {
    if (errno != EINTR) return;
  }
}

// A worker that ends with tasks unread resets the connection; what it had answered can be read after that.
std::optional<Answer> Worker::take() {
  std::array<char, longest_message> message;
  ssize_t got = 0;
  do {
    got = ::recv(descriptor_, message.data(), message.size(), 0);
  } while (got < 0 && (errno == EINTR || errno == ECONNRESET));
  if (got <= 0) return std::nullopt;
  Answer answer = answer_of({message.data(), static_cast<std::size_t>(got)});
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

}  // namespace odeval::sweep
