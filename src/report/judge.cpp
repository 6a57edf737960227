#include <algorithm>
#include <cmath>

#include "report/claims.hpp"

namespace odeval::report {
namespace {

bool all_hold(std::span<const Condition> conditions, const Findings& findings) {
  return std::ranges::all_of(conditions, [&](const Condition& condition) {
    return holds(condition, *findings.find(condition.finding)).value_or(false);
  });
}

/// Whether a condition holds at some of the neighbouring settings and not at others.
bool flips_nearby(const Claim& claim, const Findings& findings) {
  for (const auto& conditions : {claim.confirmed_if, claim.refuted_if}) {
    for (const Condition& condition : conditions) {
      const auto& nearby = findings.find(condition.finding)->nearby;
      if (nearby && nearby->first < condition.bound && nearby->second > condition.bound) return true;
    }
  }
  return false;
}

/// Why a finding decides nothing; empty when it does.
std::string why_unusable(std::string_view name, const Finding& finding) {
  if (!finding.value) return finding.missing.empty() ? std::string(name) + " has no value" : finding.missing;
  return std::isfinite(*finding.value) ? "" : finding.meaning + ": not a finite number";
}

/// Adds a reason that is not there yet.
void add_reason(std::string& all, const std::string& why) {
  if (all.find(why) == std::string::npos) all += (all.empty() ? "" : "; ") + why;
}

}  // namespace

std::optional<bool> holds(const Condition& condition, const Finding& finding) {
  double low = finding.value.value() - finding.uncertainty;
  double high = finding.value.value() + finding.uncertainty;
  if (finding.nearby) {
    low = std::min(low, finding.nearby->first);
    high = std::max(high, finding.nearby->second);
  }
  const bool below = high <= condition.bound;
  const bool above = low >= condition.bound;
  const bool at_most = condition.relation == Relation::at_most;
  if (at_most ? below : above) return true;
  if (at_most ? low > condition.bound : high < condition.bound) return false;
  return std::nullopt;
}

std::vector<std::string_view> findings_named(const Claim& claim) {
  std::vector<std::string_view> names;
  for (const auto& conditions : {claim.confirmed_if, claim.refuted_if}) {
    for (const Condition& condition : conditions) {
      if (std::ranges::find(names, condition.finding) == names.end()) names.push_back(condition.finding);
    }
  }
  return names;
}

Judged judge(const Claim& claim, const Findings& findings) {
  Judged judged{&claim, Verdict::not_measured, {}, ""};
  std::string never;
  for (const std::string_view name : findings_named(claim)) {
    const Finding* const finding = findings.find(name);
    judged.findings.push_back(finding);
    if (finding == nullptr) {
      never += (never.empty() ? "" : ", ") + std::string(name);
    } else if (const std::string why = why_unusable(name, *finding); !why.empty()) {
      add_reason(judged.missing, why);
    }
  }
  if (!never.empty()) add_reason(judged.missing, "no experiment measures " + never);
  if (!judged.missing.empty()) return judged;
  if (flips_nearby(claim, findings)) {
    judged.verdict = Verdict::not_settled;
    return judged;
  }
  judged.verdict = all_hold(claim.confirmed_if, findings) ? Verdict::confirmed
                   : all_hold(claim.refuted_if, findings) ? Verdict::refuted
                                                          : Verdict::confirmed_with_limits;
  if (judged.verdict == Verdict::refuted) {  // what decides stands first
    std::ranges::stable_partition(judged.findings, [&](const Finding* finding) {
      return std::ranges::any_of(
          claim.refuted_if, [&](const Condition& condition) { return findings.find(condition.finding) == finding; });
    });
  }
  return judged;
}

std::string_view verdict_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::confirmed:
      return "confirmed";
    case Verdict::refuted:
      return "refuted";
    case Verdict::confirmed_with_limits:
      return "confirmed with limits";
    case Verdict::not_settled:
      return "not settled";
    case Verdict::not_measured:
      break;
  }
  return "not measured";
}

}  // namespace odeval::report
