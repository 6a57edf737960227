#include "run/journal.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "odeval/error.hpp"
#include "run/clock.hpp"

namespace odeval::sweep {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view format = "odeval sweep 2";
constexpr std::size_t checksum_digits = 8;
constexpr std::size_t longest_line = 64 << 20;  // a head names every value of the grid
constexpr std::array<std::string_view, statuses> names{"ok", "diverged", "crashed", "timeout", "suspect"};

// A power failure may cost what came since the last of these.
constexpr long most_unsynced = 1000;
constexpr double longest_unsynced_s = 1;

std::uint32_t checksum(std::uint32_t seed, std::string_view text) {
  return static_cast<std::uint32_t>(::crc32_z(seed, reinterpret_cast<const Bytef*>(text.data()), text.size()));
}

/// Fields in one line, with tabs between them.
std::string pack(const std::vector<std::string>& fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) line += '\t';
    for (const char letter : fields[i]) {
      if (letter == '\\') {
        line += "\\\\";
      } else if (letter == '\t') {
        line += "\\t";
      } else if (letter == '\n') {
        line += "\\n";
      } else {
        line += letter;
      }
    }
  }
  return line;
}

std::vector<std::string> unpack(std::string_view line) {
  std::vector<std::string> fields(1);
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '\t') {
      fields.emplace_back();
    } else if (line[i] == '\\' && i + 1 < line.size()) {
      const char code = line[++i];
      fields.back() += code == 't' ? '\t' : code == 'n' ? '\n' : code;
    } else {
      fields.back() += line[i];
    }
  }
  return fields;
}

std::string packed(const Axis& axis) {
  std::vector<std::string> fields{axis.key, pack(axis.unread_by)};
  fields.insert(fields.end(), axis.values.begin(), axis.values.end());
  return pack(fields);
}

std::string packed(const std::vector<Axis>& axes) {
  std::vector<std::string> fields;
  for (const Axis& axis : axes) fields.push_back(packed(axis));
  return pack(fields);
}

std::vector<std::string> identity(const Head& head) {
  return {std::string(format), head.scenario, packed(head.axes), pack(head.columns), head.settings, head.versions};
}

/// Of the text, in eight digits.
std::string digits_of(std::uint32_t seed, std::string_view text) {
  std::array<char, checksum_digits> digits{};
  const auto end = std::to_chars(digits.begin(), digits.end(), checksum(seed, text), 16).ptr;
  return std::string(static_cast<std::size_t>(digits.end() - end), '0') + std::string(digits.begin(), end);
}

std::string with_checksum(std::uint32_t seed, const std::string& body) {
  return digits_of(seed, body) + ' ' + body + '\n';
}

/// What the line says when its checksum agrees.
std::optional<std::string_view> body_of(std::uint32_t seed, std::string_view line) {
  if (line.size() <= checksum_digits || line[checksum_digits] != ' ') return std::nullopt;
  const std::string_view body = line.substr(checksum_digits + 1);
  if (line.substr(0, checksum_digits) != digits_of(seed, body)) return std::nullopt;
  return body;
}

bool is_number(const std::string& text, long& number) {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return !text.empty() && error == std::errc() && stop == end;
}

}  // namespace

std::string_view status_name(Status status) { return names[static_cast<std::size_t>(status)]; }

std::string Head::difference(const Head& other) const {
  if (scenario != other.scenario) return "the scenario";
  if (packed(axes) != packed(other.axes)) return "the grid or the methods";
  if (settings != other.settings) return "the scenario's settings";
  if (versions != other.versions) return "the versions of odeval or its libraries";
  if (columns != other.columns) return "the columns";
  return "";
}

std::uint32_t seed_of(const Head& head) { return checksum(0, pack(identity(head))); }

std::string head_line(const Head& head) {
  std::vector<std::string> fields = identity(head);
  fields.push_back(head.shard.text());
  return with_checksum(0, pack(fields));
}

std::string row_line(std::uint32_t seed, long run, const Row& row) {
  return with_checksum(seed, pack({std::to_string(run), std::string(status_name(row.status)),
                                   std::to_string(row.cpu_us), row.reason, row.cells}));
}

