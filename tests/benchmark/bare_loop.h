#ifndef ODEVAL_BARE_LOOP_H
#define ODEVAL_BARE_LOOP_H
/* The report's double pendulum in plain C and nothing around it: what the harness is measured against. */

#ifdef __cplusplus
extern "C" {
#endif

void bare_pendulum_create(void);
/* dWorldStep, `steps` times with h = 0.001. */
void bare_pendulum_run(long steps);
/* Height of link 2's centre, m: shows that the same motion was computed. */
double bare_pendulum_height(void);
void bare_pendulum_destroy(void);

#ifdef __cplusplus
}
#endif
#endif
