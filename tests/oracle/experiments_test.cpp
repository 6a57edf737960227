// Every experiment of the page: what it leaves is whole, and the numbers that claims are judged by are those that were
// measured.
//
//   experiments_test --page OUT RELEASES   makes the page as `odeval report --out OUT --releases RELEASES` does and
//                                          checks what it is made of; tests/cli/report checks the page itself
//   experiments_test NAME                  one experiment, in this process
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "catalogue/evaluation.hpp"
#include "catalogue/paths.hpp"
#include "cli/report.hpp"
#include "experiments/experiment.hpp"
#include "experiments/highlights.hpp"
#include "experiments/parts.hpp"
#include "experiments/should_i_switch.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/metrics.hpp"
#include "report/claims.hpp"
#include "report/template.hpp"
#include "tests/check.hpp"
#include "tests/oracle/bands.hpp"
#include "tests/planar.hpp"
#include "tests/scenarios.hpp"

using namespace odeval;
using experiments::Experiment;
using experiments::Laboratory;
using report::Finding;
using report::Findings;
using test::Band;
using test::bands;
using test::units;

namespace {

Names known_names() {
  Names names;
  names.methods = catalogue::method_names();
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  return names;
}

struct Page {
  std::vector<report::Section> sections;
  Findings findings;
};

Page run_one(std::string_view name) {
  Laboratory laboratory([](const std::string& scenario) {
    return read_scenario(find_scenario(scenario, catalogue::scenario_folder()), {}, known_names());
  });
  Page page;
  for (const Experiment& experiment : experiments::experiments()) {
    if (experiment.name != name) continue;
    const double start = catalogue::cpu_seconds();
    try {
      page.sections.push_back(section_of(experiment, laboratory, page.findings));
    } catch (const std::logic_error& error) {  // template and experiment do not fit
      test::report(false, __FILE__, __LINE__, error.what());
      continue;
    }
    std::printf("%-20s %5.2f s\n", std::string(experiment.name).c_str(), catalogue::cpu_seconds() - start);
  }
  return page;
}

void print(const Findings& findings) {
  for (const auto& [name, finding] : findings.all()) {
    std::printf("%-28s %.6g +- %.2g %s\n", name.c_str(), finding.value.value_or(NAN), finding.uncertainty,
                finding.unit.c_str());
  }
}

void check_new(std::set<std::string>& taken, const std::string& name) {
  CHECK(!name.empty());
  if (!taken.insert(name).second) test::report(false, __FILE__, __LINE__, "two parts of the page are called " + name);
}

void check_panel(const std::string& figure, const report::Panel& panel) {
  const auto fail = [&](const std::string& why) { test::report(false, __FILE__, __LINE__, figure + ": " + why); };
  if (panel.series.empty()) fail("a panel without a series");
  if (panel.x_label.empty() || panel.y_label.empty()) fail("an axis without a label");
  if (panel.shade && panel.shade->why.empty()) fail("a shade without a reason");
  for (const report::Series& series : panel.series) {
    // A law beside what was measured has its colour, and no label of its own.
    const auto named = [&](const report::Series& other) {
      return other.colour == series.colour && !other.label.empty();
    };
    if (std::ranges::none_of(panel.series, named)) fail("a series without a label");
    if (series.x.size() != series.y.size()) fail(series.label + ": x and y of unlike length");
    bool drawn = false;
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      drawn = drawn || (std::isfinite(series.x[i]) && std::isfinite(series.y[i]) && (!panel.log_x || series.x[i] > 0) &&
                        (!panel.log_y || series.y[i] > 0));
    }
    if (!drawn) fail(series.label + ": no point that can be drawn");
  }
}

