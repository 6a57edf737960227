// The page of an audit: it says what the answer says, leaves out what there is none of, and shows nothing that is no
// number.
//   audit_page_test [FILE]   also writes the page, to look at
#include <algorithm>
#include <cmath>
#include <regex>

#include "output/audit_answer.hpp"
#include "output/file.hpp"
#include "report/audit_page.hpp"
#include "report/gnuplot.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using audit::Answer;
using audit::Convergence;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Two bodies on a hinge over the ground, in three refined runs; the last error has no limit.
Answer some_answer() {
  Answer answer;
  answer.program = "./walk <fast>";
  answer.stepper = "dWorldStep";
  answer.h_s = 0.001;
  answer.bodies = 2;
  answer.joints = 1;
  answer.contacts = 4;
  answer.body_names[2] = "left & foot";
  for (const int k : {1, 2, 4}) {
    answer.runs.push_back(
        {.refinement = k, .what = "run", .end = "exit status 0", .steps = 2000, .simulated_s = 1.9999999});
  }
  for (const double t : {1.0, 2.0}) {
    const auto convergence = t < 2 ? Convergence::settled : Convergence::none;
    answer.error_at.push_back({.t_s = t,
                               .distance_m = {0.0125, 1e-4, convergence},
                               .turn_rad = {0.02, 1e-4, convergence},
                               .order = 1.0,
                               .body = 2,
                               .of_runs = {0.0125, 0.0062, 0.003}});
    answer.error_of_body.push_back({t, 2, {0.0125, 1e-4, convergence}, {0.02, 1e-4, convergence}});
  }
  answer.lost_at_s = 1.5;
  answer.lost_body = 1;
  answer.until_s = 2;
  answer.steps_for_t_s = 1;
  answer.steps_for = {{1e-3, std::nullopt}, {1e-1, 0.001}};
  answer.tried.push_back({.set = "erp=0.8",
                          .error = {{0.01, 1e-4, Convergence::settled}, {NAN, NAN, Convergence::none}},
                          .cpu = 1.1,
                          .work = 1});
  for (int i = 0; i <= 20; ++i) {
    const double t = 0.1 * i;
    answer.error_over_time.push_back({t, {0.006 * t, 0.003 * t, i == 20 ? NAN : 0.0015 * t}, 1e-5 * t});
    answer.energy_over_time.push_back({t, 1 - t / 3, t / 3, {.added = 0.1 * t}, 1e-4 * t, 1e-3});
  }
  answer.energy = {.begin_J = 1, .end_J = 1, .error_J = {0.01, 1e-3, Convergence::settled}};
  answer.work = {.added = 0.2, .motors = 0.1};
  answer.gap = {1e-4, 1, 1};
  answer.joint_summaries.push_back({.kind = "hinge", .number = 1, .bodies = {1, 2}, .steps = 2000, .largest_m = 1e-4});
  answer.joint_summaries.push_back({.kind = "contact", .bodies = {2, 0}, .steps = 10, .largest_m = 1e-3});
  answer.limits = {"forces count as constant"};
  return answer;
}

/// A part without a limit does not stand for the other one.
void says_which_part_settles() {
  audit::ErrorUntil row;
  row.distance_m = {0.1, 1e-4, Convergence::settled};
  row.turn_rad = {0.2, 3, Convergence::none};
  CHECK_EQUAL(convergence_words(row), "settled, turn none");
  row.distance_m.convergence = Convergence::none;
  CHECK_EQUAL(convergence_words(row), "none");
  row.turn_rad.convergence = Convergence::rough;
  CHECK_EQUAL(convergence_words(row), "rough, place none");
}

report::Page page_of(const Answer& answer) {
  return report::audit_page(answer, {.pictures = {}, .command = "odeval audit -- x", .environment = {{"ODE", "0.16"}}});
}

std::string visible(const std::string& html) {
  return std::regex_replace(html.substr(html.find("<body>")), std::regex("<[^>]*>"), " ");
}

