#include "report/gnuplot.hpp"

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "odeval/error.hpp"

namespace odeval::report {
namespace {

[[noreturn]] void fail(const std::string& what) { throw MachineError("gnuplot: " + what); }

/// A file in memory, gone with its last user. Between two processes it needs, unlike a pipe, nobody to empty it.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : descriptor_(::memfd_create(name, MFD_CLOEXEC)) {
    if (descriptor_ < 0) fail(std::string("no memory file: ") + std::strerror(errno));
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return descriptor_; }

  void fill(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t written = ::write(descriptor_, text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) fail(std::string("the script cannot be passed on: ") + std::strerror(errno));
      text.remove_prefix(static_cast<std::size_t>(written));
    }
    ::lseek(descriptor_, 0, SEEK_SET);
  }

  std::string content() const {
    std::string text;
    std::array<char, 1 << 16> part{};
    ::lseek(descriptor_, 0, SEEK_SET);
    for (;;) {
      const ssize_t read = ::read(descriptor_, part.data(), part.size());
      if (read < 0 && errno == EINTR) continue;
      if (read < 0) fail(std::string("its answer cannot be read: ") + std::strerror(errno));
      if (read == 0) return text;
      text.append(part.data(), static_cast<std::size_t>(read));
    }
  }

 private:
  int descriptor_;
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

std::string run(std::array<const char*, 4> arguments, const std::string& input) {
  const MemoryFile in("script");
  const MemoryFile out("answer");
  const MemoryFile errors("errors");
  in.fill(input);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, in.descriptor(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, out.descriptor(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, errors.descriptor(), STDERR_FILENO);
  pid_t child = 0;
  const int cause = ::posix_spawnp(&child, arguments[0], &files, nullptr, const_cast<char* const*>(arguments.data()),
                                   environ);  // the cast: POSIX promises not to write
  posix_spawn_file_actions_destroy(&files);
  if (cause != 0) {
    fail(std::string("cannot be started: ") + std::strerror(cause) + "; scripts/install-deps installs it");
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) fail(std::string("cannot be waited for: ") + std::strerror(errno));
  }
  if (WIFSIGNALED(status)) fail(std::string("was ended by signal ") + ::strsignal(WTERMSIG(status)));
  if (WEXITSTATUS(status) != 0) {
    const std::string said = in_one_line(errors.content());
    fail("gave up with status " + std::to_string(WEXITSTATUS(status)) + (said.empty() ? "" : ": " + said));
  }
  return out.content();
}

}  // namespace

// By its name: what comes without one gnuplot reads byte by byte, 100 000 calls of the system for a curve or two.
std::string run_gnuplot(const std::string& script) {
  return run({"gnuplot", "--default-settings", "/dev/stdin", nullptr}, script);
}

std::string gnuplot_version() {
  try {
    return in_one_line(run({"gnuplot", "--version", nullptr, nullptr}, ""));
  } catch (const MachineError& error) {
    return error.what();
  }
}

}  // namespace odeval::report
