#include "report/files.hpp"

#include <cmath>

#include "output/number.hpp"

namespace odeval::report {
namespace {

std::string cell(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char letter : text) {
    quoted += letter;
    if (letter == '"') quoted += letter;
  }
  return quoted + '"';
}

std::string value_of(const Cell& value) {
  if (const double* const number = std::get_if<double>(&value)) return number_text(*number);
  if (const std::string* const text = std::get_if<std::string>(&value)) return cell(std::string_view(*text));
  return "";
}

std::string line(const std::vector<std::string>& cells) {
  std::string text;
  for (std::size_t i = 0; i < cells.size(); ++i) text += (i == 0 ? "" : ",") + cells[i];
  return text + '\n';
}

std::string value_text(const Finding& finding) { return finding.value ? number_text(*finding.value) : ""; }
std::string uncertainty_text(const Finding& finding) { return finding.value ? number_text(finding.uncertainty) : ""; }

std::string source_text(Source source) {
  switch (source) {
    case Source::reference:
      return "reference";
    case Source::fit:
      return "fit";
    case Source::timing:
      return "timing";
    case Source::step:
      break;
  }
  return "step";
}

std::string holds_text(const Condition& condition, const Finding& finding) {
  if (!finding.value || !std::isfinite(*finding.value)) return "";
  const std::optional<bool> held = holds(condition, finding);
  return !held ? "cannot tell" : *held ? "yes" : "no";
}

}  // namespace

std::string table_csv(const Table& table) {
  std::vector<std::string> cells;
  for (const std::string& column : table.columns) cells.push_back(cell(column));
  std::string text = line(cells);
  for (const auto& row : table.rows) {
    cells.clear();
    for (const Cell& value : row) cells.push_back(value_of(value));
    text += line(cells);
  }
  return text;
}

std::string findings_csv(const Findings& findings) {
  std::string text = "name,value,uncertainty,unit,meaning,missing,uncertainty_of,nearby_least,nearby_largest\n";
  for (const auto& [name, finding] : findings.all()) {
    text += line({cell(name), value_text(finding), uncertainty_text(finding), cell(finding.unit), cell(finding.meaning),
                  cell(finding.missing), finding.value && finding.uncertainty > 0 ? source_text(finding.source) : "",
                  finding.nearby ? number_text(finding.nearby->first) : "",
                  finding.nearby ? number_text(finding.nearby->second) : ""});
  }
  return text;
}

std::string verdicts_csv(std::span<const Judged> verdicts, const Findings& findings) {
  std::string text = "claim,verdict,kind,finding,relation,bound,value,uncertainty,unit,holds,missing\n";
  for (const Judged& judged : verdicts) {
    const Claim& claim = *judged.claim;
    for (const auto& [kind, conditions] :
         {std::pair("confirmed_if", claim.confirmed_if), std::pair("refuted_if", claim.refuted_if)}) {
      for (const Condition& condition : conditions) {
        const Finding* const found = findings.find(condition.finding);
        const Finding finding = found != nullptr ? *found : Finding{"", "", {}, 0, "no experiment measures it"};
        text += line({cell(claim.id), cell(verdict_text(judged.verdict)), kind, cell(condition.finding),
                      condition.relation == Relation::at_most ? "<=" : ">=", number_text(condition.bound),
                      value_text(finding), uncertainty_text(finding), cell(finding.unit),
                      holds_text(condition, finding), cell(finding.missing)});
      }
    }
  }
  return text;
}

}  // namespace odeval::report
