#include "cli/audit_runs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <future>
#include <iostream>
#include <optional>

#include "audit/judge.hpp"
#include "audit/library.hpp"
#include "audit/preload/environment.hpp"
#include "audit/recording.hpp"
#include "catalogue/versions.hpp"
#include "cli/audit_pictures.hpp"
#include "cli/audit_scratch.hpp"
#include "cli/progress.hpp"
#include "cli/readable.hpp"
#include "cli/run_files.hpp"
#include "cli/settings.hpp"
#include "odeval/audit.hpp"
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

fs::path folder_of(const AuditOptions& options) { return fs::path(options.out) / "audit"; }

constexpr double moved_by_m = 1e-10;
constexpr const char* accurately = "stepper=accurate";

/// One of the audit's runs of the program.
struct Run {
  int refinement = 1;
  bool moved = false;
  std::string set{};     // in the place of the program's settings
  bool numbers = false;  // held, where the audit holds springs
  bool ledger = false;
  bool motions = false;  // velocities, to be compared
  run::ProgramEnd end{};
};

class Audit {
 public:
  explicit Audit(const AuditOptions& options) : options_(options) {
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
    const fs::path folder = folder_of(options_);
    std::future<void> steps = std::async(std::launch::async, [&] { write_steps(folder / "steps.csv"); });
    write_whole(folder / "answer.json", audit_json(answer));
    fs::remove(folder / "film.png");  // of an audit before
    std::future<std::vector<report::Section>> drawing;
    if (answer.reason.empty()) drawing = std::async(std::launch::async, [&] { return drawn(answer, folder); });
    std::vector<std::string> missing;
    const auto pictures = [&]() -> std::vector<report::Section> {
      if (!drawing.valid()) return {};
      try {
        return drawing.get();
      } catch (const MachineError& error) {  // no OpenGL, no font
        missing.push_back(fmt::format("its pictures: {}", error.what()));
        return {};
      }
    };
    const report::Page page =
        report::audit_page(answer, {.pictures = pictures, .command = command(), .environment = catalogue::versions()});
    steps.get();
    write_whole(folder / "index.html", page.html);
    missing.insert(missing.end(), page.missing.begin(), page.missing.end());
    for (const std::string& why : missing) std::cerr << "odeval: the page lacks " << why << '\n';
  }

 private:
  /// Beside gnuplot's figures: each takes as long as the other.
  std::vector<report::Section> drawn(const Answer& answer, const fs::path& folder) const {
    std::vector<report::Section> pictures = worst_moment(answer, records());
    if (options_.film) write_whole(folder / "film.png", audit_film(answer, records()));
    return pictures;
  }

  void write_steps(const fs::path& file) const {
    AuditSteps steps(file);
    audit::each_step(scratch_.record(0), [&](const audit::StepRow& row) { steps.add(row); });
    steps.finish();
  }

  int run_all(Answer& answer) {
    answer.program = fmt::format("{}", fmt::join(options_.program, " "));
    answer.springs_held = options_.hold == "springs";
    answer.contacts_held = options_.contacts == "held";
    runs_ = {Run{.ledger = true}, Run{.motions = true}};
    if (const int signal = run_from(0)) return signal;
    find_parting(answer);
    answer.unrecorded = Recording(scratch_.record(0)).had_no_room();
    audit::describe(scratch_.record(0), answer);
    require_effects(answer);
    answer.reason = reason(answer);
    if (answer.reason.empty()) {
      limit_to_what_was_reached(answer);
      for (const int k : refinements_) {
        if (k > 1) runs_.push_back({.refinement = k});
      }
      runs_.push_back({.moved = true});
      if (const int signal = run_from(2)) return signal;
      answer.reason = reason(answer);  // threads that took turns may meet in a run that takes longer
    }
    if (answer.reason.empty()) {
      const std::vector<audit::LimitOf> limits = audit::judge(records(), answer);
      const std::size_t judged = runs_.size();
      // Every world is to get there: the first to do so may be steps before the others.
      tried_until_s_ = answer.error_at[answer.tried_at].t_s;
      beside_until_s_ = tried_until_s_ + std::max(answer.h_s, 0.01 * tried_until_s_);
      for (const std::string& set : usual_tries(answer)) runs_.push_back({.set = set});
      for (const std::string& set : asked()) runs_.push_back({.set = set});
      if (answer.springs_held) runs_.push_back({.refinement = refinements_[1], .numbers = true});
      if (const int signal = run_from(judged)) return signal;
      audit::judge_tried(records(), limits, answer);
      answer.reason = reason(answer);
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) answer.runs.push_back(described(i));
    add_limits(answer);
    return 0;
  }

