// The trace file: columns in their order, numbers back bit for bit, broken files refused.
#include <bit>
#include <clocale>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "odeval/error.hpp"
#include "output/number.hpp"
#include "output/trace_csv.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;

std::uint64_t bits(double number) { return std::bit_cast<std::uint64_t>(number); }

double back(double number) { return parse_csv("x\n" + number_text(number) + "\n", "text").columns[0][0]; }

void numbers_come_back_bit_for_bit() {
  using limits = std::numeric_limits<double>;
  for (const double number : {0.0, -0.0, 1.0, 0.1, 1.0 / 3, 1e22, 1e23, 123456789012345678.0, 5e-324,
                              2.2250738585072009e-308, limits::min(), -limits::min(), limits::max(), limits::lowest(),
                              limits::epsilon(), limits::infinity(), -limits::infinity(), -2.2250738585072014e-308}) {
    CHECK_EQUAL(bits(back(number)), bits(number));
  }
  CHECK(std::isnan(back(limits::quiet_NaN())));

  std::mt19937_64 random(1);
  for (int k = 0; k < 100000; ++k) {  // any bits, so all exponents
    const double number = std::bit_cast<double>(random());
    if (std::isnan(number)) continue;
    const std::string text = number_text(number);
    if (text.size() > longest_number || bits(back(number)) != bits(number))
      CHECK_EQUAL(text, odeval::test::shown(number));
  }
}

void numbers_are_short() {
  CHECK_EQUAL(number_text(0), "0");
  CHECK_EQUAL(number_text(-0.0), "-0");
  CHECK_EQUAL(number_text(1), "1");
  CHECK_EQUAL(number_text(0.1), "0.1");
  CHECK_EQUAL(number_text(1e-4), "0.0001");
  CHECK_EQUAL(number_text(1e22), "1e+22");
  CHECK_EQUAL(number_text(5e-324), "5e-324");
  CHECK_EQUAL(number_text(std::numeric_limits<double>::infinity()), "inf");
  CHECK_EQUAL(number_text(-std::numeric_limits<double>::quiet_NaN()), "nan");
}

// A trace with a different number in every cell: column c, row k holds 100 c + k.
Trace numbered_trace(std::size_t links, bool with_bodies, bool with_errors) {
  double next = 0;
  const auto fill = [&next](Column& column) {
    column.resize(2);
    std::iota(column.begin(), column.end(), next);
    next += 100;
  };
  Trace trace;
  fill(trace.t);
  for (auto* columns : {&trace.q, &trace.qd}) {
    columns->resize(links);
    for (Column& column : *columns) fill(column);
  }
  for (auto* column : {&trace.kinetic, &trace.potential, &trace.gap, &trace.out_of_plane}) fill(*column);
  if (with_errors) trace.error_q.resize(links);
  for (Column& column : trace.error_q) fill(column);
  for (auto* column : {&trace.contacts, &trace.condition, &trace.manipulability}) fill(*column);
  if (with_bodies) trace.bodies.resize(links);
  for (BodyColumns& body : trace.bodies) {
    for (Column& column : body.position) fill(column);
    for (Column& column : body.rotation) fill(column);
    for (Column& column : body.velocity) fill(column);
    for (Column& column : body.spin) fill(column);
    for (Column& column : body.joint_force) fill(column);
  }
  return trace;
}

