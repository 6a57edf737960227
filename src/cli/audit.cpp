// odeval audit: how wrong is a running ODE program? The program runs unchanged, and again with several smaller steps in
// the place of each of its own.
#include "odeval/audit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>

#include "audit/judge.hpp"
#include "audit/library.hpp"
#include "audit/preload/environment.hpp"
#include "audit/recording.hpp"
#include "catalogue/versions.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/progress.hpp"
#include "cli/settings.hpp"
#include "odeval/error.hpp"
#include "output/audit_answer.hpp"
#include "output/number.hpp"
#include "report/audit_page.hpp"
#include "run/pool.hpp"
#include "run/program.hpp"

namespace odeval::cli {
namespace {

namespace fs = std::filesystem;
using audit::Answer;
using audit::Recording;

constexpr double moved_by_m = 1e-10;

struct Options {
  std::vector<std::string> program;
  std::vector<std::string> refine;
  std::string hold = "springs";
  std::string contacts = "renewed";
  std::vector<std::string> tries;
  double until_s = 0;
  double timeout_s = 60;
  int jobs = 1;
  std::string out = "results";
  bool quiet = false;
  bool json = false;
};

/// Records of runs, gone with it.
class Scratch {
 public:
  Scratch() {
    std::error_code error;
    const fs::path place = fs::temp_directory_path(error);
    if (error) throw MachineError("TMPDIR: no folder for records: " + error.message());
    std::string name = (place / "odeval-audit-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {  // which fills in the letters
      throw MachineError(name + ": no folder for records: " + std::strerror(errno));
    }
    folder_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  fs::path record(std::size_t run) const { return folder_ / (std::to_string(run) + ".record"); }

 private:
  fs::path folder_;
};

/// One of the audit's runs of the program.
struct Run {
  int refinement = 1;
  bool moved = false;
  std::string set{};     // in the place of the program's settings
  bool numbers = false;  // held, where the audit holds springs
  run::ProgramEnd end{};
};

class Audit {
 public:
  explicit Audit(const Options& options) : options_(options) {
    for (const std::string& word : options.refine) refinements_.push_back(std::stoi(word));
    until_s_ = options.until_s;
  }

  /// Fills the answer. Returns 0, or the signal that ended it.
  int run(Answer& answer) {
    progress_.emplace(0, options_.quiet || options_.json);
    const int signal = run_all(answer);
    progress_.reset();  // its line makes room for what is said
    return signal;
  }

  void write(const Answer& answer) const {
    const fs::path folder = fs::path(options_.out) / "audit";
    make_folder(folder);
    AuditSteps steps(folder / "steps.csv");
    audit::each_step(scratch_.record(0), [&](const audit::StepRow& row) { steps.add(row); });
    steps.finish();
    write_whole(folder / "answer.json", audit_json(answer));
    const report::Page page = report::audit_page(
        answer, {.pictures = {}, .command = "odeval audit -- " + answer.program, .environment = catalogue::versions()});
    write_whole(folder / "index.html", page.html);
    for (const std::string& why : page.missing) std::cerr << "odeval: the page lacks " << why << '\n';
  }

 private:
  int run_all(Answer& answer) {
    answer.program = fmt::format("{}", fmt::join(options_.program, " "));
    answer.springs_held = options_.hold == "springs";
    runs_ = {Run{}, Run{}};
    if (const int signal = run_from(0)) return signal;
    find_parting(answer);
    audit::describe(scratch_.record(0), answer);
    answer.reason = reason(answer);
    if (answer.reason.empty()) {
      limit_to_what_was_reached();
      for (const int k : refinements_) {
        if (k > 1) runs_.push_back({.refinement = k});
      }
      runs_.push_back({.moved = true});
      for (const std::string& set : tries(answer)) runs_.push_back({.set = set});
      if (answer.springs_held) runs_.push_back({.refinement = refinements_.rbegin()[1], .numbers = true});
      if (const int signal = run_from(2)) return signal;
      judge(answer);
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) answer.runs.push_back(described(i));
    add_limits(answer);
    return 0;
  }

  run::Program program(std::size_t number) const {
    namespace environment = audit::environment;
    const Run& run = runs_[number];
    const char* others = std::getenv("LD_PRELOAD");
    const std::string library = audit::library_file();
    return {.words = options_.program,
            .environment = {{"LD_PRELOAD", others == nullptr ? library : library + ":" + others},
                            {environment::record, scratch_.record(number).string()},
                            {environment::refine, std::to_string(run.refinement)},
                            {environment::hold, run.numbers ? "numbers" : options_.hold},
                            {environment::set, run.set},
                            {environment::contacts, options_.contacts},
                            {environment::until, number_text(until_s_)},
                            {environment::move, number_text(run.moved ? moved_by_m : 0)}},
            .timeout_s = timeout_s(number)};
  }

