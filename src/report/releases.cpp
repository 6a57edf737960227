#include "report/releases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>

#include "odeval/error.hpp"
#include "odeval/quantity.hpp"
#include "output/comparison.hpp"
#include "report/prose.hpp"
#include "report/sections.hpp"

namespace odeval::report {
namespace {

namespace fs = std::filesystem;

constexpr const char* version_name = "ode_double";

/// "0.16.2" of "0.16.2 double (ode 2:0.16.2-1; ...)"
std::string release_of(const std::string& version) { return version.substr(0, version.find(' ')); }

/// A run's summary and trace, which are compared by themselves.
struct Run {
  const FileComparison* summary = nullptr;
  const FileComparison* trace = nullptr;

  bool in_both() const {
    return std::ranges::none_of(std::array{summary, trace}, [](const FileComparison* file) {
      return file != nullptr && !file->differences.empty() && file->differences.front().metric == "file";
    });
  }
  Sameness sameness() const {
    const auto worse = [](Sameness a, Sameness b) {
      if (a == Sameness::different || b == Sameness::different) return Sameness::different;
      return a == Sameness::within || b == Sameness::within ? Sameness::within : Sameness::bytes;
    };
    const Sameness of_trace = trace == nullptr ? Sameness::bytes : trace->sameness;
    return summary == nullptr ? of_trace : worse(summary->sameness, of_trace);
  }
};

/// The first of the run's numbers that differs; without one the first setting, word or column.
const Difference* told(const Run& run) {
  const Difference* first = nullptr;
  for (const FileComparison* const file : {run.summary, run.trace}) {
    if (file == nullptr || file->sameness != Sameness::different) continue;
    for (const Difference& one : file->differences) {
      if (quantity_named(one.metric) != nullptr) return &one;
      if (first == nullptr) first = &one;
    }
  }
  return first;
}

/// By scenario and method, of files SCENARIO/METHOD.json and .csv.
std::map<std::pair<std::string, std::string>, Run> runs_of(const Comparison& comparison) {
  std::map<std::pair<std::string, std::string>, Run> runs;
  for (const FileComparison& file : comparison.files) {
    const fs::path path(file.file);
    const std::string scenario = path.parent_path().string();
    const std::string stem = path.stem().string();
    const bool of_a_run = !scenario.empty() && !path.parent_path().has_parent_path() && scenario != "report" &&
                          scenario != "sweep" && scenario != "recommend" && scenario != "audit" && stem != "summary";
    if (!of_a_run) continue;
    if (path.extension() == ".json") runs[{scenario, stem}].summary = &file;
    if (path.extension() == ".csv") runs[{scenario, stem}].trace = &file;
  }
  return runs;
}

/// A number is shown as all others are; the table's CSV has all its digits.
Cell number_or_word(const std::string& text) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && read == end ? Cell(number) : Cell(text);
}

Table table_of(const std::map<std::pair<std::string, std::string>, Run>& runs) {
  Table table{.name = "releases",
              .columns = {"scenario", "method", "both are", "what differs first", "here", "there", "allowed",
                          "angles in the traces"}};
  for (const Sameness sameness : {Sameness::different, Sameness::within, Sameness::bytes}) {
    for (const auto& [name, run] : runs) {
      if (run.sameness() != sameness) continue;
      const Difference* const difference = told(run);
      const auto text = [&](std::string Difference::*part) {
        return difference == nullptr ? Cell(std::string("-")) : number_or_word(difference->*part);
      };
      const bool has_trace = run.trace != nullptr && run.trace->sameness != Sameness::bytes;
      table.rows.push_back({name.first, name.second,
                            std::string(sameness == Sameness::different ? "different" : text_of(sameness)),
                            text(&Difference::metric), text(&Difference::a), text(&Difference::b),
                            text(&Difference::allowed), has_trace ? run.trace->why : std::string("-")});
    }
  }
  return table;
}

}  // namespace

void require_other_release(const fs::path& other, const std::string& here) {
  const std::string there = version_of(other, version_name);
  if (release_of(there) != release_of(here)) return;
  throw UserError(
      fmt::format("--releases {}: holds results of ODE {}, which is this build's own release; another build's "
                  "are wanted (src/engines/ode/README.md)",
                  other.string(), release_of(there)));
}

Section releases_section(const fs::path& own, const std::optional<fs::path>& other, const std::string& here) {
  Content content;
  content.values = {{"here", release_of(here)},
                    {"other", ""},
                    {"there", ""},
                    {"folder", ""},
                    {"runs", 0},
                    {"same", 0},
                    {"within", 0},
                    {"different", 0},
                    {"alone", 0},
                    {"release", ""}};
  const auto set = [&](const char* name, Value value) { content.values.insert_or_assign(name, std::move(value)); };
  if (other) {
    const Comparison comparison = compare_folders(own, *other);
    auto runs = runs_of(comparison);
    set("alone", std::erase_if(runs, [](const auto& run) { return !run.second.in_both(); }));
    const auto of = [&](Sameness sameness) {
      return std::ranges::count_if(runs, [&](const auto& run) { return run.second.sameness() == sameness; });
    };
    set("other", "yes");
    set("there", release_of(version_of(*other, version_name)));
    set("folder", other->string());
    set("runs", runs.size());
    set("same", of(Sameness::bytes));
    set("within", of(Sameness::within));
    set("different", of(Sameness::different));
    content.exhibits.emplace_back(table_of(runs));
  } else {
    set("release", here.starts_with("0.16.2") ? "trixie" : "bookworm");
  }
  return section_of("releases", page_layout("releases"), std::move(content));
}

}  // namespace odeval::report