void columns_stand_in_their_order() {
  CHECK_EQUAL(trace_csv(numbered_trace(1, false, false)),
              "t,q1,qd1,kinetic,potential,energy,energy_drift,gap,out_of_plane,contacts,condition,"
              "manipulability\n"
              "0,100,200,300,400,700,0,500,600,700,800,900\n"
              "1,101,201,301,401,702,2,501,601,701,801,901\n");

  const std::string text = trace_csv(numbered_trace(2, true, true));
  CHECK_EQUAL(text.substr(0, text.find('\n')),
              "t,q1,q2,qd1,qd2,kinetic,potential,energy,energy_drift,gap,out_of_plane,error_q1,error_q2,contacts,"
              "condition,manipulability,"
              "x1,y1,z1,r111,r112,r113,r121,r122,r123,r131,r132,r133,vx1,vy1,vz1,wx1,wy1,wz1,fx1,fy1,fz1,"
              "x2,y2,z2,r211,r212,r213,r221,r222,r223,r231,r232,r233,vx2,vy2,vz2,wx2,wy2,wz2,fx2,fy2,fz2");
  const CsvColumns table = parse_csv(text, "text");
  CHECK_EQUAL(table.header.size(), 58u);
  CHECK_EQUAL(table.columns.size(), 58u);
  CHECK_EQUAL(table.columns[57].size(), 2u);
  CHECK_EQUAL(table.header[35], "fy1");
  CHECK_EQUAL(table.columns[35][1], 3301.0);  // 35 columns before it, two of them derived
  CHECK_EQUAL(table.columns[8][1], 2.0);      // energy_drift
}

/// The same of a mechanism whose parts have names, with a joint that has a way and one that has none.
Trace named_trace() {
  Trace trace = numbered_trace(2, true, false);
  trace.q.clear();
  trace.qd.clear();
  trace.body_names = {"arm", "fore.arm"};
  trace.joint_names = {"arm", "wrist"};  // a joint may have a body's name
  const Column numbers{0.25, 0.5};
  trace.joints = {{numbers, {1, 2}, {3, 4}, {5, 6}, {7, 8}}, {numbers, {}, {}, {}, {}}};
  trace.works.assign(work_names.size(), {0, 9});
  trace.unaccounted = {0, 10};
  trace.error_position = {{11, 12}, {13, 14}};
  return trace;
}

void parts_are_called_by_their_names() {
  const std::string text = trace_csv(named_trace());
  CHECK_EQUAL(text.substr(0, text.find('\n')),
              "t,kinetic,potential,energy,energy_drift,work_motors,work_stops,work_springs,work_dampers,work_torques,"
              "work_controllers,work_contacts,unaccounted,gap,out_of_plane,arm.error_position,fore.arm.error_position,"
              "contacts,condition,manipulability,"
              "arm.x,arm.y,arm.z,arm.r11,arm.r12,arm.r13,arm.r21,arm.r22,arm.r23,arm.r31,arm.r32,arm.r33,arm.vx,arm.vy,"
              "arm.vz,arm.wx,arm.wy,arm.wz,arm.fx,arm.fy,arm.fz,"
              "fore.arm.x,fore.arm.y,fore.arm.z,fore.arm.r11,fore.arm.r12,fore.arm.r13,fore.arm.r21,fore.arm.r22,"
              "fore.arm.r23,fore.arm.r31,fore.arm.r32,fore.arm.r33,fore.arm.vx,fore.arm.vy,fore.arm.vz,fore.arm.wx,"
              "fore.arm.wy,fore.arm.wz,fore.arm.fx,fore.arm.fy,fore.arm.fz,"
              "arm.q,arm.qd,arm.torque,arm.gap,arm.error_q,wrist.gap");
  const Trace back = trace_of(parse_csv(text, "text"));
  CHECK(back.body_names == named_trace().body_names && back.joint_names == named_trace().joint_names);
  CHECK(back.joints[0].load == named_trace().joints[0].load && back.joints[1].q.empty());
  CHECK(back.bodies[1].spin == named_trace().bodies[1].spin && back.error_position == named_trace().error_position);
  CHECK_EQUAL(trace_column_of("arm.q")->unit, "rad or m");
  CHECK_EQUAL(trace_column_of("fore.arm.vx")->unit, "m/s");
  for (const char* other : {"arm.", "arm.x1", "arm.contacts", "arm.r1", "arm.work_motors", ".arm", "arm"}) {
    CHECK(trace_column_of(other) == nullptr);
  }
}