void check_table(const report::Table& table) {
  if (table.rows.empty()) test::report(false, __FILE__, __LINE__, table.name + ": no rows");
  for (const std::string& heading : table.columns) {  // ± is what the reference may be off by
    if (heading == "± ms" || heading == "± ns" || (heading.starts_with("± (") && heading != "± (shift)")) {
      test::report(false, __FILE__, __LINE__, table.name + ": " + heading + " is not the reference's");
    }
  }
  for (const auto& row : table.rows) {
    if (row.size() != table.columns.size()) {
      test::report(false, __FILE__, __LINE__, table.name + ": a row of " + std::to_string(row.size()) + " cells");
    }
    for (const report::Cell& cell : row) {
      if (const double* number = std::get_if<double>(&cell); number && !std::isfinite(*number)) {
        test::report(false, __FILE__, __LINE__, table.name + ": a number that is not finite and does not say why");
      }
    }
  }
}

/// Plots over time where no shade is due, and why. Everywhere else the time from which the plot tells nothing is
/// shaded.
const std::map<std::string, std::string, std::less<>> unshaded{
    {"fig-5-14", "its last two panels are the reference's own sensitivities, known to the end"},
    {"fig-6-4", "25 steps about the first contact"},
    {"orientation-figure", "the motion is known in closed form"},
    {"single-pendulum-errors", "dWorldStep is never lost on it"},
    {"half-step-energy-figure", "of its motions one is never lost"},
    {"fig-6-3", "no method is lost in its 5 s"},
    {"remedy-errors", "on the wall pendulum no method is lost in its 5 s"},
    {"feedback-gap", "maximal-rk4 is never lost"},
    {"potra-figure", "dWorldStep is not lost in its 2.5 s"},
    {"spring-joint-figure", "a damped motion forgets its errors"},
    {"motor-lift-figure", "the motion is known in closed form"},
};

void check_shades(const report::Figure& figure) {
  const auto excused = unshaded.find(figure.name);
  bool missing = false;
  for (const report::Panel& panel : figure.panels) missing |= panel.x_label.starts_with("t, s") && !panel.shade;
  if (missing == (excused != unshaded.end())) return;
  test::report(false, __FILE__, __LINE__,
               figure.name + (missing ? ": a plot over time without a shade" : ": is excused from shades it has"));
}

void check_parts(const Page& page) {
  std::set<std::string> taken;
  for (const report::Section& section : page.sections) {
    CHECK(!section.blocks.empty());
    for (const report::Block& block : section.blocks) {
      if (const auto* table = std::get_if<report::Table>(&block)) check_table(*table);
      if (const auto* figure = std::get_if<report::Figure>(&block)) {
        check_new(taken, figure->name);
        CHECK(!figure->panels.empty());
        check_shades(*figure);
        for (const report::Panel& panel : figure->panels) check_panel(figure->name, panel);
      }
    }
  }
  std::set<std::string> tables;  // names of files
  for (const report::Section& section : page.sections) {
    for (const report::Block& block : section.blocks) {
      if (const auto* table = std::get_if<report::Table>(&block)) check_new(tables, table->name);
    }
  }
  std::set<std::string> sections;
  for (const report::Section& section : page.sections) check_new(sections, section.name);
}

/// A build without single precision or without the reference of trees lacks some numbers, and has to say so.
bool is_complete() { return test::in_this_build("ode-step-single") && test::in_this_build("mechanism-cvode"); }

/// Claims whose evidence is a section of the table have all their numbers.
void check_claims(const Page& page) {
  const bool complete = is_complete();
  for (const report::Claim& claim : report::claims()) {
    const auto shown = [&](const report::Section& section) { return section.name == claim.evidence; };
    if (std::ranges::none_of(page.sections, shown)) continue;
    for (const auto& conditions : {claim.confirmed_if, claim.refuted_if}) {
      for (const report::Condition& condition : conditions) {
        const Finding* const finding = page.findings.find(condition.finding);
        const bool measured = finding != nullptr && finding->value && std::isfinite(*finding->value) &&
                              std::isfinite(finding->uncertainty) && finding->uncertainty >= 0;
        const bool excused = !complete && finding != nullptr && !finding->value && !finding->missing.empty();
        if (!measured && !excused) {
          test::report(false, __FILE__, __LINE__, std::string(condition.finding) + " was not measured");
        }
      }
    }
  }
  for (const auto& [name, finding] : page.findings.all()) {
    if (finding.meaning.empty()) test::report(false, __FILE__, __LINE__, name + " does not say what it is");
  }
}

