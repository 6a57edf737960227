#include "reference/tree/spanning_tree.hpp"

namespace odeval::reference {
namespace {

class Growth {
 public:
  explicit Growth(const Mechanism& mechanism)
      : joints_(mechanism.joints), reached_(mechanism.bodies.size()), used_(mechanism.joints.size()) {}

  std::vector<Branch> grow() {
    hang_on({});
    follow();
    for (std::size_t body = 0; body < reached_.size(); ++body) {
      if (reached_[body]) continue;
      add({body, {}, {}});
      follow();
    }
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const Joint& joint = joints_[j];
      if (used_[j]) continue;
      const std::size_t body = joint.carried();
      tree_.push_back({body, j, joint.second ? std::optional(joint.first) : std::nullopt, true});
    }
    return tree_;
  }

 private:
  void follow() {
    for (; next_ < tree_.size(); ++next_) hang_on(tree_[next_].body);
  }

  void hang_on(std::optional<std::size_t> parent) {
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const Joint& joint = joints_[j];
      const bool from_second = joint.second == parent;
      if (used_[j] || (!from_second && parent != joint.first)) continue;
      const std::size_t child = from_second ? joint.first : joint.second.value_or(joint.first);
      if (reached_[child]) continue;
      used_[j] = true;
      add({child, j, parent});
    }
  }

  void add(const Branch& branch) {
    reached_[branch.body] = true;
    tree_.push_back(branch);
  }

  const std::vector<Joint>& joints_;
  std::vector<bool> reached_;
  std::vector<bool> used_;
  std::vector<Branch> tree_;
  std::size_t next_ = 0;  // whose children are looked for
};

}  // namespace

std::vector<Branch> spanning_tree(const Mechanism& mechanism) { return Growth(mechanism).grow(); }

}  // namespace odeval::reference
