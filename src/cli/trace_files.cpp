#include "cli/trace_files.hpp"

#include <array>
#include <cmath>

#include "odeval/error.hpp"
#include "output/number.hpp"

namespace odeval::cli {

double spacing(const Column& t, const std::string& name) {
  if (t.size() < 2) throw UserError(name + ": must have a column t with two rows or more");
  const double dt = t[1] - t[0];
  if (!(dt > 0)) {
    throw UserError(
        fmt::format("{}:3: t = {} must be more than the {} before it", name, number_text(t[1]), number_text(t[0])));
  }
  for (std::size_t row = 0; row < t.size(); ++row) {
    constexpr double rounding = 1e-6;  // of a spacing: files have as few digits as their writers like
    if (std::fabs(t[row] - static_cast<double>(row) * dt) <= rounding * dt * static_cast<double>(row + 1)) continue;
    throw UserError(fmt::format("{}:{}: t = {} must be {}: times begin at 0 and go in even steps", name, row + 2,
                                number_text(t[row]), number_text(static_cast<double>(row) * dt)));
  }
  return dt;
}

catalogue::Evaluator evaluator_at(const std::string& scenario, const Settings& settings, double dt, std::size_t rows,
                                  const std::string& name) {
  std::vector<Override> all = settings.overrides();
  refuse_searched(all, std::array<std::string_view, 3>{"step", "duration", "sample"}, "the trace");
  all.push_back({"step", number_text(dt), name});
  all.push_back({"sample", number_text(dt), name});
  all.push_back({"duration", number_text(dt * static_cast<double>(rows - 1)), name});
  const std::filesystem::path file = scenario_file(scenario);
  catalogue::Evaluator evaluator(read_scenario(file, all, known_names(), settings.import_options(file)));
  tell_of_import(file);
  return evaluator;
}

}  // namespace odeval::cli
