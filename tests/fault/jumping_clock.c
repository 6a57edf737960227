// Preloaded, makes the calendar's clock jump by a day, forth and back, at every look, and a thread's CPU time go on by
// looks alone: the second is 2 ms after the first, the third 3 ms after that. The steady clock stays true.
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static long looks;
static long jump(void) { return looks++ % 2 == 0 ? 86400 : -86400; }

static long long cpu_looks;
static struct timespec cpu_time(void) {
  const long long ms = ++cpu_looks * (cpu_looks + 1) / 2;
  return (struct timespec){ms / 1000, ms % 1000 * 1000000};
}

int clock_gettime(clockid_t id, struct timespec* now) {
  if (id == CLOCK_THREAD_CPUTIME_ID) {
    *now = cpu_time();
    return 0;
  }
  const long result = syscall(SYS_clock_gettime, id, now);
  if (result == 0 && (id == CLOCK_REALTIME || id == CLOCK_REALTIME_COARSE)) now->tv_sec += jump();
  return (int)result;
}

int gettimeofday(struct timeval* restrict now, void* restrict zone) {
  (void)zone;
  struct timespec precise;
  clock_gettime(CLOCK_REALTIME, &precise);
  now->tv_sec = precise.tv_sec;
  now->tv_usec = precise.tv_nsec / 1000;
  return 0;
}

time_t time(time_t* place) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (place) *place = now.tv_sec;
  return now.tv_sec;
}
