// The page of a small document that has every kind of block, and what it says in the place of what is missing.
//   page_test [FILE]   also writes the page, to look at
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <regex>
#include <set>

#include "odeval/error.hpp"
#include "output/file.hpp"
#include "report/files.hpp"
#include "report/gnuplot.hpp"
#include "report/page.hpp"
#include "report/plot.hpp"
#include "report/svg.hpp"
#include "report/text.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using namespace odeval::report;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

constexpr Condition small_confirmed[] = {{"T1.ratio", Relation::at_least, 2}};
constexpr Condition small_refuted[] = {{"T1.ratio", Relation::at_most, 1}};
constexpr Condition open_confirmed[] = {{"T2.never", Relation::at_least, 2}, {"T2.lost", Relation::at_most, 3}};
constexpr Condition open_refuted[] = {{"T2.never", Relation::at_most, 1}};
constexpr Claim test_claims[] = {
    {"T1", "§1", "a < b & \"c\" > 'd'", small_confirmed, small_refuted, "Use <b>, not a.", "curves"},
    {"T2", "§2", "Never measured.", open_confirmed, open_refuted, "", "no-such-section"},
};

Findings some_findings() {
  Findings findings;
  findings.add("T1.ratio", {"error of <a> over b", "", 12.5, 0.25, ""});
  findings.add("T2.lost", {"a number that was lost", "rad", {}, 0, "single precision <not> in this build"});
  findings.add("T3.infinite", {"a number beyond numbers", "", infinity, 0, ""});
  return findings;
}

std::vector<Judged> judged(const Findings& findings) {
  std::vector<Judged> verdicts;
  for (const Claim& claim : test_claims) verdicts.push_back(judge(claim, findings));
  return verdicts;
}

Series wave(const std::string& label, double shift, Mark mark, int colour, bool dashed) {
  Series series{label, {}, {}, mark, colour, dashed};
  const int points = mark == Mark::line ? 200 : 12;
  for (int i = 0; i < points; ++i) {
    series.x.push_back(10.0 * i / (points - 1));
    series.y.push_back(std::sin(series.x.back() + shift));
  }
  return series;
}

Series power(const std::string& label, double order, int colour) {
  Series series{label, {}, {}, Mark::line_and_points, colour, false};
  for (int i = 0; i < 5; ++i) {
    series.x.push_back(std::pow(10.0, -i) * 0.03);
    series.y.push_back(std::pow(series.x.back(), order));
  }
  return series;
}

Figure curves() {
  Figure figure{"fig-waves", "Waves & <shades>.", "Two waves; the second one has two gaps.", {}, 2};
  Panel time{"Waves of <q1>", "t, s", "q1, rad", {}};
  for (int i = 0; i < 4; ++i)
    time.series.push_back(wave("method " + std::to_string(i), 0.4 * i, Mark::line, i, i == 3));
  time.series[1].y[100] = nan;
  time.series[1].y[150] = infinity;
  time.shade = Shade{6.5, "the reference's own uncertainty is larger than what is compared"};
  Panel points{"",
               "t, s",
               "it's q2, rad",
               {wave("method 2", 0, Mark::points, 2, false), wave("other <x>", 1, Mark::line_and_points, 9, true)}};
  figure.panels = {time, points};
  return figure;
}

Figure log_log() {
  Panel panel{
      "", "step, s", "error, rad", {power("first order", 1, 0), power("fourth order", 4, 8), power("next", 2, -1)}};
  panel.log_x = panel.log_y = true;
  panel.series[1].y[4] = 0;  // which no logarithm has
  return {"fig-order", "Order.", "Double logarithmic.", {panel}, 1};
}

Figure circle() {
  Panel panel{"", "y, m", "z, m", {{"", {}, {}, Mark::line, 0, false}}};
  for (int i = 0; i <= 60; ++i) {
    panel.series[0].x.push_back(std::cos(i * 0.104719755));
    panel.series[0].y.push_back(std::sin(i * 0.104719755));
  }
  panel.equal_axes = true;
  Panel flat{"", "t, s", "constant", {{"flat", {0, 1, 2}, {3, 3, 3}, Mark::line, -1, false}}};
  flat.y_range = {2, 5};
  Panel none{"", "t, s", "nothing", {{"none", {0, 1, 2}, {nan, infinity, nan}, Mark::line, -1, false}}};
  return {"fig-circle", "Circle.", "One metre across is one metre up.", {panel, flat, none}, 3};
}

