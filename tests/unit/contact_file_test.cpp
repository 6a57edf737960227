// Files whose contacts are those of one shape of a body: what becomes of them, and what is refused.
#include <algorithm>
#include <string>

#include "tests/check.hpp"
#include "tests/scenario_text.hpp"

namespace {

using namespace odeval;
using test::read;
using test::refused;
using test::replaced;

const std::string sled = R"(problem = "mechanism"
duration = 1
[[planes]]
name = "floor"
[[bodies]]
name = "sled"
mass = 1
size = [1, 0.2, 0.1]
position = [0, 0, 1]
[[bodies.shapes]]
name = "heel"
shape = "sphere"
size = [0.1, 0.1, 0.1]
position = [-0.4, 0, -0.1]
[[bodies.shapes]]
name = "toe"
shape = "sphere"
size = [0.1, 0.1, 0.1]
mass = 0.5
position = [0.4, 0, -0.1]
[[bodies]]
name = "ball"
shape = "sphere"
mass = 1
size = [0.2, 0.2, 0.2]
position = [0, 0, 2]
[[contacts]]
between = ["sled.heel", "floor"]
friction = 0.4
[[contacts]]
between = ["ball", "sled.toe"]
restitution = 0.5
[[contacts]]
between = ["sled", "floor"]
)";

bool is_defined(const Scenario& scenario, const std::string& key) {
  return std::ranges::any_of(scenario.definition, [&](const auto& setting) { return setting.first == key; });
}

void shapes_have_names() {
  const Scenario scenario = read(sled);
  const Body& body = scenario.mechanism.bodies.at(0);
  const std::vector<Part> parts = body.parts();
  CHECK_EQUAL(parts.size(), 3U);
  CHECK_EQUAL(body.touches_as(parts.at(0)), "sled");  // its own, which has no name
  CHECK_EQUAL(body.touches_as(parts.at(1)), "sled.heel");
  CHECK_EQUAL(body.touches_as(parts.at(2)), "sled.toe");
  const Body& ball = scenario.mechanism.bodies.at(1);
  CHECK_EQUAL(ball.touches_as(ball.parts().at(0)), "ball");
  const std::vector<Contact>& contacts = scenario.mechanism.contacts;
  CHECK(contacts.at(0).first == "sled.heel" && contacts.at(0).second == "floor");
  CHECK(contacts.at(1).first == "ball" && contacts.at(1).second == "sled.toe");
  for (const char* key : {"bodies.0.shapes.0.name", "bodies.0.shapes.1.name", "contacts.0.between.0"}) {
    CHECK(is_defined(scenario, key));
  }
  CHECK(!is_defined(read(replaced(replaced(sled, "name = \"heel\"\n", ""), "sled.heel", "sled.toe")),
                    "bodies.0.shapes.0.name"));
}

void wrong(const char* what, const char* with, const char* message) { refused(replaced(sled, what, with), message); }

void bad_names() {
  wrong("[\"sled.heel\"", "[\"sled.heal\"",
        "contacts.0.between.0 = sled.heal: is no body with a shape of that name (nearest: 'sled.heel')");
  wrong("[\"sled.heel\"", "[\"slde.heel\"",
        "contacts.0.between.0 = slde.heel: is no body with a shape of that name (nearest: 'sled.heel')");
  wrong("[\"ball\",", "[\"ball.heel\",", "contacts.1.between.0 = ball.heel: is no body with a shape of that name");
  wrong("\"floor\"]\nfriction", "\"floor.top\"]\nfriction",
        "contacts.0.between.1 = floor.top: is no body with a shape");
  for (const char* name : {"sled.", ".heel", "sled.heel.tip", "sled..heel", "sl ed.heel"}) {
    wrong("sled.heel", name, ("contacts.0.between.0 = '" + std::string(name) + "': must be a list of 2 names").c_str());
  }
  wrong("name = \"toe\"", "name = \"heel\"", "bodies.0.shapes.1.name = heel: is the name of bodies.0.shapes.0 as well");
  wrong("name = \"toe\"", "name = \"big toe\"",
        "bodies.0.shapes.1.name = 'big toe': must be a name of at most 40 letters, digits, '_' and '-'");
  wrong("[\"ball\", \"sled.toe\"]", "[\"sled.heel\", \"sled.toe\"]",
        "contacts.1.between = [sled.heel, sled.toe]: are of one body, whose shapes do not touch one another");
  wrong("[\"ball\", \"sled.toe\"]", "[\"sled\", \"sled.toe\"]",
        "contacts.1.between = [sled, sled.toe]: are of one body, whose shapes do not touch one another");
  refused(sled + "[[joints]]\nkind = \"ball\"\nparent = \"sled\"\nchild = \"ball\"\n",
          "contacts.1.between = [ball, sled.toe]: hang together by joint 'joint1': they pass through each other");
}

