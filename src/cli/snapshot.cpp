// odeval snapshot: pictures of poses, one file a time, or all on a sheet, or the whole run as a film.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <optional>

#include "catalogue/evaluation.hpp"
#include "catalogue/versions.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/progress.hpp"
#include "cli/settings.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/number.hpp"
#include "output/summary.hpp"
#include "render/png.hpp"
#include "render/studio.hpp"

namespace odeval::cli {
namespace {

constexpr int film_rate = 25;  // frames a second, at real-time speed

struct Options {
  std::string scenario;
  std::vector<std::string> methods;
  Settings settings;
  std::string times;
  std::string size = "800x600";
  std::string camera = "corner";
  bool sheet = false;
  bool overlay = false;
  bool film = false;
  std::string out = "results";
  bool quiet = false;
};

/// The whole of the text as a finite number.
std::optional<double> finite_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// What stands between commas, empty parts included.
std::vector<std::string_view> parts(std::string_view text) {
  std::vector<std::string_view> found;
  for (std::size_t comma = text.find(','); comma != std::string_view::npos; comma = text.find(',')) {
    found.push_back(text.substr(0, comma));
    text.remove_prefix(comma + 1);
  }
  found.push_back(text);
  return found;
}

struct Size {
  int width;
  int height;
};

Size parse_size(const std::string& text) {
  const auto side = [](std::string_view digits) {
    int value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool whole = error == std::errc() && end == digits.data() + digits.size();
    return whole && value >= render::least_size && value <= render::largest_size ? value : 0;
  };
  const std::size_t x = text.find('x');
  const Size size{side(std::string_view(text).substr(0, x)), x == std::string::npos ? 0 : side(text.substr(x + 1))};
  if (size.width == 0 || size.height == 0) {
    throw UserError(fmt::format("--size {}: must be WxH, both whole numbers from {} to {}, e.g. 800x600", text,
                                render::least_size, render::largest_size));
  }
  return size;
}

render::View parse_camera(const std::string& text) {
  if (text == "front") return {0, 0, {}};
  if (text == "side") return {90, 0, {}};
  if (text == "corner") return {30, 14, {}};
  std::vector<double> numbers;
  bool good = true;
  for (const std::string_view part : parts(text)) {
    const std::optional<double> number = finite_number(part);
    good = good && number;
    numbers.push_back(number.value_or(0));
  }
  good = good && (numbers.size() == 2 || numbers.size() == 3) && std::fabs(numbers[0]) <= 360 &&
         std::fabs(numbers[1]) <= 89 && (numbers.size() == 2 || (numbers[2] >= 1e-3 && numbers[2] <= 1e6));
  if (!good) {
    throw UserError("--camera " + text +
                    ": must be front, side, corner or AZIMUTH,ELEVATION[,DISTANCE]: degrees from -360 to 360 and from "
                    "-89 to 89, m from 0.001 to 1e6");
  }
  return {numbers[0], numbers[1], numbers.size() == 3 ? std::optional(numbers[2]) : std::nullopt};
}

/// The rows nearest to the times, each once.
std::vector<std::size_t> rows_at(const std::string& times, const Scenario& scenario, const SampleGrid& grid) {
  std::vector<std::size_t> rows;
  if (times.empty()) return rows;
  for (const std::string_view part : parts(times)) {
    const std::optional<double> t = finite_number(part);
    if (!t || *t < 0 || *t > scenario.duration_s) {
      throw UserError(fmt::format("--times {}: '{}' is no time of the run; must be numbers from 0 to {} s, with commas",
                                  times, part, number_text(scenario.duration_s)));
    }
    const long row = std::min(std::lround(*t / (grid.step_s * static_cast<double>(grid.stride))), grid.rows - 1);
    const auto index = static_cast<std::size_t>(row);
    if (std::ranges::find(rows, index) == rows.end()) rows.push_back(index);
  }
  return rows;
}

/// A sample's time for captions and names: at least three digits, free of the rounding of k * h.
std::string time_text(double t) {
  std::string text = fmt::format("{:.9f}", t);
  while (text.ends_with('0') && text.size() - text.find('.') > 4) text.pop_back();
  return text;
}

/// Pictures of one method's run, written as they are made.
class Album {
 public:
  Album(const Options& options, catalogue::Evaluator& evaluator, const catalogue::Evaluation& run,
        render::Studio& studio)
      : options_(options),
        scenario_(evaluator.scenario()),
        grid_(evaluator.grid()),
        reference_(evaluator.reference()),
        run_(run),
        studio_(studio) {
    method_ = run.method->name;
    folder_ = std::filesystem::path(options.out) / scenario_.name;
    if (run.method->order > 0) step_ = "h = " + number_text(scenario_.step_s) + " s";
  }