/// All bands, or those of an experiment by itself.
void check_numbers(const Page& page, bool all) {
  const bool complete = is_complete();
  for (const Band& band : bands) {
    const Finding* const finding = page.findings.find(band.finding);
    if (!all && finding == nullptr) continue;
    const double value = finding != nullptr ? finding->value.value_or(NAN) : NAN;
    if (!complete && finding != nullptr && !finding->value) continue;
    if (!(value >= band.low && value <= band.high)) {
      test::report(false, __FILE__, __LINE__,
                   std::string(band.finding) + " = " + test::shown(value) + ", expected " + test::shown(band.low) +
                       " to " + test::shown(band.high));
    }
  }
}

/// A finding's name as a sentence has it.
std::string in_template(std::string_view name) {
  std::string out(name);
  std::ranges::replace_if(
      out, [](char letter) { return letter == '.' || letter == '-'; }, '_');
  return out;
}

/// The findings that a sentence names.
std::set<std::string> names_of(std::string_view sentence) {
  constexpr std::string_view as_percent = "_percent";
  std::set<std::string> names;
  for (std::string name : report::names_in(sentence)) {
    if (name.ends_with(as_percent)) name.resize(name.size() - as_percent.size());
    names.insert(std::move(name));
  }
  return names;
}

/// Each number of the sentences that everybody reads has a band: a wrong row, sign or time of one is seen.
void check_every_number_said_has_a_band() {
  for (const auto& rows : {experiments::highlights(), experiments::box_sentences()}) {
    for (const experiments::Row& row : rows) {
      for (const std::string& name : names_of(row.sentence)) {
        const bool held =
            std::ranges::any_of(bands, [&](const Band& band) { return in_template(band.finding) == name; });
        if (!held) CHECK_EQUAL(name, "a number with a band");
      }
    }
  }
}

/// Of a number in a sentence the unit is that one, or none.
void check_units(const Page& page) {
  std::set<std::string> said;
  for (const auto& rows : {experiments::highlights(), experiments::box_sentences()}) {
    for (const experiments::Row& row : rows) said.merge(names_of(row.sentence));
  }
  for (const auto& [name, finding] : page.findings.all()) {
    if (!said.contains(in_template(name))) continue;
    const auto* const known = std::ranges::find(units, name, &std::pair<std::string_view, std::string_view>::first);
    CHECK_EQUAL(name + ", " + finding.unit, name + ", " + std::string(known == std::end(units) ? "" : known->second));
  }
}

const report::Table* table_of(const Page& page, std::string_view name) {
  for (const report::Section& section : page.sections) {
    for (const report::Block& block : section.blocks) {
      const auto* const table = std::get_if<report::Table>(&block);
      if (table != nullptr && table->name == name) return table;
    }
  }
  return nullptr;
}

/// What stands behind a flag of a command; empty: it is not there.
std::string flag_of(const std::string& command, const std::string& flag) {
  const std::size_t at = command.find(" " + flag + " ");
  if (at == std::string::npos) return "";
  const std::size_t from = at + flag.size() + 2;
  return command.substr(from, command.find(' ', from) - from);
}

/// What is wrong with a row of the table of settings beside the run that proves it; empty: nothing.
std::string wrong_beside_proof(const std::vector<report::Cell>& row, const std::vector<report::Cell>& proof) {
  const auto& command = std::get<std::string>(proof.at(2));
  const auto same = [](double a, double b) { return std::fabs(a - b) <= 1e-9 * std::fabs(b); };  // but for rounding
  if (!same(std::get<double>(row.at(1)), 1e3 * std::stod(flag_of(command, "--step")))) return "step";
  if (const auto* const erp = std::get_if<double>(&row.at(2))) {
    const std::string flag = flag_of(command, "--erp");
    if (!same(*erp, flag.empty() ? OdeSettings{}.erp : std::stod(flag))) return "ERP";
  }
  const bool early = std::get<std::string>(row.at(4)).find("half-step start") != std::string::npos;
  if (flag_of(command, "--start") != (early ? "half-step" : "")) return "start";
  if (!std::get<std::string>(row.at(6)).ends_with(", " + flag_of(command, "--duration") + " s")) return "time";
  // In milliradians or millimetres here, in radians or metres there.
  if (!same(std::get<double>(row.at(7)), 1e3 * std::get<double>(proof.at(4)))) return "error";
  return "";
}

