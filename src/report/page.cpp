#include "report/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/sections.hpp"
#include "report/text.hpp"

namespace odeval::report {
namespace {

constexpr std::string_view title = "How far can you trust the Open Dynamics Engine?";

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

/// Gathers what the template of the page names.
class Writer {
 public:
  Writer(const Document& document, const std::vector<Judged>& verdicts, const Findings& findings)
      : document_(document), verdicts_(verdicts), findings_(findings) {}

  Page write() {
    for (const char* const fixed : {"verdicts", "rules", "findings", "files", "made-with"}) anchors_.take(fixed);
    for (const Judged& judged : verdicts_) anchors_.take(claim_anchor(*judged.claim));
    for (const auto& sections : {&document_.front, &document_.sections}) {
      for (const Section& section : *sections) anchors_.take(section.name);
    }
    Items front;  // first, since links are made to what is there
    for (const Section& section : document_.front) front.push_back(writer_.values(section, csv_of));
    Items folded;
    for (const Section& section : document_.sections) folded.push_back(evidence_values(section));
    const Values values{{"title", title},
                        {"style", page_layout("style")},
                        {"command", document_.command},
                        {"number_of_claims", verdicts_.size()},
                        {"tally", tally()},
                        {"claims", claims()},
                        {"front", std::move(front)},
                        {"folded", std::move(folded)},
                        {"many_findings", findings_.all().size() > long_rows},
                        {"findings", all_findings()},
                        {"has_files", !document_.files.empty()},
                        {"files", files()},
                        {"environment", environment()}};
    return {filled("page", page_layout("page"), values, escaped), writer_.missing()};
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
                     {"advice", advice_of(judged)}});
      items.push_back(std::move(values));
    }
    return items;
  }

  static Items numbers(const Judged& judged) {
    Items items;
    for (const Finding* finding : judged.findings) {
      if (usable(finding)) items.push_back({{"meaning", finding->meaning}, {"number", shown_plainly(*finding)}});
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

  Values evidence_values(const Section& section) {
    Values values = writer_.values(section, csv_of);
    values.insert({"settles", settles(section)});
    return values;
  }

  /// The claims that a section is the evidence for.
  Items settles(const Section& section) const {
    Items items;
    for (const Judged& judged : verdicts_) {
      if (judged.claim->evidence == section.name) items.push_back(verdict_values(judged));
    }
    return items;
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
  SectionWriter writer_{anchors_};
};

}  // namespace

std::string csv_of(const Table& table) { return "report/" + table.name + ".csv"; }

Page make_page(const Document& document, const std::vector<Judged>& verdicts, const Findings& findings) {
  return Writer(document, verdicts, findings).write();
}

}  // namespace odeval::report