/// The first table that names both counts, so that one behind it that names no others is of nothing.
void tables_that_come_too_late() {
  const char* const late = "contacts.3 does nothing: contacts.2 before it says how all that it names touch";
  refused(sled + "[[contacts]]\nbetween = [\"floor\", \"sled.toe\"]\nfriction = 0.2\n", late);
  refused(sled + "[[contacts]]\nbetween = [\"floor\", \"sled\"]\n", late);
  refused(sled + "[[contacts]]\n[[contacts]]\nbetween = [\"ball\", \"floor\"]\n",
          "contacts.4 does nothing: contacts.3 before it");
  refused(sled + "[[contacts]]\n[[contacts]]\n", "contacts.4 does nothing: contacts.3 before it");
  CHECK_EQUAL(read(sled + "[[contacts]]\nbetween = [\"floor\", \"ball\"]\n[[contacts]]\n").mechanism.contacts.size(),
              5U);
}

// Softness ---------------------------------------------------------------------------------------------------------

const std::string soft = replaced(replaced(sled, "friction = 0.4\n", "friction = 0.4\nkp = 3000\nkd = 20\n"),
                                  "restitution = 0.5\n", "restitution = 0.5\nerp = 0.3\ncfm = 0.01\n");

void contacts_have_a_softness_of_their_own() {
  const Scenario scenario = read(soft);
  const std::vector<Contact>& contacts = scenario.mechanism.contacts;
  const Contact& spring = contacts.at(0);
  CHECK(spring.spring && !spring.softness && spring.spring->kp_N_m == 3000 && spring.spring->kd_Ns_m == 20);
  CHECK_EQUAL(spring.friction->limit, 0.4);
  // Eqs. 3.6 and 3.7: h kp / (h kp + kd) and 1 / (h kp + kd).
  CHECK_NEAR(spring.softness_at(1e-3)->erp, 3.0 / 23, 1e-15);
  CHECK_NEAR(spring.softness_at(1e-3)->cfm, 1.0 / 23, 1e-15);
  CHECK_NEAR(spring.softness_at(1e-2)->erp, 30.0 / 50, 1e-15);
  const Contact& numbers = contacts.at(1);
  CHECK(!numbers.spring && numbers.softness && numbers.softness->erp == 0.3 && numbers.softness->cfm == 0.01);
  CHECK(numbers.softness_at(1e-3)->erp == 0.3 && numbers.softness_at(1e-2)->cfm == 0.01);
  CHECK(!contacts.at(2).softness_at(1e-3));
  for (const char* key : {"contacts.0.kp", "contacts.0.kd", "contacts.1.erp", "contacts.1.cfm"}) {
    CHECK(is_defined(scenario, key));
  }
  // What has none of it says none of it; and of a spring no restitution.
  for (const char* key : {"contacts.0.erp", "contacts.0.restitution", "contacts.1.kp", "contacts.2.erp"}) {
    CHECK(!is_defined(scenario, key));
  }
  CHECK(is_defined(scenario, "contacts.2.restitution"));
  const Scenario changed = read(soft, {{"contacts.0.kp", "500", "--set"}});
  CHECK_EQUAL(changed.mechanism.contacts.at(0).spring->kp_N_m, 500.0);
}

void bad_softness() {
  const auto not_so = [](const char* what, const char* with, const char* message) {
    refused(replaced(soft, what, with), message);
  };
  not_so("kp = 3000\n", "", "contacts.0.kd = 20: needs kp beside it");
  not_so("kd = 20\n", "", "contacts.0.kp = 3000: needs kd beside it");
  not_so("erp = 0.3\n", "", "contacts.1.cfm = 0.01: needs erp beside it");
  not_so("cfm = 0.01\n", "", "contacts.1.erp = 0.3: needs cfm beside it");
  not_so("kd = 20\n", "kd = 20\nerp = 0.2\n",
         "contacts.0.erp = 0.2: says the same as kp and kd; give one pair or the other");
  not_so("erp = 0.3\n", "erp = 0.3\nkp = 100\nkd = 1\n",
         "contacts.1.erp = 0.3: says the same as kp and kd; give one pair or the other");
  not_so(
      "kd = 20\n", "kd = 20\nrestitution = 0.0\n",
      "contacts.0.restitution = 0.0: has no effect beside kp and kd, which make what a bounce gives back; remove it");
  not_so("kp = 3000\nkd = 20", "kp = 0.5\nkd = 0",
         "contacts.0.kd = 0: must make step * kp + kd at least 0.001 N s/m; it is 0.0005");
  not_so("erp = 0.3", "erp = 1.3", "contacts.1.erp = 1.3: must be a number from 0 to 1");
  not_so("kd = 20", "kd = nan", "contacts.0.kd = nan: must be a number from 0");
  CHECK_THROWS(read(sled, {{"contacts.0.kp", "500", "--set"}}), UserError,
               "--set contacts.0.kp=500: contacts.0.kp needs kd beside it");
}

}  // namespace

int main() {
  shapes_have_names();
  bad_names();
  tables_that_come_too_late();
  contacts_have_a_softness_of_their_own();
  bad_softness();
  return test::verdict();
}
