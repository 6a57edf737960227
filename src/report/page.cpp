#include "report/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "odeval/error.hpp"
#include "report/plot.hpp"
#include "report/template.hpp"
#include "report/text.hpp"

namespace odeval::report {
namespace {

/// page.mustache and style.css. The palette is Okabe and Ito's, darkened on white and lightened on black until thin
/// lines are seen, with four more (dashed where they are used) for its tail.
constexpr Embedded layout[] = {
#include "page_layout.inc"
};

constexpr std::string_view title = "How far can you trust the Open Dynamics Engine?";
constexpr std::size_t long_rows = 24;  // a longer table scrolls under its head

using Items = std::vector<Values>;

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

/// Reasons for missing cells, lettered below their table.
class Footnotes {
 public:
  std::string mark(const std::string& why) {
    auto at = std::ranges::find(reasons_, why);
    if (at == reasons_.end()) at = reasons_.insert(at, why);
    return letter(static_cast<std::size_t>(at - reasons_.begin()));
  }
  Items all() const {
    Items all;
    for (std::size_t i = 0; i < reasons_.size(); ++i) all.push_back({{"letter", letter(i)}, {"why", reasons_[i]}});
    return all;
  }

 private:
  static std::string letter(std::size_t number) {
    return number < 26 ? std::string(1, static_cast<char>('a' + number)) : std::to_string(number + 1);
  }
  std::vector<std::string> reasons_;
};

bool usable(const Finding* finding) { return finding != nullptr && finding->value && std::isfinite(*finding->value); }

std::string claim_anchor(const Claim& claim) { return "claim-" + std::string(claim.id); }

/// What the page says of a verdict wherever it names a claim.
Values verdict_values(const Judged& judged) {
  const std::string_view verdict = verdict_text(judged.verdict);
  std::string verdict_class(verdict);
  std::ranges::replace(verdict_class, ' ', '-');
  return {{"anchor", claim_anchor(*judged.claim)},
          {"id", judged.claim->id},
          {"verdict", verdict},
          {"verdict_class", verdict_class}};
}

Values cell_values(const Cell& cell, Footnotes& notes) {
  if (const std::string* const text = std::get_if<std::string>(&cell)) {
    const bool one_word = text->find(' ') == std::string::npos;  // a name, which no hyphen may break
    return {{"class", one_word ? "whole" : ""}, {"text", *text}, {"mark", ""}};
  }
  if (const double* const number = std::get_if<double>(&cell); number != nullptr && std::isfinite(*number)) {
    return {{"class", "number"}, {"text", shown(*number)}, {"mark", ""}};
  }
  const Missing* const missing = std::get_if<Missing>(&cell);
  const std::string mark = notes.mark(missing != nullptr ? missing->why : "no finite number");
  return {{"class", "number"}, {"text", ""}, {"mark", mark}};
}

/// Whether a column has numbers, so that its head stands above their right ends.
bool is_numeric(const Table& table, std::size_t column) {
  return std::ranges::any_of(table.rows, [column](const std::vector<Cell>& row) {
    return column < row.size() && !std::holds_alternative<std::string>(row[column]);
  });
}

/// Each label and look once.
Items legend(const Figure& figure, const std::vector<std::vector<Look>>& looks) {
  struct Entry {
    std::string label;
    Look look;
    bool drawn;
  };
  std::vector<Entry> entries;
  for (std::size_t p = 0; p < figure.panels.size(); ++p) {
    const Panel& panel = figure.panels[p];
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
      const Series& series = panel.series[s];
      const bool drawn = report::has_points(series, panel);
      const auto known = std::ranges::find_if(
          entries, [&](const Entry& entry) { return entry.label == series.label && entry.look == looks[p][s]; });
      if (known != entries.end()) {
        known->drawn = known->drawn || drawn;
      } else if (!series.label.empty()) {
        entries.push_back({series.label, looks[p][s], drawn});
      }
    }
  }
  Items items;
  for (const Entry& entry : entries) {
    items.push_back({{"swatch", swatch_svg(entry.look)}, {"label", entry.label}, {"undrawn", !entry.drawn}});
  }
  return items;
}

/// The reasons of its shades, each once, to be put behind its caption.
std::string shades(const Figure& figure) {
  std::string all;
  std::vector<std::string> said;
  for (const Panel& panel : figure.panels) {
    const std::string text = shade_text(panel);
    if (text.empty() || std::ranges::find(said, text) != said.end()) continue;
    said.push_back(text);
    all += " " + text + (text.ends_with('.') ? "" : ".");
  }
  return all;
}

/// Gathers what the template of the page names.
class Writer {
 public:
  Writer(const Document& document, const std::vector<Judged>& verdicts, const Findings& findings)
      : document_(document), verdicts_(verdicts), findings_(findings) {}

