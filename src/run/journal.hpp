#pragma once
// What a sweep knows so far, in a file that only grows: a line a run, each with a checksum, so that nothing that
// happens to the process or the file can lose a row unnoticed, double it or bring in another sweep's.
//
// A line is eight hexadecimal digits, a blank, and what they are the checksum (CRC-32) of. The first says which sweep
// this is; the checksums of the rows start from it, so that a row of another sweep is no row of this one. The last line
// counts when it ends with its line feed. What cannot be read is passed over; its run is done again.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "run/grid.hpp"

namespace odeval::sweep {

/// Which sweep. Two with the same head, but for the shard, have the same rows.
struct Head {
  std::string scenario;  // name
  Shard shard;
  std::vector<Axis> axes;            // the method last
  std::vector<std::string> columns;  // of Row::cells
  std::string settings;              // the scenario with its settings
  std::string versions;              // of what runs it

  /// What differs, in words for the user; empty when they are parts of one sweep.
  std::string difference(const Head& other) const;
};

enum class Status { ok, diverged, crashed, timeout, suspect };
inline constexpr std::size_t statuses = 5;
std::string_view status_name(Status status);

/// What a run left.
struct Row {
  Status status = Status::ok;
  std::string reason;  // why not ok, or not to be taken for more than it is
  long cpu_us = 0;     // of the stepping, or the time after which a run was given up; no part of the table
  std::string cells;   // the columns' values as CSV; empty when the run did not get that far

  /// But for the time it took.
  bool same_as(const Row& other) const {
    return status == other.status && reason == other.reason && cells == other.cells;
  }
};

/// What the checksums of a sweep's rows start from; the shard has no part in it.
std::uint32_t seed_of(const Head& head);

std::string head_line(const Head& head);
std::string row_line(std::uint32_t seed, long run, const Row& row);

/// Empty when the line, without its line feed, is none of that kind or damaged.
std::optional<Head> head_of(std::string_view line);
std::optional<std::pair<long, Row>> row_of(std::string_view line, std::uint32_t seed);

/// Cuts text that comes in pieces into lines; one that is longer than any line of a journal is cut short.
class Lines {
 public:
  using Take = std::function<void(std::string_view line, std::uint64_t offset)>;

  void feed(std::string_view piece, const Take& take);
  /// How much of the text stands before the last line feed, this included.
  std::uint64_t whole() const { return whole_; }

 private:
  std::string line_;
  std::uint64_t whole_ = 0;
  std::uint64_t fed_ = 0;
};

/// A journal on disk, its rows by number of run.
///
/// Throws MachineError when it cannot be read or written, or another process is writing it; UserError when it is
/// another sweep's.
class Journal {
 public:
  /// To go on with the sweep of that head, or to begin it. Makes the folder.
  Journal(std::filesystem::path file, const Head& head);
  /// To read what is there.
  explicit Journal(std::filesystem::path file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  const Head& head() const { return head_; }
  long runs() const { return static_cast<long>(offsets_.size()); }  // of the whole grid
  bool has(long run) const { return offsets_[static_cast<std::size_t>(run)] != 0; }
  /// Whether a sweep that gives each run so much time has nothing left to do for it.
  bool settled(long run, double timeout_s) const;
  long rows() const { return rows_; }
  long rows(Status status) const { return by_status_[static_cast<std::size_t>(status)]; }
  long damaged() const { return damaged_; }  // lines

  /// Of a run that it has.
  Row row(long run) const;

  /// A whole line or none; a run that was given up may come again, given more time. It is safe from a power failure
  /// after the next `sync`.
  void append(long run, const Row& row);
  void sync();
  /// Where much is not safe yet, or for a second: `append` looks, and who waits long for the next row does.
  void sync_in_time();

 private:
  void open(int flags, short lock);
  [[noreturn]] void fail(const char* what, int cause) const;
  void each_line(const Lines::Take& take);
  void cut_the_tail();
  void append_line(const std::string& line);
  void note(long run, std::uint64_t offset, const Row& row);

  std::filesystem::path file_;
  int descriptor_ = -1;
  Head head_;
  std::uint32_t seed_ = 0;
  std::vector<std::uint64_t> offsets_;  // one more than where the run's line begins; 0: it has none
  long rows_ = 0;
  long by_status_[statuses] = {};
  long damaged_ = 0;
  std::uint64_t size_ = 0;  // of the whole lines
  long unsynced_ = 0;
  double unsynced_since_s_ = 0;
};

}  // namespace odeval::sweep
