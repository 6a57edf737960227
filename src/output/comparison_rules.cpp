#include "output/comparison_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "odeval/error.hpp"
#include "output/number.hpp"
#include "output/table.hpp"

namespace odeval {
namespace {

using Json = nlohmann::ordered_json;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// An angle's own rounding, beside the bound on the motion.
constexpr double angle_rounding = 1e-12;

double rounding(double a, double b) { return 1e-9 * std::max({1.0, std::fabs(a), std::fabs(b)}); }

/// Equal values, infinite ones and NaN included, or such as differ by no more than `allowed`.
bool same(double a, double b, double allowed) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return true;
  return std::fabs(a - b) <= allowed;
}

std::string allowed_text(double allowed) { return allowed == 0 ? "equal" : three_digits(allowed); }

/// The numbers and words of an object by the way that leads to them: "error_at.3.max_error_q", "impacts.0.t".
using Leaves = std::vector<std::pair<std::string, Json>>;

void add_leaves(Leaves& leaves, const std::string& way, const Json& json) {
  if (json.is_structured() && !json.empty()) {
    for (const auto& part : json.items()) {
      add_leaves(leaves, way.empty() ? part.key() : way + '.' + part.key(), part.value());
    }
  } else {
    leaves.emplace_back(way, json);
  }
}

Leaves leaves_of(const Json& json) {
  Leaves leaves;
  add_leaves(leaves, "", json);
  return leaves;
}

const Json* find(const Leaves& leaves, const std::string& way) {
  const auto found = std::ranges::find(leaves, way, &Leaves::value_type::first);
  return found == leaves.end() ? nullptr : &found->second;
}

/// A finite or infinite number; infinite ones are strings in JSON.
std::optional<double> number(const Json* json) {
  if (json == nullptr) return std::nullopt;
  if (json->is_number()) return json->get<double>();
  if (*json == "inf") return infinity;
  if (*json == "-inf") return -infinity;
  return std::nullopt;
}

std::string last_part(const std::string& way) { return way.substr(way.rfind('.') + 1); }

bool not_judged(const std::string& way) {
  return way.starts_with("versions.") || way == "reference" || way == "reference_lost_at";
}

bool must_be_equal(const std::string& way) {
  return way.starts_with("settings.") || way == "steps" || way == "evaluations" || way == "messages";
}

/// What the numbers under one key may differ by.
double allowed_at(const std::string& way, const Leaves& a, const Leaves& b) {
  const double in_a = *number(find(a, way));
  const double in_b = *number(find(b, way));
  const std::string name = last_part(way);
  if (must_be_equal(way)) return 0;
  const Quantity* const row = quantity_named(name);
  if (row == nullptr) return rounding(in_a, in_b);
  if (row->uncertainty) {
    const std::string_view bound = quantities[*row->uncertainty].name;
    const std::string beside = way.substr(0, way.size() - name.size()) + std::string(bound);
    return angle_rounding + number(find(a, beside)).value_or(0) + number(find(b, beside)).value_or(0);
  }
  if (row->scope == Scope::reference) return std::max(in_a, in_b) / 2;
  if (row->id == quantity::divergence_time) {
    return 1.001 *
           std::max(number(find(a, "settings.sample")).value_or(0), number(find(b, "settings.sample")).value_or(0));
  }
  return rounding(in_a, in_b);
}

/// What the numbers of one column of two traces may differ by at a time.
class ColumnRule {
 public:
  ColumnRule(const std::string& name, const Uncertainty& of_a, const Uncertainty& of_b)
      : row_(trace_column_of(name)), of_a_(of_a), of_b_(of_b) {}

  bool is_angle() const { return row_ != nullptr && row_->place == ColumnPlace(&Trace::q); }
  bool is_position() const { return row_ != nullptr && row_->place == ColumnPlace(&BodyColumns::position); }

  double allowed(double t, double a, double b) const {
    if (row_ == nullptr) return rounding(a, b);
    if (row_->uncertainty) return of_a_.at(*row_->uncertainty, t) + of_b_.at(*row_->uncertainty, t) + angle_rounding;
    return row_->exact ? 0 : rounding(a, b);
  }

