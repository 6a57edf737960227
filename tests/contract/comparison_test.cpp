// odeval compare tells of any one value in the files of results that is changed.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>

#include "output/comparison.hpp"
#include "output/file.hpp"
#include "output/number.hpp"
#include "tests/results.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using namespace odeval;
using namespace odeval::test;
using nlohmann::json;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// What a comparison says of two folders whose one file differs.
std::string difference(const std::filesystem::path& a, const std::filesystem::path& b) {
  const Comparison comparison = compare_folders(a, b);
  std::string names;
  for (const FileComparison& file : comparison.files) {
    if (file.sameness != Sameness::different) continue;
    for (const Difference& one : file.differences) names += one.metric + " ";
  }
  return names;
}

void visit(const json& part, const std::string& pointer, const std::function<void(const std::string&)>& at) {
  if (!part.is_structured() || part.empty()) return at(pointer);
  for (const auto& item : part.items()) visit(item.value(), pointer + "/" + item.key(), at);
}

/// One value of METHOD.json or one cell of the trace is another: the comparison names it.
void comparison_tells_of_each(const Results& results) {
  const test::TemporaryFolder folder;
  const std::filesystem::path& root = folder.path();
  const std::filesystem::path trace = results.scenario.name + "/m.csv", summary = results.scenario.name + "/m.json";
  for (const char* side : {"a", "b"}) {
    write_whole(root / side / trace, results.csv);
    write_whole(root / side / summary, results.summary);
  }
  CHECK_EQUAL(difference(root / "a", root / "b"), "");

  const json run = json::parse(results.summary);
  std::size_t blind = 0;
  const auto told = [&](const json& other, const std::string& way) {
    write_whole(root / "b" / summary, other.dump());
    return difference(root / "a", root / "b").find(way + " ") != std::string::npos;
  };
  visit(run, "", [&](const std::string& pointer) {
    json other = run;
    json& value = other[json::json_pointer(pointer)];
    const bool real = value.is_number_float();
    const double before = real ? value.get<double>() : 0;
    if (value.is_number()) {
      value = 1.5 * value.get<double>() + 1;
    } else if (value.is_boolean()) {
      value = !value.get<bool>();
    } else {
      value = value.is_null() ? json(1.25) : json("another");
    }
    std::string way = pointer.substr(1);
    std::ranges::replace(way, '/', '.');
    // What made the results is shown and not judged; that the reference is lost follows from its bound.
    const bool judged = !way.starts_with("versions.") && way != "reference" && way != "reference_lost_at";
    if (!judged) ++blind;
    test::report(told(other, way) == judged, __FILE__, __LINE__,
                 way + (judged ? ": a change is not told" : ": is judged, and should only be shown"));
    const bool setting = way.starts_with("settings.");
    if (!real || !judged || (before == 0 && !setting)) return;  // of 0 any uncertainty is more than twice as large
    // By its last bit a setting is another one, and what is measured the same.
    value = std::nextafter(before, infinity);
    test::report(told(other, way) == setting, __FILE__, __LINE__, way + ": by the last bit");
  });
  CHECK_EQUAL(blind, run["versions"].size() + 2);
  write_whole(root / "b" / summary, results.summary);

  const CsvColumns table = parse_csv(results.csv, "trace");
  const std::string header = results.csv.substr(0, results.csv.find('\n') + 1);
  const auto told_of_cell = [&](std::size_t column, double changed) {
    std::string text = header;
    for (std::size_t k = 0; k < table.columns[0].size(); ++k) {
      for (std::size_t c = 0; c < table.header.size(); ++c) {
        text += (c == 0 ? "" : ",") + number_text(c == column && k == 1 ? changed : table.columns[c][k]);
      }
      text += '\n';
    }
    write_whole(root / "b" / trace, text);
    return difference(root / "a", root / "b");
  };
  for (std::size_t column = 0; column < table.header.size(); ++column) {
    const std::string& name = table.header[column];
    const double cell = table.columns[column][1];
    // A millionth: what is measured may differ by a billionth, an angle by what the reference knows of it.
    const std::string names = told_of_cell(column, cell + 1e-6 * std::fmax(1, std::fabs(cell)));
    // Rows go together by their times: one at another time has no other.
    const std::string wanted = name == "t" ? "rows at the same times" : name + " from t = ";
    test::report(names.starts_with(wanted), __FILE__, __LINE__, name + ": a change is told as '" + names + "'");
    const bool exact = name == "t" || name == "contacts";
    test::report(told_of_cell(column, std::nextafter(cell, infinity)).empty() != exact, __FILE__, __LINE__,
                 name + ": by the last bit");
  }
}

}  // namespace

int main() {
  const std::vector<Override> settings{{"duration", "2", ""}, {"sample", "0.1", ""}};
  comparison_tells_of_each(results_of("wall_pendulum", settings, "ode-step-double"));
  comparison_tells_of_each(results_of("bouncing_ball", settings, "ode-step-double"));
  return verdict();
}
