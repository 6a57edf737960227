// What a grid, a shard and a front are made of.
#include "run/grid.hpp"

#include "odeval/error.hpp"
#include "run/front.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using namespace odeval::sweep;

bool none_whole(const std::string&) { return false; }
bool all_whole(const std::string&) { return true; }

std::string joined(const Axis& axis) {
  std::string text = axis.key + ":";
  for (const std::string& value : axis.values) text += ' ' + value;
  return text;
}

void axes() {
  CHECK_EQUAL(joined(parse_axis("step=1e-3,0.002", none_whole)), "step: 1e-3 0.002");
  CHECK_EQUAL(joined(parse_axis("q0=[1.0,0.5],[0.1,0.2]", none_whole)), "q0: [1.0,0.5] [0.1,0.2]");
  CHECK_EQUAL(joined(parse_axis("ode.start=\"as,given\",half-step", none_whole)), "ode.start: \"as,given\" half-step");
  // Whole decades are whole decades, and the ends are the ends.
  CHECK_EQUAL(joined(parse_axis("step=log:1e-5:1e-2:4", none_whole)), "step: 1e-05 0.0001 0.001 0.01");
  CHECK_EQUAL(joined(parse_axis("ode.erp=lin:0.1:0.9:5", none_whole)), "ode.erp: 0.1 0.3 0.5 0.7 0.9");
  CHECK_EQUAL(joined(parse_axis("x=lin:1:0:3", none_whole)), "x: 1 0.5 0");
  CHECK_EQUAL(joined(parse_axis("ode.iterations=log:1:10:7", all_whole)), "ode.iterations: 1 2 3 5 7 10");
  // 13 values, each the same factor above the one before, to the 15 digits they are written with.
  const Axis many = parse_axis("step=log:1e-5:1e-2:13", none_whole);
  CHECK_EQUAL(many.values.size(), 13U);
  for (std::size_t i = 1; i < many.values.size(); ++i) {
    CHECK_NEAR(std::stod(many.values[i]) / std::stod(many.values[i - 1]), std::pow(10, 0.25), 1e-13);
  }

  for (const char* bad : {"", "=1", "step", "step=", "step=1,,2", "step=1,1", "step=log:0:1:3", "step=log:1:2",
                          "step=log:1:2:1", "step=log:1:2:3:4", "step=lin:a:2:3", "step=lin:1:inf:3",
                          "step=log:1:2:2000000", "step=lin:1:2:3.5", "step=lin:1:1:2"}) {
    CHECK_THROWS(parse_axis(bad, none_whole), UserError, "--grid");
  }
  // Found by scripts/fuzz: a line break in what is quoted.
  CHECK_THROWS(parse_axis("a=1\n,1\n", none_whole), UserError, "has the value 1  twice");
}

void products() {
  const Grid grid({{"a", {"1", "2"}}, {"b", {"x", "y", "z"}}});
  CHECK_EQUAL(grid.runs(), 6);
  std::string all;
  for (long run = 0; run < grid.runs(); ++run) all += grid.values(run)[0] + grid.values(run)[1] + ' ';
  CHECK_EQUAL(all, "1x 1y 1z 2x 2y 2z ");
  CHECK_EQUAL(Grid({}).runs(), 1);
  CHECK_THROWS(Grid({{"a", {"1"}}, {"a", {"2"}}}), UserError, "twice");
  const std::vector<std::string> thousand(1001, "v");
  CHECK_THROWS(Grid({{"a", thousand}, {"b", thousand}}), UserError, "1000000");
}

// A key that a method does not read multiplies the runs of the others alone, and has no value in its rows.
void unread_keys() {
  const Grid grid({{"erp", {"1", "2"}, {"rk4", "quad"}}, {"step", {"x", "y"}}, {"method", {"ode", "rk4", "quad"}}});
  std::string all;
  for (long run = 0; run < grid.runs(); ++run) {
    const std::vector<std::string> values = grid.values(run);
    all += values[0] + values[1] + values[2] + ' ';
  }
  CHECK_EQUAL(all, "1xode xrk4 xquad 1yode yrk4 yquad 2xode 2yode ");
  CHECK(grid.places(1) == (std::vector<std::size_t>{0, 0, 1}));
  CHECK(grid.places(7) == (std::vector<std::size_t>{1, 1, 0}));
}

// Every run is in one shard, shards are as long as each other to one run, and none has all of one method.
void shards() {
  for (const long count : {1, 2, 3, 7}) {
    for (const long runs : {1L, 6L, 42L, 100L}) {
      std::vector<long> held(static_cast<std::size_t>(count) + 1);
      for (long run = 0; run < runs; ++run) {
        long holders = 0;
        for (long index = 1; index <= count; ++index) {
          if (!Shard{index, count}.holds(run)) continue;
          ++holders;
          ++held[static_cast<std::size_t>(index)];
        }
        CHECK_EQUAL(holders, 1);
      }
      for (long index = 1; index <= count; ++index) {
        CHECK_EQUAL(held[static_cast<std::size_t>(index)], (Shard{index, count}.runs_of(runs)));
        CHECK(held[static_cast<std::size_t>(index)] >= runs / count);
        CHECK(held[static_cast<std::size_t>(index)] <= runs / count + 1);
      }
    }
  }
  const Shard second{2, 3};
  bool method[3] = {};
  for (long run = 0; run < 9; ++run) method[run % 3] = method[run % 3] || second.holds(run);
  CHECK(method[0] && method[1] && method[2]);
  CHECK(parse_shard("2/8") == (Shard{2, 8}));
  for (const char* bad : {"", "2", "0/3", "4/3", "-1/3", "1/0", "1/x", "1.5/2", "1/2/3", "/", "1/"}) {
    CHECK_THROWS(parse_shard(bad), UserError, "--shard");
  }
}

void fronts() {
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto runs = [](const std::vector<Point>& points) {
    std::string text;
    for (const Point& point : pareto_front(points)) text += std::to_string(point.run) + ' ';
    return text;
  };
  CHECK_EQUAL(runs({}), "");
  CHECK_EQUAL(runs({{0, 3, 1}, {1, 1, 3}, {2, 2, 2}, {3, 2.5, 2.5}}), "1 2 0 ");
  CHECK_EQUAL(runs({{0, 1, 1}, {1, 1, 1}, {2, 1, 2}, {3, 2, 1}}), "0 ");
  CHECK_EQUAL(runs({{0, 1, nan}, {1, 2, inf}, {2, 3, 0}}), "2 ");
  // Beyond what the references know nothing is bought but a better reference.
  CHECK_EQUAL(runs({{0, 1, 1e-3}, {1, 2, 1e-9, false}, {2, 3, 0.9e-9, false}, {3, 4, 0.8e-9}}), "0 1 3 ");
  CHECK_EQUAL(runs({{0, 1, 1e-3, false}, {1, 2, 1e-9, false}}), "0 1 ");
  // One that is not worth naming still stands before those that are dearer and worse.
  CHECK_EQUAL(runs({{0, 1, 1e-3}, {1, 2, 1e-9}, {2, 3, 0.6e-9, false}, {3, 4, 0.8e-9}}), "0 1 ");
}

}  // namespace

int main() {
  axes();
  products();
  unread_keys();
  shards();
  fronts();
  return odeval::test::verdict();
}
