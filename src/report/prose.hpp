#pragma once
// Words from a template, numbers from an experiment: one section of the page.
//
// A template is a mustache file whose first line is the section's title. Then come, parted by empty lines and in the
// order of the page, paragraphs and the places of what was measured:
//
//   # Friction: pyramid, constant force and Coulomb
//
//   A box of {{mass}} kg sets out at {{speed}} m/s over level ground.
//
//   [figure friction-figure] Friction over the direction of the slide
//   Coulomb's law knows no direction: 1 on the left, 0 on the right.
//
//   [table friction] How far a box slides, and where to
//   The direction is counted from one of the two axes that ODE lets friction act along.
//
//   [picture picture-chain] A chain of eight links.
//   Of the run with {{method}}.
//
// A line that ends goes on in the next. Nothing is escaped here: the page does that.
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "report/document.hpp"
#include "report/template.hpp"

namespace odeval::report {

/// In the place of an exhibit that could not be made.
struct Lacking {
  std::string name;
  std::string why;
};

using Exhibit = std::variant<Table, Figure, Picture, Lacking>;

/// What an experiment has measured, to be put into its template. The exhibits come without title, caption and note,
/// which stand in the template, and in any order.
struct Content {
  Values values;
  std::vector<Exhibit> exhibits;
};

/// The title of a template.
std::string title_of(std::string_view prose);

/// Throws std::logic_error where template and measurement differ: a {{name}} without a value, a value that is named
/// nowhere, a place without its exhibit, an exhibit without its place; or where the template is no template.
Section section_of(std::string name, std::string_view prose, Content content);

}  // namespace odeval::report
