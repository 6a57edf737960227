#include "run/grid.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <set>

#include "odeval/error.hpp"

namespace odeval::sweep {
namespace {

/// On one line and not too long, for a message.
std::string shown(const std::string& text) {
  constexpr std::size_t longest = 80;
  std::string line = text.substr(0, longest);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char letter) { return letter < 32 || letter == 127; }, ' ');
  return line + (line.size() < text.size() ? "..." : "");
}

[[noreturn]] void fail(const std::string& text, const std::string& rule) {
  throw UserError("--grid " + shown(text) + ": " + rule);
}

/// At commas outside of brackets and quotes.
std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  char quote = 0;
  for (const char letter : text) {
    if (quote != 0) {
      if (letter == quote) quote = 0;
    } else if (letter == '"' || letter == '\'') {
      quote = letter;
    } else if (letter == '[' || letter == '{') {
      ++depth;
    } else if (letter == ']' || letter == '}') {
      --depth;
    } else if (letter == ',' && depth == 0) {
      parts.emplace_back();
      continue;
    }
    parts.back() += letter;
  }
  return parts;
}

template <class Number>
bool is_number(const std::string& text, Number& number) {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return !text.empty() && error == std::errc() && stop == end;
}

/// A spelling without the dust that powers leave in the last digit.
std::string spelled(double number) {
  char text[32];
  const auto end = std::to_chars(std::begin(text), std::end(text), number, std::chars_format::general, 15);
  return {text, end.ptr};
}

struct Range {
  bool logarithmic;
  double first;
  double last;
  long count;

  double value(long i) const {
    if (i == 0) return first;
    if (i == count - 1) return last;
    const double part = static_cast<double>(i) / static_cast<double>(count - 1);
    return logarithmic ? first * std::pow(last / first, part) : first + (last - first) * part;
  }
};

Range range_of(const std::string& text, const std::string& words) {
  const bool logarithmic = words.starts_with("log:");
  const std::string rule = logarithmic ? "must be KEY=log:A:B:N with A and B above 0 and N from 2 to 1000000"
                                       : "must be KEY=lin:A:B:N with numbers A and B and N from 2 to 1000000";
  std::vector<std::string> parts(1);
  for (const char letter : words.substr(4)) {
    if (letter == ':') {
      parts.emplace_back();
    } else {
      parts.back() += letter;
    }
  }
  Range range{logarithmic, 0, 0, 0};
  if (parts.size() != 3 || !is_number(parts[0], range.first) || !is_number(parts[1], range.last) ||
      !is_number(parts[2], range.count)) {
    fail(text, rule);
  }
  const bool fits = std::isfinite(range.first) && std::isfinite(range.last) && range.count >= 2 &&
                    range.count <= most_runs && (!logarithmic || (range.first > 0 && range.last > 0));
  if (!fits) fail(text, rule);
  return range;
}

}  // namespace

Axis parse_axis(const std::string& text, const std::function<bool(const std::string& key)>& is_whole) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    fail(text, "must be KEY=V1,V2,..., KEY=log:A:B:N or KEY=lin:A:B:N, e.g. --grid step=log:1e-4:1e-2:9");
  }
  Axis axis{text.substr(0, equals), {}};
  const std::string words = text.substr(equals + 1);
  if (words.starts_with("log:") || words.starts_with("lin:")) {
    const Range range = range_of(text, words);
    const bool whole = is_whole(axis.key);
    for (long i = 0; i < range.count; ++i) {
      const std::string value = spelled(whole ? std::round(range.value(i)) : range.value(i));
      if (!whole || axis.values.empty() || axis.values.back() != value) axis.values.push_back(value);
    }
  } else {
    axis.values = split(words);
  }
  std::set<std::string> seen;
  for (const std::string& value : axis.values) {
    if (value.empty()) fail(text, "has an empty value");
    double number = 0;  // 1e-3 and 0.001 are the same
    if (!seen.insert(is_number(value, number) ? std::to_string(std::bit_cast<std::uint64_t>(number)) : value).second) {
      fail(text, "has the value " + shown(value) + " twice");
    }
  }
  return axis;
}

Grid::Grid(std::vector<Axis> axes) : axes_(std::move(axes)) {
  std::set<std::string> keys;
  std::size_t product = 1;
  for (const Axis& axis : axes_) {
    if (!keys.insert(axis.key).second) throw UserError("--grid " + shown(axis.key) + ": stands twice");
    product *= axis.values.size();
    if (product > most_runs) {
      throw UserError("--grid " + shown(axis.key) + ": makes more than " + std::to_string(most_runs) + " runs");
    }
  }
  const std::vector<std::string> methods = axes_.empty() ? std::vector<std::string>() : axes_.back().values;
  for (const std::string& method : methods) {
    for (const Axis& axis : axes_) unread_.push_back(std::ranges::find(axis.unread_by, method) != axis.unread_by.end());
  }
  for (std::uint32_t place = 0; place < product; ++place) {
    const std::vector<std::size_t> chosen = unpacked(place);
    bool again = false;  // differs from another run only in what its method does not read
    for (std::size_t i = 0; i < chosen.size(); ++i) again = again || (chosen[i] != 0 && !reads(chosen.back(), i));
    if (!again) places_.push_back(place);
  }
}

std::vector<std::size_t> Grid::unpacked(std::uint32_t place) const {
  std::vector<std::size_t> chosen(axes_.size());
  std::size_t rest = place;
  for (std::size_t i = axes_.size(); i-- > 0;) {
    chosen[i] = rest % axes_[i].values.size();
    rest /= axes_[i].values.size();
  }
  return chosen;
}

std::vector<std::size_t> Grid::places(long run) const { return unpacked(places_[static_cast<std::size_t>(run)]); }

std::vector<std::string> Grid::values(long run) const {
  const std::vector<std::size_t> chosen = places(run);
  std::vector<std::string> values;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    values.push_back(reads(chosen.back(), i) ? axes_[i].values[chosen[i]] : "");
  }
  return values;
}

Shard parse_shard(const std::string& text) {
  Shard shard;
  const std::size_t slash = text.find('/');
  const bool numbers = slash != std::string::npos && is_number(text.substr(0, slash), shard.index) &&
                       is_number(text.substr(slash + 1), shard.count);
  if (!numbers || shard.index < 1 || shard.index > shard.count || shard.count > most_runs) {
    throw UserError("--shard " + shown(text) + ": must be I/N with I from 1 to N, e.g. --shard 2/8");
  }
  return shard;
}

}  // namespace odeval::sweep
