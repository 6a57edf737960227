#pragma once
// Impacts as a scenario wants them told, seen from outside an engine: from where its bodies are after each step.
#include <memory>
#include <optional>
#include <vector>

#include "engines/tree/world.hpp"
#include "odeval/motion.hpp"
#include "odeval/scenario.hpp"

namespace odeval::engine_tree {

/// An impact is a run of steps in which something touches. It may last many: engines whose contacts are springs take
/// their time.
class Impacts {
 public:
  explicit Impacts(const Scenario& scenario);

  /// After each step: when it began, what touched in it, the bodies before and after it, links' absolute angles.
  void look(double from_s, const Touched& touched, const std::vector<Placed>& before, const std::vector<Placed>& after,
            const std::vector<double>& angles);
  std::vector<Impact> take() { return std::move(impacts_); }

 private:
  struct Watched {
    ImpactView view;
    bool touching = false;
    std::optional<std::size_t> impact = {};  // number of the one that goes on
  };
  double rate(const ImpactView& view, const std::vector<Placed>& bodies) const;

  std::shared_ptr<const PlanarView> planar_;
  std::vector<Watched> watched_;
  std::vector<Impact> impacts_;
};

}  // namespace odeval::engine_tree