void says_the_answer(const std::string& html) {
  CHECK(has(html,
            "Until 1 s body 2 (left &amp; foot) is up to 0.0125 ± 0.0001 m from where it would be at a step of 0. "
            "From 1.5 s on it is another motion."));
  CHECK(has(html, "<code>./walk &lt;fast&gt;</code>"));
  CHECK(has(html,
            "<dt>motion</dt><dd>lost at 1.5 s: body 1 is off by more than a tenth of how far it has gone until then"));
  CHECK(has(html, "<dt>ODE</dt><dd>0.16</dd>"));
  CHECK(has(html, "<td class=\"whole\">erp=0.8</td><td class=\"number\">0.01</td>"));
  CHECK(has(html, "steps down to h/4 do not bring the runs together</p>"));
  CHECK(has(html, "<td>body 2 (left &amp; foot), the world</td>"));
  CHECK(has(html, "forces count as constant"));
  CHECK(has(html, "Until 2 s</b>"));  // of a sum of steps
  CHECK(!std::regex_search(visible(html), std::regex("\\b(nan|inf|NaN|Infinity)\\b")));
}

void leaves_out_what_there_is_none_of() {
  Answer answer = some_answer();
  answer.contacts = 0;
  answer.joints = 0;
  const std::string html = page_of(answer).html;
  CHECK(has(html, "<section id=\"energy\">") && has(html, "<section id=\"error\">"));
  CHECK(!has(html, "<section id=\"joints\">") && !has(html, "<section id=\"contacts\">"));

  Answer none;
  none.program = "true";
  none.reason = "it took no step";
  none.runs.emplace_back();
  const std::string reason = page_of(none).html;
  CHECK(has(reason, "<p class=\"lead\">No error can be told: it took no step.</p>"));
  CHECK(!has(reason, "<section id=\"error\">") && !has(reason, "<section id=\"energy\">"));
}

/// What is known by its size only, and what was tried and changes nothing, in the terminal, on the page and for
/// programs.
void says_no_more_than_is_known() {
  Answer answer = some_answer();
  answer.steps_for = {{1e-3, std::nullopt}, {1e-2, std::nullopt}, {1e-1, 0.001}};
  const auto tried = [&answer](const char* set, double error, bool asked) {
    const audit::Estimate its{error, 1e-4, Convergence::settled};
    answer.tried.push_back({.set = set, .error = {its, its}, .cpu = 1, .work = 1, .asked = asked});
  };
  tried("w=1", 0.012503, false);
  tried("w=1.5", 0.012497, false);
  tried("cfm=0.1", 0.0125, true);
  const std::string text = audit_text(answer);
  CHECK(has(text, "of 1 mm, of 1 cm: none down to 0.00025 s is known to keep it, of 10 cm: this one\n"));
  CHECK(has(text, "as it is: 0.0125 m, erp=0.8: 0.01 m, cfm=0.1: 0.0125 m; the same to three digits: w=1.5, w=1\n"));

  answer.error_at.front().distance_m = {0.296, 0.3, Convergence::rough};
  answer.error_at.front().turn_rad = {0.3, 0.301, Convergence::rough};
  const std::string rough = audit_text(answer);
  CHECK(has(rough, "at most 0.6  ") && has(rough, "at most 0.61  ") && !has(rough, "0.296"));
  CHECK(has(rough, "as it is: at most 0.6 m"));
  const std::string html = page_of(answer).html;
  CHECK(has(html, "is at most 0.6 m from where") && has(html, "at most 0.61") && !has(html, "0.296 ±"));
  CHECK(has(audit_json(answer), "\"only_bounded\": true"));
  answer.error_at.front().distance_m.uncertainty = 0.29;
  CHECK(has(audit_text(answer), "0.296 ± 0.3"));  // rounded: 0.29
}

