#pragma once
// Named lists of named things, for people and for programs.
#include <string>
#include <utility>
#include <vector>

namespace odeval {

struct Listing {
  std::string name;
  std::vector<std::pair<std::string, std::string>> rows;  // name, what it is
};

std::string listing_text(const std::vector<Listing>& listings);

/// An object with a list of {"name", "is"} for each listing.
std::string listing_json(const std::vector<Listing>& listings);

}  // namespace odeval