  /// A step that is refined by k costs k steps, and what it finds to do once more.
  double timeout_s(std::size_t number) const {
    return (runs_[number].refinement > 1 ? 2 : 1) * runs_[number].refinement * options_.timeout_s;
  }

  /// Those from `first` on, in the pool.
  int run_from(std::size_t first) {
    std::vector<run::Job> plan;
    for (std::size_t i = first; i < runs_.size(); ++i) plan.push_back({.number = static_cast<std::uint32_t>(i)});
    // The longest first.
    std::ranges::stable_sort(plan, std::ranges::greater(),
                             [&](const run::Job& job) { return runs_[job.number].refinement; });
    const run::Work work{.prepare = {}, .job = [&](long job, long, std::string_view) {
                           return run::packed(run::run_program(program(static_cast<std::size_t>(job))));
                         }};
    const auto take = [&](long job, const run::Result& result) {
      if (result.kind == run::Result::Kind::refused) throw UserError(result.text);
      if (result.kind != run::Result::Kind::done) throw MachineError(options_.program.front() + ": " + result.text);
      runs_[static_cast<std::size_t>(job)].end = run::unpacked(result.text);
      progress_->show(
          fmt::format("[{}/{}] {}", ++done_, runs_.size(), description(runs_[static_cast<std::size_t>(job)])));
    };
    return run::run_pool(work, plan, take, {.processes = options_.jobs, .passed = {}});
  }

  /// What is tried of any program, and what was asked for.
  std::vector<std::string> tries(const Answer& answer) const {
    std::vector<std::string> sets{"erp=0.8", "start=half-step", "rotation=finite"};
    if (answer.stepper == "dWorldQuickStep") {
      sets.insert(sets.end(), {"iterations=50", "w=1", "stepper=step"});
    } else {
      sets.emplace_back("stepper=quick");
    }
    sets.insert(sets.end(), options_.tries.begin(), options_.tries.end());
    return sets;
  }

  /// Why there is nothing to refine; empty: there is.
  std::string reason(const Answer& answer) const {
    for (const std::size_t number : {std::size_t{0}, std::size_t{1}}) {
      const Recording run(scratch_.record(number));
      if (run.has(audit::single_precision))
        return "its ODE is single precision, and the audit follows double precision only";
      if (run.has(audit::several_threads)) return "it steps from several threads, and the audit follows one";
      if (run.had_no_room() && answer.h_s == 0) return "there is no room on the disk for its record";
    }
    if (answer.h_s == 0) return "it took no step of an ODE in a shared library";
    if (answer.parting) {
      return "a program that does not repeat can not be told from one that is wrong; does its step come from the "
             "clock, "
             "or a start from random numbers?";
    }
    return "";
  }

  /// Where this process ended them, that one went farther says nothing.
  void find_parting(Answer& answer) const {
    answer.parting = audit::parting(scratch_.record(0), scratch_.record(1));
    const bool ended_here = runs_[0].end.late || runs_[1].end.late;
    if (!answer.parting || !ended_here) return;
    if (answer.parting->step > std::min(reached(0).steps, reached(1).steps)) answer.parting.reset();
  }

  /// A program that was ended from outside is refined until the time that it reached.
  void limit_to_what_was_reached() {
    if (runs_[0].end.late || runs_[1].end.late) until_s_ = std::min(reached(0).t_s, reached(1).t_s);
  }

  struct Reached {
    double t_s = 0;
    std::uint64_t steps = 0;
  };
  Reached reached(std::size_t number) const {
    Recording run(scratch_.record(number));
    Reached last;
    for (auto moment = run.next(); moment; moment = run.next()) {
      last.t_s = std::max(last.t_s, moment->frame.t);
      last.steps = std::max(last.steps, moment->frame.step);
    }
    return last;
  }

  static std::string description(const Run& run) {
    if (!run.set.empty()) return run.set;
    if (run.numbers) return fmt::format("numbers held at steps of h/{}", run.refinement);
    if (run.moved) return fmt::format("starts moved by {:g} m", moved_by_m);
    return run.refinement == 1 ? "unchanged" : fmt::format("steps of h/{}", run.refinement);
  }

  audit::ProgramRun described(std::size_t number) const {
    const Run& run = runs_[number];
    const Reached last = reached(number);
    std::string end = run::end_text(run.end, timeout_s(number));
    const bool by_itself = run.end.signal == 0 && !run.end.late;
    const bool cut = Recording(scratch_.record(number)).has(audit::reached_until);
    if (cut) end = fmt::format("ended at {:.4g} s", last.t_s);
    return {.refinement = run.refinement,
            .what = description(run),
            .end = end,
            .exit_status = by_itself && !cut ? std::optional(run.end.status) : std::nullopt,
            .steps = last.steps,
            .simulated_s = last.t_s,
            .cpu_s = run.end.cpu_s};
  }

