#pragma once
// What a program left in its record, frame by frame.
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <vector>

#include "audit/preload/record_format.hpp"

namespace odeval::audit {

/// The file is mapped, and as much of it in memory as the system likes.
class Recording {
 public:
  /// Throws MachineError where the file is there and cannot be read.
  explicit Recording(const std::filesystem::path& file);
  ~Recording();
  Recording(Recording&& other) noexcept;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  /// Null where the program made none: it has taken no step of ODE, or there was no room for the first bytes.
  const Head* head() const { return head_ ? &*head_ : nullptr; }
  bool has(Remark remark) const;
  bool had_no_room() const { return begun_in_vain_ || has(no_room); }

  struct Moment {
    Frame frame;
    std::span<const BodySample> bodies;
    std::span<const MotionSample> motions;  // of those, or none
    const Account* account = &none;

    static constexpr Account none{};
  };
  /// The next frame; nothing after the last, or where what follows is no frame.
  std::optional<Moment> next();

 private:
  void map(int descriptor, std::size_t file_bytes);

  std::optional<Head> head_;
  std::byte* frames_ = nullptr;  // mapped
  std::size_t size_ = 0;
  std::size_t end_ = 0;  // of the frames
  std::size_t at_ = 0;
  bool begun_in_vain_ = false;  // the file is there, and nothing is in it
};

constexpr double rounding_of_time = 1e-9;  // relative, of a sum of steps

/// The same step of the same world, with the same bodies.
bool same_bodies(const Recording::Moment& a, const Recording::Moment& b);

/// The first body, from 1, whose place or motion is no finite number; 0: none.
std::uint32_t not_finite(const Recording::Moment& moment);

/// Rows beside a record, of PartSample or ShapeSample; none where there is no such file.
template <class Row>
std::vector<Row> read_rows(const std::filesystem::path& file) {
  std::vector<Row> rows;
  std::ifstream in(file, std::ios::binary);
  for (Row row; in.read(reinterpret_cast<char*>(&row), sizeof row);) {
    std::uint32_t first = 0;  // the kind of each
    std::memcpy(&first, &row, sizeof first);
    if (first == 0) break;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace odeval::audit
