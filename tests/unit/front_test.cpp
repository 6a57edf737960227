// The sentences of the page's box: of what can be measured each says what holds, and one of each group is there.
#include <map>
#include <string>
#include <vector>

#include "experiments/highlights.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;

/// What is measured today, or near it.
const std::map<std::string, double> usual{{"answer.step", 1},
                                          {"answer.error", 5},
                                          {"answer.early", 1},
                                          {"answer.lost", 1},
                                          {"answer.lost_at", 6},
                                          {"answer.until", 10},
                                          {"answer.energy_drift", 0.1},
                                          {"answer.energy_share", 0.01},
                                          {"answer.arm_budget", 1},
                                          {"answer.arm_until", 2},
                                          {"answer.arm_step", 2},
                                          {"answer.arm_erp", 1},
                                          {"answer.arm_half_step", 1},
                                          {"answer.arm_gain", 10},
                                          {"answer.arm_keeps", 1},
                                          {"answer.arm_default_keeps", 1},
                                          {"answer.arm_default_step", 0.2},
                                          {"answer.arm_of_acrobot", 0.4},
                                          {"answer.arm_of_three_link", 200},
                                          {"answer.arm_of_puma", 3000},
                                          {"answer.arms_accurate", 0.03},
                                          {"answer.wall_step", 1},
                                          {"answer.wall_steps", 61},
                                          {"answer.wall_nearby", 3},
                                          {"answer.wall_until", 5},
                                          {"answer.impacts", 4},
                                          {"answer.impact_first", 2},
                                          {"answer.impact_error", 8},
                                          {"answer.impact_angle", 20},
                                          {"answer.impact_steps", 3},
                                          {"C14.anisotropy", 0.4},
                                          {"answer.single_step", 1},
                                          {"answer.single_until", 2},
                                          {"answer.single_ratio", 1},
                                          {"answer.single_fine_step", 0.2},
                                          {"answer.single_fine_ratio", 7},
                                          {"C4.long_axis_spin_single", 3}};

/// The box where some of it is measured otherwise.
std::vector<std::string> box_with(const std::map<std::string, double>& otherwise) {
  std::map<std::string, double> values = otherwise;
  values.insert(usual.begin(), usual.end());
  report::Findings findings;
  for (const auto& [name, value] : values) findings.add(name, {name, "", value, 0, ""});
  std::vector<report::Section> sections;
  std::vector<std::string> sentences;
  const std::vector<report::Section> front = experiments::front_of(sections, findings);
  for (const report::Block& block : front.front().blocks) {
    sentences.push_back(std::get<report::Text>(block).text);
  }
  return sentences;
}

bool says(const std::vector<std::string>& sentences, std::size_t place, const std::string& words) {
  return place < sentences.size() && sentences[place].find(words) != std::string::npos;
}

struct Case {
  std::map<std::string, double> otherwise;
  std::size_t place;
  std::string words;
};

const std::vector<Case> cases{
    {{}, 0, "tells nothing of it"},
    {{}, 0, "0.1, 1 % of its largest kinetic energy"},
    {{{"answer.energy_share", 0.5}}, 0, "drifts by 0.1 meanwhile, 50 %"},
    {{{"answer.lost", 0}}, 0, "until 10 it stays the same motion"},
    {{}, 1, "ERP 1 and the half-step start"},
    {{{"answer.arm_half_step", 0}}, 1, "a step of 2 and ERP 1; with ODE's defaults a step of 0.2"},
    {{{"answer.arm_gain", 1}}, 1, "no settings that were tried allow a much larger one"},
    {{}, 2, "0.4 on an acrobot, 200 on an arm that turns in space (three_link_arm) and 3000 on a falling PUMA robot"},
    {{{"answer.arms_accurate", 0.07}}, 2, "the accurate step at the same step at most 0.07"},
    {{},
     3,
     "At a step of 1 the first impact of a link on a wall is off by up to 2, the worst of 4 in 5 by 8 and the angles"},
    {{}, 3, "by 20 (the most of 61 steps within 3 of it)"},
    {{}, 3, "too strong along the diagonal"},
    {{{"C14.anisotropy", 0.01}}, 3, "the same in all directions"},
    {{{"answer.impact_steps", 0.1}}, 3, "an impact of a link on a wall is right to 8, less than the step"},
    {{}, 4, "is 1 times that of double precision with the same settings (at 0.2 7 times); not for long thin bodies"},
    {{{"C4.long_axis_spin_single", 0}}, 4, "(at 0.2 7 times), and for long thin bodies"},
    {{{"answer.single_ratio", 2}}, 4, "Single precision is not safe"},
};