  Page write() {
    for (const char* const fixed : {"rules", "findings", "files", "made-with"}) anchors_.take(fixed);
    for (const Judged& judged : verdicts_) anchors_.take(claim_anchor(*judged.claim));
    const Section verdicts{"verdicts", "What of the 2010 report holds", {}};
    std::vector<const Section*> front;
    for (const Section& section : document_.front) front.push_back(&section);
    front.push_back(&verdicts);
    for (const Section* section : front) anchors_.take(section->name);
    for (const Section& section : document_.sections) anchors_.take(section.name);
    Items sections;  // first, since links are made to what is there
    for (const Section* section : front) sections.push_back(section_values(*section, section == &verdicts, false));
    for (const Section& section : document_.sections) sections.push_back(section_values(section, false, true));
    Items front_links;
    for (const Section* section : front) front_links.push_back(link_values(*section));
    Items evidence_links;
    for (const Section& section : document_.sections) evidence_links.push_back(link_values(section));
    const Values values{{"title", title},
                        {"style", text_of(layout, "style")},
                        {"command", document_.command},
                        {"number_of_claims", verdicts_.size()},
                        {"tally", tally()},
                        {"claims", claims()},
                        {"front", std::move(front_links)},
                        {"folded", std::move(evidence_links)},
                        {"sections", std::move(sections)},
                        {"many_findings", findings_.all().size() > long_rows},
                        {"findings", all_findings()},
                        {"has_files", !document_.files.empty()},
                        {"files", files()},
                        {"environment", environment()}};
    return {filled("page", text_of(layout, "page"), values, escaped), std::move(missing_)};
  }

 private:
  Items tally() const {
    Items items;
    for (const Verdict verdict : {Verdict::confirmed, Verdict::confirmed_with_limits, Verdict::refuted,
                                  Verdict::not_settled, Verdict::not_measured}) {
      const auto count = std::ranges::count(verdicts_, verdict, &Judged::verdict);
      if (count > 0) items.push_back({{"count", count}, {"verdict", verdict_text(verdict)}});
    }
    return items;
  }

  Items claims() const {
    Items items;
    for (const Judged& judged : verdicts_) {
      const Claim& claim = *judged.claim;
      Values values = verdict_values(judged);
      values.insert({{"text", claim.text},
                     {"where", claim.where},
                     {"numbers", numbers(judged)},
                     {"missing", judged.missing},
                     {"evidence", anchors_.has(claim.evidence) ? claim.evidence : ""},
                     {"rules", Items{{{"kind", "Confirmed"}, {"conditions", conditions(claim.confirmed_if)}},
                                     {{"kind", "Refuted"}, {"conditions", conditions(claim.refuted_if)}}}},
                     {"advice", claim.advice}});
      items.push_back(std::move(values));
    }
    return items;
  }

  static Items numbers(const Judged& judged) {
    Items items;
    for (const Finding* finding : judged.findings) {
      if (usable(finding)) items.push_back({{"meaning", finding->meaning}, {"number", shown(*finding)}});
    }
    return items;
  }

  Items conditions(std::span<const Condition> all) const {
    Items items;
    for (const Condition& condition : all) {
      const Finding* const finding = findings_.find(condition.finding);
      const bool is_known = usable(finding);
      std::optional<bool> held;
      if (is_known) held = holds(condition, *finding);
      items.push_back({{"meaning", finding != nullptr ? finding->meaning : ""},
                       {"finding", condition.finding},
                       {"relation", condition.relation == Relation::at_most ? "≤" : "≥"},
                       {"bound", shown(condition.bound)},
                       {"number", is_known ? shown(*finding) : ""},
                       {"holds", held.value_or(false)},
                       {"fails", !held.value_or(true)},
                       {"open", !held}});
    }
    return items;
  }

  static Values link_values(const Section& section) { return {{"name", section.name}, {"title", section.title}}; }

  Values section_values(const Section& section, bool is_claims, bool folds) {
    const Items settled = settles(section);
    Items blocks;
    for (const Block& block : section.blocks) {
      Values values{
          {"paragraph", ""}, {"table", Items{}}, {"figure", Items{}}, {"picture", Items{}}, {"highlight", Items{}}};
      std::visit([&](const auto& one) { add_block(values, one); }, block);
      blocks.push_back(std::move(values));
    }
    return {{"name", section.name},      {"title", section.title}, {"is_front", !folds},         {"folds", folds},
            {"claims_table", is_claims}, {"settles", settled},     {"blocks", std::move(blocks)}};
  }

  /// The claims that a section is the evidence for.
  Items settles(const Section& section) const {
    Items items;
    for (const Judged& judged : verdicts_) {
      if (judged.claim->evidence == section.name) items.push_back(verdict_values(judged));
    }
    return items;
  }