  void pictures(const std::vector<std::size_t>& rows) {
    for (const std::size_t row : rows) {
      if (!there(row)) continue;
      const std::string t = time_text(run_.trace.t[row]);
      write("t" + t, render::png(studio_.picture(shot(row), caption(row)), texts(t)));
    }
  }

  void sheet(const std::vector<std::size_t>& rows) {
    std::vector<render::Shot> shots;
    std::string all;
    for (const std::size_t row : rows) {
      const std::string t = time_text(grid_.time(static_cast<long>(row)));
      shots.push_back(there(row) ? shot(row) : render::Shot{{}, {}, "t = " + t + " s: diverged"});
      all += (all.empty() ? "" : ",") + t;
    }
    write("sheet", render::png(studio_.sheet(shots, {who(), step_}), texts(all)));
  }

  void film() {
    const Column& t = run_.trace.t;
    render::Film film(film_rate, texts(time_text(t.front()) + ".." + time_text(t.back())));
    const double spacing = t.size() > 1 ? t[1] - t[0] : 1;
    for (long frame = 0;; ++frame) {
      const auto row = static_cast<std::size_t>(std::lround(static_cast<double>(frame) / film_rate / spacing));
      if (row >= t.size()) break;
      film.add(studio_.frame(shot(row), caption(row)));
    }
    write("film", film.finish());
  }

  const std::vector<std::string>& written() const { return written_; }

  /// Times of rows whose links lie in part outside of the picture, with commas.
  std::string cut_off(const std::vector<std::size_t>& rows) const {
    std::string all;
    for (const std::size_t row : rows) {
      if (!there(row) || studio_.shows(render::pose_at(scenario_, run_.trace, row))) continue;
      all += (all.empty() ? "" : ",") + time_text(run_.trace.t[row]);
    }
    return all;
  }

 private:
  bool there(std::size_t row) const { return row < run_.trace.rows(); }

  render::Shot shot(std::size_t row) const {
    render::Shot shot{render::pose_at(scenario_, run_.trace, row), {}, "t = " + time_text(run_.trace.t[row]) + " s"};
    if (options_.overlay) shot.outline = render::pose_at(scenario_, reference_.trace, row);
    return shot;
  }

  std::string who() const {
    return scenario_.name + ", " + method_ + (options_.overlay ? " (outline: reference)" : "");
  }

  render::Caption caption(std::size_t row) const {
    return {who(), (step_.empty() ? "" : step_ + ", ") + "t = " + time_text(run_.trace.t[row]) + " s"};
  }

  render::PngTexts texts(const std::string& t) const {
    render::PngTexts all{{"scenario", scenario_.name}, {"method", method_}, {"t", t}};
    if (options_.overlay) all.emplace_back("overlay", reference_.origin);
    all.emplace_back("Software", "odeval " + catalogue::versions().front().second);
    return all;
  }

  void write(const std::string& what, const std::string& bytes) {
    const std::filesystem::path file = folder_ / (method_ + "-" + what + ".png");
    write_whole(file, bytes);
    written_.push_back(file.string());
  }

