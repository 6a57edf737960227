// The clock of a program whose step comes from the clock: simulated time, so that it repeats. A library of its own,
// which is loaded beside that of the audit when that is asked for.
//
// A reading is the simulated time, but a tick more than the reading before at least. So a program that reads the clock
// n times between its steps has steps of n ticks, one that steps when it is time to waits for it, and all of them the
// same each time. Sleeping takes no time of the machine's and as much of this clock as was asked for. Only the first
// thread makes it go on.
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/times.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>

#include "audit/preload/clock.hpp"
#include "audit/preload/environment.hpp"

namespace {

constexpr long begin_s = 946684800;  // of the year 2000
constexpr double nanoseconds = 1e-9;

pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
double now_s = 0;

double tick_s() {
  static const double tick = [] {
    const char* text = std::getenv(odeval::audit::environment::tick);
    return text == nullptr ? 1.0 / 60 : std::strtod(text, nullptr);
  }();
  return tick;
}

bool first_thread() { return ::syscall(SYS_gettid) == ::getpid(); }

/// Since the program's start, s.
double reading() {
  odeval_clock_asked = true;
  ::pthread_mutex_lock(&lock);
  if (first_thread()) now_s = std::max(odeval_simulated_s.load(), now_s + tick_s());
  const double now = now_s;
  ::pthread_mutex_unlock(&lock);
  return now;
}

/// As far as somebody sleeps: for so long, or until then.
void go_on(double seconds, bool until) {
  odeval_clock_asked = true;
  if (!first_thread()) return;
  ::pthread_mutex_lock(&lock);
  now_s = std::max(now_s, until ? seconds : now_s + seconds);
  ::pthread_mutex_unlock(&lock);
}

timespec as_timespec(double seconds, long from_s) {
  const double whole = std::floor(seconds);
  return {from_s + static_cast<long>(whole), static_cast<long>((seconds - whole) / nanoseconds)};
}

double seconds(const timespec& time, long from_s) {
  return static_cast<double>(time.tv_sec - from_s) + nanoseconds * static_cast<double>(time.tv_nsec);
}

long origin(clockid_t clock) {
  return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE || clock == CLOCK_TAI ? begin_s : 0;
}

}  // namespace

#pragma GCC visibility push(default)
extern "C" {

std::atomic<double> odeval_simulated_s = 0;
std::atomic<bool> odeval_clock_asked = false;

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  *time = as_timespec(reading(), origin(clock));
  return 0;
}

int gettimeofday(timeval* __restrict time, void* __restrict zone) noexcept {
  (void)zone;
  const timespec now = as_timespec(reading(), begin_s);
  *time = {now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

time_t time(time_t* place) noexcept {
  const time_t now = as_timespec(reading(), begin_s).tv_sec;
  if (place != nullptr) *place = now;
  return now;
}

int timespec_get(timespec* time, int base) noexcept {
  *time = as_timespec(reading(), begin_s);
  return base;
}

// Of CPU time, as much as the clock has gone on.
clock_t clock() noexcept { return static_cast<clock_t>(reading() * CLOCKS_PER_SEC); }

clock_t times(tms* time) noexcept {
  const double now = reading();
  const auto ticks = static_cast<clock_t>(now * static_cast<double>(::sysconf(_SC_CLK_TCK)));
  if (time != nullptr) *time = {ticks, 0, 0, 0};
  return ticks;
}

// As <sys/timeb.h> had it.
int ftime(void* place) {
  struct Time {
    time_t seconds;
    unsigned short milliseconds;
    short zone, summer;
  };
  const timespec now = as_timespec(reading(), begin_s);
  *static_cast<Time*>(place) = {now.tv_sec, static_cast<unsigned short>(now.tv_nsec / 1000000), 0, 0};
  return 0;
}

int nanosleep(const timespec* wanted, timespec* left) {
  go_on(seconds(*wanted, 0), false);
  if (left != nullptr) *left = {};
  return 0;
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* wanted, timespec* left) {
  const bool until = (flags & TIMER_ABSTIME) != 0;
  go_on(seconds(*wanted, until ? origin(clock) : 0), until);
  if (left != nullptr) *left = {};
  return 0;
}

int usleep(useconds_t microseconds) {
  go_on(1e-6 * microseconds, false);
  return 0;
}

unsigned sleep(unsigned wanted) {
  go_on(wanted, false);
  return 0;
}

}  // extern "C"
#pragma GCC visibility pop