// A contact's softness shows where it takes longer than the finest step, a quarter of a millisecond, however long the
// program's own is; held as a number it is another at each step.
void stiff_is_what_the_finest_step_does_not_show() {
  Answer answer = some_answer();
  for (const auto& [stops_in_s, stiff] : {std::pair{0.0, false}, {2.4e-4, true}, {2.6e-4, false}, {2e-3, false}}) {
    answer.contact_s = stops_in_s;
    CHECK_EQUAL(has(audit_text(answer), "with rigid contacts"), stiff);
  }
  answer.contact_s = 2.4e-4;
  answer.springs_held = false;
  CHECK(!has(audit_text(answer), "with rigid contacts"));
}

std::string line_of(const Answer& answer, const std::string& name) {
  for (const auto& [its, what] : audit_lines(answer)) {
    if (its == name) return what;
  }
  return "";
}

/// All that is wrong with it is told, which part it is, and what may help.
void says_what_is_wrong() {
  Answer answer = some_answer();
  audit::ErrorUntil& first = answer.error_at[0];
  audit::ErrorUntil& second = answer.error_at[1];
  CHECK_EQUAL(line_of(answer, "verdict"), "h = 0.001 s is too coarse for this motion from 1.5 s on");
  first.turn_rad.convergence = Convergence::rough;
  CHECK(has(line_of(answer, "verdict"), "until 1 s the turn is known to its size only"));
  first.distance_m.convergence = Convergence::rough;
  CHECK(has(line_of(answer, "verdict"), "until 1 s the error and the turn are each known to its size only"));
  first.turn_rad.convergence = Convergence::settled;
  CHECK(has(line_of(answer, "verdict"), "until 1 s the error is known to its size only"));
  CHECK(has(line_of(answer, "verdict"), "; h = 0.001 s is too coarse for this motion from 1.5 s on"));
  answer.lost_at_s.reset();
  CHECK(has(line_of(answer, "verdict"),
            "; until 2 s steps down to h/4 do not bring the runs together: nothing is extrapolated there, and finer "
            "ones may do (--refine 1,2,4,8,16)"));
  second.distance_m.convergence = Convergence::settled;
  CHECK(has(line_of(answer, "verdict"), "do not bring the turns together"));
  second.turn_rad.convergence = Convergence::settled;
  second.distance_m.convergence = Convergence::none;
  CHECK(has(line_of(answer, "verdict"), "do not bring the places together"));
  CHECK(has(page_of(answer).html, "of 0. After that steps down to h/4 do not bring the runs together.</p>"));
  answer.chaos_from_s = 1.8;
  CHECK(!has(line_of(answer, "verdict"), "--refine"));
  answer.lost_at_s = 2.1;
  CHECK(has(page_of(answer).html, "bring the runs together. From 2.1 s on it is another motion.</p>"));
  CHECK(!has(line_of(answer, "verdict"), "too coarse"));
}

/// Whether no step helps, or the step is what is wrong.
void tells_chaos_from_the_step() {
  Answer answer = some_answer();
  CHECK_EQUAL(line_of(answer, "chaos"), "");
  answer.growth = 1;
  CHECK_EQUAL(line_of(answer, "chaos"),
              "none: starts that differ by 1e-10 m stay as close, so the step makes the error");
  answer.growth = 1e5;
  CHECK_EQUAL(line_of(answer, "chaos"),
              "not yet: starts that differ by 1e-10 m are at most 1e-05 m apart, so the step makes the error");
  answer.flies_apart = true;
  CHECK(has(line_of(answer, "chaos"), "end 1e-05 m apart, as nothing does at the smallest step"));
  answer.chaos_from_s = 1.8;
  CHECK_EQUAL(line_of(answer, "chaos"),
              "from 1.8 s on starts that differ by 1e-10 m part by as much as the error: no step helps");
}

/// Where there is no limit, nothing is held against it, and what was asked for is told.
void holds_nothing_against_no_limit() {
  Answer answer = some_answer();
  for (audit::ErrorUntil& row : answer.error_at)
    row.distance_m.convergence = row.turn_rad.convergence = Convergence::none;
  answer.tried.push_back({.set = "w=1", .error = {{0.01, 1e-4, Convergence::none}}, .asked = true});
  CHECK_EQUAL(line_of(answer, "settings"), "w=1: there is no limit to hold them against");
  CHECK(has(line_of(answer, "step"), "none is told"));
  CHECK(!has(line_of(answer, "settings"), "erp=0.8"));
}