/// The settings and the error in the table are those of the run that proves them, row by row.
void check_answers(const Page& page) {
  const report::Table* const answers = table_of(page, "answer");
  const report::Table* const proofs = table_of(page, "answer-proofs");
  if (answers == nullptr || proofs == nullptr) return;
  for (const auto& row : answers->rows) {
    const auto& task = std::get<std::string>(row.at(0));
    const auto proof = std::ranges::find_if(proofs->rows, [&](const auto& one) {
      return std::get<std::string>(one.at(0)) == task && std::get<std::string>(one.at(1)) == "ODE's best";
    });
    const bool keeps = std::holds_alternative<double>(row.at(1));
    CHECK_EQUAL(proof != proofs->rows.end(), keeps);
    if (keeps && proof != proofs->rows.end()) CHECK_EQUAL(task + ": " + wrong_beside_proof(row, *proof), task + ": ");
  }
}

/// A number of another row, unit or time is seen.
void check_wrong_answers_are_seen() {
  const std::vector<report::Cell> row{"an arm", 2.0, 0.8, 1e-10, "half-step start", "-", "1 mrad, 2 s", 0.753};
  const std::vector<report::Cell> proof{
      "an arm", "ODE's best", "odeval run x --duration 2 --step 0.002 --erp 0.8 --start half-step --out proofs/arm",
      "max_error_q", 0.000753};
  CHECK_EQUAL(wrong_beside_proof(row, proof), "");
  const auto with = [&](std::size_t column, report::Cell cell) {
    std::vector<report::Cell> changed = row;
    changed[column] = std::move(cell);
    return wrong_beside_proof(changed, proof);
  };
  CHECK_EQUAL(with(1, 0.002), "step");
  CHECK_EQUAL(with(2, 0.2), "ERP");
  CHECK_EQUAL(with(4, "-"), "start");
  CHECK_EQUAL(with(6, "1 mrad, 1 s"), "time");
  CHECK_EQUAL(with(7, 0.000753), "error");
}

// Which no band notices: exponents and ratios forgive another chain.
void check_chain_of() {
  Scenario file = test::report_scenario("chain", 5, 1e-3);
  file.planar = test::make_planar(file.planar->frame, {{3, 1, 0.1, 0.1}}, {0.5, -0.25}, {});
  const Scenario chain = experiments::chain_of(file, 4, 1);
  const PlanarView& view = *chain.planar;
  CHECK_EQUAL(chain.mechanism.bodies.size(), 4u);
  CHECK_EQUAL(view.links.size(), 4u);
  CHECK_EQUAL(view.links[3].mass_kg, 3.0);
  CHECK(view.q0 == std::vector<double>({0.5, -0.25, 0, 0}));
  CHECK(view.qd0 == std::vector<double>(4, 0.0));
  CHECK_EQUAL(chain.duration_s, 1.0);
  CHECK_EQUAL(chain.sample_s.value(), 0.02);
}

// What four templates say of a build without single precision, and of no other.
void check_left_out() {
  CHECK_EQUAL(experiments::left_out({"ode-step-double"}), "");
  for (const catalogue::Method& method : catalogue::methods()) {
    if (method.make != nullptr) continue;
    CHECK_EQUAL(experiments::left_out({"ode-step-double", std::string(method.name)}),
                fmt::format("{} ({})", method.name, method.why_missing));
  }
}

