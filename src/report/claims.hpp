#pragma once
// The report's claims and the rules by which measured numbers confirm or refute them.
//
// A rule is data: the page prints the conditions that the verdict was computed from, so what is stated and what is
// computed cannot differ.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "report/findings.hpp"

namespace odeval::report {

enum class Relation { at_most, at_least };

/// "finding <= bound" or "finding >= bound". With its uncertainty the finding has to lie wholly on one side; where the
/// bound lies within it, or within what neighbouring settings give, the condition is undecided.
struct Condition {
  std::string_view finding;
  Relation relation;
  double bound;
};

enum class Verdict { confirmed, refuted, confirmed_with_limits, not_settled, not_measured };

/// Row of the one table of claims.
struct Claim {
  std::string_view id;                      // "C8b"
  std::string_view where;                   // "§5.7.2"; "odeval" for the project's own
  std::string_view text;                    // the claim in our own words
  std::span<const Condition> confirmed_if;  // all of them
  std::span<const Condition> refuted_if;    // all of them
  std::string_view advice;                  // what somebody who uses ODE does with it; one or two sentences
  std::string_view evidence;                // anchor of the section or figure that shows it
  Verdict advised_on = Verdict::confirmed;  // the verdict that the advice was written for
};

std::span<const Claim> claims();

/// Whether a condition holds; the empty optional says that its bound lies within the finding's uncertainty. The finding
/// has a value.
std::optional<bool> holds(const Condition& condition, const Finding& finding);

struct Judged {
  const Claim* claim;
  Verdict verdict;
  std::vector<const Finding*>
      findings;         // as the conditions name them, first confirmed_if, each once; null: never measured
  std::string missing;  // why not_measured
};

/// confirmed              every condition of confirmed_if holds
/// refuted                every condition of refuted_if holds
/// confirmed_with_limits  neither: some of it holds, or the numbers cannot tell
/// not_settled            a condition holds at some of the settings beside those that were measured, and not at others
/// not_measured           a finding that a condition names has no finite value
Judged judge(const Claim& claim, const Findings& findings);

/// The claim's advice; of another verdict than it was written for with that said.
std::string advice_of(const Judged& judged);

/// "confirmed with limits"
std::string_view verdict_text(Verdict verdict);

/// The findings that the conditions name, first those of `confirmed_if`, each once.
std::vector<std::string_view> findings_named(const Claim& claim);

}  // namespace odeval::report