/// What is next to nothing is no finding; what adds up to nothing is one.
void leaves_rounding_out() {
  Answer answer = some_answer();
  answer.work = {.motors = 1, .stops = -1, .joints = -1e-10};
  answer.energy = {.begin_J = 1, .end_J = 1, .error_J = {2e-14, 0, Convergence::settled}};
  CHECK_EQUAL(line_of(answer, "work"), "motors +1 J, stops -1 J");
  CHECK(has(line_of(answer, "energy"), "error below 1e-09 J"));
  answer.gap = {5e-10, 1, 1};
  CHECK_EQUAL(line_of(answer, "joints"), "none is more than 1e-06 m apart");
  answer.error_at[0].distance_m = {2e-14, 0, Convergence::settled};
  CHECK(has(audit_text(answer), "below 1e-09") && !has(audit_text(answer), "± 0 "));
  answer.bodies_made = 7;
  CHECK(has(audit_text(answer), "; 7 bodies, 2 at a time, 1 joint; "));
  answer.tried.push_back({.set = "cfm=0", .error = {{1, 0, Convergence::settled}}, .is_own = true, .asked = true});
  answer.error_at[0].distance_m = {0.1, 0, Convergence::settled};
  CHECK(has(line_of(answer, "settings"), "cfm=0: changes nothing"));
}

/// All that there can be to say at once is 25 lines, and how many limits there are besides is said.
void says_it_in_25_lines() {
  Answer answer = some_answer();
  while (answer.error_at.size() < 6) answer.error_at.push_back(answer.error_at.front());
  answer.diverged = audit::Parting{1900, 1.9, 1};
  answer.growth = 5;
  answer.softness_m = 1;
  answer.messages = 1;
  answer.first_message = "LCP";
  answer.limits = {"one", "two"};
  const auto lines = [](const std::string& text) { return std::ranges::count(text, '\n'); };
  const std::string whole = audit_text(answer);
  CHECK_EQUAL(lines(whole), 25);
  for (const auto& [name, what] : audit_lines(answer)) CHECK(has(whole, name + "  ") && has(whole, what));
  CHECK_EQUAL(audit_lines(answer).size(), 12U);  // all that there are
  CHECK(has(whole, "limits     one\n           two\n") && !has(whole, "more on the page"));
  answer.limits = {"one", "two", "three", "four"};
  const std::string cut = audit_text(answer);
  CHECK_EQUAL(lines(cut), 25);
  CHECK(has(cut, "limits     one\n           and 3 more on the page\n") && !has(cut, "two"));
}

/// What is not followed of a kind of joint is no 0.
void tells_what_is_not_followed() {
  Answer answer = some_answer();
  answer.joint_summaries[0] = {.kind = "pr", .number = 1, .largest_m = NAN, .motor_work_J = NAN};
  const std::string json = audit_json(answer);
  for (const char* key : {"gap", "motor_work", "steps_at_limit", "steps_at_stop"})
    CHECK(has(json, std::string("\"") + key + "\": null"));
  CHECK(has(page_of(answer).html, "not followed"));
}

}  // namespace

int main(int argc, char** argv) {
  says_which_part_settles();
  const report::Page page = page_of(some_answer());
  if (argc > 1) write_whole(argv[1], page.html);
  says_the_answer(page.html);
  if (report::gnuplot_version().starts_with("gnuplot ")) CHECK_EQUAL(page.missing.size(), 0U);
  leaves_out_what_there_is_none_of();
  says_no_more_than_is_known();
  says_what_is_wrong();
  tells_chaos_from_the_step();
  holds_nothing_against_no_limit();
  stiff_is_what_the_finest_step_does_not_show();
  leaves_rounding_out();
  says_it_in_25_lines();
  tells_what_is_not_followed();
  return test::verdict();
}
