// The table of quantities: sound in itself, and every row of it where users meet quantities: the list, the results of a
// run and of a sweep, and a file's tolerances.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <set>
#include <sstream>

#include "catalogue/evaluation.hpp"
#include "cli/commands.hpp"
#include "cli/settings.hpp"
#include "measure/metrics.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "output/summary.hpp"
#include "output/sweep_table.hpp"
#include "reference/providers.hpp"
#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using namespace odeval;
namespace fs = std::filesystem;

void the_table_is_sound() {
  std::set<std::string_view> names;
  std::size_t place = 0;
  for (const Quantity& row : quantities) {
    CHECK_EQUAL(static_cast<std::size_t>(row.id), place++);
    CHECK(names.insert(row.name).second);
    CHECK(quantity_named(row.name) == &row);
    CHECK(!row.unit.empty() && !row.meaning.empty());
  }
  CHECK_EQUAL(place, static_cast<std::size_t>(quantity::count));
  CHECK(quantity_named("max_gape") == nullptr && quantity_named("") == nullptr);
}

// What bounds an error is of the reference and has the error's unit; and what is of the reference bounds something.
void bounds_have_the_units_of_their_errors() {
  for (const Quantity& row : quantities) {
    if (row.uncertainty) {
      const Quantity& bound = quantities[*row.uncertainty];
      CHECK_EQUAL(bound.unit, row.unit);
      CHECK(bound.scope == Scope::reference && !bound.uncertainty);
    }
    const auto bounded = [&](const Quantity& other) { return other.uncertainty == row.id; };
    CHECK_EQUAL(row.scope == Scope::reference, std::ranges::any_of(quantities, bounded));
    if (row.scope == Scope::reference) CHECK(row.direction == Direction::neither);
  }
}

/// What the program says on standard output.
std::string said(const std::vector<std::string>& words) {
  std::ostringstream text;
  std::streambuf* const before = std::cout.rdbuf(text.rdbuf());
  cli::CommandLine().read(words)();
  std::cout.rdbuf(before);
  return text.str();
}

std::vector<std::string> words_of(std::string text, char between) {
  std::ranges::replace(text, between, ' ');
  std::istringstream words(text);
  return {std::istream_iterator<std::string>(words), {}};
}

std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const Quantity& row : quantities) names.emplace_back(row.name);
  return names;
}

bool holds_all(const std::vector<std::string>& names) {
  return !std::ranges::search(names, all_names()).empty();  // in the table's order, without gaps
}

void every_quantity_is_listed() {
  CHECK(words_of(said({"list", "--names", "metrics"}), '\n') == all_names());
  const std::string list = said({"list", "metrics"});
  for (const Quantity& row : quantities) {
    CHECK(list.find(std::string(row.meaning) + ", " + std::string(row.unit) + "\n") != std::string::npos);
  }
}

void every_quantity_is_in_results() {
  const std::string summary = summary_csv({});
  CHECK(holds_all(words_of(summary.substr(0, summary.find('\n')), ',')));
  CHECK(holds_all(result_columns()));
}

// A file may limit each, and it is that one which is judged.
void every_quantity_may_be_limited(const fs::path& folder) {
  const fs::path file = folder / "limited.toml";
  fs::copy_file(fs::path(ODEVAL_SOURCE_DIR) / "scenarios/double_pendulum.toml", file);
  std::ofstream text(file, std::ios::app);
  for (const Quantity& row : quantities) {
    text << "\n[[tolerances]]\nmethod = \"lagrange-rk4\"\nmetric = \"" << row.name << "\"\nuntil = 1\nat_most = 2\n";
  }
  text.close();
  const std::vector<Tolerance> all = read_scenario(file, {}, cli::known_names()).tolerances;
  CHECK(all.size() >= quantity::count);
  for (const Quantity& row : quantities) {
    const Tolerance& tolerance = all.at(all.size() - quantity::count + row.id);
    Metrics metrics;
    metrics[row.id] = 1;
    CHECK(judge(tolerance, metrics) == Judgement::kept);
    metrics[row.id] = 3;
    CHECK(judge(tolerance, metrics) == Judgement::failed);
    if (!row.uncertainty) continue;
    metrics[*row.uncertainty] = 1.5;
    CHECK(judge(tolerance, metrics) == Judgement::undecided);
  }
}

// Each has a value in some run: of links that get lost and that strike a wall, of boxes in flight, sliding to rest and
// on a spring, of a mechanism with works.
void every_quantity_is_taken() {
  std::set<quantity::Id> taken;
  std::vector<const char*> names{"double_pendulum", "wall_pendulum", "thin_body", "friction_slide", "spring_joint"};
  if (reference::mechanism_cvode != nullptr) {
    names.push_back("cart_pole");
  } else {
    taken.insert(quantity::max_unaccounted_energy);
  }
  for (const char* name : names) {
    const fs::path file = fs::path(ODEVAL_SOURCE_DIR) / "scenarios" / (std::string(name) + ".toml");
    catalogue::Evaluator evaluator(read_scenario(file, {{"step", "0.005", "--set"}}, cli::known_names()));
    const auto run = evaluator.evaluate(catalogue::find_method("ode-step-double"));
    for (const double until_s : {1.0, evaluator.scenario().duration_s}) {
      const Metrics metrics = evaluator.measure(run, until_s);
      for (const Quantity& row : quantities) {
        if (metrics[row.id]) taken.insert(row.id);
      }
    }
  }
  for (const Quantity& row : quantities) {
    if (!taken.contains(row.id)) std::printf("%s is never taken\n", std::string(row.name).c_str());
  }
  CHECK_EQUAL(taken.size(), static_cast<std::size_t>(quantity::count));
}

}  // namespace

int main() {
  const test::TemporaryFolder folder;
  const std::string name = folder.path().string();
  the_table_is_sound();
  bounds_have_the_units_of_their_errors();
  every_quantity_is_listed();
  every_quantity_is_in_results();
  every_quantity_may_be_limited(name);
  every_quantity_is_taken();
  return test::verdict();
}