 private:
  const TraceColumn* row_;  // null: a column of no trace of this version
  const Uncertainty& of_a_;
  const Uncertainty& of_b_;
};

/// The largest difference of columns of a kind.
struct Largest {
  std::string_view name;
  std::string_view unit;
  bool there = false;
  double difference = 0;
  double t = 0;

  void look_at(double a, double b, double at) {
    there = true;
    if (!(std::fabs(a - b) > difference)) return;
    difference = std::fabs(a - b);
    t = at;
  }

  std::string text() const {
    return fmt::format("largest |{}| {:.2g} {}, at t = {}", name, difference, unit, number_text(t));
  }
};

/// Rows of cells; a quoted cell keeps its commas.
std::vector<std::vector<std::string>> cells_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows(1, {""});
  bool quoted = false;
  for (const char letter : text) {
    if (letter == '"') {
      quoted = !quoted;
    } else if (letter == ',' && !quoted) {
      rows.back().emplace_back();
    } else if (letter == '\n' && !quoted) {
      rows.push_back({""});
    } else {
      rows.back().back() += letter;
    }
  }
  return rows;
}

std::string cell_at(const std::vector<std::vector<std::string>>& rows, std::size_t row, std::size_t column) {
  return row < rows.size() && column < rows[row].size() ? rows[row][column] : "absent";
}

}  // namespace

Place place_of(const std::filesystem::path& file) {
  const std::string folder = file.parent_path().string();
  const std::string name = file.filename().string();
  const std::string stem = file.stem().string();
  const std::string type = file.extension().string();
  if (folder.empty()) {
    const bool timing = name == "timing.csv" || name == "timing.json" || name == "index.html";
    return {timing ? Kind::timing : Kind::other, "", name};
  }
  if (folder == "report") return {name == "verdicts.csv" ? Kind::verdicts : Kind::report, "", file.string()};
  if (folder == "sweep") {
    // The table holds no times; the journal has the order in which the runs were done, the front their cost.
    const bool table =
        type == ".csv" && !stem.ends_with("-timing") && !stem.ends_with("-front") && !stem.ends_with("-front-ode");
    return {table ? Kind::sweep : Kind::timing, "", file.string()};
  }
  if (file.parent_path().has_parent_path()) return {Kind::other, "", file.string()};
  if (name == "summary.csv") return {Kind::summaries, folder, "summary"};
  if (type == ".json") return {Kind::summary, folder, stem};
  if (type == ".csv") return {Kind::trace, folder, stem};
  return {Kind::other, folder, name};
}

std::string shown_json(const Json* json) {
  if (json == nullptr) return "absent";
  if (json->is_number_float()) return number_text(json->get<double>());
  return json->is_string() ? json->get<std::string>() : json->dump();
}

void compare_summaries(const Place& place, const Json& json_a, const Json& json_b, FileComparison& file) {
  const Leaves a = leaves_of(json_a);
  const Leaves b = leaves_of(json_b);
  std::vector<std::string> ways;
  for (const auto& leaf : a) ways.push_back(leaf.first);
  for (const auto& leaf : b) {
    if (find(a, leaf.first) == nullptr) ways.push_back(leaf.first);
  }
  std::size_t near = 0;
  for (const std::string& way : ways) {
    const Json* in_a = find(a, way);
    const Json* in_b = find(b, way);
    if (not_judged(way) || (in_a != nullptr && in_b != nullptr && *in_a == *in_b)) continue;
    const std::optional<double> number_a = number(in_a);
    const std::optional<double> number_b = number(in_b);
    double allowed = 0;
    if (number_a && number_b) allowed = allowed_at(way, a, b);
    if (number_a && number_b && same(*number_a, *number_b, allowed)) {
      ++near;
    } else {
      file.differences.push_back(
          {place.scenario, place.method, way, shown_json(in_a), shown_json(in_b), allowed_text(allowed)});
    }
  }
  file.why =
      fmt::format("{} of {} values differ, {} more within the uncertainty", file.differences.size(), ways.size(), near);
}

Uncertainty::Uncertainty(const Json* summary) {
  if (summary == nullptr || !summary->is_object()) return;
  for (const auto& [way, value] : leaves_of(*summary)) {
    const bool at_time = way.starts_with("error_at.");
    const Quantity* const row = quantity_named(at_time ? last_part(way) : way);
    const auto known = number(&value);
    if (row == nullptr || row->scope != Scope::reference || !known) continue;
    until_[row->id][at_time ? std::strtod(way.c_str() + std::string("error_at.").size(), nullptr) : infinity] = *known;
  }
}

