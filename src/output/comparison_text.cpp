// A comparison as tables, and for programs.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "output/comparison_rules.hpp"
#include "output/table.hpp"

namespace odeval {
namespace {
using Json = nlohmann::ordered_json;
}  // namespace

std::string text_of(Sameness sameness) {
  switch (sameness) {
    case Sameness::bytes:
      return "same bytes";
    case Sameness::within:
      return "same within uncertainty";
    case Sameness::shown:
      return "shown, not judged";
    case Sameness::different:
      return "DIFFERENT";
    case Sameness::not_compared:
      break;
  }
  return "not compared";
}

std::string comparison_table(const Comparison& comparison, std::size_t most) {
  std::string text;
  if (!comparison.versions.empty()) {
    TextTable versions("lll", {"made by", "A", "B"});
    for (const VersionDifference& version : comparison.versions) versions.add({version.name, version.a, version.b});
    text += versions.text() + '\n';
  }
  TextTable files("lll", {"file", "A and B are", ""});
  for (const FileComparison& file : comparison.files) files.add({file.file, text_of(file.sameness), file.why});
  // Summaries first: they name the settings.
  TextTable differences("lllrrr", {"scenario", "method", "metric", "A", "B", "allowed"});
  std::size_t count = 0;
  for (const bool summaries : {true, false}) {
    for (const FileComparison& file : comparison.files) {
      if (file.sameness != Sameness::different || (place_of(file.file).kind == Kind::summary) != summaries) continue;
      for (const Difference& one : file.differences) {
        if (count++ < most) differences.add({one.scenario, one.method, one.metric, one.a, one.b, one.allowed});
      }
    }
  }
  text += files.text();
  if (count > 0) {
    text += fmt::format("\n{} of {} differences\n", std::min(most, count), count) + differences.text();
  }
  TextTable shown("llrr", {"table", "cell", "A", "B"});
  std::size_t cells = 0;
  for (const FileComparison& file : comparison.files) {
    if (file.sameness != Sameness::shown) continue;
    for (const Difference& one : file.differences) {
      if (cells++ < most) shown.add({file.file, one.metric, one.a, one.b});
    }
  }
  if (cells > 0) {
    text +=
        fmt::format("\n{} of {} cells of the report's tables, CPU times among them\n", std::min(most, cells), cells) +
        shown.text();
  }
  const auto of = [&](Sameness sameness) {
    return std::ranges::count(comparison.files, sameness, &FileComparison::sameness);
  };
  return text +
         fmt::format("\n{} files: {} same bytes, {} same within uncertainty, {} different, {} shown, {} not compared\n",
                     comparison.files.size(), of(Sameness::bytes), of(Sameness::within), of(Sameness::different),
                     of(Sameness::shown), of(Sameness::not_compared));
}

std::string comparison_json(const Comparison& comparison) {
  Json json = {{"same", !comparison.different()}, {"versions", Json::array()}, {"files", Json::array()}};
  for (const VersionDifference& version : comparison.versions) {
    json["versions"].push_back({{"name", version.name}, {"a", version.a}, {"b", version.b}});
  }
  for (const FileComparison& file : comparison.files) {
    Json differences = Json::array();
    for (const Difference& one : file.differences) {
      differences.push_back({{"scenario", one.scenario},
                             {"method", one.method},
                             {"metric", one.metric},
                             {"a", one.a},
                             {"b", one.b},
                             {"allowed", one.allowed}});
    }
    json["files"].push_back(
        {{"file", file.file}, {"verdict", text_of(file.sameness)}, {"why", file.why}, {"differences", differences}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace odeval
