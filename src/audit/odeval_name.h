#ifndef ODEVAL_NAME_H
#define ODEVAL_NAME_H
/* Names for what `odeval audit` tells of, from a program in C (C11) or C++:
 *
 *   odeval_name(body, "left foot");
 *   odeval_name(joint, "left ankle");
 *
 * Without the audit nothing happens. There is nothing to link (before glibc 2.34: -ldl). */
#include <dlfcn.h>
#include <ode/ode.h>

/* Of the library that the program is linked to, where it is. */
#ifdef __cplusplus
extern "C" {
#endif
extern void odeval_audit_name_body(dBodyID, const char*) __attribute__((weak));
extern void odeval_audit_name_joint(dJointID, const char*) __attribute__((weak));
#ifdef __cplusplus
}
#endif

/* Of the library that is loaded beside the program; null when there is none. */
static inline void* odeval_name_find(const char* function) {
  void* everything = dlopen(0, RTLD_LAZY);
  return everything ? dlsym(everything, function) : 0;
}

static inline void odeval_name_body(dBodyID body, const char* name) {
  union {
    void* found;
    void (*call)(dBodyID, const char*);
  } its;
  if (odeval_audit_name_body) {
    odeval_audit_name_body(body, name);
    return;
  }
  its.found = odeval_name_find("odeval_audit_name_body");
  if (its.found) its.call(body, name);
}

static inline void odeval_name_joint(dJointID joint, const char* name) {
  union {
    void* found;
    void (*call)(dJointID, const char*);
  } its;
  if (odeval_audit_name_joint) {
    odeval_audit_name_joint(joint, name);
    return;
  }
  its.found = odeval_name_find("odeval_audit_name_joint");
  if (its.found) its.call(joint, name);
}

#ifdef __cplusplus
inline void odeval_name(dBodyID body, const char* name) { odeval_name_body(body, name); }
inline void odeval_name(dJointID joint, const char* name) { odeval_name_joint(joint, name); }
#else
#define odeval_name(what, name) _Generic((what), dBodyID : odeval_name_body, dJointID : odeval_name_joint)(what, name)
#endif

#endif