  void add_block(Values& block, const Text& text) { block.insert_or_assign("paragraph", text.text); }

  void add_block(Values& block, const Table& table) {
    if (!tables_.insert(table.name).second) throw std::logic_error("two tables are named '" + table.name + "'");
    Items columns;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      columns.push_back({{"numeric", is_numeric(table, i)}, {"text", table.columns[i]}});
    }
    Footnotes notes;
    Items rows;
    for (const auto& row : table.rows) {
      Items cells;
      for (const Cell& cell : row) cells.push_back(cell_values(cell, notes));
      for (Values& cell : cells) cell.insert({"anchor", ""});
      if (rows.size() < table.evidence.size()) cells.front().insert_or_assign("anchor", table.evidence[rows.size()]);
      rows.push_back({{"cells", std::move(cells)}});
    }
    block.insert_or_assign("table", Items{{{"id", anchors_.take("table", table.name)},
                                           {"title", table.title},
                                           {"csv", csv_of(table)},
                                           {"long", table.rows.size() > long_rows},
                                           {"columns", std::move(columns)},
                                           {"rows", std::move(rows)},
                                           {"footnotes", notes.all()},
                                           {"note", table.note}}});
  }

  Values panel_values(const Figure& figure, std::size_t number, const std::vector<Look>& looks, const std::string& id) {
    const Panel& panel = figure.panels[number];
    std::string plot;
    std::string why_not;
    try {
      if (has_points(panel)) {
        plot = plot_svg(panel, looks, fmt::format("{}-{}", id, number + 1));
      } else {
        why_not = "there is no number to draw";
      }
    } catch (const MachineError& error) {
      why_not = error.what();
    }
    if (!why_not.empty()) missing_.push_back(fmt::format("{}: {}", figure.name, why_not));
    return {{"plot", plot}, {"why_not", why_not}, {"x", panel.x_label}, {"y", panel.y_label}};
  }

  void add_block(Values& block, const Figure& figure) {
    const std::string id = anchors_.take("figure", figure.name);
    const auto looks = looks_of(figure);
    Items panels;
    for (std::size_t i = 0; i < figure.panels.size(); ++i) panels.push_back(panel_values(figure, i, looks[i], id));
    const Items labels = legend(figure, looks);
    block.insert_or_assign("figure", Items{{{"id", id},
                                            {"columns", std::clamp(figure.columns, 1, 4)},
                                            {"panels", std::move(panels)},
                                            {"has_legend", !labels.empty()},
                                            {"legend", labels},
                                            {"title", figure.title},
                                            {"caption", figure.caption + shades(figure)}}});
  }

  void add_block(Values& block, const Picture& picture) {
    block.insert_or_assign("picture", Items{{{"id", anchors_.take("picture", picture.name)},
                                             {"png", base64(picture.png)},
                                             {"title", picture.title},
                                             {"caption", picture.caption}}});
  }

  void add_block(Values& block, const Highlight& highlight) {
    const Figure& figure = highlight.figure;
    const std::string id = anchors_.take("short", figure.name);
    const auto looks = looks_of(figure);
    Values values = panel_values(figure, 0, looks[0], id);
    values.insert({{"id", id},
                   {"sentence", highlight.sentence},
                   {"evidence", highlight.evidence},
                   {"legend", legend(figure, looks)}});
    block.insert_or_assign("highlight", Items{std::move(values)});
  }

  Items all_findings() const {
    Items items;
    for (const auto& [name, finding] : findings_.all()) {
      items.push_back({{"name", name},
                       {"meaning", finding.meaning},
                       {"number", usable(&finding) ? shown(finding) : ""},
                       {"missing", finding.missing.empty() ? "no finite number" : finding.missing}});
    }
    return items;
  }

  Items files() const {
    Items items;
    for (const Files& kind : document_.files) {
      Items paths;
      for (const std::string& path : kind.paths) {
        paths.push_back({{"path", path}, {"name", path.substr(path.rfind('/') + 1)}});
      }
      items.push_back({{"about", kind.about}, {"paths", std::move(paths)}});
    }
    return items;
  }

  Items environment() const {
    Items items;
    for (const auto& [name, what] : document_.environment) items.push_back({{"name", name}, {"what", what}});
    return items;
  }

  const Document& document_;
  const std::vector<Judged>& verdicts_;
  const Findings& findings_;
  Anchors anchors_;
  std::set<std::string> tables_;
  std::vector<std::string> missing_;
};

}  // namespace

std::string csv_of(const Table& table) { return "report/" + table.name + ".csv"; }

Page make_page(const Document& document, const std::vector<Judged>& verdicts, const Findings& findings) {
  return Writer(document, verdicts, findings).write();
}

}  // namespace odeval::report