  void judge(Answer& answer) {
    audit::Records records;
    records.moved_by_m = moved_by_m;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (i == 1) continue;  // the same as the first
      if (runs_[i].moved) {
        records.moved = scratch_.record(i);
      } else if (!runs_[i].set.empty()) {
        records.tried.push_back(scratch_.record(i));
        records.tried_sets.push_back(runs_[i].set);
      } else if (runs_[i].numbers) {
        records.with_numbers = scratch_.record(i);
      } else {
        records.refined.push_back(scratch_.record(i));
        records.refinements.push_back(runs_[i].refinement);
      }
    }
    audit::judge(records, answer);
  }

  void add_limits(Answer& answer) const {
    const audit::ProgramRun& own = answer.runs.front();
    for (const audit::ProgramRun& run : answer.runs) {
      if (run.simulated_s < own.simulated_s * (1 - 1e-9)) {
        answer.limits.push_back(
            fmt::format("the run with {} reached {:.4g} s ({})", run.what, run.simulated_s, run.end));
      }
    }
    const run::ProgramEnd& end = runs_.front().end;
    if ((end.signal != 0 || end.status != 0) && !end.last_line.empty()) {
      answer.limits.push_back("the program's last line: " + end.last_line);
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const Recording run(scratch_.record(i));
      if (run.had_no_room()) {
        answer.limits.push_back(fmt::format("no room on the disk for all of the run with {}", description(runs_[i])));
      }
      if (i == 0 && run.has(audit::several_processes)) {
        answer.limits.push_back("several processes of the program step: the audit is of the first");
      }
      if (i == 2 && run.has(audit::contacts_stayed)) {
        answer.limits.push_back("contacts stay as they are within a step: what makes them can not be called again");
      }
    }
    if (!Recording(scratch_.record(0)).has(audit::single_precision) && answer.reason.empty()) {
      answer.limits.emplace_back("forces that the program adds count as constant over each of its own steps");
    }
  }

  const Options& options_;
  std::optional<Progress> progress_;  // while runs are under way
  Scratch scratch_;
  std::vector<int> refinements_;
  double until_s_ = 0;
  std::vector<Run> runs_;  // two unchanged, those refined, the one moved, those tried, the one with numbers
  std::size_t done_ = 0;
};

/// KEY=V of what can be tried.
std::string wrong_try(const std::string& text) {
  const std::size_t sign = text.find('=');
  std::vector<std::string> keys;
  for (const auto& row : audit::environment::tries) {
    keys.emplace_back(row.key);
    if (sign == std::string::npos || text.substr(0, sign) != row.key) continue;
    const std::string value = text.substr(sign + 1);
    if (*row.words == 0) return number_within(row.least, row.most)(value);
    const std::string words = std::string(",") + row.words + ",";
    return words.find("," + value + ",") != std::string::npos && !value.empty()
               ? ""
               : fmt::format("{} must be one of {}, not {}", row.key, row.words, value);
  }
  return fmt::format("must be KEY=V with a key of {}, not {}", fmt::join(keys, ", "), text);
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

int audit_program(const Options& options) {
  require_refinements(options.refine);
  Answer answer;
  Audit audit(options);
  if (const int signal = audit.run(answer)) {
    std::cerr << fmt::format("odeval: stopped by {}\n", ::strsignal(signal));
    return 128 + signal;
  }
  audit.write(answer);
  if (options.json) {
    std::cout << audit_json(answer);
  } else if (!options.quiet) {
    std::cout << audit_text(answer) << "\nwrote " << (fs::path(options.out) / "audit" / "index.html").string() << "\n";
  }
  return answer.reason.empty() ? 0 : 1;
}

}  // namespace

Action attach_audit(Flags& flags) {
  const auto options = std::make_shared<Options>();
  options->refine = {"1", "2", "4", "8"};
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
  flags.add_option("--until", options->until_s, "simulated time after which the program is ended")
      .type_name("T")
      .check(number_within(1e-6, 1e9));
  flags.add_option("--timeout", options->timeout_s, "seconds after which an unchanged run is ended")
      .type_name("S")
      .check(number_within(1e-3, 1e7))
      .capture_default_str();
  add_jobs_option(flags, options->jobs);
  add_out_option(flags, options->out);
  flags.add_flag("--quiet", options->quiet, "nothing but the files and the exit status");
  flags.add_flag("--json", options->json, "answer.json on standard output");
  return [options] { return audit_program(*options); };
}

}  // namespace odeval::cli
