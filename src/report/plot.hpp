#pragma once
// Panels of a figure as SVG that is part of a page: its colours and its font are the page's.
#include <string>
#include <vector>

#include "report/document.hpp"

namespace odeval::report {

/// How a series looks, in its plot and in the legend.
struct Look {
  int colour;  // of the style sheet's variables --c0, --c1, ...
  int dash;    // of the dash patterns; 0: solid
  int marker;  // of the shapes of points
  bool has_line;
  bool has_points;

  bool operator==(const Look&) const = default;
};

/// The looks of all series of a figure, panel by panel. A colour that was asked for stays whatever else is drawn; past
/// the eight colours of methods that everybody tells apart, the dashes and markers differ as well.
std::vector<std::vector<Look>> looks_of(const Figure& figure);

/// One plot. `id` is unique on the page and begins the name of everything in it. Throws MachineError as `run_gnuplot`.
std::string plot_svg(const Panel& panel, const std::vector<Look>& looks, const std::string& id);

/// Whether there is a point to draw: finite, and above zero on a logarithmic axis.
bool has_points(const Panel& panel);
bool has_points(const Series& series, const Panel& panel);

/// A short piece of line with its marker, for the legend.
std::string swatch_svg(const Look& look);

/// The shade of a panel in words: "Shaded from t = 5.91 s on: ..."; empty without one or where it lies outside.
std::string shade_text(const Panel& panel);

/// What has no place on its logarithmic axis: "Not drawn: 3 below 1e-12, of 401"; empty where all has.
std::string not_drawn_text(const Panel& panel);

}  // namespace odeval::report
