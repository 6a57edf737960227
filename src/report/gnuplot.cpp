#include "report/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string_view>

#include "odeval/error.hpp"

namespace odeval::report {
namespace {

// Descriptors of gnuplot's own, beside the usual three. Ours are above them all.
constexpr int script_at = 3;
constexpr int figure_at = 4;
constexpr int first_of_ours = 10;

constexpr std::string_view all_drawn = "\n-- drawn, errors: 0 --\n";
constexpr std::string_view not_drawn = "\n-- drawn, errors: 1 --\n";

[[noreturn]] void fail(const std::string& what) { throw MachineError("gnuplot: " + what); }
[[noreturn]] void fail_by_errno(const std::string& what) { fail(what + ": " + std::strerror(errno)); }

/// Closed with its last user, and not passed on to children.
class Descriptor {
 public:
  explicit Descriptor(int opened) : number_(opened < 0 ? -1 : ::fcntl(opened, F_DUPFD_CLOEXEC, first_of_ours)) {
    if (opened >= 0) ::close(opened);
    if (number_ < 0) fail_by_errno("no way to it");
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }

 private:
  int number_;
};

/// A file in memory. Between two processes it needs, unlike a pipe, nobody to empty it.
class MemoryFile : public Descriptor {
 public:
  MemoryFile() : Descriptor(::memfd_create("gnuplot", MFD_CLOEXEC)) {}

  void fill(std::string_view text) const {
    if (::ftruncate(number(), 0) != 0) fail_by_errno("the script cannot be passed on");
    ::lseek(number(), 0, SEEK_SET);
    while (!text.empty()) {
      const ssize_t written = ::write(number(), text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) fail_by_errno("the script cannot be passed on");
      text.remove_prefix(static_cast<std::size_t>(written));
    }
  }

  std::string content() const {
    std::string text;
    std::array<char, 1 << 16> part{};
    ::lseek(number(), 0, SEEK_SET);
    for (;;) {
      const ssize_t read = ::read(number(), part.data(), part.size());
      if (read < 0 && errno == EINTR) continue;
      if (read < 0) fail_by_errno("its answer cannot be read");
      if (read == 0) return text;
      text.append(part.data(), static_cast<std::size_t>(read));
    }
  }
};

/// On one line, without the blanks and carets that gnuplot points with.
std::string in_one_line(const std::string& text) {
  std::string line;
  for (const char letter : text) {
    const bool blank = letter == ' ' || letter == '\n' || letter == '\t' || letter == '^';
    if (!blank) {
      line += letter;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  while (line.ends_with(' ')) line.pop_back();
  return line;
}

/// Both ends of a way there and back: what is told to gnuplot, and what it says when it has drawn or complains.
struct Talk {
  std::optional<Descriptor> ours, gnuplots;

  Talk() {
    std::array<int, 2> ends{-1, -1};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) fail_by_errno("no way to it");
    ours.emplace(ends[0]);
    gnuplots.emplace(ends[1]);
  }
};

/// A gnuplot that draws one figure after the other: to start it takes longer than to draw most of them.
class Gnuplot {
 public:
  Gnuplot() {
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    const auto give = [&files](const Descriptor& ours, int as) {
      posix_spawn_file_actions_adddup2(&files, ours.number(), as);
    };
    give(*talk_.gnuplots, STDIN_FILENO);
    give(*talk_.gnuplots, STDERR_FILENO);
    give(figure_, STDOUT_FILENO);
    give(script_, script_at);
    give(figure_, figure_at);
    std::array<const char*, 3> words{"gnuplot", "--default-settings", nullptr};
    const int cause = ::posix_spawnp(&child_, words[0], &files, nullptr, const_cast<char* const*>(words.data()),
                                     environ);  // the cast: POSIX promises not to write
    posix_spawn_file_actions_destroy(&files);
    if (cause != 0) {
      fail(std::string("cannot be started: ") + std::strerror(cause) + "; scripts/install-deps installs it");
    }
    talk_.gnuplots.reset();
  }
  ~Gnuplot() {
    talk_.ours.reset();  // the end of what it reads is its own
    if (child_ != 0) wait();
  }
  Gnuplot(const Gnuplot&) = delete;
  Gnuplot& operator=(const Gnuplot&) = delete;

  // The script by its name: what comes without one gnuplot reads byte by byte, 100 000 calls of the system for a curve
  // or two.
  std::string draw(const std::string& script) {
    script_.fill(script);
    figure_.fill("");
    tell(
        fmt::format("reset session\nreset errors\nset output '/dev/fd/{}'\nload '/dev/fd/{}'\nunset output\nset print\n"
                    "print sprintf(\"\\n-- drawn, errors: %d --\", GPVAL_ERRNO != 0)\n",
                    figure_at, script_at));
    std::string said;
    while (!said.ends_with(all_drawn)) {
      if (said.ends_with(not_drawn)) fail("gave up: " + in_one_line(said.substr(0, said.size() - not_drawn.size())));
      std::array<char, 1 << 12> part{};
      const ssize_t read = ::read(talk_.ours->number(), part.data(), part.size());
      if (read < 0 && errno == EINTR) continue;
      if (read <= 0) fail_by_its_end(said);
      said.append(part.data(), static_cast<std::size_t>(read));
    }
    return figure_.content();
  }

 private:
  /// What it does not read any more it says nothing to, either.
  void tell(std::string_view commands) const {
    while (!commands.empty()) {
      const ssize_t sent = ::send(talk_.ours->number(), commands.data(), commands.size(), MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) continue;
      if (sent <= 0) return;
      commands.remove_prefix(static_cast<std::size_t>(sent));
    }
  }

  int wait() {
    int status = 0;
    while (::waitpid(child_, &status, 0) < 0) {
      if (errno == EINTR) continue;
      child_ = 0;
      fail_by_errno("cannot be waited for");
    }
    child_ = 0;
    return status;
  }

  [[noreturn]] void fail_by_its_end(const std::string& said) {
    const int status = wait();
    if (WIFSIGNALED(status)) fail(std::string("was ended by signal ") + ::strsignal(WTERMSIG(status)));
    const std::string why = in_one_line(said);
    fail("ended with status " + std::to_string(WEXITSTATUS(status)) + (why.empty() ? "" : ": " + why));
  }

  Talk talk_;
  MemoryFile script_;
  MemoryFile figure_;
  pid_t child_ = 0;
};

/// Of this thread, while there is an OneGnuplot.
thread_local int wanted = 0;
thread_local std::optional<Gnuplot> shared;

}  // namespace

OneGnuplot::OneGnuplot() { ++wanted; }
OneGnuplot::~OneGnuplot() {
  if (--wanted == 0) shared.reset();
}

std::string run_gnuplot(const std::string& script) {
  if (wanted == 0) return Gnuplot().draw(script);
  try {
    if (!shared) shared.emplace();
    return shared->draw(script);
  } catch (const MachineError&) {
    shared.reset();
    throw;
  }
}

std::string gnuplot_version() {
  try {
    return in_one_line(
        run_gnuplot(fmt::format("set print '/dev/fd/{}'\nprint sprintf('gnuplot %.1f patchlevel %s', GPVAL_VERSION, "
                                "GPVAL_PATCHLEVEL)\nunset print\n",
                                figure_at)));
  } catch (const MachineError& error) {
    return error.what();
  }
}

}  // namespace odeval::report