// Whoever reads a file finds the table's row of each of its columns, of body 12 as well, and none for other words.
void columns_are_known_by_their_names() {
  Trace trace = numbered_trace(12, true, true);
  for (auto* columns : {&trace.error_position, &trace.error_turn}) columns->assign(12, Column(2));
  for (auto* column : {&trace.angular_momentum_drift, &trace.penetration}) column->assign(2, 0.0);
  std::set<const TraceColumn*> seen;
  for (const std::string& name : parse_csv(trace_csv(trace), "text").header) {
    const TraceColumn* const row = trace_column_of(name);
    CHECK(row != nullptr && name.starts_with(row->name));
    seen.insert(row);
  }
  for (const std::string& name : parse_csv(trace_csv(named_trace()), "text").header) {
    CHECK(trace_column_of(name) != nullptr);
    seen.insert(trace_column_of(name));
  }
  CHECK_EQUAL(seen.size(), std::size(trace_columns));
  const auto row = [](const char* name) { return trace_column_of(name)->name; };
  CHECK_EQUAL(row("q12"), "q");
  CHECK_EQUAL(row("qd1"), "qd");
  CHECK_EQUAL(row("error_q2"), "error_q");
  CHECK_EQUAL(row("r1211"), "r");
  CHECK_EQUAL(row("z3"), "");
  CHECK_EQUAL(trace_column_of("vy1")->unit, "m/s");
  CHECK(trace_column_of("contacts")->exact && trace_column_of("t")->exact && !trace_column_of("gap")->exact);
  CHECK(trace_column_of("q1")->uncertainty == quantity::reference_uncertainty && !trace_column_of("qd1")->uncertainty);
  for (const char* other : {"", "q", "1", "qd", "x", "u1", "r11", "vz", "gap1", "tt", "q1x"}) {
    CHECK(trace_column_of(other) == nullptr);
  }
}

// A locale with a decimal comma must not reach the file; where none is installed there is nothing to see.
void locale_does_not_matter() {
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"}) std::setlocale(LC_ALL, name);
  CHECK_EQUAL(number_text(0.5), "0.5");
  CHECK_EQUAL(back(0.5), 0.5);
  std::setlocale(LC_ALL, "C");
}

void broken_files_are_refused() {
  CHECK_THROWS(parse_csv("a,b\n1,2\n3\n", "x.csv"), UserError, "x.csv:3: has fewer cells than the header");
  CHECK_THROWS(parse_csv("a,b\n1,2,3\n", "x.csv"), UserError, "x.csv:2: has more cells than the header");
  CHECK_THROWS(parse_csv("a,b\n1,two\n", "x.csv"), UserError, "x.csv:2: b: 'two' is no number");
  CHECK_THROWS(parse_csv("a,b\n1,\n", "x.csv"), UserError, "x.csv:2: b: '' is no number");
  CHECK_THROWS(parse_csv("a,b\n1,2x\n", "x.csv"), UserError, "'2x' is no number");
  CHECK_THROWS(parse_csv("a,b,a\n1,2,3\n", "x.csv"), UserError, "x.csv:1: has two columns a");
  CHECK_THROWS(parse_csv("a,,b\n1,2,3\n", "x.csv"), UserError, "x.csv:1: column 2 has no name");
  CHECK_THROWS(parse_csv("a;b\n1;2\n", "x.csv"), UserError, "x.csv:1: columns must be parted by commas, not by ';'");
  CHECK_THROWS(parse_csv("a\n1\n\n2\n", "x.csv"), UserError, "x.csv:3: is empty");
  CHECK_EQUAL(parse_csv("\xef\xbb\xbfy\n 1 \n\n", "x.csv").header[0], "y");
  CHECK_THROWS(read_csv("no/such.csv"), UserError, "no/such.csv: cannot be read");
  CHECK_THROWS(read_csv("/"), UserError, "cannot be read");
  CHECK_EQUAL(parse_csv("", "x.csv").header.size(), 0u);
  CHECK_EQUAL(parse_csv("a\r\n1\r\n", "x.csv").columns[0][0], 1.0);
  CHECK_EQUAL(parse_csv("a\n1", "x.csv").columns[0].size(), 1u);
}

}  // namespace

int main() {
  numbers_come_back_bit_for_bit();
  numbers_are_short();
  columns_stand_in_their_order();
  parts_are_called_by_their_names();
  columns_are_known_by_their_names();
  locale_does_not_matter();
  broken_files_are_refused();
  return odeval::test::verdict();
}