double Uncertainty::at(quantity::Id bound, double t) const {
  const auto next = until_[bound].lower_bound(t);
  return next == until_[bound].end() ? 0 : next->second;
}

namespace {

/// The rows that two traces have at the same times, up to the rounding of a number of steps: runs of other steps or
/// spacings share some.
std::vector<std::pair<std::size_t, std::size_t>> rows_at_same_times(const Column& a, const Column& b) {
  constexpr double rounding = 1e-9;  // far below the least step
  std::vector<std::pair<std::size_t, std::size_t>> rows;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    const double apart = a[i] - b[j];
    if (std::fabs(apart) <= rounding * std::max(1.0, std::fabs(a[i]))) {
      rows.emplace_back(i++, j++);
    } else {
      ++(apart < 0 ? i : j);
    }
  }
  return rows;
}

}  // namespace

void compare_traces(const Place& place, const CsvColumns& a, const CsvColumns& b, const Uncertainty& of_a,
                    const Uncertainty& of_b, FileComparison& file) {
  const auto differ = [&](const std::string& what, const std::string& in_a, const std::string& in_b, double allowed) {
    file.differences.push_back({place.scenario, place.method, what, in_a, in_b, allowed_text(allowed)});
  };
  if (a.header != b.header) {
    differ("columns", std::to_string(a.header.size()), std::to_string(b.header.size()), 0);
    return;
  }
  if (a.columns.empty() || a.header[0] != trace_columns[0].name) throw UserError("no column t");
  const Column& t = a.columns[0];
  const auto rows = rows_at_same_times(t, b.columns[0]);
  if (t.size() != b.columns[0].size()) {
    differ("rows", std::to_string(t.size()), std::to_string(b.columns[0].size()), 0);
  } else if (rows.size() != t.size()) {
    differ("rows at the same times", std::to_string(t.size()), std::to_string(rows.size()), 0);
  }
  Largest angle{"dq", "rad"};
  Largest coordinate{"dx|, |dy|, |dz", "m"};
  for (std::size_t i = 0; i < a.header.size(); ++i) {
    const ColumnRule rule(a.header[i], of_a, of_b);
    Largest* const largest = rule.is_angle() ? &angle : rule.is_position() ? &coordinate : nullptr;
    bool told = false;
    for (const auto& [k, in_other] : rows) {
      const double in_a = a.columns[i][k];
      const double in_b = b.columns[i][in_other];
      if (largest != nullptr) largest->look_at(in_a, in_b, t[k]);
      const double allowed = rule.allowed(t[k], in_a, in_b);
      if (told || same(in_a, in_b, allowed)) continue;
      differ(fmt::format("{} from t = {}", a.header[i], number_text(t[k])), number_text(in_a), number_text(in_b),
             allowed);
      told = true;
    }
  }
  file.why = rows.empty()       ? "no rows at the same times"
             : angle.there      ? angle.text()
             : coordinate.there ? coordinate.text()
                                : fmt::format("{} rows at the same times", rows.size());
}

void compare_tables(const Place& place, const std::string& text_a, const std::string& text_b, FileComparison& file,
                    std::size_t columns) {
  const auto a = cells_of(text_a);
  const auto b = cells_of(text_b);
  for (std::size_t row = 0; row < std::max(a.size(), b.size()); ++row) {
    const std::size_t width = std::max(row < a.size() ? a[row].size() : 0, row < b.size() ? b[row].size() : 0);
    for (std::size_t column = 0; column < std::min(width, columns); ++column) {
      const std::string in_a = cell_at(a, row, column);
      const std::string in_b = cell_at(b, row, column);
      if (in_a == in_b) continue;
      const std::string named = fmt::format("{}, {}", cell_at(a, row, 0), cell_at(a, 0, column));
      file.differences.push_back({place.scenario, place.method, named, in_a, in_b, "equal"});
    }
  }
  file.why = fmt::format("{} cells differ", file.differences.size());
}

}  // namespace odeval
