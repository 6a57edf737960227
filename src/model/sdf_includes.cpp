#include "model/sdf_includes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>
#include <vector>

#include "model/one_line.hpp"
#include "model/toml_tree.hpp"
#include "model/xml_outline.hpp"
#include "odeval/error.hpp"

namespace odeval {
namespace {

namespace fs = std::filesystem;

/// Comments blanked, so that nothing in them is found and all else stays in its line.
std::string without_comments(std::string text) {
  for (std::size_t at = 0; (at = text.find("<!--", at)) != std::string::npos;) {
    const std::size_t end = std::min(text.find("-->", at), text.size() - 3) + 3;
    std::replace_if(
        text.begin() + static_cast<std::ptrdiff_t>(at), text.begin() + static_cast<std::ptrdiff_t>(end),
        [](char letter) { return letter != '\n'; }, ' ');
    at = end;
  }
  return text;
}

/// An element's place in a text: its whole, and what stands between its tags.
struct Element {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t inside = 0;
  std::size_t inside_end = 0;
};

/// The first element of a name from a place on, which holds none of its own name.
std::optional<Element> find_element(std::string_view text, std::string_view name, std::size_t from = 0) {
  const std::string open = fmt::format("<{}", name);
  const std::string close = fmt::format("</{}>", name);
  for (std::size_t at = from; (at = text.find(open, at)) != std::string_view::npos; at += open.size()) {
    const std::size_t after = at + open.size();
    if (after >= text.size() || std::string_view(" \t\r\n/>").find(text[after]) == std::string_view::npos) continue;
    const std::size_t tag_end = text.find('>', after);
    if (tag_end == std::string_view::npos) return std::nullopt;
    if (text[tag_end - 1] == '/') return Element{at, tag_end + 1, tag_end + 1, tag_end + 1};
    const std::size_t end = text.find(close, tag_end);
    if (end == std::string_view::npos) return std::nullopt;
    return Element{at, end + close.size(), tag_end + 1, end};
  }
  return std::nullopt;
}

std::string trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return "";
  return std::string(text.substr(begin, text.find_last_not_of(" \t\r\n") + 1 - begin));
}

/// The first one that stands in no other, from within its parent on.
std::optional<Element> find_child(std::string_view text, std::string_view name, std::size_t from) {
  int depth = 0;
  for (std::size_t at = from; (at = text.find('<', at)) != std::string_view::npos; ++at) {
    const std::size_t end = text.find('>', at);
    if (end == std::string_view::npos) break;
    if (text[at + 1] == '/') {
      if (--depth < 0) break;
      continue;
    }
    const auto here = find_element(text, name, at);
    if (depth == 0 && here && here->begin == at) return here;
    if (text[end - 1] != '/') ++depth;
  }
  return std::nullopt;
}

/// The attribute of the outermost element; empty without one.
std::string_view version_of(std::string_view text) {
  const std::optional<Element> sdf = find_element(text, "sdf");
  if (!sdf) return "";
  const std::string_view tag = text.substr(sdf->begin, sdf->inside - sdf->begin);
  const std::size_t name = tag.find("version");
  const std::size_t open = name == std::string_view::npos ? name : tag.find_first_of("\"'", name);
  if (open == std::string_view::npos) return "";
  return tag.substr(open + 1, tag.find(tag[open], open + 1) - open - 1);
}

/// How an axis is told: until 1.4 along the model's axes; then along the joint's, until 1.6 with a word for those of
/// the model, that later versions do not know.
enum class AxesOf { model, joint_or_model, any_frame };
AxesOf axes_of(std::string_view version) {
  std::pair<int, int> number{};
  const std::size_t dot = std::min(version.find('.'), version.size());
  std::from_chars(version.data(), version.data() + dot, number.first);
  if (dot < version.size()) std::from_chars(version.data() + dot + 1, version.data() + version.size(), number.second);
  if (number <= std::pair(1, 4)) return AxesOf::model;
  return number <= std::pair(1, 6) ? AxesOf::joint_or_model : AxesOf::any_frame;
}

/// Whether a model's axes would be others in a file of that version.
bool turns_axes(std::string_view model, std::string_view version, std::string_view into) {
  const AxesOf from = axes_of(version);
  const AxesOf to = axes_of(into);
  if (from == to || !find_element(model, "axis")) return false;
  if (from == AxesOf::model || to == AxesOf::model) return true;
  return find_element(model, "use_parent_model_frame").has_value();
}

class Includes {
 public:
  std::string of(const fs::path& file, std::string_view said) {
    constexpr std::size_t deepest = 20;
    if (open_.size() == deepest)
      fail(file, "include", fmt::format("more than {} files stand within one another", deepest));
    open_.push_back(fs::weakly_canonical(file));
    std::string text = without_comments(std::string(said));
    const std::string version(version_of(text));
    for (std::size_t at = 0;;) {
      const std::optional<Element> include = find_element(text, "include", at);
      if (!include) break;
      const std::string model = included(file, version, text.substr(include->begin, include->end - include->begin));
      text.replace(include->begin, include->end - include->begin, model);
      at = include->begin + model.size();
    }
    open_.pop_back();
    return text;
  }

