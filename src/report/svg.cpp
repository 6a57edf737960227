#include "report/svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "odeval/error.hpp"
#include "report/text.hpp"

namespace odeval::report {
namespace {

constexpr int first_code = 16;  // of the palette; below are the others

struct Attribute {
  std::string name;
  std::string value;
};

/// One piece of markup between "<" and ">".
struct Tag {
  std::string name;
  std::vector<Attribute> attributes;
  bool closes = false;  // </name>
  bool empty = false;   // <name/>
};

bool is_blank(char letter) { return letter == ' ' || letter == '\n' || letter == '\t' || letter == '\r'; }

class TagReader {
 public:
  explicit TagReader(std::string_view inside) : rest_(inside) {}

  Tag read() {
    Tag tag;
    tag.closes = take('/');
    tag.name = word();
    for (skip_blanks(); !rest_.empty(); skip_blanks()) {
      if (take('/')) {
        tag.empty = true;
        continue;
      }
      Attribute attribute{word(), ""};
      skip_blanks();
      if (take('=')) {
        skip_blanks();
        attribute.value = quoted();
      }
      tag.attributes.push_back(std::move(attribute));
    }
    return tag;
  }

 private:
  bool take(char letter) {
    if (rest_.empty() || rest_.front() != letter) return false;
    rest_.remove_prefix(1);
    return true;
  }

  void skip_blanks() {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
  }

  std::string until(std::size_t end) {
    std::string part(rest_.substr(0, end));
    rest_.remove_prefix(std::min(end, rest_.size()));
    return part;
  }

  std::string word() {
    const auto* const end =
        std::ranges::find_if(rest_, [](char letter) { return is_blank(letter) || letter == '=' || letter == '/'; });
    const auto length = static_cast<std::size_t>(end - rest_.begin());
    if (length == 0) throw MachineError("gnuplot: its SVG has a tag without a name");
    return until(length);
  }

  std::string quoted() {
    if (rest_.empty() || (rest_.front() != '"' && rest_.front() != '\'')) {
      throw MachineError("gnuplot: its SVG has an attribute without quotes");
    }
    const char quote = rest_.front();
    rest_.remove_prefix(1);
    std::string value = until(rest_.find(quote));
    take(quote);
    return value;
  }

