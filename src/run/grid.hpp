#pragma once
// The runs of a sweep: the cross product of lists of values, each run once.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace odeval::sweep {

struct Axis {
  std::string key;                       // of the scenario file, or "method"
  std::vector<std::string> values;       // as --set spells them
  std::vector<std::string> unread_by{};  // methods that the key means nothing to: it does not multiply their runs
};

/// Most runs one sweep may have: each costs a few bytes of memory.
inline constexpr long most_runs = 1'000'000;

/// Reads "KEY=V1,V2,..." (a list in brackets is one value), "KEY=log:A:B:N" (N values from A to B, each the same factor
/// above the one before, to 15 digits) or "KEY=lin:A:B:N". Where `is_whole` says so of the key, made values are rounded
/// to whole numbers, each once. Throws UserError; whether a value suits its key is for the reader of scenarios to say.
Axis parse_axis(const std::string& text, const std::function<bool(const std::string& key)>& is_whole);

class Grid {
 public:
  /// The last axis is the method. Throws UserError when a key stands twice or the runs are too many.
  explicit Grid(std::vector<Axis> axes);

  const std::vector<Axis>& axes() const { return axes_; }
  long runs() const { return static_cast<long>(places_.size()); }

  /// Which value of each axis a run has: the first, where its method does not read the key. The last axis changes
  /// fastest.
  std::vector<std::size_t> places(long run) const;
  /// Those values; none, "", where its method does not read the key.
  std::vector<std::string> values(long run) const;

 private:
  std::vector<std::size_t> unpacked(std::uint32_t place) const;
  bool reads(std::size_t method, std::size_t axis) const { return !unread_[method * axes_.size() + axis]; }

  std::vector<Axis> axes_;
  std::vector<bool> unread_;           // by method and axis
  std::vector<std::uint32_t> places_;  // in the cross product, of each run
};

/// One of several parts of a grid that are done in different places: one run of every `count` that follow each other,
/// each time another place among them, so that no shard gets all of one method.
struct Shard {
  long index = 1;
  long count = 1;

  bool holds(long run) const { return of(run) == index; }
  /// Which shard holds a run.
  long of(long run) const { return (run + run / count) % count + 1; }
  bool whole() const { return count == 1; }
  /// How many of `runs` runs it holds.
  long runs_of(long runs) const {
    long held = runs / count;
    for (long run = held * count; run < runs; ++run) held += holds(run) ? 1 : 0;
    return held;
  }
  std::string text() const { return std::to_string(index) + "/" + std::to_string(count); }

  bool operator==(const Shard&) const = default;
};

/// Reads "2/8". Throws UserError.
Shard parse_shard(const std::string& text);

}  // namespace odeval::sweep