  /// That makes this page again.
  std::string command() const {
    std::string text = "odeval audit";
    const auto add = [&text](const char* flag, const std::string& value) {
      text += fmt::format(" {} {}", flag, value);
    };
    if (options_.refine != default_refinements()) add("--refine", fmt::format("{}", fmt::join(options_.refine, ",")));
    if (options_.hold != "springs") add("--hold", options_.hold);
    if (options_.contacts != "renewed") add("--contacts", options_.contacts);
    if (options_.clock != "wall") add("--clock", options_.clock);
    if (options_.tick_s != AuditOptions().tick_s) add("--tick", number_text(options_.tick_s));
    for (const std::string& set : options_.tries) add("--try", set);
    if (options_.accurate) text += " --accurate";
    if (options_.records_gb != AuditOptions().records_gb) add("--records", number_text(options_.records_gb));
    if (options_.until_s > 0) add("--until", number_text(options_.until_s));
    return fmt::format("{} -- {}", text, fmt::join(options_.program, " "));
  }

  run::Program program(std::size_t number) const {
    namespace environment = audit::environment;
    const Run& run = runs_[number];
    const char* others = std::getenv("LD_PRELOAD");
    std::string libraries = audit::library_file(audit::recorder);
    if (options_.clock == "simulated") libraries += ":" + audit::library_file(audit::simulated_clock);
    if (others != nullptr) libraries += std::string(":") + others;
    return {.words = options_.program,
            .environment = {{"LD_PRELOAD", libraries},
                            {environment::tick, number_text(options_.tick_s)},
                            {environment::accurate, audit::library_file(audit::accurate_stepper)},
                            {environment::record, scratch_.record(number).string()},
                            {environment::refine, std::to_string(run.refinement)},
                            {environment::hold, run.numbers ? "numbers" : options_.hold},
                            {environment::set, run.set},
                            {environment::ledger, run.ledger ? "1" : "0"},
                            {environment::motions, run.motions ? "1" : "0"},
                            {environment::timed, run.motions || !run.set.empty() ? "1" : "0"},
                            {environment::contacts, options_.contacts},
                            {environment::most_bytes, number_text(most_bytes())},
                            {environment::until, number_text(until_s(run))},
                            {environment::move, number_text(run.moved ? moved_by_m : 0)}},
            .timeout_s = timeout_s(number)};
  }

  /// Of each record: those of all runs that there may be share the room.
  double most_bytes() const {
    constexpr std::size_t usual = 14;  // one unchanged, one moved, one with numbers, and at most eleven tried
    return std::floor(1e9 * options_.records_gb / static_cast<double>(usual + refinements_.size() + asked().size()));
  }

  /// Beside the refined runs: nothing is told of it after Answer::tried_at.
  static bool is_beside(const Run& run) { return !run.set.empty() || run.numbers; }

