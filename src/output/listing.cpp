#include "output/listing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace odeval {

std::string listing_text(const std::vector<Listing>& listings) {
  std::string text;
  for (const Listing& listing : listings) {
    std::size_t width = 0;
    for (const auto& row : listing.rows) width = std::max(width, row.first.size());
    text += listing.name + '\n';
    for (const auto& [name, is] : listing.rows) text += fmt::format("  {:<{}}  {}\n", name, width, is);
  }
  return text;
}

std::string listing_json(const std::vector<Listing>& listings) {
  nlohmann::ordered_json all;
  for (const Listing& listing : listings) {
    auto& rows = all[listing.name] = nlohmann::ordered_json::array();
    for (const auto& [name, is] : listing.rows) rows.push_back({{"name", name}, {"is", is}});
  }
  return all.dump(2) + '\n';
}

}  // namespace odeval
