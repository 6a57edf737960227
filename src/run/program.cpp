#include "run/program.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "odeval/error.hpp"
#include "run/clock.hpp"

namespace odeval::run {
namespace {

class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0) throw MachineError(std::string("no pipe: ") + std::strerror(errno));
  }
  ~Pipe() {
    ::close(ends_[0]);
    close_writing();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int reading() const { return ends_[0]; }
  int writing() const { return ends_[1]; }
  void close_writing() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

/// As a shell would start it: this process's blocked or ignored signals are no business of the program's.
void restore_signals() {
  for (int signal = 1; signal < NSIG; ++signal) ::signal(signal, SIG_DFL);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

[[noreturn]] void become(const Program& program, const Pipe& errors, const Pipe& failure, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(0);
  ::setpgid(0, 0);
  restore_signals();
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  ::dup2(nowhere, STDIN_FILENO);
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(errors.writing(), STDERR_FILENO);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  for (const auto& [name, value] : program.environment) ::setenv(name.c_str(), value.c_str(), 1);
  std::vector<char*> words;
  for (const std::string& word : program.words) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  ::execvp(words.front(), words.data());
  const int cause = errno;
  [[maybe_unused]] const ssize_t told = ::write(failure.writing(), &cause, sizeof cause);
  ::_exit(127);
}

/// The last line of all that comes, however much it is.
class Tail {
 public:
  void take(const char* bytes, std::size_t count) {
    text_.append(bytes, count);
    constexpr std::size_t most = 4096;
    if (text_.size() > most) text_.erase(0, text_.size() - most);
  }
  std::string line() const {
    const std::size_t end = text_.find_last_not_of("\r\n");
    if (end == std::string::npos) return "";
    const std::size_t begin = text_.find_last_of("\r\n", end);
    std::string line = text_.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
    std::erase_if(line, [](unsigned char letter) { return letter < ' '; });  // nothing for the terminal to obey
    return line;
  }

 private:
  std::string text_;
};

/// False when there is nothing more.
bool drain(int descriptor, Tail& tail) {
  std::array<char, 1 << 16> bytes;
  const ssize_t got = ::read(descriptor, bytes.data(), bytes.size());
  if (got > 0) tail.take(bytes.data(), static_cast<std::size_t>(got));
  return got > 0 || (got < 0 && errno == EINTR);
}

/// Until the process has ended; true when that is later than it may.
bool wait_for(int process, int errors, double timeout_s, Tail& tail) {
  const double until = steady_seconds() + timeout_s;
  std::array<pollfd, 2> waits{{{process, POLLIN, 0}, {errors, POLLIN, 0}}};
  for (;;) {
    const double left_ms = std::ceil(1e3 * (until - steady_seconds()));
    if (left_ms <= 0) return true;
    if (::poll(waits.data(), waits.size(), static_cast<int>(std::min(left_ms, 1e6))) < 0 && errno != EINTR) return true;
    if (waits[1].revents != 0 && !drain(errors, tail)) waits[1].fd = -1;
    if ((waits[0].revents & POLLIN) != 0) return false;
  }
}

/// What is left in the pipe. A process that the program left running may keep it open.
void drain_the_rest(int errors, Tail& tail) {
  ::fcntl(errors, F_SETFL, O_NONBLOCK);
  while (drain(errors, tail)) {
  }
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

void read_failure(Pipe& failure, const Program& program) {
  failure.close_writing();
  int cause = 0;
  ssize_t got = 0;
  do {
    got = ::read(failure.reading(), &cause, sizeof cause);
  } while (got < 0 && errno == EINTR);
  if (got == static_cast<ssize_t>(sizeof cause)) {
    throw UserError(program.words.front() + ": cannot be started: " + std::strerror(cause));
  }
}

}  // namespace

ProgramEnd run_program(const Program& program) {
  Pipe errors;
  Pipe failure;
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process < 0) throw MachineError(std::string("no process for a program: ") + std::strerror(errno));
  if (process == 0) become(program, errors, failure, parent);
  errors.close_writing();
  ::setpgid(process, process);  // both do, since either may be first

  ProgramEnd end;
  Tail tail;
  std::string refused;
  try {
    read_failure(failure, program);
    const auto handle = static_cast<int>(::syscall(SYS_pidfd_open, process, 0));  // glibc 2.36 declares it for C alone
    if (handle < 0) throw MachineError(std::string("cannot wait for a program: ") + std::strerror(errno));
    end.late = wait_for(handle, errors.reading(), program.timeout_s, tail);
    ::close(handle);
  } catch (...) {
    ::kill(-process, SIGKILL);
    ::waitpid(process, nullptr, 0);
    throw;
  }
  ::kill(-process, SIGKILL);  // what it has started, and itself where it is late
  int status = 0;
  rusage use{};
  while (::wait4(process, &status, 0, &use) < 0 && errno == EINTR) {
  }
  drain_the_rest(errors.reading(), tail);
  if (WIFSIGNALED(status) && !end.late) end.signal = WTERMSIG(status);
  if (WIFEXITED(status)) end.status = WEXITSTATUS(status);
  end.cpu_s = seconds(use.ru_utime) + seconds(use.ru_stime);
  end.last_line = tail.line();
  return end;
}

std::string end_text(const ProgramEnd& end, double timeout_s) {
  if (end.late) {
    std::ostringstream text;
    text << "ended after " << timeout_s << " s of --timeout";
    return text.str();
  }
  if (end.signal != 0) return "signal " + std::to_string(end.signal) + " (" + ::strsignal(end.signal) + ")";
  return "exit status " + std::to_string(end.status);
}

std::string packed(const ProgramEnd& end) {
  std::ostringstream text;
  text.precision(17);
  text << end.status << ' ' << end.signal << ' ' << end.late << ' ' << end.cpu_s << '\n' << end.last_line;
  return text.str();
}

ProgramEnd unpacked(const std::string& text) {
  std::istringstream in(text);
  ProgramEnd end;
  in >> end.status >> end.signal >> end.late >> end.cpu_s;
  in.ignore(1);
  std::getline(in, end.last_line);
  return end;
}

}  // namespace odeval::run
