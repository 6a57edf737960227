// odeval audit: how wrong is a running ODE program? The program runs unchanged, and again with several smaller steps in
// the place of each of its own.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <memory>
#include <set>

#include "audit/preload/environment.hpp"
#include "cli/audit_runs.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/settings.hpp"
#include "odeval/error.hpp"
#include "output/number.hpp"

namespace odeval::cli {
namespace {

/// KEY=V of what can be tried.
std::string wrong_try(const std::string& text) {
  const std::size_t sign = text.find('=');
  std::vector<std::string> keys;
  for (const auto& row : audit::environment::tries) {
    keys.emplace_back(row.key);
    if (text.substr(0, sign) != row.key) continue;
    if (sign == std::string::npos || sign + 1 == text.size())
      return fmt::format("{} has no value: must be {}=V", row.key, row.key);
    const std::string value = text.substr(sign + 1);
    if (*row.words == 0) {
      const std::string wrong = row.whole
                                    ? whole_within(static_cast<long>(row.least), static_cast<long>(row.most))(value)
                                    : number_within(row.least, row.most)(value);
      return wrong.empty() ? "" : fmt::format("{} {}", row.key, wrong);
    }
    const std::string words = std::string(",") + row.words + ",";
    return words.find("," + value + ",") != std::string::npos
               ? ""
               : fmt::format("{} must be one of {}, not {}", row.key, row.words, value);
  }
  return fmt::format("must be KEY=V with a key of {}, not {}", fmt::join(keys, ", "), text);
}

/// A number may be written in several ways: cfm=1e-5, cfm=0.00001.
std::string in_one_way(const std::string& set) {
  const std::size_t value = set.find('=') + 1;
  char* end = nullptr;
  const double number = std::strtod(set.c_str() + value, &end);
  const bool is_number = end != set.c_str() + value && *end == '\0';
  return is_number ? set.substr(0, value) + number_text(number) : set;
}

/// In one way, and each once.
void require_different(std::vector<std::string>& tries, bool accurate) {
  std::set<std::string> seen;
  if (accurate) seen.insert("stepper=accurate");
  for (std::string& set : tries) {
    set = in_one_way(set);
    if (!seen.insert(set).second) throw UserError(fmt::format("--try {}: is asked for twice", set));
  }
}

void require_refinements(const std::vector<std::string>& words) {
  int last = 0;
  for (const std::string& word : words) {
    if (std::stoi(word) <= last) throw UserError("--refine " + word + ": refinements must rise from 1");
    last = std::stoi(word);
  }
  if (words.size() < 3 || words.front() != "1") {
    throw UserError(fmt::format("--refine {}: must be 1 and two more at least, as 1,2,4", fmt::join(words, ",")));
  }
}

}  // namespace

Action attach_audit(Flags& flags) {
  const auto options = std::make_shared<AuditOptions>();
  flags.add_option("PROGRAM", options->program, "the program and its arguments, after --").required();
  flags.add_option("--refine", options->refine, "steps in the place of one of the program's; default: 1,2,4,8")
      .type_name("K,K,K...")
      .delimiter(',')
      .check(whole_within(1, 1024))
      .one_value();
  flags
      .add_option(
          "--hold", options->hold,
          "what stays when the step gets smaller: springs, dampers and drag, or the numbers ERP, CFM and damping")
      .one_of({"springs", "numbers"})
      .capture_default_str();
  flags
      .add_option("--contacts", options->contacts,
                  "within a step of the program: made anew by its own callback, or held")
      .one_of({"renewed", "held"})
      .capture_default_str();
  flags.add_option("--try", options->tries, "a setting to run the program with as well: KEY=V, each --try another run")
      .type_name("KEY=V")
      .check(wrong_try)
      .one_value();
  flags.add_flag("--accurate", options->accurate,
                 "the same program by the accurate step as well: --try stepper=accurate");
  flags
      .add_option("--clock", options->clock,
                  "what the program's calls of the clock get: the machine's time, or the simulated, so that one whose "
                  "step comes from the clock repeats")
      .one_of({"wall", "simulated"})
      .capture_default_str();
  Flag tick =
      flags.add_option("--tick", options->tick_s,
                       "seconds that the simulated clock goes on from one reading to the next at least; default: 1/60");
  tick.type_name("S").check(number_within(1e-9, 1e3));
  flags.add_option("--until", options->until_s, "simulated time after which the program is ended")
      .type_name("T")
      .check(number_within(1e-6, 1e9));
  flags.add_option("--timeout", options->timeout_s, "seconds after which an unchanged run is ended")
      .type_name("S")
      .check(number_within(1e-3, 1e7))
      .capture_default_str();
  flags
      .add_option(
          "--records", options->records_gb,
          "the most that the records of all runs may take on the disk, until the answer is there: what does not "
          "fit is not audited")
      .type_name("GB")
      .check(number_within(0.01, 1e5))
      .capture_default_str();
  add_jobs_option(flags, options->jobs);
  add_out_option(flags, options->out);
  flags.add_flag("--film", options->film, "this run and its limit as an animated PNG at real-time speed: film.png");
  flags.add_flag("--quiet", options->quiet, "nothing but the files and the exit status");
  flags.add_flag("--json", options->json, "answer.json on standard output");
  return [options, tick] {
    if (tick.given() && options->clock != "simulated")
      throw UserError("--tick: has no effect without --clock simulated");
    require_refinements(options->refine);
    require_different(options->tries, options->accurate);
    return run_audit(*options);
  };
}

}  // namespace odeval::cli