 private:
  [[noreturn]] static void fail(const fs::path& file, const std::string& what, const std::string& why) {
    throw UserError(fmt::format("{}: {}: {}", one_line(file.string()), one_line(what), why));
  }

  static std::optional<std::string> child(std::string_view element, std::string_view name) {
    const std::optional<Element> found = find_element(element, name, 1);
    if (!found) return std::nullopt;
    return trimmed(element.substr(found->inside, found->inside_end - found->inside));
  }

  /// What may stand in an <include>; of anything else nobody knows what it would change.
  static void require_known(const fs::path& file, std::string_view include) {
    constexpr std::array<std::string_view, 4> known{"uri", "name", "pose", "static"};
    if (!include.starts_with("<include>")) fail(file, "include", "takes no attributes");
    for (const auto& [path, count] : xml_outline(one_line(file.string()), include)) {
      const std::string name = path.substr(path.rfind('/') + 1);
      if (path == "include" || (count == 1 && std::ranges::find(known, name) != known.end())) continue;
      fail(file, "include",
           fmt::format("has <{}>{}; it may have one each of uri, name, pose and static", one_line(name, 40),
                       count > 1 ? fmt::format(" {} times", count) : ""));
    }
  }

  /// The file that a uri names: itself, or a model's folder.
  static fs::path file_of(const fs::path& from, const std::string& uri) {
    std::string name = uri;
    if (name.starts_with("model://")) name.erase(0, 8);
    const fs::path relative(name);
    const bool inside = std::ranges::none_of(relative, [](const fs::path& part) { return part == ".."; });
    if (name.empty() || name.find("://") != std::string::npos || relative.is_absolute() || !inside) {
      fail(from, "include.uri = \"" + uri + "\"", "must be model://NAME, or a file or folder below that of this file");
    }
    std::error_code ignored;
    for (const fs::path& folder : {from.parent_path(), from.parent_path() / ".."}) {
      const fs::path place = (folder / relative).lexically_normal();
      if (fs::is_regular_file(place, ignored)) return place;
      if (fs::is_regular_file(place / "model.sdf", ignored)) return place / "model.sdf";
    }
    fail(from, "include.uri = \"" + uri + "\"",
         "there is no such file, and no folder with a model.sdf, in the folder of this file or the one above");
  }

  std::string included(const fs::path& from, const std::string& into, const std::string& include) {
    require_known(from, include);
    const std::string uri = child(include, "uri").value_or("");
    const fs::path file = file_of(from, uri);
    if (std::ranges::find(open_, fs::weakly_canonical(file)) != open_.end()) {
      fail(from, "include.uri = \"" + uri + "\"", "includes itself");
    }
    const std::string text = of(file, scenario_text(file));
    static_cast<void>(xml_outline(one_line(file.string()), text));
    const std::size_t begin = text.find("<model");
    const std::size_t end = text.rfind("</model>");
    if (begin == std::string::npos || end == std::string::npos || end < begin) fail(file, "model", "is missing");
    std::string model = text.substr(begin, end + 8 - begin);
    if (const std::string_view version = version_of(text); turns_axes(model, version, into)) {
      fail(from, "include.uri = \"" + uri + "\"",
           fmt::format("is SDFormat {} and this file {}, which tell the axes of joints otherwise; write both in one",
                       one_line(version, 20), one_line(into, 20)));
    }
    if (const auto name = child(include, "name")) rename(from, model, *name);
    if (const auto pose = find_element(include, "pose", 1)) {
      put(model, "pose", include.substr(pose->begin, pose->end - pose->begin));
    }
    if (const auto fixed = find_element(include, "static", 1)) {
      put(model, "static", include.substr(fixed->begin, fixed->end - fixed->begin));
    }
    return model;
  }

  static void rename(const fs::path& file, std::string& model, const std::string& name) {
    if (name.find_first_of("<>&\"'") != std::string::npos) fail(file, "include.name", "must have no <, >, & or quotes");
    const std::size_t tag_end = model.find('>');
    std::size_t at = model.find("name=", 0);
    if (at == std::string::npos || at > tag_end) fail(file, "model", "has no name");
    at += 5;
    const std::size_t end = model.find(model[at], at + 1);
    model.replace(at + 1, end - at - 1, name);
  }

  /// In the place of the model's own, or at its top.
  static void put(std::string& model, std::string_view name, const std::string& element) {
    const std::size_t top = model.find('>') + 1;
    if (const auto own = find_child(model, name, top)) {
      model.replace(own->begin, own->end - own->begin, element);
    } else {
      model.insert(top, element);
    }
  }

  std::vector<fs::path> open_;
};

}  // namespace

std::string with_includes(const fs::path& file, std::string_view text) {
  if (text.find("<include") == std::string_view::npos) return std::string(text);
  return Includes().of(file, text);
}

}  // namespace odeval