  double until_s(const Run& run) const {
    if (!is_beside(run)) return until_s_;
    return until_s_ > 0 ? std::min(until_s_, beside_until_s_) : beside_until_s_;
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

  std::vector<std::string> asked() const {
    std::vector<std::string> sets = options_.tries;
    if (options_.accurate) sets.emplace_back(accurately);
    return sets;
  }

  /// Why a setting does nothing to this program; empty where it may.
  static std::string idle(const std::string& set, const Answer& answer) {
    const auto is = [&](const char* key) { return set.starts_with(std::string(key) + "="); };
    if (answer.stepper == "dWorldStep" && (is("iterations") || is("w"))) {
      return "the program takes dWorldStep, and only dWorldQuickStep has it";
    }
    const std::string_view own = answer.stepper == "dWorldStep"        ? "stepper=step"
                                 : answer.stepper == "dWorldQuickStep" ? "stepper=quick"
                                                                       : "";
    if (set == own) return fmt::format("the program takes {} as it is", answer.stepper);
    if (answer.contacts == 0 && (is("max_correcting_vel") || is("surface_layer"))) return "the program has no contacts";
    if (answer.contacts == 0 && answer.joints == 0 && (is("erp") || is("cfm"))) {
      return "the program has no joints and no contacts";
    }
    return "";
  }

  void require_effects(const Answer& answer) const {
    if (answer.h_s == 0) return;
    if (answer.contacts == 0 && answer.contacts_held) {
      throw UserError("--contacts held: has no effect: the program has no contacts");
    }
    const Recording own(scratch_.record(0));
    if (options_.clock == "simulated" && !own.has(audit::asked_the_clock)) {
      throw UserError("--clock simulated: has no effect: the program asks no clock before its last step");
    }
    for (const std::string& set : asked()) {
      const std::string why = idle(set, answer);
      if (!why.empty()) throw UserError(fmt::format("--try {}: has no effect: {}", set, why));
    }
  }

  /// What is tried of any program, but for what was asked for.
  std::vector<std::string> usual_tries(const Answer& answer) const {
    const Recording own(scratch_.record(0));
    std::vector<std::string> sets;
    const auto add = [&sets](const char* key, double own_value, std::initializer_list<double> values) {
      for (const double value : values) {
        const bool is_own = std::fabs(value - own_value) <= 1e-3 * value;
        if (!is_own) sets.push_back(fmt::format("{}={}", key, number_text(value)));
      }
    };
    add("erp", own.head()->erp, {0.2, 0.8});
    add("cfm", own.head()->cfm, {1e-10, 1e-5});  // the defaults of ODE in double and in single precision
    if (answer.stepper == "dWorldQuickStep") {
      add("iterations", own.head()->iterations, {10, 50});
      add("w", own.head()->w, {1, 1.5});
    }
    sets.emplace_back(answer.stepper == "dWorldQuickStep" ? "stepper=step" : "stepper=quick");
    sets.insert(sets.end(), {"rotation=finite", "start=half-step"});
    const std::vector<std::string> others = asked();
    std::erase_if(sets, [&](const std::string& set) {
      return std::ranges::find(others, set) != others.end() || !idle(set, answer).empty();
    });
    return sets;
  }

  /// Why there is nothing to refine; empty: there is.
  std::string reason(const Answer& answer) const {
    for (std::size_t number = 0; number < runs_.size(); ++number) {
      const Recording run(scratch_.record(number));
      if (run.has(audit::single_precision))
        return "its ODE is single precision, and the audit follows double precision only";
      if (run.has(audit::several_threads))
        return "several of its threads step, collide or make bodies, and the audit follows one";
      if (run.had_no_room() && answer.h_s == 0) return "there is no room on the disk for its record";
    }
    if (answer.diverged && answer.diverged->step <= 1) {
      return body_name(answer, answer.diverged->body) + " is no finite number from the first step on";
    }
    if (answer.h_s == 0)
      return "it took no step of an ODE in a shared library (what accurate_step takes is none of ODE's)";
    if (answer.parting) {
      const std::string what = "a program that does not repeat can not be told from one that is wrong; ";
      if (Recording(scratch_.record(0)).has(audit::pool_of_threads)) {
        return what + "it has ODE take its steps with several threads (dWorldSetStepThreadingImplementation)";
      }
      return what + fmt::format("does its step come from the clock{}, or a start from random numbers?",
                                options_.clock == "simulated" ? "" : " (try --clock simulated)");
    }
    return "";
  }

  /// Where this process ended them, or a record has no more room, that one went farther says nothing.
  void find_parting(Answer& answer) const {
    answer.parting = audit::parting(scratch_.record(0), scratch_.record(1));
    const auto is_cut = [this](std::size_t number) {
      return runs_[number].end.late || is_full(number) || Recording(scratch_.record(number)).had_no_room();
    };
    if (!answer.parting || !(is_cut(0) || is_cut(1))) return;
    if (answer.parting->step > std::min(reached(0).steps, reached(1).steps)) answer.parting.reset();
  }

  bool is_full(std::size_t number) const { return Recording(scratch_.record(number)).has(audit::record_full); }

  /// A program that was ended from outside, or is longer than its record, is refined until the time that it reached;
  /// one that is no number any more, until then.
  void limit_to_what_was_reached(const Answer& answer) {
    const auto limit = [this](double t_s) { until_s_ = until_s_ > 0 ? std::min(until_s_, t_s) : t_s; };
    if (runs_[0].end.late || runs_[1].end.late || is_full(0)) limit(std::min(reached(0).t_s, reached(1).t_s));
    if (answer.diverged) limit(answer.diverged->t_s);
  }

  struct Reached {
    double t_s = 0;
    std::uint64_t steps = 0;
  };
  Reached reached(std::size_t number) const {
    const Recording run(scratch_.record(number));
    return run.head() == nullptr ? Reached{} : Reached{run.head()->t, run.head()->steps};
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
    if (cut) end = fmt::format("ended at {:.4g} s", is_full(number) ? options_.until_s : last.t_s);
    return {.refinement = run.refinement,
            .what = description(run),
            .end = end,
            .exit_status = by_itself && !cut ? std::optional(run.end.status) : std::nullopt,
            .steps = last.steps,
            .simulated_s = last.t_s,
            .cpu_s = run.end.cpu_s};
  }

  audit::Records records() const {
    audit::Records records;
    records.moved_by_m = moved_by_m;
    records.unchanged_again = scratch_.record(1);
    records.asked = asked().size();
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
    return records;
  }

  void add_limits(Answer& answer) const {
    const audit::ProgramRun& own = answer.runs.front();
    if (is_full(0)) {
      answer.limits.push_back(
          fmt::format("what is told is of the first {:.4g} s: all records may take {:g} GB (--records)",
                      own.simulated_s, options_.records_gb));
    }
    if (options_.until_s > 0 && own.exit_status && own.simulated_s < options_.until_s * (1 - 1e-9)) {
      answer.limits.push_back(fmt::format("--until {:g} has no effect: the program ends by itself at {:.4g} s",
                                          options_.until_s, own.simulated_s));
    }
    const double until_s = answer.diverged ? answer.diverged->t_s - answer.h_s : own.simulated_s;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const Recording run(scratch_.record(i));
      if (!run.has(audit::not_accurately)) continue;
      const char* why = run.head()->last_words;
      answer.limits.push_back(
          fmt::format("the accurate step can not take it from {:.4g} s on: {}", reached(i).t_s, why));
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const audit::ProgramRun& run = answer.runs[i];
      if (run.what == accurately) continue;
      const double to_reach_s = is_beside(runs_[i]) ? std::min(until_s, tried_until_s_) : until_s;
      if (run.simulated_s < to_reach_s * (1 - 1e-9)) {
        const std::string which = run.what == "unchanged" ? "the second unchanged run" : "the run with " + run.what;
        answer.limits.push_back(fmt::format("{} reached {:.4g} s ({})", which, run.simulated_s, run.end));
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
      if (i == 0 && run.has(audit::steps_in_vain)) {
        answer.limits.emplace_back("ODE had no memory for some steps and did not take them: dWorldStep returned 0");
      }
      if (i == 0 && run.has(audit::pool_of_threads)) {
        answer.limits.emplace_back("ODE takes its steps with several threads: it may repeat now, and not another time");
      }
      if (i == 0 && run.has(audit::too_many_parts)) {
        answer.limits.push_back("more joints, touching bodies or geoms than there is room for: some are not told of");
      }
      if (i == 2 && run.has(audit::contacts_stayed)) {
        answer.limits.push_back("contacts stay as they are within a step: what makes them can not be called again");
      }
    }
    if (answer.reason.empty() && stiff_contacts(answer)) {
      answer.limits.push_back(
          fmt::format("contacts stop what they hold in {:.2g} s, less than the finest step: errors are from where they "
                      "would be rigid; steps as short as that may bring bounces and impacts out otherwise",
                      answer.contact_s));
    }
    if (answer.adds_forces && answer.reason.empty()) {
      answer.limits.emplace_back("forces that the program adds count as constant over each of its own steps");
    }
  }

  const AuditOptions& options_;
  std::optional<Progress> progress_;  // while runs are under way
  AuditScratch scratch_;
  std::vector<int> refinements_;
  double until_s_ = 0;
  double tried_until_s_ = 0;   // what is told of those tried
  double beside_until_s_ = 0;  // when they are ended
  std::vector<Run> runs_;      // two unchanged, those refined, the one moved, those tried, the one with numbers
  std::size_t done_ = 0;
};

}  // namespace

int run_audit(const AuditOptions& options) {
  const ResultFolder folder(folder_of(options));  // before the runs, which may take long
  Answer answer;
  Audit audit(options);
  if (const int signal = audit.run(answer)) {
    std::cerr << fmt::format("odeval: stopped by {}\n", ::strsignal(signal));
    return 128 + signal;
  }
  make_readable(answer);
  if (options.json) {
    std::cout << audit_json(answer) << std::flush;
  } else if (!options.quiet) {
    std::cout << audit_text(answer) << std::flush;  // its page, with figures, takes a moment
  }
  audit.write(answer);
  if (!options.json && !options.quiet) {
    std::cout << "\nwrote " << (folder_of(options) / "index.html").string() << "\n";
  }
  return answer.reason.empty() && !answer.diverged ? 0 : 1;
}

}  // namespace odeval::cli
