#include "report/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "odeval/error.hpp"
#include "report/plot.hpp"
#include "report/text.hpp"

namespace odeval::report {
namespace {

constexpr std::string_view title = "How far can you trust the Open Dynamics Engine?";

std::string paragraph(const std::string& text) { return text.empty() ? "" : "<p>" + escaped(text) + "</p>\n"; }

std::string link(const std::string& target, const std::string& text) {
  return "<a href=\"" + escaped(target) + "\">" + escaped(text) + "</a>";
}

std::string code(std::string_view text) { return "<code>" + escaped(text) + "</code>"; }

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
    return fmt::format("—<sup>{}</sup>", letter(static_cast<std::size_t>(at - reasons_.begin())));
  }
  std::string text() const {
    std::string all;
    for (std::size_t i = 0; i < reasons_.size(); ++i) {
      all += fmt::format("<p class=\"note missing\"><sup>{}</sup> {}</p>\n", letter(i), escaped(reasons_[i]));
    }
    return all;
  }

 private:
  static std::string letter(std::size_t number) {
    return number < 26 ? std::string(1, static_cast<char>('a' + number)) : std::to_string(number + 1);
  }
  std::vector<std::string> reasons_;
};

class Writer {
 public:
  Writer(const Document& document, const std::vector<Judged>& verdicts, const Findings& findings)
      : document_(document), verdicts_(verdicts), findings_(findings) {}

  Page write() {
    for (const char* const fixed : {"verdicts", "rules", "findings", "files", "made-with"}) anchors_.take(fixed);
    for (const Judged& judged : verdicts_) anchors_.take(claim_anchor(*judged.claim));
    for (const Section& section : document_.sections) anchors_.take(section.name);
    std::string sections;  // first, since links are made to what is there
    for (const Section& section : document_.sections) sections += section_html(section);

    html_ =
        "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n"
        "<meta charset=\"utf-8\"/>\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
        "<meta name=\"color-scheme\" content=\"light dark\"/>\n<title>";
    html_ += fmt::format("{}</title>\n<style>\n{}</style>\n</head>\n<body>\n", escaped(title), style_sheet);
    html_ += header() + verdict_table() + contents() + "<main>\n" + rules() + sections + all_findings() + files() +
             made_with() + "</main>\n</body>\n</html>\n";
    return {std::move(html_), std::move(missing_)};
  }

 private:
  static std::string claim_anchor(const Claim& claim) { return "claim-" + std::string(claim.id); }

  std::string header() const {
    return fmt::format("<header>\n<h1>{}</h1>\n", escaped(title)) +
           "<p class=\"lead\">This page does the experiments of a report of TU Eindhoven again (R.C. Kooijman, "
           "<cite>Evaluation of Open Dynamics Engine Software</cite>, D&amp;C 2010.022) and settles what it claimed "
           "and "
           "what it left open. The same motions are computed by ODE, by other methods, and by a reference that says "
           "how "
           "far it may itself be off; all numbers, figures and verdicts are computed from these runs.</p>\n"
           "<p>It was made by " +
           code(document_.command) +
           " with the <a href=\"#made-with\">versions and the machine "
           "named below</a>. The same command with the same versions gives the same numbers again, but for those that "
           "were timed. After ± stands the half width of what a number may be off by: the reference’s own error, or "
           "the 95 % interval of a fit.</p>\n</header>\n";
  }

  std::string evidence(const Claim& claim) const {
    return anchors_.has(claim.evidence) ? link("#" + std::string(claim.evidence), "evidence") : "none yet";
  }

  static std::string verdict_html(Verdict verdict) {
    std::string name(verdict_text(verdict));
    std::ranges::replace(name, ' ', '-');
    return fmt::format("<span class=\"verdict {}\">{}</span>", name, escaped(verdict_text(verdict)));
  }

  static std::string number_html(const Finding& finding) {
    return fmt::format("{} <b class=\"whole\">{}</b>", escaped(finding.meaning), escaped(shown(finding)));
  }

  static bool usable(const Finding* finding) {
    return finding != nullptr && finding->value && std::isfinite(*finding->value);
  }

  std::string numbers(const Judged& judged) const {
    std::string items;
    for (const Finding* finding : judged.findings) {
      if (usable(finding)) items += "<li>" + number_html(*finding) + "</li>";
    }
    if (!judged.missing.empty()) items += "<li class=\"missing\">" + escaped(judged.missing) + "</li>";
    return "<ul>" + items + "</ul>";
  }

