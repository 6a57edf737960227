#include "model/nearest.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace odeval {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);  // distances from the part of `a` seen so far to each start of `b`
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (const char letter : a) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (letter == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

namespace {

bool goes_on(std::string_view word, std::string_view known) {
  constexpr std::size_t enough = 3;  // letters to tell what was meant
  return word.size() >= enough && known.starts_with(word);
}

}  // namespace

std::string nearest(std::string_view word, std::span<const std::string> known) {
  const auto longer = std::ranges::find_if(known, [word](const std::string& other) { return goes_on(word, other); });
  if (longer != known.end()) return *longer;
  const auto best = std::min_element(known.begin(), known.end(), [word](const auto& a, const auto& b) {
    return edit_distance(word, a) < edit_distance(word, b);
  });
  return best == known.end() ? std::string() : *best;
}

std::string nearest_hint(std::string_view word, std::span<const std::string> known) {
  const std::string found = nearest(word, known);
  if (found.empty() || (!goes_on(word, found) && 2 * edit_distance(word, found) > found.size())) return {};
  return " (nearest: '" + found + "')";
}

}  // namespace odeval
