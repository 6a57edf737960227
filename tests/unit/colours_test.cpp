// A colour has one meaning on the whole page, on light and on dark paper: violet and pink are what a figure varies, and
// no method has them.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "experiments/experiment.hpp"
#include "experiments/parts.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using report::first_variant;
using report::method_colours;
using report::variant_colours;

struct Rgb {
  double red, green, blue;  // 0 to 255
};

/// The colours of the style sheet in the order of their numbers, one list for light and one for dark paper.
std::vector<std::vector<Rgb>> palettes() {
  std::ifstream file(std::string(ODEVAL_SOURCE_DIR) + "/src/report/style.css");
  const std::string css{std::istreambuf_iterator<char>(file), {}};
  const std::regex colour("--c(\\d+): #([0-9a-f]{6});");
  std::vector<std::vector<Rgb>> all;
  for (std::sregex_iterator at(css.begin(), css.end(), colour), end; at != end; ++at) {
    const auto number = static_cast<std::size_t>(std::stoi((*at)[1]));
    if (number == 0) all.emplace_back();
    CHECK_EQUAL(all.back().size(), number);
    const int code = std::stoi((*at)[2], nullptr, 16);
    all.back().push_back(
        {static_cast<double>(code >> 16), static_cast<double>(code >> 8 & 255), static_cast<double>(code & 255)});
  }
  return all;
}

/// From blue over violet to pink: what has less green than either of the others, and is not nearly grey.
bool is_violet_or_pink(const Rgb& colour) {
  const double most = std::max(colour.red, colour.blue);
  const double least = std::min({colour.red, colour.green, colour.blue});
  const double hue = 60 * ((colour.red - colour.green) / (most - least) + 4);  // degrees, where blue is the most
  if (colour.green > least || most - least < 0.12 * 255) return false;
  return colour.blue >= colour.red ? hue > 248 : colour.blue > colour.green + 0.45 * (colour.red - colour.green);
}

void violet_and_pink_are_no_method() {
  CHECK(is_violet_or_pink({106, 72, 201}) && is_violet_or_pink({195, 59, 143}));
  CHECK(!is_violet_or_pink({74, 111, 165}) && !is_violet_or_pink({161, 35, 16}) && !is_violet_or_pink({27, 29, 33}));
  const auto both = palettes();
  CHECK_EQUAL(both.size(), 2U);
  for (const std::vector<Rgb>& paper : both) {
    CHECK_EQUAL(paper.size(), static_cast<std::size_t>(first_variant + variant_colours));
    for (int i = 0; i < static_cast<int>(paper.size()); ++i) {
      const bool varied = i >= first_variant;
      if (is_violet_or_pink(paper[static_cast<std::size_t>(i)]) != varied) {
        CHECK_EQUAL("--c" + std::to_string(i), varied ? "violet or pink" : "neither violet nor pink");
      }
    }
  }
}

report::Series series(const std::string& label, int colour, double height) {
  return {label, {0, 1, 2}, {height, height + 1, height}, report::Mark::line, colour};
}

/// A curve for two names has the colour of the method among them; of two that are not told apart, grey.
void a_curve_for_two_has_the_methods_colour() {
  const int ours = experiments::colour_of("ode-rk4-double");
  CHECK(ours >= 0 && ours < method_colours);
  for (const int other : {-1, report::rest_colour}) {
    for (const bool swapped : {false, true}) {
      report::Panel panel;
      panel.series = {series("a", swapped ? other : ours, 0), series("b", swapped ? ours : other, 0),
                      series("c", -1, 5)};
      const report::Panel drawn = experiments::told_apart(panel);
      CHECK_EQUAL(drawn.series.size(), 2U);
      CHECK_EQUAL(drawn.series[0].label, "a = b");
      CHECK_EQUAL(drawn.series[0].colour, ours);
      CHECK_EQUAL(drawn.series[1].colour, -1);
    }
  }
}

}  // namespace

int main() {
  violet_and_pink_are_no_method();
  a_curve_for_two_has_the_methods_colour();
  return test::verdict();
}