  const Options& options_;
  const Scenario& scenario_;
  const SampleGrid& grid_;
  const Reference& reference_;
  const catalogue::Evaluation& run_;
  render::Studio& studio_;
  std::string method_;
  std::string step_;  // empty where the method has no fixed step
  std::filesystem::path folder_;
  std::vector<std::string> written_;
};

/// Poses of a trace in the rows that are shown; of a film in enough of all.
void add_poses(std::vector<render::Pose>& poses, const Scenario& scenario, const Trace& trace,
               const std::vector<std::size_t>& rows, bool film) {
  const auto add = [&](std::size_t row) {
    if (row < trace.rows()) poses.push_back(render::pose_at(scenario, trace, row));
  };
  for (const std::size_t row : rows) add(row);
  if (!film) return;
  constexpr std::size_t enough = 200;
  for (std::size_t row = 0; row < trace.rows(); row += std::max<std::size_t>(trace.rows() / enough, 1)) add(row);
}

/// What the camera has to hold: bodies where the reference has them, which is near where any method has them that has
/// not blown up; links where the method has them, which keep within their reach. Other methods have no say, so that a
/// method's pictures are the same whatever is drawn beside it.
std::vector<render::Pose> shown_poses(catalogue::Evaluator& evaluator, const catalogue::Evaluation& run,
                                      const std::vector<std::size_t>& rows, const Options& options) {
  const Scenario& scenario = evaluator.scenario();
  std::vector<render::Pose> poses;
  if (!scenario.planar || options.overlay) {
    add_poses(poses, scenario, evaluator.reference().trace, rows, options.film);
  }
  if (scenario.planar) add_poses(poses, scenario, run.trace, rows, options.film);
  return poses;
}

/// What went wrong in a run, or was left out of its pictures.
void warn(const catalogue::Evaluation& run, const std::string& times_cut_off) {
  if (!times_cut_off.empty()) {
    std::cerr << "odeval: " << run.method->name
              << ": the picture does not hold all of the bodies at t = " << times_cut_off
              << " s; --camera sees more from farther away\n";
  }
  if (const std::string why = suspicion(run.outcome); !why.empty()) {
    std::cerr << "odeval: " << run.method->name << " is suspect: " << why << '\n';
  }
  if (run.outcome.diverged) {
    std::cerr << "odeval: " << run.method->name << " diverged: " << run.outcome.reason
              << "; there are no pictures after that\n";
  }
}

int snapshot(const Options& options) {
  const Scenario scenario = options.settings.read(options.scenario);
  const auto methods = chosen_methods(options.methods, scenario);
  require_read(options.settings.overrides(), {{{scenario, methods}}});
  const Size size = parse_size(options.size);
  const render::View view = parse_camera(options.camera);
  catalogue::Evaluator evaluator(scenario);
  const std::vector<std::size_t> rows = rows_at(options.times, scenario, evaluator.grid());
  if (rows.empty() && !options.film) throw UserError("--times: names no time; give --times T1[,T2...] in s, or --film");
  if (rows.empty() && options.sheet) throw UserError("--sheet: needs --times T1[,T2...] in s");

  if (options.sheet && !render::fit_on_sheet(rows.size(), size.width, size.height)) {
    throw UserError(
        fmt::format("--times: {} poses do not fit on a sheet of --size {}; fewer times or a larger size will",
                    rows.size(), options.size));
  }
  std::optional<render::Studio> studio;
  bool diverged = false;
  std::vector<std::string> written;
  {
    Progress progress(methods.size(), options.quiet, Progress::Clock::shown);
    for (const catalogue::Method* method : methods) {
      progress.next(scenario.name + " " + std::string(method->name));
      const catalogue::Evaluation run = evaluator.evaluate(*method);
      const std::vector<render::Pose> shown = shown_poses(evaluator, run, rows, options);
      if (!studio) {
        studio.emplace(scenario, view, size.width, size.height, render::caption_font(), shown);
      } else {
        studio->restage(scenario, shown);
      }
      Album album(options, evaluator, run, *studio);
      if (options.sheet) album.sheet(rows);
      if (!options.sheet) album.pictures(rows);
      if (options.film) album.film();
      std::ranges::copy(album.written(), std::back_inserter(written));
      warn(run, album.cut_off(rows));
      diverged = diverged || run.outcome.diverged;
    }
  }
  if (!options.quiet) {
    for (const std::string& file : written) std::cout << "wrote " << file << '\n';
  }
  return diverged ? 1 : 0;
}

}  // namespace

Action attach_snapshot(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("SCENARIO", options->scenario, "a name ('odeval list') or a .toml file").required();
  add_method_option(flags, options->methods);
  flags.add_option("--times", options->times, "times in s; each gives a picture, of the nearest sample of the run")
      .type_name("T1[,T2...]");
  flags.add_option("--size", options->size, "pixels of a picture or sheet, 16x16 to 8192x8192")
      .type_name("WxH")
      .capture_default_str();
  flags
      .add_option(
          "--camera", options->camera,
          "front, side, corner, or AZIMUTH,ELEVATION[,DISTANCE] in degrees (and m from the first hinge or the middle)")
      .type_name("VIEW")
      .capture_default_str();
  flags.add_flag("--sheet", options->sheet, "put all times on one picture");
  flags.add_flag("--overlay", options->overlay, "the reference's pose as an outline over the method's");
  flags.add_flag("--film", options->film, "the whole run as an animated PNG at real-time speed");
  add_out_option(flags, options->out);
  flags.add_flag("--quiet", options->quiet, "print neither files nor progress");
  options->settings.attach(flags);
  return [options] { return snapshot(*options); };
}

}  // namespace odeval::cli
