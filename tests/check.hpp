#pragma once
// Checks for tests: print what was measured beside what was expected, count, go on. NaN fails every check.
//
// A test is a plain program: its main runs checks and returns `odeval::test::verdict()`.
#include <cmath>
#include <cstdio>
#include <exception>
#include <sstream>
#include <string>

namespace odeval::test {

inline int failures = 0;
inline int checks = 0;

template <class Value>
std::string shown(const Value& value) {
  std::ostringstream out;
  out.precision(17);
  out << value;
  return out.str();
}

inline void report(bool passed, const char* file, int line, const std::string& text) {
  ++checks;
  if (passed) return;
  ++failures;
  std::printf("%s:%d: %s\n", file, line, text.c_str());
}

inline int verdict() {
  std::printf("%d checks, %d failed\n", checks, failures);
  return failures == 0 && checks > 0 ? 0 : 1;
}

}  // namespace odeval::test

#define CHECK(condition) ::odeval::test::report((condition), __FILE__, __LINE__, "failed: " #condition)

#define CHECK_EQUAL(actual, wanted)                                                                                 \
  do {                                                                                                              \
    const auto check_actual = (actual);                                                                             \
    const auto check_wanted = (wanted);                                                                             \
    ::odeval::test::report(                                                                                         \
        check_actual == check_wanted, __FILE__, __LINE__,                                                           \
        #actual " = " + ::odeval::test::shown(check_actual) + ", expected " + ::odeval::test::shown(check_wanted)); \
  } while (false)

#define CHECK_BETWEEN(actual, low, high)                                                                       \
  do {                                                                                                         \
    const double check_actual = (actual);                                                                      \
    const double check_low = (low);                                                                            \
    const double check_high = (high);                                                                          \
    ::odeval::test::report(check_actual >= check_low && check_actual <= check_high, __FILE__, __LINE__,        \
                           #actual " = " + ::odeval::test::shown(check_actual) + ", expected " +               \
                               ::odeval::test::shown(check_low) + " to " + ::odeval::test::shown(check_high)); \
  } while (false)

#define CHECK_NEAR(actual, wanted, tolerance)                                                             \
  do {                                                                                                    \
    const double check_actual = (actual);                                                                 \
    const double check_wanted = (wanted);                                                                 \
    const double check_tolerance = (tolerance);                                                           \
    ::odeval::test::report(std::fabs(check_actual - check_wanted) <= check_tolerance, __FILE__, __LINE__, \
                           #actual " = " + ::odeval::test::shown(check_actual) + ", expected " +          \
                               ::odeval::test::shown(check_wanted) + " within " +                         \
                               ::odeval::test::shown(check_tolerance));                                   \
  } while (false)

/// The statement must throw the type with a message that contains the text.
#define CHECK_THROWS(statement, Type, text)                                                                            \
  do {                                                                                                                 \
    std::string check_message = "nothing thrown";                                                                      \
    bool check_passed = false;                                                                                         \
    try {                                                                                                              \
      statement;                                                                                                       \
    } catch (const Type& check_error) {                                                                                \
      check_message = check_error.what();                                                                              \
      check_passed = check_message.find(text) != std::string::npos;                                                    \
    } catch (const std::exception& check_error) {                                                                      \
      check_message = std::string("another type: ") + check_error.what();                                              \
    }                                                                                                                  \
    ::odeval::test::report(check_passed, __FILE__, __LINE__,                                                           \
                           #statement ": " + check_message + "; expected " #Type " with '" + std::string(text) + "'"); \
  } while (false)
