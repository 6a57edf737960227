#pragma once
// What a report page holds, before it is HTML: sections of text, tables, figures and pictures.
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "odeval/trace.hpp"

namespace odeval::report {

/// In the place of a number that could not be had.
struct Missing {
  std::string why;
};

using Cell = std::variant<double, std::string, Missing>;

/// A table of the page, and a file `DIR/report/NAME.csv` with all digits.
struct Table {
  std::string name{};  // file stem and anchor: "order"
  std::string title{};
  std::vector<std::string> columns{};  // with units: "error until 3 s, rad"
  std::vector<std::vector<Cell>> rows{};
  std::string note{};                   // what one has to know to read it; may be empty
  std::vector<std::string> evidence{};  // a row an anchor that its first cell leads to, or empty; none: no such links
};

enum class Mark { line, points, line_and_points };

// Colours, by their index in the style sheet. One of them has one meaning on a whole page: the first are those of
// methods; what is there to be compared with and is not told apart is grey, and so is what marks a value, dotted; those
// of variants (of a setting, a quantity, a body) each figure counts anew, and no method has one of them.
inline constexpr int method_colours = 12;
inline constexpr int rest_colour = method_colours;
inline constexpr int guide_colour = rest_colour + 1;
inline constexpr int first_variant = guide_colour + 1;
inline constexpr int variant_colours = 6;  // then their dashes and markers differ

/// Points that belong together. A value that is not finite is a gap.
struct Series {
  std::string label;
  Column x;
  Column y;
  Mark mark = Mark::line;
  int colour = -1;  // so that a method has one colour in all figures; < 0: that of the next variant
  bool dashed = false;
};

/// From where on a plot no longer tells anything, and why: drawn as a shade with its reason in the caption.
struct Shade {
  double from;
  std::string why;
};

struct Panel {
  std::string title{};  // above it, where a figure has several; empty: what is on its y axis
  std::string x_label{};
  std::string y_label{};
  std::vector<Series> series{};
  bool log_x = false;
  bool log_y = false;
  bool equal_axes = false;  // one metre across is one metre up
  std::optional<Shade> shade = {};
  std::optional<std::pair<double, double>> y_range = {};  // absent: all of the data
};

/// One or more plots that are read together.
struct Figure {
  std::string name{};  // anchor: "fig-5-13"
  std::string title{};
  std::string caption{};
  std::vector<Panel> panels{};
  int columns = 1;  // panels beside each other on a wide page
};

/// A rendered PNG.
struct Picture {
  std::string name{};
  std::string title{};
  std::string caption{};
  std::string png{};  // bytes
};

/// A paragraph of plain text; the page escapes it.
struct Text {
  std::string text;
  std::string evidence{};  // anchor of the section that shows it, or empty
  std::string lead{};      // a word or two before it that say what it is about, or empty
};

/// A sentence that stands for a section, beside one small plot of it.
struct Highlight {
  std::string sentence;
  Figure figure;         // of one panel, without caption; its name is its anchor
  std::string evidence;  // anchor of the section
};

using Block = std::variant<Text, Table, Figure, Picture, Highlight>;

struct Section {
  std::string name;  // anchor
  std::string title;
  std::vector<Block> blocks;
};

/// Files beside the page that hold the same kind of thing.
struct Files {
  std::string about;
  std::vector<std::string> paths;  // relative to the page, with slashes
};

/// Everything a page says besides the claims.
struct Document {
  std::vector<Section> front;     // what everybody reads: open, before the claims
  std::vector<Section> sections;  // the evidence: folded
  std::vector<Files> files;
  std::string command;                                           // the exact command that made it
  std::vector<std::pair<std::string, std::string>> environment;  // versions and machine, by name
};

}  // namespace odeval::report
