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

[[noreturn]] void fail(const fs::path& file, const std::string& cause) {
  throw MachineError(fmt::format("{}: cannot be written: {}", file.string(), cause));
}
[[noreturn]] void fail(const fs::path& file, int cause) { fail(file, std::strerror(cause)); }

/// The first link on the way that leads nowhere, which the system calls a file that exists; empty without one.
fs::path dangling_link(const fs::path& folder) {
  fs::path way;
  for (const fs::path& part : folder) {
    way /= part;
    std::error_code ignored;
    if (fs::is_symlink(way, ignored) && !fs::exists(way, ignored)) return way;
  }
  return {};
}

/// Why a folder cannot be made; empty when it is there.
std::string folder_trouble(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) return "";
  const fs::path link = dangling_link(folder);
  if (link.empty()) return std::strerror(error.value());
  std::error_code ignored;
  return fmt::format("{} is a link to {}, which is not there", link.string(), fs::read_symlink(link, ignored).string());
}

}  // namespace

void make_folder(const fs::path& folder) {
  if (const std::string cause = folder_trouble(folder); !cause.empty()) {
    throw MachineError(fmt::format("{}: cannot be made: {}", folder.string(), cause));
  }
}

WholeFile::WholeFile(fs::path file) : file_(std::move(file)) {
  if (file_.has_parent_path()) {
    if (const std::string cause = folder_trouble(file_.parent_path()); !cause.empty()) fail(file_, cause);
  }
  std::error_code absent;
  target_ = fs::is_symlink(file_, absent) && fs::exists(file_, absent) ? fs::canonical(file_) : file_;
  const fs::file_status status = fs::status(target_, absent);
  if (fs::is_directory(status)) fail(file_, EISDIR);

  const bool whole = !fs::exists(status) || fs::is_regular_file(status);
  written_ = target_;
  if (whole) written_.replace_filename(fmt::format(".{}.{}.part", target_.filename().string(), ::getpid()));
  const int flags = O_WRONLY | O_CLOEXEC | (whole ? O_CREAT | O_TRUNC : 0);
  descriptor_ = ::open(written_.c_str(), flags, 0666);
  if (descriptor_ < 0) fail(file_, errno);
}

WholeFile::~WholeFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  if (written_ != target_) ::unlink(written_.c_str());
}

void WholeFile::give_up(int cause) {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (written_ != target_) ::unlink(written_.c_str());
  fail(file_, cause);
}

void WholeFile::write(std::string_view text) {
  constexpr std::size_t enough = 1 << 16;
  buffer_ += text;
  if (buffer_.size() >= enough) flush();
}

void WholeFile::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written > 0) {
      rest.remove_prefix(static_cast<std::size_t>(written));
    } else if (written == 0) {
      give_up(EIO);
    } else if (errno != EINTR) {
      give_up(errno);
    }
  }
  buffer_.clear();
}

void WholeFile::finish() {
  flush();
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) give_up(errno);
  if (written_ != target_ && ::rename(written_.c_str(), target_.c_str()) != 0) give_up(errno);
}

void write_whole(const fs::path& file, std::string_view text) {
  WholeFile whole(file);
  whole.write(text);
  whole.finish();
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
