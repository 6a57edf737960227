#pragma once
// The points of a grid as runs: a scenario with settings of its own in a method.
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "catalogue/evaluation.hpp"
#include "model/read_scenario.hpp"
#include "run/grid.hpp"
#include "run/sweep.hpp"

namespace odeval::catalogue {

/// Rows that a run of a sweep records where nothing says `sample`: more cost time and memory and show no more.
inline constexpr long enough_rows = 10'000;

/// The same with a `sample` of at most so many intervals, where every step would be more.
Scenario with_enough_rows(Scenario scenario, long intervals = enough_rows);

class GridRuns {
 public:
  /// The last axis of the grid is the method, by name; the others are keys of the file, on top of the settings.
  GridRuns(const ScenarioFile& file, std::vector<Override> settings, Names names, sweep::Grid grid);

  const sweep::Grid& grid() const { return grid_; }

  /// Of a run: the given ones and the grid's.
  std::vector<Override> settings(long run) const;

  /// As the run has it, with a `sample` of at most `enough_rows` intervals. Throws UserError.
  Scenario scenario(long run) const;

  /// Checks every run, and says which of them share a reference: those that differ only in what concerns the engine.
  /// Groups are numbered as they come. Throws UserError for a value that is not allowed.
  std::vector<std::uint32_t> groups(const std::function<void(long run)>& checked = {});

  /// How a worker does them, once `groups` has been called. Lives no longer than this.
  sweep::Work work();

 private:
  sweep::Row run(long run, long group, std::string_view prepared);

  const ScenarioFile& file_;
  std::vector<Override> settings_;
  Names names_;
  sweep::Grid grid_;
  std::vector<long> first_of_group_;

  // Of a worker: the reference it used last.
  long group_ = -1;
  std::shared_ptr<const Reference> reference_;
};

}  // namespace odeval::catalogue