/// The sentences in short that stand beside this figure, of those whose numbers are there.
std::vector<std::string> in_short(const std::string& section, const std::string& figure,
                                  const std::map<std::string, double>& values) {
  report::Findings findings;
  for (const auto& [name, value] : values) findings.add(name, {name, "", value, 0, ""});
  report::Figure plot{figure, "", "", {{}, {}}, 2};
  std::vector<report::Section> sections{{section, "", {plot}}};
  std::vector<std::string> sentences;
  const std::vector<report::Section> front = experiments::front_of(sections, findings);
  for (const report::Block& block : front.back().blocks) {
    if (const auto* const one = std::get_if<report::Highlight>(&block)) sentences.push_back(one->sentence);
  }
  return sentences;
}

/// What one sentence says of another, and of what was not looked at, follows from the numbers as well.
void sentences_in_short() {
  std::map<std::string, double> values{{"potra.impacts", 5},      {"potra.until", 2.5},       {"potra.step", 1},
                                       {"potra.late_steps", 1.7}, {"answer.impact_steps", 8}, {"answer.impacts", 5},
                                       {"C14.anisotropy", 0.4},   {"friction.told_off", 1e-3}};
  const auto potra = [&] { return in_short("potra", "potra-figure", values); };
  const auto friction = [&] { return in_short("friction", "friction-figure", values); };
  CHECK_EQUAL(potra().size(), 1U);
  CHECK(says(potra(), 0, "of the 5 impacts on the wall of the box at the top the worst is 8 steps off."));
  CHECK_EQUAL(friction().size(), 1U);
  CHECK(says(friction(), 0, "40 % stronger. Where each contact is told the way it slides, a box slides as far as it"));
  CHECK(says(friction(), 0, "in every direction, to 0.1 %."));
  values["answer.impact_steps"] = 1;
  values["friction.told_off"] = 0.2;
  CHECK_EQUAL(potra().size(), 1U);
  CHECK(!says(potra(), 0, "the worst is"));
  CHECK_EQUAL(friction().size(), 1U);
  CHECK(says(friction(), 0, "leaves the way of a box 20 % off"));
  values["C14.anisotropy"] = 0;
  CHECK(friction().empty());
}

/// What has no number where ODE's settings keep nothing.
void settings_that_keep_nothing() {
  std::map<std::string, double> values = usual;
  for (const char* const name : {"answer.arm_gain", "answer.arm_default_step"}) values.erase(name);
  const auto arm = [](std::map<std::string, double> all) {
    report::Findings findings;
    for (const auto& [name, value] : all) findings.add(name, {name, "", value, 0, ""});
    std::vector<report::Section> sections;
    const auto front = experiments::front_of(sections, findings);
    return std::get<report::Text>(front.front().blocks.at(1)).text;
  };
  values["answer.arm_default_keeps"] = 0;
  CHECK(arm(values).find("with ODE's defaults no step that was tried is small enough") != std::string::npos);
  for (const char* const name : {"answer.arm_step", "answer.arm_erp"}) values.erase(name);
  values["answer.arm_keeps"] = 0;
  CHECK(arm(values).starts_with("No settings that were tried keep 1 for 2"));
}

}  // namespace

int main() {
  for (const Case& one : cases) {
    const std::vector<std::string> sentences = box_with(one.otherwise);
    CHECK_EQUAL(sentences.size(), 5U);
    if (!says(sentences, one.place, one.words)) {
      CHECK_EQUAL(one.place < sentences.size() ? sentences[one.place] : "", one.words);
    }
  }
  settings_that_keep_nothing();
  sentences_in_short();
  return odeval::test::verdict();
}