// Of ODE as it is, of it with a setting changed, and of an engine, on two motions. On the second ODE as it is keeps the
// error at no step: 8 s at its finest are a lower bound. The setting makes the same run of the first, whatever it took.
void check_advice() {
  using namespace experiments::engines;
  const catalogue::Method& ode = catalogue::find_method("ode-step-double");
  const catalogue::Method& other = catalogue::find_method("lagrange-rk4");
  const std::vector<Way> ways{{&ode, Move::stay, "", nullptr},
                              {&ode, Move::change_a_setting, "friction along the slide", nullptr},
                              {&other, Move::leave, "", nullptr}};
  const auto tried = [](double setting, double error, bool keeps, double us_per_s) {
    Tried one;
    one.setting = setting;
    one.error.error = error;
    one.keeps = keeps;
    one.us_per_s = us_per_s;
    return one;
  };
  const std::vector<Result> results{
      {ways, {tried(0.02, 0.5, true, 3), tried(0.02, 0.5, true, 2), tried(0.01, 0.25, true, 1)}},
      {ways, {tried(0.0002, 7, false, 8), tried(0.02, 0.5, true, 0.5), tried(0.01, 0.25, true, 2)}}};
  const Advice advice = advice_of(results).value();
  CHECK(advice.move == Move::change_a_setting);
  CHECK_NEAR(advice.factor, 4, 1e-12);  // of 1 and 16; rounding of a few logarithms
  CHECK_EQUAL(gain_of(advice),
              "at least 4 times less CPU time (ODE as it is keeps the error at no step on 1 of 2 motions)");
  CHECK_EQUAL(spread_of(advice), "1 to at least 16");
  const Advice engine = best_of(results).at(Move::leave);
  CHECK_EQUAL(engine.method, "lagrange-rk4");
  CHECK_NEAR(engine.factor, std::sqrt(12.0), 1e-12);  // of 3 and 4
  CHECK_EQUAL(best_of(std::span(results).first(1)).at(Move::leave).bounds, 0U);
}

/// What everybody reads is all there: a sentence whose numbers or plot went missing leaves the page in silence. One
/// sentence of the answer and one of those in short are about single precision, one of the answer about trees.
void check_front(const std::vector<report::Section>& front) {
  const std::ptrdiff_t trees = test::in_this_build("mechanism-cvode") ? 1 : 0;
  const std::ptrdiff_t missing = test::in_this_build("ode-step-single") ? 0 : 1;
  const auto count = [](const report::Section& section, auto is) { return std::ranges::count_if(section.blocks, is); };
  CHECK_EQUAL(
      count(front.at(0), [](const report::Block& block) { return std::holds_alternative<report::Text>(block); }),
      4 + trees - missing);
  std::set<std::string_view> figures;  // of the sentences for one figure one holds
  for (const experiments::Row& row : experiments::highlights()) figures.insert(row.figure);
  CHECK_EQUAL(
      count(front.at(2), [](const report::Block& block) { return std::holds_alternative<report::Highlight>(block); }),
      static_cast<std::ptrdiff_t>(figures.size()) - missing);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 4 && std::string_view(argv[1]) == "--page") {
    const auto check = [](const report::Document& document, const Findings& findings) {
      Page page{document.sections, findings};
      page.sections.push_back(document.front.at(0));  // the answer, whose evidence is a section of its own
      CHECK_EQUAL(page.sections.size(), experiments::experiments().size() + 2);  // and that of the releases
      print(findings);
      check_parts(page);
      check_claims(page);
      check_numbers(page, true);
      check_units(page);
      check_answers(page);
      check_front(document.front);
    };
    CHECK_EQUAL(cli::report({.out = argv[2], .releases = argv[3]}, check), 0);
  } else if (argc == 2) {
    const Page page = run_one(argv[1]);
    CHECK_EQUAL(page.sections.size(), 1u);
    print(page.findings);
    check_parts(page);
    check_numbers(page, false);
    check_units(page);
    check_answers(page);
  } else {
    std::fputs("usage: experiments_test --page OUT RELEASES | NAME\n", stderr);
    return 2;
  }
  check_every_number_said_has_a_band();
  check_wrong_answers_are_seen();
  check_chain_of();
  check_left_out();
  check_advice();
  return test::verdict();
}
