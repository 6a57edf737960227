#include "model/xml_outline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "model/one_line.hpp"
#include "odeval/error.hpp"

namespace odeval {
namespace {

class Outline {
 public:
  Outline(const std::string& file, std::string_view text) : file_(file), text_(text) {}

  std::map<std::string, std::size_t> paths() {
    while ((at_ = text_.find('<', at_)) != std::string_view::npos) {
      if (skip("<!--", "-->") || skip("<![CDATA[", "]]>") || skip("<?", "?>")) continue;
      if (text_.substr(at_).starts_with("<!")) fail("has a document type; remove it");
      tag();
    }
    if (!open_.empty()) fail_at_end(fmt::format("<{}> is not closed", one_line(open_.back(), 40)));
    if (paths_.empty()) fail_at_end("is not XML");
    return paths_;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    throw UserError(fmt::format("{}:{}: {}", file_, line, what));
  }
  [[noreturn]] void fail_at_end(const std::string& what) {
    at_ = text_.size();
    fail(what);
  }

  bool skip(std::string_view begin, std::string_view end) {
    if (!text_.substr(at_).starts_with(begin)) return false;
    const std::size_t stop = text_.find(end, at_ + begin.size());
    if (stop == std::string_view::npos) fail(fmt::format("{} is not closed", begin));
    at_ = stop + end.size();
    return true;
  }

  /// The end of the tag: a '>' outside quotes.
  std::size_t end_of_tag() const {
    char quote = 0;
    for (std::size_t i = at_ + 1; i < text_.size(); ++i) {
      const char letter = text_[i];
      if (quote != 0) {
        if (letter == quote) quote = 0;
      } else if (letter == '"' || letter == '\'') {
        quote = letter;
      } else if (letter == '>') {
        return i;
      } else if (letter == '<') {
        break;
      }
    }
    fail("a tag is not closed");
  }

  void tag() {
    const std::size_t end = end_of_tag();
    std::string_view inside = text_.substr(at_ + 1, end - at_ - 1);
    const bool closing = inside.starts_with("/");
    const bool empty = inside.ends_with("/");
    if (closing) inside.remove_prefix(1);
    const std::string name(inside.substr(0, inside.find_first_of(" \t\r\n/")));
    if (name.empty() || (closing && empty)) fail("a tag has no name");
    if (closing) {
      if (open_.empty() || open_.back() != name) {
        fail(fmt::format("</{}> closes {}", one_line(name, 40),
                         open_.empty() ? "nothing" : "<" + one_line(open_.back(), 40) + ">"));
      }
      open_.pop_back();
    } else {
      constexpr std::size_t deepest = 100;
      if (open_.empty() && !paths_.empty()) fail("has a second element beside the first; one holds all");
      if (open_.size() == deepest) fail(fmt::format("more than {} elements stand within one another", deepest));
      open_.push_back(name);
      ++paths_[fmt::format("{}", fmt::join(open_, "/"))];
      if (empty) open_.pop_back();
    }
    at_ = end + 1;
  }

  const std::string& file_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::vector<std::string> open_;
  std::map<std::string, std::size_t> paths_;
};

}  // namespace

std::map<std::string, std::size_t> xml_outline(const std::string& file, std::string_view text) {
  return Outline(file, text).paths();
}

}  // namespace odeval
