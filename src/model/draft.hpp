#pragma once
// A scenario on its way from the file's tree to what runs, and how it is said where it is wrong.
#include <string>
#include <string_view>
#include <vector>

#include "model/scenario_keys.hpp"
#include "model/toml_tree.hpp"
#include "odeval/scenario.hpp"

namespace odeval {

struct Draft {
  const toml::table& tree;  // the file's, with the overrides on top
  const std::vector<Override>& overrides;
  const Names& names;
  Scenario scenario;  // `file` is there from the start
  Description said = {};

  enum class Blame { length, whole, parts };

  /// The last setting that gave the value at the path or one number of it (with Blame::length not one number, which
  /// makes no list longer), or with Blame::parts something inside it; null: the file did.
  const Override* setting_of(std::string_view path, Blame blame = Blame::whole) const;

  /// `where` is the path of the value at fault, `value` its text or empty when there is none.
  [[noreturn]] void fail(const std::string& where, const std::string& value, const std::string& rule,
                         Blame blame = Blame::whole) const;

  /// Of a direction: its unit vector. Fails where it has none.
  void make_unit(const std::string& where, Vec3& direction) const;

  /// Fails for a key or a table that another kind of problem has.
  void refuse(const char* key) const;
  void refuse(const char* section, const char* key) const;
  void refuse_in(const char* list, const char* key) const;
};

/// "ode.erp"; without a section the name alone.
std::string joined(std::string_view section, std::string_view name);

/// A value as the user wrote it, cut for a message.
std::string shown(const toml::node& node);

// Steps of reading in their order; those of links are for pendulums, those of bodies for all else. All throw UserError
// of one line.

/// Fails for what a file has no word for, but a good reason.
void refuse_misplaced(const Draft& draft);

/// Fills the scenario by the table of keys.
void read_keys(Draft& draft);

/// ERP and CFM, or kp and kd: both or none. The command line may replace the file's pair by the other.
void choose_softness(Draft& draft);

/// The same of each of [[contacts]] that has a softness of its own.
void check_softness_of_contacts(const Draft& draft);

/// Links and start angles of a pendulum, completed.
void settle_links(Draft& draft);

/// A body that says nothing of a shape of its own has its tables [[bodies.shapes]] alone.
void settle_shapes(Draft& draft);

/// Bodies in space, thin ones made thin.
void settle_bodies(Draft& draft);

/// A pendulum that starts clear of its wall.
void check_start_of_links(const Draft& draft);

/// Joints between bodies with names: a tree that its start fits. Axes become unit ones.
void settle_joints(Draft& draft);

/// Planes with names, and contacts between what there is. Normals become unit ones.
void settle_contacts(Draft& draft);

/// Bodies where they start in the world: laid on the ground, pulled out of the joint, which is checked before.
void place_bodies(Draft& draft);

}  // namespace odeval
