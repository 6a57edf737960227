#ifndef ODEVAL_BARE_ENGINE_H
#define ODEVAL_BARE_ENGINE_H
/* The report's double pendulum in an engine alone: two links of 1 kg and 1 m by 0.1 m by 0.1 m on hinges along x, the
   first at 2.1 m above the origin and up at 45 degrees towards +y, the second level. Each engine has these four in a
   module of its own. */

#ifdef __cplusplus
extern "C" {
#endif

/* method: as odeval calls it. */
__attribute__((visibility("default"))) void bare_create(const char* method);
/* `steps` times h = 0.001; a method that chooses its steps goes to where these end. */
__attribute__((visibility("default"))) void bare_run(long steps);
/* Height of link 2's centre, m: shows that the same motion was computed. */
__attribute__((visibility("default"))) double bare_height(void);
__attribute__((visibility("default"))) void bare_destroy(void);

#ifdef __cplusplus
}
#endif
#endif
