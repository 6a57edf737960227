#include "audit/recording.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "odeval/error.hpp"

namespace odeval::audit {

static_assert(sizeof(Frame) % alignof(BodySample) == 0 && head_bytes % alignof(Frame) == 0);

Recording::Recording(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 && errno == ENOENT) return;
  struct stat status {};
  void* place = MAP_FAILED;
  if (descriptor >= 0 && ::fstat(descriptor, &status) == 0 && status.st_size >= static_cast<off_t>(head_bytes)) {
    size_ = static_cast<std::size_t>(status.st_size);
    place = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
  }
  const int cause = errno;
  if (descriptor >= 0) ::close(descriptor);
  begun_in_vain_ = descriptor >= 0 && status.st_size < static_cast<off_t>(head_bytes);
  if (begun_in_vain_) return;
  if (place == MAP_FAILED) throw MachineError(file.string() + ": cannot be read: " + std::strerror(cause));
  bytes_ = static_cast<const std::byte*>(place);
  at_ = head_bytes;
  end_ = std::min(size_, head_bytes + static_cast<std::size_t>(head() == nullptr ? 0 : head()->committed));
}

Recording::~Recording() {
  if (bytes_ != nullptr) ::munmap(const_cast<std::byte*>(bytes_), size_);
}

Recording::Recording(Recording&& other) noexcept
    : bytes_(std::exchange(other.bytes_, nullptr)),
      size_(other.size_),
      end_(other.end_),
      at_(other.at_),
      begun_in_vain_(other.begun_in_vain_) {}

const Head* Recording::head() const {
  const auto* const head = reinterpret_cast<const Head*>(bytes_);
  return head != nullptr && head->magic == record_magic ? head : nullptr;
}

bool Recording::has(Remark remark) const { return head() != nullptr && (head()->remarks & remark) != 0; }

std::optional<Recording::Moment> Recording::next() {
  if (end_ - at_ < sizeof(Frame)) return std::nullopt;
  Moment moment{};
  std::memcpy(&moment.frame, bytes_ + at_, sizeof(Frame));
  const std::size_t whole = sizeof(Frame) + moment.frame.bodies * sizeof(BodySample);
  if (moment.frame.bytes != whole || end_ - at_ < whole) return std::nullopt;
  moment.bodies = {reinterpret_cast<const BodySample*>(bytes_ + at_ + sizeof(Frame)), moment.frame.bodies};
  at_ += whole;
  return moment;
}

}  // namespace odeval::audit
