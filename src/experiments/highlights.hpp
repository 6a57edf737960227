#pragma once
// What the experiments found, in ten sentences: each beside one plot of its section.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "report/claims.hpp"
#include "report/document.hpp"
#include "report/findings.hpp"

namespace odeval::experiments {

/// Row of the table of highlights or of the box, in the order of the page. Of the rows of one section and figure the
/// conditions are such that one holds, whatever was measured.
struct Row {
  std::string_view section;                     // whose evidence it is
  std::string_view figure;                      // of that section
  std::size_t panel;                            // of that figure
  std::span<const report::Condition> holds_if;  // the sentence is true if all of them hold; else the page leaves it out
  std::string_view sentence;   // names findings, with underscores for dots and dashes: {{C12_smooth_gain}},
                               // {{C14_anisotropy_percent}}
  std::string_view lead = {};  // of a sentence of the box: what it is about
};

std::span<const Row> highlights();
std::span<const Row> box_sentences();

/// What everybody reads, from all that was measured: the section of the experiment `answer`, which leaves `sections`,
/// below a few sentences of the kind; and the highlights whose conditions hold and whose plots are there.
std::vector<report::Section> front_of(std::vector<report::Section>& sections, const report::Findings& findings);

}  // namespace odeval::experiments
