// A ball that bounces, in a program with something wrong with it.
//
//   faulty FAULT [STEPS]
#include <ode/ode.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "audit/odeval_name.h"

extern "C" void name_in_c(dBodyID body, dJointID joint);  // of named.c

namespace {

dWorldID world;
dSpaceID space;
dJointGroupID contacts;
dBodyID ball;
dGeomID ball_geom;
dBodyID lost;  // has no geom, and nothing holds it
std::string fault;
long steps = 1000;
long now = 0;

bool is(const char* name) { return fault == name; }

void near(void* data, dGeomID one, dGeomID other) {
  dContact contact[4]{};
  const int found = dCollide(one, other, 4, &contact[0].geom, sizeof(dContact));
  if (is("throws") && found > 0) throw std::runtime_error("a touch");
  if (data != nullptr && *static_cast<const int*>(data) != 17) std::abort();
  for (int i = 0; i < found; ++i) {
    contact[i].surface.mode = dContactBounce;
    contact[i].surface.bounce = 0.5;
    if (is("rolls")) contact[i].surface = {.mode = 0, .mu = dInfinity};
    dJointAttach(dJointCreateContact(world, contacts, &contact[i]), dGeomGetBody(one), dGeomGetBody(other));
  }
}

void collide() {
  if (is("own-pairs")) return near(nullptr, dSpaceGetGeom(space, 0), dSpaceGetGeom(space, 1));
  const int on_the_stack = 17;  // gone when this returns
  void* const data = is("stack") ? const_cast<int*>(&on_the_stack) : nullptr;
  try {
    dSpaceCollide(space, data, near);
  } catch (const std::runtime_error&) {
  }
}

/// Since the call before, by one clock after the other.
double elapsed() {
  static double last = 0;
  timespec fine{};
  ::clock_gettime(CLOCK_MONOTONIC, &fine);
  timeval coarse{};
  ::gettimeofday(&coarse, nullptr);
  static const long begin = coarse.tv_sec;
  const double of_chrono = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  const double sum = static_cast<double>(fine.tv_sec) + 1e-9 * static_cast<double>(fine.tv_nsec) +
                     static_cast<double>(coarse.tv_sec - begin) + 1e-6 * static_cast<double>(coarse.tv_usec) +
                     of_chrono;
  const double since = last == 0 ? 0 : sum - last;
  last = sum;
  return since;
}

void step() {
  collide();
  if (is("clock")) {
    ::usleep(200);
    const double h = elapsed() / 3;
    if (h > 0) dWorldStep(world, h);
    dJointGroupEmpty(contacts);
    ++now;
    return;
  }
  if (is("rolls")) {
    dWorldStep(world, 0.01);
    dJointGroupEmpty(contacts);
    ++now;
    return;
  }
  if (is("runaway")) dBodyAddForce(lost, 0, 0, 1e7 * dBodyGetPosition(lost)[2]);
  dWorldStep(world, 0.001);
  dJointGroupEmpty(contacts);
  ++now;
}

void make() {
  dInitODE2(0);
  world = dWorldCreate();
  space = dHashSpaceCreate(nullptr);
  contacts = dJointGroupCreate(0);
  dWorldSetGravity(world, 0, 0, -9.81);
  if (is("rolls")) dWorldSetCFM(world, 1e-5);
  if (is("rolls")) dWorldSetGravity(world, 2.54, 0, -9.48);  // down a slope of 15 degrees
  if (is("damped")) dWorldSetLinearDamping(world, 0.01);
  if (!is("free") && !is("damped")) dCreatePlane(space, 0, 0, 1, 0);
  if (is("static-pair")) dGeomSetPosition(dCreateBox(space, 1, 1, 1), 5, 0, 0.3);  // 0.2 m in the plane
  ball = dBodyCreate(world);
  dMass mass;
  dMassSetSphereTotal(&mass, 1, 0.1);
  dBodySetMass(ball, &mass);
  dBodySetPosition(ball, 0, 0, is("rolls") ? 0.1 : 0.3);
  ball_geom = dCreateSphere(space, 0.1);
  dGeomSetBody(ball_geom, ball);
  if (is("nan-place") || is("nan-start") || is("runaway") || is("falls-beside")) lost = dBodyCreate(world);
  if (is("nan-start")) dBodySetPosition(lost, dReal(0) / dReal(0), 0, 0);
  if (is("named")) odeval_name(ball, "the ball");
  if (is("named-nothing")) {
    odeval_name(ball, "");
    odeval_name(dBodyCreate(world), "the other");
    odeval_name(dBodyCreate(world), nullptr);
  }
  if (is("named-in-c")) name_in_c(ball, dJointCreateNull(world, nullptr));
  if (is("latin-name")) odeval_name(ball, "Fu\xdf");
}

void shout() {
  for (int i = 0; i < 1000000; ++i) std::printf("a line of a thousand %0980d\n", i);
}

/// A million times, in a space with nothing in it; exits with 9 where that takes more than 16 MB.
void collide_for_ever() {
  const auto most_kB = [] {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  };
  const long before = most_kB();
  dSpaceID empty = dSimpleSpaceCreate(nullptr);
  for (int i = 0; i < 1000000; ++i) dSpaceCollide(empty, nullptr, near);
  if (most_kB() - before > 16384) ::_exit(9);
}

/// From now on ODE gets no memory for a step, but for its list of islands, without which it does not live.
void take_its_memory() {
  const dWorldStepMemoryFunctionsInfo once{
      .struct_size = sizeof once,
      .alloc_block = [](dsizeint size) -> void* {
        static bool first = true;
        return std::exchange(first, false) ? std::malloc(size) : nullptr;
      },
      .shrink_block = [](void* block, dsizeint, dsizeint) { return block; },
      .free_block = [](void* block, dsizeint) { std::free(block); },
  };
  dWorldCleanupWorkingMemory(world);
  if (dWorldSetStepMemoryManager(world, &once) == 0) std::abort();
}

/// What goes wrong half way.
void go_wrong() {
  if (is("segv")) std::raise(SIGSEGV);
  if (is("kill")) std::raise(SIGKILL);
  if (is("abort")) std::abort();
  if (is("ode-abort")) dWorldStep(world, 0);
  if (is("ode-message")) dMessage(0, "something is odd with %d", 17);
  if (is("exit3")) std::exit(3);
  if (is("quick-exit")) ::_exit(4);
  if (is("nan")) dBodyAddForce(ball, dReal(0) / dReal(0), 0, 0);
  if (is("nan-place")) dBodySetPosition(lost, dReal(0) / dReal(0), 0, 0);
  if (is("latin-complaint")) {
    std::fputs("zu gro\xdf\n", stderr);
    std::exit(3);
  }
  if (is("hang")) {
    for (;;) ::pause();
  }
  if (is("in-vain")) take_its_memory();
  if (is("busy")) {
    for (volatile bool on = true; on;) {
    }
  }
  if (is("close")) {
    for (int descriptor = 0; descriptor < 1024; ++descriptor) ::close(descriptor);
    if (std::fopen("/dev/null", "w") == nullptr) std::abort();  // takes the lowest of them
  }
  if (is("shout")) shout();
  if (is("complain")) {
    for (int i = 0; i < 200000; ++i) std::fprintf(stderr, "complaint %d\n", i);
  }
  if (is("fork-child-steps")) {
    const pid_t child = ::fork();
    for (int i = 0; child == 0 && i < 100; ++i) step();
    if (child == 0) ::_exit(0);
    ::waitpid(child, nullptr, 0);
  }
  if (is("fork-parent-waits")) {
    const pid_t child = ::fork();
    if (child != 0) {
      int status = 0;
      ::waitpid(child, &status, 0);
      ::_exit(WEXITSTATUS(status));
    }
  }
  if (is("daemon") && ::fork() == 0) {
    for (;;) ::pause();
  }
  if (is("thread")) std::thread(step).join();
  const char* refined = std::getenv("ODEVAL_AUDIT_REFINE");  // as threads that meet in runs that take longer
  if (is("thread-refined") && refined != nullptr && std::strcmp(refined, "4") == 0) std::thread(step).join();
  if (is("thread-collides")) std::thread(collide).join();
  if (is("thread-makes")) std::thread([] { dBodyCreate(world); }).join();
  if (is("collides")) collide_for_ever();
  if (is("new-body")) {
    dBodyID more = dBodyCreate(world);
    dBodySetPosition(more, 1, 0, 5);
  }
  if (is("destroy-body")) {
    dGeomDestroy(ball_geom);
    dBodyDestroy(ball);
  }
  if (is("destroy-geom-after-collide")) {
    collide();
    dGeomDestroy(ball_geom);
  }
  if (is("destroy-world")) {
    dJointGroupEmpty(contacts);
    dSpaceDestroy(space);
    dWorldDestroy(world);
    make();
  }
  if (is("second-world")) {
    dWorldID second = dWorldCreate();
    dBodyCreate(second);
    dBodyCreate(second);
    dWorldStep(second, 0.001);
  }
  if (is("chdir") && ::chdir("/") != 0) std::abort();
  if (is("environment")) ::clearenv();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) fault = argv[1];
  if (is("rolls")) steps = 300;
  if (argc > 2) steps = std::atol(argv[2]);
  if (is("nothing")) return 0;
  if (is("no-file")) {
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_FSIZE, &none);
  }
  if (is("exec")) {
    ::setenv("ONCE", "1", 1);
    ::execl("/proc/self/exe", "faulty", "none", "1000", nullptr);
  }
  make();
  if (is("no-step")) return 0;
  if (is("thread-first")) std::thread(step).join();  // and then this one
  if (is("random")) {
    timespec time{};
    ::clock_gettime(CLOCK_MONOTONIC, &time);
    dBodySetLinearVel(ball, 1e-6 * static_cast<double>(time.tv_nsec % 1000003), 0, 0);
  }
  if (is("fork-at-once")) {
    const pid_t child = ::fork();
    if (child != 0) {
      int status = 0;
      ::waitpid(child, &status, 0);
      return WEXITSTATUS(status);
    }
  }
  const double coarse = is("coarse") ? 0.05 : 0;
  while (is("for-ever") || now < steps) {
    if (now == steps / 2) go_wrong();
    if (coarse > 0) dWorldStep(world, coarse);
    step();
  }
  return 0;
}
