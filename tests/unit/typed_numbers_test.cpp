// Every number that the page's prose says comes from what was measured or set: none is typed into a template, a
// sentence of the first screen or an advice, but for those below, each with its reason.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "report/claims.hpp"
#include "tests/check.hpp"

namespace {

namespace fs = std::filesystem;

const char* const number_words =
    "two|three|four|five|six|seven|eight|nine|ten|eleven|twelve|(thir|four|fif|six|seven|eigh|nine)teen|twenty|thirty|"
    "forty|fifty|sixty|seventy|eighty|ninety|hundreds?|thousands?|millions?|dozens?|twice|thrice|half|thirds?|"
    "quarters?|tenths?|one (second|metre)|(one|a) (milliradian|millisecond|millimetre)";

struct Allowed {
  const char* pattern;
  const char* reason;
  const char* only_in = "";  // a file; empty: anywhere
  int used = 0;
};

Allowed allowed[] = {
    // Names.
    {"\\b2010\\b", "the report's year, by which it is called"},
    {"(Figure|Table|Chapter|equation) \\d+(\\.\\d+)?", "what the 2010 report numbers so"},
    {"\\b(dh-|lagrange-)?ode45('s)?\\b", "a method's name"},
    {"\\bode[-_]rk4(-double)?\\b", "a method's name, and that of its folder"},
    {"\\bdContact(Approx1|FDir1)\\b", "names of ODE's interface"},
    {"\\bq[12]\\b", "angles' names, as the report has them"},
    {"D&amp;C _\\.\\d+", "the report's number", "page"},
    {"to three digits", "how the page shows numbers", "page"},
    {"the two runs", "one and the other that starts beside it", "sensitivity.cpp"},
    {"\\bhalf width\\b", "of the interval of a fit", "half_step.cpp"},
    {"to the third\\b", "of impacts, in their order", "half_step.cpp"},
    {"ERP 0$", "no feedback", "should_i_switch_runs.cpp"},
    {"\\b[CO]\\d+[ab]?\\b", "claims' names"},
    {"\\b1-norm\\b", "a norm's name"},
    {"\\bA01\\b", "a problem's name in the IFToMM library", "iftomm"},
    {"\\bet al\\. 2006\\b", "a paper's name", "potra"},
    {"\\b(2018|2014|data/666|49 balls|216 balls|6 x 6 x 6|10 kg|20 s|10 s|10 ms|up to 1000|60 degrees)\\b",
     "what others' benchmarks are made of, as they published them", "benchmarks"},
    {"[Tt]wo points\\b", "the benchmark of Potra et al.", ""},
    {"Gazebo 6|S\\. Peters, 2015|ODE 0\\.16\\b", "the release that was measured, its source, and the release here",
     "free-box"},
    {"\\b[Hh]alf[- ](a )?step\\b|\\bhalf\\s+a\\s+step\\b", "the name of what O1 is about"},
    {"(cases 1, 3 and 4|Cases 1 and 2|five cases)\\b", "the rows of the 2010 report's Table 5.2", "table-5-2"},
    {"95 % interval", "the one interval that fits are given with"},
    // Mathematics: true of the formula, whatever is measured.
    {"-pi/2|h\\s*/\\s*2|g h T / 2|kd²/2m|w h / 2|2 atan|/\\s*2 and comes back|t = -?0|t = -h/2|M\\^-1|x\\)\\^-1( - "
     "1)?|1/s(²)?|1/ERP|"
     "\\(1 \\+ c\\)|1 / \\(h kp|1 - ERP|1 \\+ a\\^2|R'R - 1",
     "formulas"},
    {"\\b(ERP|CFM)( =)? 0\\b", "none of it"},
    {"square root of\\s+two", "of forces at a right angle"},
    {"half the square of", "of an angle's cosine"},
    {"six conditions", "of an orthogonal matrix", "orientation"},
    {"(order|ones) by (two|four)|by 2 to the p", "what an order is"},
    {"each half the one\\b", "how the ladder of steps is made", "order"},
    {"a step and its half\\b", "what a local slope is of", "order"},
    {"half the step, half the error, twice the cost", "what first order is"},
    {"far from 1\\b", "what manipulability is at best", "double-pendulum"},
    {"two axes", "how ODE's friction is made", "friction"},
    {"(hinge|hinges) (made )?twice|same thing twice|hinge twice", "what is done to the hinges"},
};

struct Prose {
  std::string where;  // file without folder and ending
  std::string text;
};

std::string whole(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Without values, names of exhibits and the ends of lines.
std::string words_of_template(const std::string& text) {
  std::string words = std::regex_replace(text, std::regex("\\{\\{[^}]*\\}\\}\\}?"), "");
  words = std::regex_replace(words, std::regex("\\[(table|figure|picture) [^\\]]*\\]"), "");
  return std::regex_replace(words, std::regex("\\s+"), " ");
}

/// The string literals of a source that are prose: of several words, and no flags of a command.
std::vector<std::string> literals_of(const std::string& source) {
  const std::string code = std::regex_replace(source, std::regex("//[^\n]*"), "");
  const std::regex literal("\"((?:[^\"\\\\\n]|\\\\.)*)\"");
  std::vector<std::string> all;
  for (std::sregex_iterator at(code.begin(), code.end(), literal), end; at != end; ++at) {
    const std::string text = std::regex_replace(words_of_template((*at)[1].str()), std::regex("\\{[^{}]*\\}"), "");
    if (text.find(' ') != std::string::npos && !text.starts_with(" --")) all.push_back(text);
  }
  return all;
}

std::vector<Prose> all_prose() {
  const fs::path folder = fs::path(ODEVAL_SOURCE_DIR) / "src" / "experiments";
  std::vector<Prose> all;
  for (const auto& entry : fs::directory_iterator(folder / "text")) {
    all.push_back({entry.path().stem().string(), words_of_template(whole(entry.path()))});
  }
  // What says nothing by itself: a style, markup, and the names of values.
  const fs::path layout = fs::path(ODEVAL_SOURCE_DIR) / "src" / "report" / "page.mustache";
  all.push_back({"page", words_of_template(std::regex_replace(whole(layout), std::regex("<[^>]*>"), " "))});
  for (const char* const file : {"answer.cpp", "highlights.cpp", "should_i_switch.cpp", "should_i_switch_runs.cpp",
                                 "half_step.cpp", "sensitivity.cpp"}) {
    for (std::string& text : literals_of(whole(folder / file))) all.push_back({file, std::move(text)});
  }
  for (const odeval::report::Claim& claim : odeval::report::claims()) {
    all.push_back({"advice of " + std::string(claim.id), std::string(claim.advice)});
  }
  return all;
}

/// What is left once the allowed ones are taken out: the first number, with what stands around it.
std::string typed_number(const Prose& prose) {
  std::string text = prose.text;
  for (Allowed& one : allowed) {
    if (*one.only_in != '\0' && prose.where != one.only_in) continue;
    const std::regex pattern(one.pattern);
    if (!std::regex_search(text, pattern)) continue;
    ++one.used;
    text = std::regex_replace(text, pattern, "_");
  }
  std::smatch found;
  const std::regex number("\\d|\\b(" + std::string(number_words) + ")\\b", std::regex::icase);
  if (!std::regex_search(text, found, number)) return "";
  const auto at = static_cast<std::size_t>(found.position());
  const std::size_t from = at < 40 ? 0 : at - 40;
  return prose.where + ": ..." + text.substr(from, 100) + "...";
}

/// The test sees what it is there to see.
void a_typed_number_is_seen() {
  for (const char* const text :
       {"an error of 0.3 rad", "three times as large", "after one second", "twice as good", "ERP 0.8"}) {
    CHECK(!typed_number({"x", words_of_template(text)}).empty());
  }
  CHECK(typed_number({"x", words_of_template("an error of {{error}} rad, {{#list}}{{one}}{{/list}} at h/2")}).empty());
  CHECK_EQUAL(literals_of("f(\"step of 2 ms\", \"n=32\", \" --set n=32\"); // \"of 3 ms\"").size(), 1U);
}

}  // namespace

int main() {
  a_typed_number_is_seen();
  for (Allowed& one : allowed) one.used = 0;
  const std::vector<Prose> all = all_prose();
  CHECK(all.size() > 80);  // 33 templates, 22 advices, the sentences
  for (const Prose& prose : all) CHECK_EQUAL(typed_number(prose), "");
  for (const Allowed& one : allowed) {
    if (one.used == 0) CHECK_EQUAL(std::string(one.pattern), "used, or struck from the list");
  }
  return odeval::test::verdict();
}
