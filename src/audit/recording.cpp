#include "audit/recording.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "odeval/error.hpp"

namespace odeval::audit {

// So that each of them, one after the other, stands where it may.
static_assert(sizeof(Frame) % alignof(BodySample) == 0 && sizeof(BodySample) % alignof(MotionSample) == 0 &&
              sizeof(MotionSample) % alignof(Account) == 0 && sizeof(Account) % alignof(Frame) == 0);

Recording::Recording(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 && errno == ENOENT) return;
  struct stat status {};
  Head head{};
  bool is_read = descriptor >= 0 && ::fstat(descriptor, &status) == 0;
  begun_in_vain_ = is_read && status.st_size < static_cast<off_t>(head_bytes + window_bytes);
  if (is_read && !begun_in_vain_) {
    is_read = ::pread(descriptor, &head, sizeof head, 0) == static_cast<ssize_t>(sizeof head);
    if (is_read && head.magic == record_magic) {
      head_ = head;
      errno = EPROTO;  // should the file be shorter than its head says
      map(descriptor, static_cast<std::size_t>(status.st_size));
      is_read = frames_ != nullptr;
    }
  }
  const int cause = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (!is_read) throw MachineError(file.string() + ": cannot be read: " + std::strerror(cause));
}

/// What was written behind the window, and then the window, as one piece of memory.
void Recording::map(int descriptor, std::size_t file_bytes) {
  const std::size_t before = head_bytes + window_bytes;
  const std::size_t behind = head_->behind;
  if (file_bytes < before + behind) return;
  const std::size_t size = behind + window_bytes;
  void* const place = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (place == MAP_FAILED) return;
  frames_ = static_cast<std::byte*>(place);
  size_ = size;
  const auto put = [&](std::size_t at, std::size_t bytes, std::size_t from) {
    const auto offset = static_cast<off_t>(from);
    return bytes == 0 ||
           ::mmap(frames_ + at, bytes, PROT_READ, MAP_PRIVATE | MAP_FIXED, descriptor, offset) != MAP_FAILED;
  };
  const bool whole = put(0, behind, before) && put(behind, window_bytes, head_bytes);
  end_ = whole ? std::min<std::size_t>(size_, head_->committed) : 0;
}

Recording::~Recording() {
  if (frames_ != nullptr) ::munmap(frames_, size_);
}

Recording::Recording(Recording&& other) noexcept
    : head_(other.head_),
      frames_(std::exchange(other.frames_, nullptr)),
      size_(other.size_),
      end_(other.end_),
      at_(other.at_),
      begun_in_vain_(other.begun_in_vain_) {}

bool Recording::has(Remark remark) const { return head() != nullptr && (head()->remarks & remark) != 0; }

std::optional<Recording::Moment> Recording::next() {
  if (end_ - at_ < sizeof(Frame)) return std::nullopt;
  Moment moment{};
  std::memcpy(&moment.frame, frames_ + at_, sizeof(Frame));
  const std::size_t count = moment.frame.bodies;
  const std::size_t motions = moment.frame.has_motions != 0 ? count : 0;
  const std::size_t after_bodies = sizeof(Frame) + count * sizeof(BodySample);
  const std::size_t after_motions = after_bodies + motions * sizeof(MotionSample);
  const std::size_t whole = after_motions + (moment.frame.has_account != 0 ? sizeof(Account) : 0);
  if (moment.frame.bytes != whole || end_ - at_ < whole) return std::nullopt;
  const std::byte* const begin = frames_ + at_;
  moment.bodies = {reinterpret_cast<const BodySample*>(begin + sizeof(Frame)), count};
  moment.motions = {reinterpret_cast<const MotionSample*>(begin + after_bodies), motions};
  if (moment.frame.has_account != 0) moment.account = reinterpret_cast<const Account*>(begin + after_motions);
  at_ += whole;
  return moment;
}

bool same_bodies(const Recording::Moment& a, const Recording::Moment& b) {
  return a.frame.world == b.frame.world && a.frame.step == b.frame.step &&
         std::ranges::equal(a.bodies, b.bodies, {}, &BodySample::body, &BodySample::body) &&
         std::fabs(a.frame.t - b.frame.t) <= rounding_of_time * (1 + a.frame.t);
}

std::uint32_t not_finite(const Recording::Moment& moment) {
  const auto finite = [](const auto& values) {
    return std::ranges::all_of(values, [](double x) { return std::isfinite(x); });
  };
  for (std::size_t i = 0; i < moment.bodies.size(); ++i) {
    const BodySample& body = moment.bodies[i];
    const bool moves = moment.motions.empty() || (finite(moment.motions[i].velocity) && finite(moment.motions[i].spin));
    if (!moves || !finite(body.position) || !finite(body.quaternion)) return body.body + 1;
  }
  return 0;
}

}  // namespace odeval::audit
