/* A drawstuff that draws nothing, for ODE's own demos.
 *
 *   FRAMES   how many, then the program ends
 *   KEYS     pressed, before which frame: "10:b 20:b"
 *   DIGEST   file that gets, at the end, a number that depends on every bit that was to be drawn */
#include <drawstuff/drawstuff.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Demos that take their seed from the clock get the same one in every second. */
time_t time(time_t* result) {
  const time_t second = 1262304000; /* 2010-01-01 */
  if (result) *result = second;
  return second;
}

static uint64_t digest = 14695981039346656037u; /* FNV-1a */
static int stopped;

static void take(const void* bytes, size_t count) {
  for (size_t i = 0; i < count; ++i) digest = (digest ^ ((const unsigned char*)bytes)[i]) * 1099511628211u;
}

static void pose(const void* position, const void* rotation, size_t size) {
  take(position, 3 * size);
  for (int row = 0; row < 3; ++row) take((const char*)rotation + row * 4 * size, 3 * size); /* the fourth is unused */
}

static long number(const char* name, long otherwise) {
  const char* text = getenv(name);
  return text ? atol(text) : otherwise;
}

static void press(const dsFunctions* functions, long frame) {
  const char* keys = getenv("KEYS");
  for (; keys && *keys; keys = strchr(keys, ' ') ? strchr(keys, ' ') + 1 : "") {
    const char* key = strchr(keys, ':');
    if (key && atol(keys) == frame && functions->command) functions->command(key[1]);
  }
}

void dsSimulationLoop(int argc, char** argv, int width, int height, dsFunctions* functions) {
  (void)argc, (void)argv, (void)width, (void)height;
  const long frames = number("FRAMES", 1000);
  if (functions->start) functions->start();
  for (long frame = 0; frame < frames && !stopped; ++frame) {
    press(functions, frame);
    if (functions->step) functions->step(0);
  }
  if (functions->stop) functions->stop();
  FILE* file = getenv("DIGEST") ? fopen(getenv("DIGEST"), "w") : 0;
  if (!file) return;
  fprintf(file, "%016llx\n", (unsigned long long)digest);
  fclose(file);
}

static void say(const char* text, va_list values) {
  vfprintf(stderr, text, values);
  fputc('\n', stderr);
}
void dsError(const char* text, ...) {
  va_list values;
  va_start(values, text);
  say(text, values);
  exit(1);
}
void dsDebug(const char* text, ...) {
  va_list values;
  va_start(values, text);
  say(text, values);
  abort();
}
void dsPrint(const char* text, ...) { (void)text; }
void dsStop(void) { stopped = 1; }
double dsElapsedTime(void) { return 1.0 / 60; }

void dsSetViewpoint(float at[3], float to[3]) { (void)at, (void)to; }
void dsGetViewpoint(float at[3], float to[3]) {
  for (int i = 0; i < 3; ++i) at[i] = to[i] = 0;
}
void dsSetTexture(int texture) { (void)texture; }
void dsSetColor(float r, float g, float b) { (void)r, (void)g, (void)b; }
void dsSetColorAlpha(float r, float g, float b, float a) { (void)r, (void)g, (void)b, (void)a; }
void dsSetSphereQuality(int n) { (void)n; }
void dsSetCapsuleQuality(int n) { (void)n; }
void dsSetDrawMode(int mode) { (void)mode; }

void dsDrawBox(const float p[3], const float r[12], const float sides[3]) { (void)sides, pose(p, r, sizeof *p); }
void dsDrawSphere(const float p[3], const float r[12], float radius) { (void)radius, pose(p, r, sizeof *p); }
void dsDrawCylinder(const float p[3], const float r[12], float l, float w) { (void)l, (void)w, pose(p, r, sizeof *p); }
void dsDrawCapsule(const float p[3], const float r[12], float l, float w) { (void)l, (void)w, pose(p, r, sizeof *p); }
void dsDrawLine(const float a[3], const float b[3]) { take(a, 3 * sizeof *a), take(b, 3 * sizeof *b); }
void dsDrawTriangle(const float p[3], const float r[12], const float* a, const float* b, const float* c, int solid) {
  (void)a, (void)b, (void)c, (void)solid, pose(p, r, sizeof *p);
}
void dsDrawTriangles(const float p[3], const float r[12], const float* v, const int n, int solid) {
  (void)v, (void)n, (void)solid, pose(p, r, sizeof *p);
}
void dsDrawConvex(const float p[3], const float r[12], const float* planes, unsigned m, const float* points, unsigned n,
                  const unsigned* polygons) {
  (void)planes, (void)m, (void)points, (void)n, (void)polygons, pose(p, r, sizeof *p);
}

void dsDrawBoxD(const double p[3], const double r[12], const double sides[3]) { (void)sides, pose(p, r, sizeof *p); }
void dsDrawSphereD(const double p[3], const double r[12], float radius) { (void)radius, pose(p, r, sizeof *p); }
void dsDrawCylinderD(const double p[3], const double r[12], float l, float w) {
  (void)l, (void)w, pose(p, r, sizeof *p);
}
void dsDrawCapsuleD(const double p[3], const double r[12], float l, float w) {
  (void)l, (void)w, pose(p, r, sizeof *p);
}
void dsDrawLineD(const double a[3], const double b[3]) { take(a, 3 * sizeof *a), take(b, 3 * sizeof *b); }
void dsDrawTriangleD(const double p[3], const double r[12], const double* a, const double* b, const double* c,
                     int solid) {
  (void)a, (void)b, (void)c, (void)solid, pose(p, r, sizeof *p);
}
void dsDrawTrianglesD(const double p[3], const double r[12], const double* v, const int n, int solid) {
  (void)v, (void)n, (void)solid, pose(p, r, sizeof *p);
}
void dsDrawConvexD(const double p[3], const double r[12], const double* planes, unsigned m, const double* points,
                   unsigned n, const unsigned* polygons) {
  (void)planes, (void)m, (void)points, (void)n, (void)polygons, pose(p, r, sizeof *p);
}
