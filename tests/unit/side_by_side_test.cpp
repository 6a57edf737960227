// Experiments in processes of their own: what they leave arrives whole and in order, and one that fails says so.
#include "experiments/side_by_side.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "odeval/error.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using experiments::Experiment;
using experiments::Laboratory;

constexpr const char* everything_said = R"(# All

words

[table table] A table
n

[figure figure] A figure
caption

[picture p] t
c
)";

/// One of every kind of block, cell and optional part.
report::Content everything(Laboratory&, report::Findings& findings) {
  findings.add("a.number", {"what it means", "m", 0.1, 1e-3, ""});
  findings.add("b.missing", {"what it would mean", "", std::nullopt, 0, "why there is none"});
  const report::Table table{
      .name = "table", .columns = {"x", "y"}, .rows = {{1.5, std::string("text")}, {report::Missing{"why"}, -0.0}}};
  report::Panel panel{.x_label = "t, s", .y_label = "y", .log_y = true};
  panel.series = {{"a", {1, 2}, {3, NAN}, report::Mark::points, 4, true}, {"b", {}, {}}};
  panel.shade = report::Shade{0.5, "because"};
  panel.y_range = {{-1, 1}};
  const report::Figure figure{.name = "figure", .panels = {panel, {}}, .columns = 2};
  return {{}, {table, figure, report::Picture{.name = "p", .png = {"\0png", 4}}}};
}

report::Content fails(Laboratory&, report::Findings&) { throw MachineError("the disk is full"); }
report::Content is_wrong(Laboratory&, report::Findings&) { throw UserError("no scenario named 'x'"); }
report::Content dies(Laboratory&, report::Findings&) { _exit(3); }
report::Content hangs(Laboratory&, report::Findings&) {
  for (;;) ::pause();
}
report::Content is_long(Laboratory&, report::Findings&) {
  return {{{"words", std::string(1'000'000, 'x')}}, {}};  // more than a pipe holds
}

constexpr Experiment some[] = {
    {"fails", "# One that fails\n", fails},      {"everything", everything_said, everything},
    {"dies", "# One that dies\n", dies},         {"long", "# Long\n\n{{words}}\n", is_long},
    {"everything", everything_said, everything}, {"is_wrong", "# One that is wrong\n", is_wrong},
};

std::string words(const report::Outcome& outcome) { return std::get<report::Text>(outcome.section.blocks.at(0)).text; }

Laboratory no_laboratory() {
  return Laboratory([](const std::string&) -> Scenario { throw std::logic_error("no scenario is asked for"); });
}

void check(unsigned processes) {
  Laboratory laboratory = no_laboratory();
  std::size_t finished = 0;
  const auto outcomes =
      experiments::run_side_by_side(some, laboratory, processes, [&](const Experiment&) { ++finished; });
  CHECK_EQUAL(outcomes.size(), std::size(some));

  CHECK_EQUAL(outcomes[0].section.title, "One that fails");
  CHECK(words(outcomes[0]).ends_with("its numbers are missing: the disk is full"));
  CHECK_EQUAL(outcomes[0].failures.at(0), "fails: the disk is full");
  CHECK_EQUAL(outcomes[2].failures.at(0), "dies: its process ended with exit status 3");
  CHECK_EQUAL(outcomes[5].failures.at(0), "is_wrong: no scenario named 'x'");
  CHECK_EQUAL(finished, std::size(some));
  CHECK_EQUAL(words(outcomes[3]).size(), 1'000'000U);

  // What arrives is what was made here, to the last bit.
  report::Findings findings;
  report::Outcome own;
  own.section = section_of(some[1], laboratory, findings);
  for (const auto& finding : findings.all()) own.findings.emplace_back(finding);
  CHECK(report::outcome_bytes(outcomes[1]) == report::outcome_bytes(own));
  CHECK(report::outcome_bytes(outcomes[4]) == report::outcome_bytes(own));
  const auto& table = std::get<report::Table>(outcomes[1].section.blocks.at(1));
  CHECK_EQUAL(std::get<report::Missing>(table.rows.at(1).at(0)).why, "why");
  CHECK(std::signbit(std::get<double>(table.rows.at(1).at(1))));
  const auto& figure = std::get<report::Figure>(outcomes[1].section.blocks.at(2));
  CHECK_EQUAL(figure.panels.at(0).shade->why, "because");
  CHECK(!figure.panels.at(1).shade && !figure.panels.at(1).y_range);
  CHECK_EQUAL(figure.panels.at(0).y_range->second, 1.0);
  CHECK_EQUAL(std::get<report::Picture>(outcomes[1].section.blocks.at(3)).png.size(), 4U);
  CHECK(!outcomes[1].findings.at(1).second.value);
}

// The program ends as a signal ends any program, though one of the experiments hangs.
void stopped() {
  constexpr Experiment few[] = {{"fails", "# One that fails\n", fails}, {"hangs", "# One that hangs\n", hangs}};
  const pid_t child = ::fork();
  if (child == 0) {
    Laboratory laboratory = no_laboratory();
    experiments::run_side_by_side(few, laboratory, 1, [](const Experiment&) { ::raise(SIGTERM); });
    ::_exit(0);
  }
  int status = 0;
  CHECK_EQUAL(::waitpid(child, &status, 0), child);
  CHECK(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
}

}  // namespace

int main() {
  check(1);
  check(2);
  check(3);
  stopped();
  return odeval::test::verdict();
}
