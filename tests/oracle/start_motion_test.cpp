// A joint that starts at its q moves as the same one that is drawn there; only its column counts from elsewhere.
#include <cmath>
#include <string>

#include "catalogue/evaluation.hpp"
#include "tests/check.hpp"
#include "tests/scenario_text.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using test::replaced;

const std::string pendulum = R"(problem = "mechanism"
duration = 1
step = 0.002
[[bodies]]
name = "bob"
mass = 1.5
size = [1, 0.1, 0.1]
position = [0.5, 0, 1]
[[joints]]
name = "pivot"
kind = "hinge"
parent = "world"
child = "bob"
anchor = [0, 0, 1]
axis = [0, 1, 0]
)";

/// Of the same pendulum drawn at this angle and rate.
std::string drawn_at(double q, double qd) {
  const double c = std::cos(q) / 2;
  const double s = std::sin(q) / 2;
  const auto list = [](double a, double b, double z) {
    return "[" + std::to_string(a) + ", " + std::to_string(b) + ", " + std::to_string(z) + "]";
  };
  char place[200];
  std::snprintf(place, sizeof place, "position = [%.17g, 0, %.17g]\nvelocity = [%.17g, 0, %.17g]\n", c, 1 - s, -qd * s,
                -qd * c);
  return replaced(pendulum, "position = [0.5, 0, 1]\n",
                  place + ("turn = " + list(0, q, 0)) + "\nspin = " + list(0, qd, 0) + "\n");
}

const std::string loads = R"([[springs]]
joint = "pivot"
stiffness = 4
damping = 0.1
rest = REST
[[controllers]]
joint = "pivot"
kp = 3
kd = 0.2
target = TARGET
)";

void same_motion(const std::string& said, const std::string& drawn, double q, const char* method) {
  catalogue::Evaluator one(test::read(said));
  catalogue::Evaluator two(test::read(drawn));
  const Trace a = one.evaluate(catalogue::find_method(method)).trace;
  const Trace b = two.evaluate(catalogue::find_method(method)).trace;
  CHECK(a.rows() == b.rows() && a.rows() > 400);
  double most = 0;
  double column = 0;
  for (std::size_t k = 0; k < a.rows(); ++k) {
    for (std::size_t d = 0; d < 3; ++d) {
      most = std::fmax(most, std::fabs(a.bodies[0].position[d][k] - b.bodies[0].position[d][k]));
    }
    column = std::fmax(column, std::fabs(a.joints[0].q[k] - b.joints[0].q[k] - q));
  }
  CHECK_NEAR(most, 0, 1e-12);  // seen: 1e-14
  CHECK_NEAR(column, 0, 1e-12);
  CHECK_NEAR(a.joints[0].q.front(), q, 1e-15);
  CHECK_NEAR(a.joints[0].error_q.back(), b.joints[0].error_q.back(), 1e-11);  // the references' own rounding
}

void as_drawn_there() {
  const std::string said = pendulum + "q = 0.5\nqd = 1\n";
  for (const char* method : {"ode-step-double", "ode-rk4-double"}) same_motion(said, drawn_at(0.5, 1), 0.5, method);
}

// Into the upper stop and back, pulled by the spring and pressed by the controller.
void loads_and_stops() {
  const auto with = [&](const std::string& text, const char* stops, const char* rest, const char* target) {
    return text + "stops = " + stops + "\nstop_restitution = 0.5\n" +
           replaced(replaced(loads, "REST", rest), "TARGET", target);
  };
  same_motion(with(pendulum + "q = 0.5\nqd = 1\n", "[-0.25, 0.75]", "0.25", "1"),
              with(drawn_at(0.5, 1), "[-0.75, 0.25]", "-0.25", "0.5"), 0.5, "ode-step-double");
}

const std::string lift = R"(problem  = "mechanism"
duration = 0.1

[[bodies]]
name     = "arm"
mass     = 2.0
size     = [1.0, 0.05, 0.05]
position = [0.5, 0.0, 1.0]

[[bodies]]
name     = "brace"
mass     = 1.0
size     = [1.0, 0.05, 0.05]
position = [0.5, 0.0, 1.3]

[[bodies]]
name     = "platform"
mass     = 5.0
size     = [0.2, 0.4, 0.3]
position = [1.1, 0.0, 1.15]

[[joints]]
name     = "shoulder"
kind     = "hinge"
parent   = "world"
child    = "arm"
anchor   = [0.0, 0.0, 1.0]
axis     = [0.0, -1.0, 0.0]
q        = 0.5
qd       = -1.0

[[joints]]
name     = "upper"
kind     = "hinge"
parent   = "world"
child    = "brace"
anchor   = [0.0, 0.0, 1.3]
axis     = [0.0, -1.0, 0.0]

[[joints]]
name     = "wrist"
kind     = "hinge"
parent   = "arm"
child    = "platform"
anchor   = [1.0, 0.0, 1.0]
axis     = [0.0, -1.0, 0.0]

[[joints]]
name     = "link"
kind     = "hinge"
parent   = "brace"
child    = "platform"
anchor   = [1.0, 0.0, 1.3]
axis     = [0.0, -1.0, 0.0]
)";

// A parallelogram: where one arm is, the other is as well, and the platform stays level.
void a_loop_in_columns() {
  catalogue::Evaluator evaluator(test::read(lift));
  for (const char* method : {"ode-step-double", "ode-rk4-double", "mechanism-cvode"}) {
    const Trace trace = evaluator.evaluate(catalogue::find_method(method)).trace;
    const std::array wanted{0.5, 0.5, -0.5, -0.5};
    for (std::size_t j = 0; j < wanted.size(); ++j) {
      CHECK_NEAR(trace.joints[j].q.front(), wanted[j], 1e-12);
      CHECK_NEAR(trace.joints[j].qd.front(), -2 * wanted[j], 1e-11);
    }
    CHECK_NEAR(trace.bodies[2].position[0].front(), std::cos(0.5) + 0.1, 1e-12);
    CHECK_NEAR(trace.bodies[2].position[2].front(), std::sin(0.5) + 1.15, 1e-12);
    CHECK(std::fabs(trace.joints[1].q.back() - trace.joints[0].q.back()) < 1e-4);  // ODE's gaps at 1 ms
  }
}

// A start that the joints do not quite allow is mended once, for every engine and both references: the first row is
// one.
void a_mended_start() {
  const std::string near = replaced(drawn_at(0.5, 1), "spin = [0.000000, 1.000000", "spin = [0.004, 1.002");
  catalogue::Evaluator evaluator(test::read(near));
  const auto first_of = [&](const char* method) {
    const Trace trace = evaluator.evaluate(catalogue::find_method(method)).trace;
    return Vec3{trace.bodies[0].spin[0].front(), trace.bodies[0].spin[1].front(), trace.bodies[0].spin[2].front()};
  };
  const Vec3 ode = first_of("ode-step-double");
  CHECK_NEAR(ode[0], 0, 1e-14);
  CHECK(ode[1] > 1 && ode[1] < 1.002);
  for (const char* method : {"ode-rk4-double", "ode-rk8-double", "mechanism-cvode"}) {
    CHECK_NEAR(distance(first_of(method), ode), 0, 1e-14);
  }
}

}  // namespace

int main() {
  a_loop_in_columns();
  a_mended_start();
  as_drawn_there();
  loads_and_stops();
  return test::verdict();
}