  std::string tally() const {
    std::string text;
    for (const Verdict verdict :
         {Verdict::confirmed, Verdict::confirmed_with_limits, Verdict::refuted, Verdict::not_measured}) {
      const auto count = std::ranges::count(verdicts_, verdict, &Judged::verdict);
      if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, verdict_text(verdict));
    }
    return fmt::format("{} claims: {}.", verdicts_.size(), text);
  }

  std::string verdict_table() const {
    std::string rows;
    for (const Judged& judged : verdicts_) {
      const Claim& claim = *judged.claim;
      rows += fmt::format(
          "<tr><th scope=\"row\"><a href=\"#{}\">{}</a></th><td class=\"claim\">{} <small>{}</small></td>"
          "<td>{}</td><td class=\"numbers\">{}</td><td>{}</td></tr>\n",
          claim_anchor(claim), escaped(claim.id), escaped(claim.text), escaped(claim.where),
          verdict_html(judged.verdict), numbers(judged), evidence(claim));
    }
    return "<section id=\"verdicts\">\n<h2>Verdicts</h2>\n" + paragraph(tally()) +
           "<table class=\"verdicts\">\n<thead><tr><th scope=\"col\">Claim</th><th scope=\"col\">says (§: of the 2010 "
           "report)</th><th scope=\"col\">Verdict</th><th scope=\"col\">Measured</th><th scope=\"col\">See</th></tr>"
           "</thead>\n<tbody>\n" +
           rows + "</tbody>\n</table>\n</section>\n";
  }

  std::string contents() const {
    std::string items;
    const auto add = [&](const std::string& anchor, const std::string& text) {
      items += "<li>" + link("#" + anchor, text) + "</li>\n";
    };
    add("rules", "What each verdict rests on");
    for (const Section& section : document_.sections) add(section.name, section.title);
    add("findings", "All numbers");
    if (!document_.files.empty()) add("files", "Files");
    add("made-with", "Made with");
    return "<nav aria-label=\"Contents\">\n<h2>Contents</h2>\n<ol>\n" + items + "</ol>\n</nav>\n";
  }

  std::string condition_html(const Condition& condition) const {
    const Finding* const finding = findings_.find(condition.finding);
    const std::string meaning = finding != nullptr ? escaped(finding->meaning) + " " : "";
    const std::string rule =
        fmt::format("{}{} <span class=\"whole\">{} {}</span>", meaning, code(condition.finding),
                    condition.relation == Relation::at_most ? "≤" : "≥", escaped(shown(condition.bound)));
    if (!usable(finding)) return "<li>" + rule + ": <span class=\"missing\">not measured</span></li>\n";
    const std::optional<bool> held = holds(condition, *finding);
    return fmt::format("<li>{}: measured <span class=\"whole\">{}</span>, which <b>{}</b></li>\n", rule,
                       escaped(shown(*finding)),
                       !held   ? "leaves it open: the bound lies within the uncertainty"
                       : *held ? "holds"
                               : "does not hold");
  }

  std::string conditions(std::string_view introduction, std::span<const Condition> all) const {
    std::string items;
    for (const Condition& condition : all) items += condition_html(condition);
    return fmt::format("<p class=\"rule\">{}</p>\n<ul class=\"conditions\">\n{}</ul>\n", introduction, items);
  }

  std::string rules() const {
    std::string all =
        "<section id=\"rules\">\n<h2>What each verdict rests on</h2>\n"
        "<p>A claim is confirmed when all conditions for that hold, refuted when all conditions against it do, and "
        "confirmed with limits when neither is the case. A condition holds when the measured number lies on its side "
        "of "
        "the bound with all of its uncertainty. A claim with a number missing is not measured.</p>\n";
    for (const Judged& judged : verdicts_) {
      const Claim& claim = *judged.claim;
      all += fmt::format("<article id=\"{}\">\n<h3>{}: {}</h3>\n<p>{} <small>{}</small> {}</p>\n", claim_anchor(claim),
                         escaped(claim.id), escaped(claim.text), verdict_html(judged.verdict), escaped(claim.where),
                         evidence(claim));
      if (!judged.missing.empty()) {
        all += "<p class=\"missing\">Not measured: " + escaped(judged.missing) + ".</p>\n";
      }
      all += conditions("Confirmed if all of these hold:", claim.confirmed_if);
      all += conditions("Refuted if all of these hold:", claim.refuted_if);
      if (!claim.reading.empty()) all += fmt::format("<p class=\"reading\">{}</p>\n", escaped(claim.reading));
      all += "</article>\n";
    }
    return all + "</section>\n";
  }

  std::string section_html(const Section& section) {
    std::string html = fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n", escaped(section.name), escaped(section.title));
    const std::string settled = settles(section);
    html += settled.empty() ? "" : "<p class=\"settles\">" + settled + "</p>\n";
    for (const Block& block : section.blocks) {
      html += std::visit([this](const auto& one) { return block_html(one); }, block);
    }
    return html + "</section>\n";
  }

  /// The claims that a section is the evidence for.
  std::string settles(const Section& section) const {
    std::string all;
    for (const Judged& judged : verdicts_) {
      if (judged.claim->evidence != section.name) continue;
      all += (all.empty() ? "" : " ") + link("#" + claim_anchor(*judged.claim), std::string(judged.claim->id)) + " " +
             verdict_html(judged.verdict);
    }
    return all;
  }

  static std::string block_html(const Text& text) { return paragraph(text.text); }

  static std::string cell_html(const Cell& cell, Footnotes& notes) {
    if (const std::string* const text = std::get_if<std::string>(&cell)) {
      const bool one_word = text->find(' ') == std::string::npos;  // a name, which no hyphen may break
      return (one_word ? "<td class=\"whole\">" : "<td>") + escaped(*text) + "</td>";
    }
    if (const double* const number = std::get_if<double>(&cell); number != nullptr && std::isfinite(*number)) {
      return "<td class=\"number\">" + shown(*number) + "</td>";
    }
    const Missing* const missing = std::get_if<Missing>(&cell);
    return "<td class=\"number\">" + notes.mark(missing != nullptr ? missing->why : "no finite number") + "</td>";
  }

  /// Whether a column has numbers, so that its head stands above their right ends.
  static bool is_numeric(const Table& table, std::size_t column) {
    return std::ranges::any_of(table.rows, [column](const std::vector<Cell>& row) {
      return column < row.size() && !std::holds_alternative<std::string>(row[column]);
    });
  }

  /// The box that a table scrolls in: sideways, and a long one up and down under its head as well.
  static std::string box(std::size_t rows) {
    return rows > 24 ? "<div class=\"scroll long\" tabindex=\"0\">" : "<div class=\"scroll\" tabindex=\"0\">";
  }

  std::string block_html(const Table& table) {
    if (!tables_.insert(table.name).second) throw std::logic_error("two tables are named '" + table.name + "'");
    const std::string& id = anchors_.take("table", table.name);
    Footnotes notes;
    std::string head;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      head += fmt::format("<th scope=\"col\"{}>{}</th>", is_numeric(table, i) ? " class=\"number\"" : "",
                          escaped(table.columns[i]));
    }
    std::string rows;
    for (const auto& row : table.rows) {
      rows += "<tr>";
      for (const Cell& cell : row) rows += cell_html(cell, notes);
      rows += "</tr>\n";
    }
    std::string html = fmt::format("<figure class=\"table\" id=\"{}\">\n<figcaption><b>{}</b> {}</figcaption>\n",
                                   escaped(id), escaped(table.title), link(csv_of(table), "CSV"));
    html += box(table.rows.size()) + "<table>\n<thead><tr>" + head + "</tr></thead>\n<tbody>\n" + rows +
            "</tbody>\n</table></div>\n" + notes.text();
    if (!table.note.empty()) html += "<p class=\"note\">" + escaped(table.note) + "</p>\n";
    return html + "</figure>\n";
  }

  std::string panel_html(const Figure& figure, std::size_t number, const std::vector<Look>& looks,
                         const std::string& id) {
    const Panel& panel = figure.panels[number];
    const auto instead = [&](const std::string& why) {
      missing_.push_back(fmt::format("{}: {}", figure.name, why));
      return fmt::format("<p class=\"missing\">A plot of {} is missing here: {}.</p>\n",
                         escaped(panel.y_label + " against " + panel.x_label), escaped(why));
    };
    if (!has_points(panel)) return instead("there is no number to draw");
    try {
      return plot_svg(panel, looks, fmt::format("{}-{}", id, number + 1)) + "\n";
    } catch (const MachineError& error) {
      return instead(error.what());
    }
  }

  static std::string legend(const Figure& figure, const std::vector<std::vector<Look>>& looks) {
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
    std::string items;
    for (const Entry& entry : entries) {
      items += "<li>" + swatch_svg(entry.look) + " " + escaped(entry.label) +
               (entry.drawn ? "" : " <span class=\"missing\">(no number to draw)</span>") + "</li>";
    }
    return items.empty() ? "" : "<ul class=\"legend\">" + items + "</ul>\n";
  }

  static std::string shades(const Figure& figure) {
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

  std::string block_html(const Figure& figure) {
    const std::string id = anchors_.take("figure", figure.name);
    const auto looks = looks_of(figure);
    const int columns = std::clamp(figure.columns, 1, 4);
    std::string plots;
    for (std::size_t i = 0; i < figure.panels.size(); ++i) plots += panel_html(figure, i, looks[i], id);
    return fmt::format(
        "<figure class=\"plots\" id=\"{}\">\n<div class=\"panels in-{}\" style=\"--columns:{}\">\n{}</div>\n{}"
        "<figcaption><b>{}</b> {}</figcaption>\n</figure>\n",
        escaped(id), columns, columns, plots, legend(figure, looks), escaped(figure.title),
        escaped(figure.caption + shades(figure)));
  }

  std::string block_html(const Picture& picture) {
    const std::string id = anchors_.take("picture", picture.name);
    return fmt::format(
        "<figure class=\"picture\" id=\"{}\">\n<img src=\"data:image/png;base64,{}\" alt=\"{}\"/>\n"
        "<figcaption><b>{}</b> {}</figcaption>\n</figure>\n",
        escaped(id), base64(picture.png), escaped(picture.title), escaped(picture.title), escaped(picture.caption));
  }

  std::string all_findings() const {
    std::string rows;
    for (const auto& [name, finding] : findings_.all()) {
      const std::string value =
          usable(&finding) ? "<td class=\"number\">" + escaped(shown(finding)) + "</td>"
                           : "<td class=\"missing\">— " +
                                 escaped(finding.missing.empty() ? "no finite number" : finding.missing) + "</td>";
      rows += "<tr><td>" + code(name) + "</td><td>" + escaped(finding.meaning) + "</td>" + value + "</tr>\n";
    }
    return "<section id=\"findings\">\n<h2>All numbers</h2>\n<p>What the experiments found, by name, to three digits; "
           "with all digits in " +
           link("report/findings.csv", "findings.csv") +
           ", and every condition of every claim "
           "beside it in " +
           link("report/verdicts.csv", "verdicts.csv") + ".</p>\n" + box(findings_.all().size()) +
           "<table>\n<thead><tr><th scope=\"col\">name</th><th scope=\"col\">"
           "meaning</th><th scope=\"col\" class=\"number\">value</th></tr></thead>\n<tbody>\n" +
           rows + "</tbody>\n</table></div>\n</section>\n";
  }

  std::string files() const {
    if (document_.files.empty()) return "";
    std::string items;
    for (const Files& kind : document_.files) {
      items += "<li>" + escaped(kind.about) + ":";
      for (const std::string& path : kind.paths) {
        items += (path == kind.paths.front() ? " " : ", ") + link(path, path.substr(path.rfind('/') + 1));
      }
      items += "</li>\n";
    }
    return "<section id=\"files\">\n<h2>Files</h2>\n<p>Beside this page, in the same folder:</p>\n<ul>\n" + items +
           "</ul>\n</section>\n";
  }

  std::string made_with() const {
    std::string rows;
    for (const auto& [name, what] : document_.environment) {
      rows += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escaped(name), escaped(what));
    }
    return "<section id=\"made-with\">\n<h2>Made with</h2>\n<p>" + code(document_.command) + "</p>\n<dl>\n" + rows +
           "</dl>\n</section>\n";
  }

  const Document& document_;
  const std::vector<Judged>& verdicts_;
  const Findings& findings_;
  Anchors anchors_;
  std::set<std::string> tables_;
  std::string html_;
  std::vector<std::string> missing_;
};

}  // namespace

std::string csv_of(const Table& table) { return "report/" + table.name + ".csv"; }

Page make_page(const Document& document, const std::vector<Judged>& verdicts, const Findings& findings) {
  return Writer(document, verdicts, findings).write();
}

}  // namespace odeval::report