  std::string_view rest_;
};

/// The colour that "rgb(  0,   0,  17)" codes, as CSS; nothing when it codes none.
std::optional<std::string> css_colour(std::string value) {
  std::erase(value, ' ');
  const std::string_view black = "rgb(0,0,";
  if (value == "black") return "currentColor";
  if (!value.starts_with(black)) return std::nullopt;
  int code = 0;
  std::from_chars(value.data() + black.size(), value.data() + value.size(), code);
  if (code >= first_code) return fmt::format("var(--c{})", code - first_code);
  return code == -svg_grid ? "var(--grid)" : code == -svg_shade ? "var(--shade)" : "currentColor";
}

/// An attribute as the page wants it, or no more. What becomes CSS goes to `style`.
void rewrite(const Tag& tag, const Attribute& attribute, const std::string& id, std::string& kept, std::string& style) {
  const std::string& name = attribute.name;
  const std::string& value = attribute.value;
  const auto keep = [&](std::string_view as, const std::string& what) { kept += fmt::format(" {}=\"{}\"", as, what); };
  if (name == "font-family") return;
  if (name == "color" || name == "fill" || name == "stroke") {
    const std::optional<std::string> css = css_colour(value);
    const bool inherited = name == "color" && (!css || *css == "currentColor");
    if (inherited) return;
    if (css && *css != "currentColor") {
      style += fmt::format("{}{}:{}", style.empty() ? "" : ";", name, *css);
    } else {
      keep(name, css.value_or(value));
    }
  } else if (name == "id") {
    keep(name, id + "-" + value);
  } else if (name == "xlink:href" || name == "href") {
    keep("href", "#" + id + "-" + value.substr(value.find('#') + 1));
  } else if (name == "font-size" && tag.name == "tspan") {  // relative, so that the page may scale the text
    double size = svg_font_size;
    std::from_chars(value.data(), value.data() + value.size(), size);
    keep(name, fmt::format("{:.3g}em", size / svg_font_size));
  } else {
    keep(name, value);
  }
}

std::string rewritten(const Tag& tag, const std::string& id) {
  if (tag.closes) return "</" + tag.name + ">";
  std::string kept;
  std::string style;
  for (const Attribute& attribute : tag.attributes) rewrite(tag, attribute, id, kept, style);
  if (!style.empty()) kept += " style=\"" + style + "\"";
  return "<" + tag.name + kept + (tag.empty ? "/>" : ">");
}

std::string opening(const Tag& root, const std::string& id, const std::string& description) {
  const auto box = std::ranges::find(root.attributes, "viewBox", &Attribute::name);
  if (box == root.attributes.end()) throw MachineError("gnuplot: its SVG has no viewBox");
  return fmt::format(
      "<svg class=\"plot\" id=\"{}\" viewBox=\"{}\" role=\"img\" aria-label=\"{}\" "
      "xmlns=\"http://www.w3.org/2000/svg\">"
      "<title>{}</title>",
      id, box->value, escaped(description), escaped(description));
}

/// Pieces of the page's markup, without groups that hold nothing.
class Pieces {
 public:
  void open(std::string markup) { pieces_.push_back({std::move(markup), true}); }
  void add(std::string markup) { pieces_.push_back({std::move(markup), false}); }
  void close(std::string markup, bool may_vanish) {
    if (may_vanish && !pieces_.empty() && pieces_.back().opens) {
      pieces_.pop_back();
    } else {
      add(std::move(markup));
    }
  }
  std::string text() const {
    std::string all;
    for (const Piece& piece : pieces_) all += piece.markup;
    return all;
  }

 private:
  struct Piece {
    std::string markup;
    bool opens;
  };
  std::vector<Piece> pieces_;
};

bool all_blank(std::string_view text) { return std::ranges::all_of(text, is_blank); }

}  // namespace

std::string svg_colour_code(int colour) { return fmt::format("#{:06x}", colour < 0 ? -colour : first_code + colour); }

std::string page_svg(std::string_view gnuplots, const std::string& id, const std::string& description) {
  Pieces pieces;
  std::size_t depth = 0;
  std::string skipped_until;  // the name of an element that is left out
  std::size_t at = gnuplots.find("<svg");
  while (at < gnuplots.size()) {
    const std::size_t tag_end = gnuplots.find('>', at);
    if (tag_end == std::string_view::npos) throw MachineError("gnuplot: its SVG ends within a tag");
    const Tag tag = TagReader(gnuplots.substr(at + 1, tag_end - at - 1)).read();
    const std::size_t next = std::min(gnuplots.find('<', tag_end), gnuplots.size());
    const std::string_view text = gnuplots.substr(tag_end + 1, next - tag_end - 1);
    at = next;

    if (!skipped_until.empty()) {
      if (tag.closes && tag.name == skipped_until) skipped_until.clear();
      continue;
    }
    const bool own_words = depth == 1 && (tag.name == "title" || tag.name == "desc");
    if (!tag.closes && !tag.empty && (own_words || tag.name == "filter")) {
      skipped_until = tag.name;
      continue;
    }
    if (tag.closes) {
      --depth;
      pieces.close(rewritten(tag, id), tag.name == "g");
    } else if (depth == 0) {
      ++depth;
      pieces.add(opening(tag, id, description));
    } else if (tag.empty) {
      pieces.add(rewritten(tag, id));
    } else {
      ++depth;
      pieces.open(rewritten(tag, id));
    }
    if (depth > 0 && !all_blank(text)) pieces.add(std::string(text));
  }
  if (depth != 0 || gnuplots.find("<svg") == std::string_view::npos)
    throw MachineError("gnuplot: it drew no whole SVG");
  return pieces.text();
}

}  // namespace odeval::report
