#pragma once
// Sections of a page as the values of blocks.mustache, which is part of each page's template.
#include <set>
#include <string>
#include <vector>

#include "report/document.hpp"
#include "report/gnuplot.hpp"
#include "report/plot.hpp"
#include "report/template.hpp"

namespace odeval::report {

using Items = std::vector<Values>;

inline constexpr std::size_t long_rows = 24;  // a longer table scrolls under its head

/// page.mustache, audit.mustache, with blocks.mustache in them, and style.css. The palette is Okabe and Ito's,
/// darkened on white and lightened on black until thin lines are seen, with four more (dashed where they are used) for
/// its tail.
std::string page_layout(std::string_view name);

/// Anchors of the page: each once.
class Anchors {
 public:
  /// Throws std::logic_error when the name is taken.
  const std::string& take(const std::string& name) {
    const auto [at, is_new] = taken_.insert(name);
    if (!is_new) throw std::logic_error("two parts of the page are named '" + name + "'");
    return *at;
  }
  /// The name, or one with its kind in front when the name is a section's.
  const std::string& take(const std::string& kind, const std::string& name) {
    return take(taken_.contains(name) ? kind + "-" + name : name);
  }
  bool has(std::string_view name) const { return taken_.contains(name); }

 private:
  std::set<std::string, std::less<>> taken_;
};

/// What a page's sections say, and what they can not.
class SectionWriter {
 public:
  explicit SectionWriter(Anchors& anchors) : anchors_(anchors) {}

  /// Its anchor is taken already, for links are made to what is there. `csv` names the file
  /// that has the numbers of a table; null: none has. Throws std::logic_error when two tables, or two anchors, share a
  /// name.
  Values values(const Section& section, std::string (*csv)(const Table&) = nullptr);

  /// What could not be drawn, and why.
  const std::vector<std::string>& missing() const { return missing_; }

 private:
  void add_block(Values& block, const Text& text);
  void add_block(Values& block, const Table& table);
  void add_block(Values& block, const Figure& figure);
  void add_block(Values& block, const Picture& picture);
  void add_block(Values& block, const Highlight& highlight);
  Values panel_values(const Figure& figure, std::size_t number, const std::vector<Look>& looks, const std::string& id);

  Anchors& anchors_;
  std::string (*csv_)(const Table&) = nullptr;
  std::set<std::string> tables_;
  std::vector<std::string> missing_;
  OneGnuplot figures_;  // draws all of them
};

}  // namespace odeval::report
