#include "run/shared.hpp"

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace odeval::run {
namespace {

[[noreturn]] void fail() {
  throw SharedError(std::string("no memory for what processes share: ") + std::strerror(errno));
}

}  // namespace

Shared::Shared() : descriptor_(::memfd_create("shared", MFD_CLOEXEC)) {
  if (descriptor_ < 0) fail();
}

Shared::~Shared() { ::close(descriptor_); }

void Shared::fill(std::string_view bytes) const {
  clear();
  ::lseek(descriptor_, 0, SEEK_SET);
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail();
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void Shared::clear() const {
  if (::ftruncate(descriptor_, 0) != 0) fail();
}

void Shared::with(const std::function<void(std::string_view bytes)>& use) const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail();
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return use({});
  void* const bytes = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor_, 0);
  if (bytes == MAP_FAILED) fail();
  struct Unmap {
    void* bytes;
    std::size_t size;
    ~Unmap() { ::munmap(bytes, size); }
  } const unmap{bytes, size};
  use({static_cast<const char*>(bytes), size});
}

}  // namespace odeval::run