Table table() {
  return {"numbers",
          "Numbers of <all> kinds.",
          {"method", "steps", "error, rad", "time, s"},
          {{"a & b", 10000.0, 0.00888123, 1.0},
           {"single", Missing{"not <built>"}, Missing{"not <built>"}, nan},
           {"with, comma \"q\"", 1e9, 5.37e-5, 0.999999}},
          "What one has to know."};
}

Document every_block() {
  Document document;
  document.front = {{"answer", "The <answer>", {Text{"So & so."}, Highlight{"One <sentence>.", circle(), "curves"}}}};
  document.sections = {{"curves", "Curves & <tables>", {Text{"Plain <words> & more."}, curves(), log_log(), table()}},
                       {"numbers",
                        "A section named as a table",
                        {circle(), Picture{"pic", "A <picture>.", "Of \"it\".", "\x89PNG\r\n"}}}};
  document.files = {{"traces", {"double_pendulum/a.csv", "double_pendulum/b.csv"}}};
  document.command = "odeval report --out <dir>";
  document.environment = {{"odeval", "0 <&>"}};
  return document;
}

Page page_of(const Document& document) {
  const Findings findings = some_findings();
  return make_page(document, judged(findings), findings);
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

bool holds_text(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<std::string> matches(const std::string& text, const std::string& pattern) {
  std::vector<std::string> all;
  const std::regex wanted(pattern);
  for (std::sregex_iterator at(text.begin(), text.end(), wanted); at != std::sregex_iterator(); ++at)
    all.push_back((*at)[1]);
  return all;
}

void numbers_have_three_digits() {
  CHECK_EQUAL(shown(0.0), "0");
  CHECK_EQUAL(shown(-0.0), "0");
  CHECK_EQUAL(shown(1.0), "1");
  CHECK_EQUAL(shown(0.2), "0.2");
  CHECK_EQUAL(shown(-0.25), "-0.25");
  CHECK_EQUAL(shown(0.999999), "1.00");
  CHECK_EQUAL(shown(0.00888123), "0.00888");
  CHECK_EQUAL(shown(5.3712e-5), "5.37e-5");
  CHECK_EQUAL(shown(1e-12), "1e-12");
  CHECK_EQUAL(shown(10000.0), "10000");
  CHECK_EQUAL(shown(12345.6), "12300");
  CHECK_EQUAL(shown(999.6), "1000");
  CHECK_EQUAL(shown(123.45), "123");
  CHECK_EQUAL(shown(-1e9), "-1e9");
  CHECK_EQUAL(shown(1.23456e22), "1.23e22");
  CHECK_EQUAL(shown(Finding{"", "rad", 0.00888123, 3.3e-10, ""}), "0.00888 ± 3e-10 rad");
  CHECK_EQUAL(shown(Finding{"", "", 2.0, 0, ""}), "2");
}

void bytes_become_base64() {  // RFC 4648, section 10
  CHECK_EQUAL(base64(""), "");
  CHECK_EQUAL(base64("f"), "Zg==");
  CHECK_EQUAL(base64("fo"), "Zm8=");
  CHECK_EQUAL(base64("foo"), "Zm9v");
  CHECK_EQUAL(base64("foobar"), "Zm9vYmFy");
  CHECK_EQUAL(base64("\xff\xfe\xfd"), "//79");
}

void text_is_escaped(const std::string& html) {
  for (const char* const raw :
       {"a < b", "<all>", "<tables>", "<words>", "<not>", "<built>", "<dir>", "<picture>", "<x>", "<&>", "<a> over"}) {
    CHECK(!holds_text(html, raw));
  }
  CHECK(holds_text(html, "a &lt; b &amp; &quot;c&quot; &gt; &#39;d&#39;"));
  CHECK(holds_text(html, "Use &lt;b&gt;, not a."));
  CHECK(holds_text(html, "other &lt;x&gt;"));
  CHECK(holds_text(html, "single precision &lt;not&gt; in this build"));
}

void ids_are_unique_and_links_have_a_target(const std::string& html) {
  const std::vector<std::string> ids = matches(html, " id=\"([^\"]*)\"");
  const std::set<std::string> known(ids.begin(), ids.end());
  CHECK_EQUAL(known.size(), ids.size());
  for (const std::string& target : matches(html, "href=\"#([^\"]*)\"")) {
    if (!known.contains(target)) CHECK_EQUAL(target, "an id of the page");
  }
  CHECK(known.contains("numbers"));
  CHECK(known.contains("table-numbers"));  // the section has the plain name
  CHECK(!holds_text(html, "no-such-section"));
}

void every_panel_is_drawn_or_accounted_for(const Page& page) {
  CHECK_EQUAL(count(page.html, "<svg class=\"plot\""), 6U);
  CHECK_EQUAL(page.missing.size(), 1U);
  CHECK_EQUAL(page.missing.at(0), "fig-circle: there is no number to draw");
  CHECK(holds_text(page.html, "A plot of nothing against t, s is missing here: there is no number to draw."));
  CHECK(holds_text(page.html, "none <span class=\"missing\">(no number to draw)</span>"));
  CHECK(holds_text(page.html, "Shaded from t = 6.5 s on: the reference&#39;s own uncertainty"));
  CHECK(holds_text(page.html, "aria-label=\"q1, rad against t, s: method 0, method 1, method 2, method 3\""));
  for (const char* const other : {"Arial", "rgb(", "black", "xlink", "white'", "<filter", "<?xml"})
    CHECK(!holds_text(page.html.substr(page.html.find("<main>")), other));
}

void what_is_missing_is_said_in_its_place(const std::string& html) {
  CHECK(
      holds_text(html, "—<sup>a</sup></td><td class=\"number\">—<sup>a</sup></td><td class=\"number\">—<sup>b</sup>"));
  CHECK(holds_text(html, "<sup>a</sup> not &lt;built&gt;</p>"));
  CHECK(holds_text(html, "<sup>b</sup> no finite number</p>"));
  CHECK(holds_text(html, "single precision &lt;not&gt; in this build; no experiment measures T2.never"));
  CHECK(holds_text(html, "<span class=\"verdict not-measured\">not measured</span>"));
  CHECK(holds_text(html, "2 claims: 1 confirmed, 1 not measured."));
  const std::string visible = std::regex_replace(html.substr(html.find("<body>")), std::regex("<[^>]*>"), " ");
  CHECK(!std::regex_search(visible, std::regex("\\b(nan|inf|NaN|Infinity)\\b")));
}

void files_are_linked(const std::string& html) {
  CHECK(holds_text(html,
                   "<li>traces: <a href=\"double_pendulum/a.csv\">a.csv</a>, "
                   "<a href=\"double_pendulum/b.csv\">b.csv</a></li>"));
  CHECK(holds_text(html, "<a href=\"report/numbers.csv\">CSV</a>"));
}

void a_verdict_shows_its_numbers_and_rule(const std::string& html) {
  CHECK(holds_text(html, "error of &lt;a&gt; over b <b class=\"whole\">12.5 ± 0.2</b>"));
  CHECK(holds_text(html,
                   "<code>T1.ratio</code> <span class=\"whole\">≥ 2</span>: measured <span class=\"whole\">12.5 ± "
                   "0.2</span>, which <b>holds</b>"));
  CHECK(holds_text(html,
                   "<code>T1.ratio</code> <span class=\"whole\">≤ 1</span>: measured <span class=\"whole\">12.5 ± "
                   "0.2</span>, which <b>does not hold</b>"));
  CHECK(holds_text(
      html, "<code>T2.never</code> <span class=\"whole\">≥ 2</span>: <span class=\"missing\">not measured</span>"));
}

/// ± is the reference's; what else is not known is a range.
void an_uncertainty_says_what_it_is() {
  Finding finding{"", "rad", 12.5, 0.25, ""};
  CHECK_EQUAL(shown(finding), "12.5 ± 0.2 rad");
  finding.source = Source::fit;
  CHECK_EQUAL(shown(finding), "12.5 rad (12.2 to 12.8)");
  finding.uncertainty = 1e-3;  // three digits do not tell its ends apart
  CHECK_EQUAL(shown(finding), "12.5 rad");
  finding.uncertainty = 0;
  finding.nearby = {7, 13};
  CHECK_EQUAL(shown(finding), "12.5 rad (7 to 13 at neighbouring settings)");
}

/// What everybody reads stands open and first, then the claims; what shows it is folded behind them.
void the_answer_stands_before_the_evidence(const std::string& html) {
  const std::size_t answer = html.find("<h2 id=\"answer\">The &lt;answer&gt;</h2>");
  const std::size_t claims = html.find("<h2 id=\"verdicts\">");
  const std::size_t evidence = html.find("<details><summary><h2>Curves &amp; &lt;tables&gt;</h2>");
  CHECK(answer != std::string::npos && answer < claims && claims < evidence && evidence != std::string::npos);
  CHECK(html.find("<details", answer) > claims);
  CHECK(holds_text(html, "<figcaption>One &lt;sentence&gt;. <a href=\"#curves\">evidence</a></figcaption>"));
  CHECK(holds_text(html, "<td>Use &lt;b&gt;, not a.</td></tr>"));
}

void tables_have_all_digits_beside_the_page() {
  CHECK_EQUAL(table_csv(table()),
              "method,steps,\"error, rad\",\"time, s\"\na & b,10000,0.00888123,1\nsingle,,,nan\n"
              "\"with, comma \"\"q\"\"\",1000000000,5.37e-05,0.999999\n");
  const Findings findings = some_findings();
  CHECK_EQUAL(findings_csv(findings),
              "name,value,uncertainty,unit,meaning,missing,uncertainty_of,nearby_least,nearby_largest\n"
              "T1.ratio,12.5,0.25,,error of <a> over b,,reference,,\n"
              "T2.lost,,,rad,a number that was lost,single precision <not> in this build,,,\n"
              "T3.infinite,inf,0,,a number beyond numbers,,,,\n");
  CHECK_EQUAL(verdicts_csv(judged(findings), findings),
              "claim,verdict,kind,finding,relation,bound,value,uncertainty,unit,holds,missing\n"
              "T1,confirmed,confirmed_if,T1.ratio,>=,2,12.5,0.25,,yes,\n"
              "T1,confirmed,refuted_if,T1.ratio,<=,1,12.5,0.25,,no,\n"
              "T2,not measured,confirmed_if,T2.never,>=,2,,,,,no experiment measures it\n"
              "T2,not measured,confirmed_if,T2.lost,<=,3,,,rad,,single precision <not> in this build\n"
              "T2,not measured,refuted_if,T2.never,<=,1,,,,,no experiment measures it\n");
}

void a_colour_stays_with_its_index() {
  const auto looks = looks_of(curves());
  CHECK_EQUAL(looks[0][2].colour, 2);
  CHECK(looks[0][2].colour == looks[1][0].colour && looks[0][2].marker == looks[1][0].marker);
  CHECK(looks[0][3].dash != looks[0][2].dash);
  const auto order = looks_of(log_log());
  CHECK_EQUAL(order[0][2].colour, first_variant);  // no method's
  Figure twice = log_log();
  twice.panels.push_back(twice.panels[0]);
  const auto both = looks_of(twice);
  CHECK(both[0] == both[1]);  // as many panels as there are, one label has one look
  // No two indices look alike, with or without dashes; what marks a value is dotted, asked for or not.
  std::vector<Look> seen;
  for (int index = 0; index < first_variant + 2 * variant_colours; ++index) {
    for (const bool dashed : {false, true}) {
      if (index == guide_colour && dashed) continue;
      const Look look = looks_of({"", "", "", {{"", "", "", {{"", {}, {}, Mark::line, index, dashed}}}}, 1})[0][0];
      CHECK(std::ranges::none_of(
          seen, [&](const Look& other) { return other.colour == look.colour && other.dash == look.dash; }));
      seen.push_back(look);
    }
  }
}

/// Letters and titles where there are several panels; each with the legend of its own curves; what is grey in one
/// entry.
void a_panel_says_what_it_is(const std::string& html) {
  CHECK(holds_text(html, "<p class=\"panel-title\"><b>a</b> Waves of &lt;q1&gt;</p>"));
  CHECK(holds_text(html, "<p class=\"panel-title\"><b>b</b> it&#39;s q2</p>"));  // of the y axis, without its unit
  CHECK(!holds_text(html, "<b>a</b> error</p>"));                                // alone
  const std::size_t second = html.find("it&#39;s q2</p>");
  const std::string legend = html.substr(second, html.find("</ul>", second) - second);
  CHECK(holds_text(legend, "method 2") && holds_text(legend, "other &lt;x&gt;") && !holds_text(legend, "method 1"));
  Document grey;
  Figure rest{"fig-rest", "", "", {{"", "t, s", "q, rad", {}}}, 1};
  for (const char* const label : {"one", "two", "three"})
    rest.panels[0].series.push_back(wave(label, 0.1, Mark::line, label[0] == 't' ? rest_colour : 0, false));
  grey.sections = {{"rest", "", {rest}}};
  const std::string page = page_of(grey).html;
  CHECK(holds_text(page, "two, three</li>") && count(page, "<svg class=\"swatch\"") == 2);
  // Behind the others.
  CHECK(page.find("<title>two</title>") < page.find("<title>one</title>"));
}

/// The powers of ten that the axes of a plot name.
std::set<int> powers_of(const Panel& panel) {
  std::set<int> powers;
  const std::string svg = plot_svg(panel, looks_of({"", "", "", {panel}, 1})[0], "plot");
  for (const std::string& power : matches(svg, "font-size=\"0.8em\"[^>]*>(-?[0-9]+)<")) {
    powers.insert(std::atoi(power.c_str()));
  }
  return powers;
}

/// A logarithmic axis begins where the data do: what is left of rounding at the start takes none of it, and is told;
/// across it begins and ends at 1, 2 or 5 times a power of ten.
void logarithmic_axes_begin_where_the_data_are() {
  Series error{"error", {}, {}};
  for (int i = 0; i <= 300; ++i) {
    error.x.push_back(0.01 * i);
    error.y.push_back(i < 2 ? 1.1e-16 : std::pow(10, -6 + 0.01 * i));
  }
  Panel panel{"", "t, s", "error, rad", {error}};
  panel.log_y = true;
  CHECK(powers_of(panel) == std::set<int>({-6, -5, -4, -3}));
  CHECK_EQUAL(not_drawn_text(panel), "Not drawn: 2 below 1e-06, of 301");
  panel.series[0].mark = Mark::line_and_points;  // measured one by one
  CHECK(powers_of(panel).contains(-16));
  CHECK_EQUAL(not_drawn_text(panel), "");

  panel = {"", "h, s", "order", {{"error", {1e-4, 5e-4, 2e-3}, {1, 2, 3}, Mark::line_and_points}}};
  panel.log_x = true;
  CHECK(powers_of(panel) == std::set<int>({-4, -3}));  // ends at 2e-3
  panel.series[0].x = {1.5e-3, 2e-3, 4e-3};            // between two powers: from one to the other
  CHECK(powers_of(panel) == std::set<int>({-3, -2}));

  Document document;
  Figure figure{"fig-rounding", "", "So.", {panel, panel}, 2};
  figure.panels[1].series = {error};
  figure.panels[1].log_x = false;
  figure.panels[1].log_y = true;
  document.sections = {{"section", "", {figure}}};
  figure.panels.erase(figure.panels.begin());
  document.front = {{"front", "", {Highlight{"A sentence.", figure, "section"}}}};
  const std::string html = page_of(document).html;
  CHECK(holds_text(html, "So. b: Not drawn: 2 below 1e-06, of 301."));
  CHECK(holds_text(html, "<p class=\"note\">Not drawn: 2 below 1e-06, of 301.</p>"));  // no caption of another
}

void the_same_name_twice_is_a_mistake() {
  Document twice = every_block();
  twice.sections.push_back(twice.sections.back());
  CHECK_THROWS(page_of(twice), std::logic_error, "named 'numbers'");
  Document tables;
  tables.sections = {{"one", "", {table(), table()}}};
  CHECK_THROWS(page_of(tables), std::logic_error, "two tables are named 'numbers'");
}

void gnuplot_fails_in_one_line() {
  try {
    run_gnuplot("plot nonsense nonsense\n");
    CHECK(!"gnuplot takes nonsense");
  } catch (const MachineError& error) {
    CHECK(holds_text(error.what(), "gnuplot: gave up: "));
    CHECK(!holds_text(error.what(), "\n"));
  }
}

// One gnuplot for all draws what one each would, also after one that it could not draw.
void one_gnuplot_draws_the_same() {
  const auto dots = [] {
    return page_svg(run_gnuplot("set terminal svg size 400,300\nset logscale y\nplot '-' with points pt 3\n1 10\n"
                                "2 100\ne\n"),
                    "dots", "");
  };
  const auto line = [] { return page_svg(run_gnuplot("set terminal svg size 300,200\nplot x title 'x'\n"), "x", ""); };
  const std::string dots_alone = dots();
  const std::string line_alone = line();
  const OneGnuplot one;
  CHECK(dots() == dots_alone && line() == line_alone && dots() == dots_alone);
  CHECK_THROWS(run_gnuplot("set multiplot layout 2,1\nplot nonsense\n"), MachineError, "gnuplot: gave up: ");
  CHECK(line() == line_alone);
  CHECK_THROWS(run_gnuplot("exit status 3\n"), MachineError, "gnuplot: ended with status 3");
  CHECK(line() == line_alone);
}

// The path of a curve starts anew after each gap.
void what_is_not_finite_is_a_gap(const std::string& html) {
  const auto starts = [&](const std::string& label) {
    const std::size_t from = html.find("<title>" + label + "</title>");
    return count(html.substr(from, html.find("</g>", from) - from), "M");
  };
  CHECK_EQUAL(starts("method 0"), 1U);
  CHECK_EQUAL(starts("method 1"), 3U);
}

// A page without gnuplot is made all the same.
void without_gnuplot_the_page_says_so() {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  CHECK_THROWS(run_gnuplot("print 1\n"), MachineError, "gnuplot: cannot be started");
  const Page page = page_of(every_block());
  setenv("PATH", path.c_str(), 1);
  CHECK_EQUAL(count(page.html, "<svg class=\"plot\""), 0U);
  CHECK_EQUAL(page.missing.size(), 7U);
  CHECK(holds_text(page.html, "A plot of q1, rad against t, s is missing here: gnuplot: cannot be started"));
  ids_are_unique_and_links_have_a_target(page.html);
}

}  // namespace

int main(int argc, char** argv) {
  const Page page = page_of(every_block());
  if (argc > 1) write_whole(argv[1], page.html);
  numbers_have_three_digits();
  bytes_become_base64();
  text_is_escaped(page.html);
  ids_are_unique_and_links_have_a_target(page.html);
  every_panel_is_drawn_or_accounted_for(page);
  what_is_missing_is_said_in_its_place(page.html);
  files_are_linked(page.html);
  a_verdict_shows_its_numbers_and_rule(page.html);
  an_uncertainty_says_what_it_is();
  the_answer_stands_before_the_evidence(page.html);
  tables_have_all_digits_beside_the_page();
  a_colour_stays_with_its_index();
  a_panel_says_what_it_is(page.html);
  logarithmic_axes_begin_where_the_data_are();
  the_same_name_twice_is_a_mistake();
  what_is_not_finite_is_a_gap(page.html);
  gnuplot_fails_in_one_line();
  one_gnuplot_draws_the_same();
  without_gnuplot_the_page_says_so();
  CHECK(page_of(every_block()).html == page.html);
  return odeval::test::verdict();
}