std::optional<Head> head_of(std::string_view line) {
  const auto body = body_of(0, line);
  if (!body) return std::nullopt;
  const std::vector<std::string> fields = unpack(*body);
  if (fields.size() != 7 || fields[0] != format) return std::nullopt;
  Head head{fields[1], {}, {}, unpack(fields[3]), fields[4], fields[5]};
  for (const std::string& field : unpack(fields[2])) {
    const std::vector<std::string> parts = unpack(field);
    if (parts.size() < 3) return std::nullopt;
    std::vector<std::string> unread_by;
    if (!parts[1].empty()) unread_by = unpack(parts[1]);
    head.axes.push_back({parts[0], {parts.begin() + 2, parts.end()}, std::move(unread_by)});
  }
  try {
    head.shard = parse_shard(fields[6]);
    if (Grid(head.axes).runs() < 1) return std::nullopt;
  } catch (const UserError&) {
    return std::nullopt;
  }
  return head;
}

std::optional<std::pair<long, Row>> row_of(std::string_view line, std::uint32_t seed) {
  const auto body = body_of(seed, line);
  if (!body) return std::nullopt;
  std::vector<std::string> fields = unpack(*body);
  if (fields.size() != 5) return std::nullopt;
  std::pair<long, Row> found;
  auto& [run, row] = found;
  const auto name = std::find(names.begin(), names.end(), fields[1]);
  if (name == names.end() || !is_number(fields[0], run) || run < 0 || !is_number(fields[2], row.cpu_us)) {
    return std::nullopt;
  }
  row.status = static_cast<Status>(name - names.begin());
  row.reason = std::move(fields[3]);
  row.cells = std::move(fields[4]);
  return found;
}

void Lines::feed(std::string_view piece, const Take& take) {
  while (!piece.empty()) {
    const std::size_t feed = piece.find('\n');
    const std::string_view part = piece.substr(0, feed);
    line_ += part.substr(0, std::min(part.size(), longest_line + 1 - std::min(line_.size(), longest_line + 1)));
    fed_ += part.size();
    if (feed == std::string_view::npos) return;
    ++fed_;
    take(line_, whole_);
    whole_ = fed_;
    line_.clear();
    piece.remove_prefix(feed + 1);
  }
}

Journal::Journal(fs::path file, const Head& head) : file_(std::move(file)) {
  std::error_code error;
  fs::create_directories(file_.parent_path(), error);
  if (error) fail("cannot be made", error.value());
  open(O_RDWR | O_CREAT | O_APPEND, F_WRLCK);
  head_ = head;
  seed_ = seed_of(head_);

  bool titled = false;
  std::size_t damaged_bytes = 0;  // of the last damaged line
  offsets_.assign(static_cast<std::size_t>(Grid(head_.axes).runs()), 0);
  each_line([&](std::string_view line, std::uint64_t offset) {
    if (const auto row = row_of(line, seed_)) return note(row->first, offset, row->second);
    const auto found = head_of(line);
    if (!found) {
      ++damaged_;
      damaged_bytes = line.size();
      return;
    }
    titled = true;
    const std::string other = found->difference(head_);
    const std::string which = !other.empty()                ? other + " differ"
                              : found->shard != head_.shard ? "it is shard " + found->shard.text()
                                                            : "";
    if (!which.empty()) {
      throw UserError("--out: " + file_.string() + " is another sweep's (" + which +
                      "); give another folder, or remove that file");
    }
  });
  // One line alone may be our own first one.
  const bool ours = damaged_ == 0 || (damaged_ == 1 && damaged_bytes + 1 == head_line(head_).size());
  if (!titled && !ours && rows_ == 0) {
    throw UserError("--out: " + file_.string() +
                    " is damaged, or no journal of a sweep; give another folder, or remove that file");
  }
  cut_the_tail();
  if (titled) return;
  append_line(head_line(head_));
  sync();
  // The file's name as well.
  const int folder = ::open(file_.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    ::fsync(folder);
    ::close(folder);
  }
}

Journal::Journal(fs::path file) : file_(std::move(file)) {
  open(O_RDONLY, F_RDLCK);
  std::optional<Head> found;
  each_line([&](std::string_view line, std::uint64_t) {
    if (!found) found = head_of(line);
  });
  if (!found) {
    throw UserError(file_.string() +
                    ": is no journal of a sweep, or its first line is damaged; the sweep's command again mends it");
  }
  head_ = *found;
  seed_ = seed_of(head_);
  offsets_.assign(static_cast<std::size_t>(Grid(head_.axes).runs()), 0);
  each_line([&](std::string_view line, std::uint64_t offset) {
    if (const auto row = row_of(line, seed_)) {
      note(row->first, offset, row->second);
    } else if (!head_of(line)) {
      ++damaged_;
    }
  });
}

Journal::~Journal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void Journal::fail(const char* what, int cause) const {
  throw MachineError(file_.string() + ": " + what + ": " + std::strerror(cause));
}

