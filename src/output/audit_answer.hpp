#pragma once
// The answer of an audit, for a terminal and for programs.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "odeval/audit.hpp"
#include "output/file.hpp"

namespace odeval {

/// "body 2", or "body 2 (left foot)".
std::string body_name(const audit::Answer& answer, std::uint32_t body);
std::string joint_name(const audit::Answer& answer, std::uint32_t joint);

/// What ran: stepper, step, bodies, joints, how it ended.
std::string audit_head(const audit::Answer& answer);
const char* convergence_word(audit::Convergence convergence);
/// Of both parts: "settled", or "settled, turn none" where only one of them has a limit.
std::string convergence_words(const audit::ErrorUntil& row);

/// Whether no more is known of an error than how large it can be: its uncertainty is as large as itself.
bool only_bounded(const audit::Estimate& error);
/// Whether some contact's spring and damper are shorter than the finest step, so that no run shows them.
bool stiff_contacts(const audit::Answer& answer);
/// Whether there is an error, at this one of Answer::error_at, that steps or settings can be told by.
bool has_limit(const audit::Answer& answer, std::size_t at);
/// "steps down to h/8 do not bring the runs together": why an error has no limit.
std::string no_limit_text(const audit::Answer& answer);
/// "the error is more than a tenth of how far body 2 has gone until then"; where the motion is lost.
std::string lost_text(const audit::Answer& answer);
/// Of the refinements, the largest.
int finest(const audit::Answer& answer);
/// Of what was tried, that keeps the error within a tenth; null where the program's own settings are as cheap, to a
/// twentieth.
const audit::Tried* cheapest(const audit::Answer& answer);
/// Of what steps and settings are told by: "m", or "rad" where next to nothing of the error is a distance.
const char* unit(const audit::Answer& answer);
/// How large it can be, rounded up: "0.6".
std::string most_text(const audit::Estimate& error);

/// What there is to say besides the errors, each under its name: "motion", "step".
using AuditLines = std::vector<std::pair<std::string, std::string>>;
AuditLines audit_lines(const audit::Answer& answer);

/// At most 25 lines.
std::string audit_text(const audit::Answer& answer);

/// answer.json.
std::string audit_json(const audit::Answer& answer);

/// steps.csv: a row a step of the program.
class AuditSteps {
 public:
  explicit AuditSteps(const std::filesystem::path& file);
  void add(const audit::StepRow& row);
  void finish() { file_.finish(); }

 private:
  WholeFile file_;
};

}  // namespace odeval
