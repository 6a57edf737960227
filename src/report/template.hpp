#pragma once
// Mustache templates, filled with named values.
#include <fmt/format.h>

#include <algorithm>
#include <concepts>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace odeval::report {

class Value;
using Values = std::map<std::string, Value, std::less<>>;

/// What a template's {{name}} stands for: text, or a number with all its digits. As {{#name}} ... {{/name}} a text that
/// is empty (or false) leaves out what is between, and a list repeats it, with the values of each of its items;
/// {{^name}} ... {{/name}} stands when that does not. {{#again}}, {{/again}} stands before every item but the first.
class Value {
 public:
  Value(std::string text) : is_(std::move(text)) {}
  Value(std::string_view text) : is_(std::string(text)) {}
  Value(const char* text) : is_(std::string(text)) {}
  Value(std::vector<Values> items) : is_(std::move(items)) {}
  Value(std::same_as<bool> auto stands) : is_(std::string(stands ? "yes" : "")) {}
  template <class Number>
  requires(std::is_arithmetic_v<Number> && !std::same_as<Number, bool>) Value(Number number)
      : is_(fmt::format("{}", number)) {}

  const std::variant<std::string, std::vector<Values>>& get() const { return is_; }

 private:
  std::variant<std::string, std::vector<Values>> is_;
};

/// A file of the sources that the build puts into the program (src/embed.cmake).
struct Embedded {
  std::string_view name;  // without folder and ending
  std::string_view text;
};

/// Without a file of that name it does not compile.
consteval std::string_view text_of(std::span<const Embedded> files, std::string_view name) {
  return std::ranges::find(files, name, &Embedded::name)->text;
}

/// The names that a template asks for.
std::set<std::string, std::less<>> names_in(std::string_view text);

/// The template `text` with its values; {{name}} escaped, {{{name}}} as it is. Throws std::logic_error, which calls the
/// template `title`, where the two differ: a name without a value, a value that is named nowhere; or where the template
/// is none.
std::string filled(std::string_view title, std::string_view text, const Values& values,
                   std::string (*escape)(std::string_view));

}  // namespace odeval::report
