#pragma once
// How the bodies of a mechanism hang on one another.
#include <optional>
#include <vector>

#include "odeval/mechanism.hpp"

namespace odeval::reference {

/// A body, and what it hangs on.
struct Branch {
  std::size_t body = 0;               // number
  std::optional<std::size_t> joint;   // number; absent: the body is free
  std::optional<std::size_t> parent;  // number of the body that the joint hangs it on; absent: the world
  bool again = false;                 // the body has a branch before: the joint closes a loop
};

/// All bodies, each after the one that it hangs on: from the world outwards, then from the first of bodies that hang
/// together and on nothing else. After these, for each joint that is left, a branch of a body that is there again.
std::vector<Branch> spanning_tree(const Mechanism& mechanism);

}  // namespace odeval::reference
