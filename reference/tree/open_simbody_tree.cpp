#include <string>

#include "odeval/part.hpp"
#include "reference/tree/simbody_tree.hpp"

namespace odeval::reference {

std::unique_ptr<SimbodyTree> open_simbody_tree(const Mechanism& mechanism, const std::vector<Branch>& tree,
                                               double gravity) {
  using Make = SimbodyTree* (*)(const Mechanism*, const std::vector<Branch>*, double);
  const std::string module = part_file(ODEVAL_INSTALLED_SIMBODY, ODEVAL_BUILT_SIMBODY);
  const auto make = part_function<Make>(module, "odeval_make_simbody_tree", "reference");
  return std::unique_ptr<SimbodyTree>(make(&mechanism, &tree, gravity));
}

}  // namespace odeval::reference
