#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "model/draft.hpp"
#include "model/joint_kinds.hpp"
#include "model/nearest.hpp"

namespace odeval {
namespace {

void settle_plane(Draft& draft, std::size_t number) {
  PlaneTable& plane = draft.said.planes[number];
  const std::string path = fmt::format("planes.{}", number);
  draft.make_unit(path + ".normal", plane.normal);
  const auto same = [&](const PlaneTable& other) { return other.name == plane.name; };
  const bool twice =
      std::ranges::find_if(draft.said.planes, same) - draft.said.planes.begin() != static_cast<std::ptrdiff_t>(number);
  if (twice || draft.said.body_named(plane.name) || plane.name == world_name) {
    draft.fail(path + ".name", plane.name, "is the name of something else as well");
  }
}

bool is_plane(const Description& said, const std::string& name) {
  return std::ranges::find(said.planes, name, &PlaneTable::name) != said.planes.end();
}

bool is_of_shape(std::string_view name) { return name.find('.') != name.npos; }

/// Of a body or of one of its shapes; of a plane the plane's.
std::string body_of(const std::string& name) { return name.substr(0, name.find('.')); }

/// All that may stand in `between`.
std::vector<std::string> names_in(const Description& said) {
  std::vector<std::string> names;
  for (const BodyTable& body : said.bodies) {
    names.push_back(body.name);
    for (const ShapeTable& shape : body.shapes) {
      if (!shape.name.empty()) names.push_back(body.name + "." + shape.name);
    }
  }
  for (const PlaneTable& plane : said.planes) names.push_back(plane.name);
  return names;
}

void check_names(const Draft& draft, const std::string& path, const ContactTable& contact) {
  const std::vector<std::string> names = names_in(draft.said);
  for (std::size_t i = 0; i < contact.between.size(); ++i) {
    const std::string& name = contact.between[i];
    if (std::ranges::find(names, name) != names.end()) continue;
    const char* const no =
        is_of_shape(name) ? "is no body with a shape of that name" : "is the name of no body and no plane";
    draft.fail(fmt::format("{}.{}", path, i), name, no + nearest_hint(name, names));
  }
}

/// The first table that names two is theirs, so that one that names no others does nothing.
void check_not_before(const Draft& draft, std::size_t number) {
  const auto names_of = [&](std::size_t i) -> std::array<std::string, 2> {
    const std::vector<std::string>& between = draft.said.contacts[i].between;
    if (between.empty()) return {};
    return {between[0], between[1]};
  };
  const auto [first, second] = names_of(number);
  for (std::size_t before = 0; before < number; ++before) {
    const auto [one, other] = names_of(before);
    if (!Contact{.first = one, .second = other}.is_between(first, second)) continue;
    draft.fail(fmt::format("contacts.{}", number), "",
               fmt::format("does nothing: contacts.{} before it says how all that it names touch", before),
               Draft::Blame::parts);
  }
}

void check_contact(const Draft& draft, std::size_t number) {
  const Description& said = draft.said;
  const ContactTable& contact = said.contacts[number];
  const std::string path = fmt::format("contacts.{}.between", number);
  check_names(draft, path, contact);
  check_not_before(draft, number);
  if (contact.between.empty()) return;
  const std::string first = body_of(contact.between[0]);
  const std::string second = body_of(contact.between[1]);
  const std::string said_so = fmt::format("[{}, {}]", contact.between[0], contact.between[1]);
  if (contact.between[0] == contact.between[1]) draft.fail(path, said_so, "must be two");
  if (first == second) draft.fail(path, said_so, "are of one body, whose shapes do not touch one another");
  if (is_plane(said, first) && is_plane(said, second)) {
    draft.fail(path, said_so, "are two planes, which do not move; one must be a body");
  }
  for (const JointTable& joint : said.joints) {
    if ((joint.parent == first && joint.child == second) || (joint.parent == second && joint.child == first)) {
      draft.fail(path, said_so, fmt::format("hang together by joint '{}': they pass through each other", joint.name));
    }
  }
}

}  // namespace

void settle_contacts(Draft& draft) {
  for (std::size_t i = 0; i < draft.said.planes.size(); ++i) settle_plane(draft, i);
  for (std::size_t i = 0; i < draft.said.contacts.size(); ++i) check_contact(draft, i);
  if (!draft.said.planes.empty() && draft.said.contacts.empty()) {
    draft.fail("planes", "", "have a meaning only where [[contacts]] say what touches them");
  }
}

}  // namespace odeval