// The kernel lets go of the lock with the process, however that ends, and does not hand it on to a forked worker.
void Journal::open(int flags, short lock) {
  descriptor_ = ::open(file_.c_str(), flags | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("cannot be opened", errno);
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    throw MachineError(file_.string() + ": is no regular file; a sweep's journal has to be one");
  }
  struct flock wanted {};
  wanted.l_type = lock;
  wanted.l_whence = SEEK_SET;
  if (::fcntl(descriptor_, F_SETLK, &wanted) == 0) return;
  if (errno != EACCES && errno != EAGAIN) fail("cannot be locked", errno);
  wanted.l_pid = 0;
  ::fcntl(descriptor_, F_GETLK, &wanted);
  const std::string who = wanted.l_pid > 0 ? " (process " + std::to_string(wanted.l_pid) + ")" : "";
  throw MachineError(file_.string() + ": another sweep" + who + " is at work on it");
}

void Journal::each_line(const Lines::Take& take) {
  Lines lines;
  std::vector<char> piece(1 << 16);
  for (std::uint64_t at = 0;;) {
    const ssize_t got = ::pread(descriptor_, piece.data(), piece.size(), static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("cannot be read", errno);
    if (got == 0) break;
    lines.feed({piece.data(), static_cast<std::size_t>(got)}, take);
    at += static_cast<std::uint64_t>(got);
  }
  size_ = lines.whole();
}

// What stands after the last line feed was never finished.
void Journal::cut_the_tail() {
  if (::ftruncate(descriptor_, static_cast<off_t>(size_)) != 0) fail("cannot be written", errno);
}

void Journal::note(long run, std::uint64_t offset, const Row& found) {
  if (run >= runs()) {
    ++damaged_;
    return;
  }
  std::uint64_t& place = offsets_[static_cast<std::size_t>(run)];
  if (place != 0) {
    const Row before = row(run);
    if (before.same_as(found)) return;
    if (before.status == Status::timeout) {
      place = offset + 1;
      --by_status_[static_cast<std::size_t>(before.status)];
      ++by_status_[static_cast<std::size_t>(found.status)];
      return;
    }
    throw MachineError(file_.string() + ": two rows of run " + std::to_string(run) +
                       " contradict each other; remove the file and sweep again");
  }
  place = offset + 1;
  ++rows_;
  ++by_status_[static_cast<std::size_t>(found.status)];
}

bool Journal::settled(long run, double timeout_s) const {
  if (!has(run)) return false;
  if (rows(Status::timeout) == 0) return true;
  const Row known = row(run);
  return known.status != Status::timeout || static_cast<double>(known.cpu_us) >= 1e6 * timeout_s - 1;
}

Row Journal::row(long run) const {
  std::string line(512, '\0');
  const auto at = static_cast<off_t>(offsets_[static_cast<std::size_t>(run)] - 1);
  for (;;) {
    const ssize_t got = ::pread(descriptor_, line.data(), line.size(), at);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("cannot be read", errno);
    const std::size_t feed = std::string_view(line.data(), static_cast<std::size_t>(got)).find('\n');
    if (feed != std::string_view::npos) {
      auto found = row_of(std::string_view(line).substr(0, feed), seed_);
      if (found && found->first == run) return std::move(found->second);
    } else if (static_cast<std::size_t>(got) == line.size() && line.size() < longest_line) {
      line.resize(2 * line.size());
      continue;
    }
    throw MachineError(file_.string() + ": has changed while it was in use");
  }
}

void Journal::append_line(const std::string& line) {
  std::string_view rest = line;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int cause = written == 0 ? EIO : errno;
      // A whole line or none. Should that fail too, the next sweep cuts the rest off.
      [[maybe_unused]] const int cut = ::ftruncate(descriptor_, static_cast<off_t>(size_));
      fail("cannot be written", cause);
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  size_ += line.size();
}

void Journal::append(long run, const Row& row) {
  const std::uint64_t offset = size_;
  append_line(row_line(seed_, run, row));
  note(run, offset, row);
  if (unsynced_++ == 0) unsynced_since_s_ = run::steady_seconds();
  sync_in_time();
}

void Journal::sync_in_time() {
  if (unsynced_ >= most_unsynced ||
      (unsynced_ > 0 && run::steady_seconds() - unsynced_since_s_ >= longest_unsynced_s)) {
    sync();
  }
}

void Journal::sync() {
  if (::fdatasync(descriptor_) != 0) fail("cannot be written", errno);
  unsynced_ = 0;
}

}  // namespace odeval::sweep
