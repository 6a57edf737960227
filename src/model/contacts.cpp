#include <fmt/format.h>

#include <algorithm>

#include "model/draft.hpp"
#include "model/joint_kinds.hpp"
#include "model/nearest.hpp"

namespace odeval {
namespace {

void settle_plane(Draft& draft, std::size_t number) {
  PlaneTable& plane = draft.said.planes[number];
  const std::string path = fmt::format("planes.{}", number);
  if (plane.normal == Vec3{}) draft.fail(path + ".normal", "[0, 0, 0]", "must have a direction");
  plane.normal = unit(plane.normal);
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

void check_contact(const Draft& draft, std::size_t number) {
  const Description& said = draft.said;
  const ContactTable& contact = said.contacts[number];
  const std::string path = fmt::format("contacts.{}.between", number);
  std::vector<std::string> names;
  for (const BodyTable& body : said.bodies) names.push_back(body.name);
  for (const PlaneTable& plane : said.planes) names.push_back(plane.name);
  for (std::size_t i = 0; i < contact.between.size(); ++i) {
    const std::string& name = contact.between[i];
    if (std::ranges::find(names, name) != names.end()) continue;
    draft.fail(fmt::format("{}.{}", path, i), name, "is the name of no body and no plane" + nearest_hint(name, names));
  }
  if (contact.between.empty()) return;
  const std::string& first = contact.between[0];
  const std::string& second = contact.between[1];
  const std::string said_so = fmt::format("[{}, {}]", first, second);
  if (first == second) draft.fail(path, said_so, "must be two");
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
