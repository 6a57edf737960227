#include "output/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>

#include "odeval/error.hpp"

namespace odeval {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const fs::path& file, int cause) {
  throw MachineError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(cause)));
}

/// Writes all of the text to the open file and closes it. Returns 0 or the error number.
int write_and_close(int descriptor, std::string_view text) {
  int cause = 0;
  while (cause == 0 && !text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written > 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (written == 0) {
      cause = EIO;
    } else if (errno != EINTR) {
      cause = errno;
    }
  }
  if (::close(descriptor) != 0 && cause == 0) cause = errno;
  return cause;
}

void make_folders(const fs::path& file) {
  if (!file.has_parent_path()) return;
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) fail(file, error.value());
}

}  // namespace

void write_whole(const fs::path& file, std::string_view text) {
  make_folders(file);
  std::error_code absent;
  const fs::path target = fs::is_symlink(file, absent) && fs::exists(file, absent) ? fs::canonical(file) : file;
  const fs::file_status status = fs::status(target, absent);
  if (fs::is_directory(status)) fail(file, EISDIR);

  const bool whole = !fs::exists(status) || fs::is_regular_file(status);
  fs::path written = target;
  if (whole) written.replace_filename(fmt::format(".{}.{}.part", target.filename().string(), ::getpid()));
  const int flags = O_WRONLY | O_CLOEXEC | (whole ? O_CREAT | O_TRUNC : 0);
  const int descriptor = ::open(written.c_str(), flags, 0666);
  if (descriptor < 0) fail(file, errno);
  int cause = write_and_close(descriptor, text);
  if (!whole) {
    if (cause != 0) fail(file, cause);
    return;
  }
  if (cause == 0 && ::rename(written.c_str(), target.c_str()) != 0) cause = errno;
  if (cause != 0) {
    ::unlink(written.c_str());
    fail(file, cause);
  }
}

std::string read_whole(const fs::path& file) {
  std::error_code ignored;
  errno = fs::is_directory(file, ignored) ? EISDIR : 0;
  std::ifstream in;
  if (errno == 0) in.open(file, std::ios::binary);
  if (!in.is_open()) throw UserError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(errno)));
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad()) throw UserError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(errno)));
  return std::move(text).str();
}

}  // namespace odeval
