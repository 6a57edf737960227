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

void make_folders(const fs::path& file) {
  if (!file.has_parent_path()) return;
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) fail(file, error.value());
}

}  // namespace

WholeFile::WholeFile(fs::path file) : file_(std::move(file)) {
  make_folders(file_);
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
