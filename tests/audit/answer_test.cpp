// What a whole audit says of programs (of plain/) of which it is known, beside the error that truth_test holds it to.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using namespace odeval;
using Json = nlohmann::json;

struct Said {
  Json json;
  std::string text;
};

std::string read(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Of a second in steps of 1 ms.
Said audit(const std::string& scenario) {
  const test::TemporaryFolder folder;
  const std::string command = ODEVAL_PROGRAM " audit --out " + folder.path().string() + " -- " ODEVAL_PLAIN " " +
                              scenario + " 0.001 1 > " + (folder.path() / "text").string();
  CHECK_EQUAL(std::system(command.c_str()), 0);
  return {Json::parse(read(folder.path() / "audit" / "answer.json")), read(folder.path() / "text")};
}

/// The number in the text where the expression has its group; none where it is not there.
double number_in(const std::string& text, const char* expression) {
  std::smatch found;
  return std::regex_search(text, found, std::regex(expression)) ? std::stod(found[1]) : NAN;
}

// A box in flight: ODE's gravity takes m g^2 h t / 2 of its energy, which the step has and no force, and its spin's
// part of it, 0.013 J measured. Nothing else changes it at a step of 0, so that this is the error. What its start is
// moved by it keeps.
void of_a_free_box() {
  const Said its = audit("free_box");
  const Json& energy = its.json["energy"];
  const double change = energy["end"].get<double>() - energy["begin"].get<double>();
  CHECK_NEAR(change, -10 * 9.8 * 9.8 * 1e-3 / 2, 0.02);
  CHECK_NEAR(energy["error"]["value"].get<double>(), -change, energy["error"]["uncertainty"].get<double>());
  CHECK_EQUAL(energy["error"]["convergence"], "settled");
  CHECK_NEAR(number_in(its.text, "the step's own (\\S+) J"), change, 1e-3);  // of three digits
  CHECK_NEAR(its.json["order"].get<double>(), 1, 1e-3);
  CHECK_NEAR(its.json["growth"].get<double>(), 1, 1e-3);
}

// Of two links the lower one is farther off, each by what it says; QuickStep takes 20 iterations of 10 rows, at 10 ns a
// row, and dWorldStep 125 ns, both 500 ns besides (solver_rows.cpp).
void of_a_double_pendulum() {
  const Said its = audit("double_pendulum");
  const Json& row = its.json["error_at"].back();
  CHECK_EQUAL(row["body"], 2U);
  CHECK_BETWEEN(row["order"].get<double>(), 0.95, 1.05);  // first, with a tenth of the second at most
  double largest = 0;
  for (const Json& body : its.json["error_of_body"]) {
    const double error = body["value"].get<double>();
    largest = std::max(largest, error);
    if (body["body"] == row["body"]) CHECK_EQUAL(error, row["value"].get<double>());
    if (body["body"] != row["body"]) CHECK_BETWEEN(error, 0.1 * row["value"].get<double>(), row["value"]);
  }
  CHECK_EQUAL(largest, row["value"].get<double>());
  for (const Json& tried : its.json["settings"]) {
    const bool quick = tried["set"] == "stepper=quick";
    CHECK_NEAR(tried["work_ratio"].get<double>(), quick ? (500.0 + 20 * 100) / (500 + 125) : 1, 1e-9);
  }
}

// Where in a step a ball bounces no run sees: ± of more than a millimetre, so that none is said to keep one, whatever
// the finest run's value is (0.7 mm).
void of_a_bouncing_ball() {
  const Said its = audit("bouncing_ball");
  const double hidden = its.json["error_at"].back()["uncertainty"];
  CHECK_BETWEEN(hidden, 1e-3, 1e-2);
  for (const Json& step : its.json["step_for"]) {
    const bool is_hidden = hidden > step["error"].get<double>();
    CHECK_EQUAL(step["h"].is_null(), is_hidden);
  }
}

// The motor gets to 0.5 m/s at 5.19 m/s^2 in 96 whole steps, and the box to rest in 679 or 680.
void of_steps_at_limits() {
  CHECK_EQUAL(number_in(audit("motor").text, "the motor of joint 1 is at its limit in (\\S+) % of its steps"), 9.6);
  CHECK_NEAR(number_in(audit("friction_slide").text, "sliding in (\\S+) % of its steps"), 68, 0.15);
}

}  // namespace

int main() {
  of_a_free_box();
  of_a_double_pendulum();
  of_a_bouncing_ball();
  of_steps_at_limits();
  return test::verdict();
}
