/* What the programs of this folder share: one world with what is in it, and what main.c does with it in each step. */
#ifndef PLAIN_H
#define PLAIN_H
#include <ode/ode.h>
#include <stdlib.h>

/* By the name of its function; where something touches, its contacts are made before each step. */
typedef struct {
  const char* name;
  void (*make)(void);
  int touches;
} Scenario;

/* Each ends with a scenario without a name. */
extern const Scenario of_bodies[], of_callbacks[], of_contacts[], of_joints[], of_motors[], of_pendulums[], of_stops[];

extern dWorldID world; /* with gravity of 9.81 m/s^2 along -z */
extern dSpaceID space;
extern dBodyID bodies[]; /* whose poses are written */
extern int count;        /* of them */
extern double h;         /* s, of a step */

extern void (*control)(void); /* before each step; 0: nothing */

/* Of contacts: their surface, and what is done with each, 0: nothing. */
extern double bounce, friction, friction2;
extern int coefficients;             /* which of the two are coefficients, of dContactApprox1; others are forces */
extern const dReal* first_direction; /* of friction; 0: ODE's */
extern enum Softness { hard, soft, only_soft_erp, only_soft_cfm } contact_is;
extern void (*feel)(dJointID touch);

dBodyID add(double x, double y, double z);      /* one of `bodies` */
dBodyID float_at(double x, double y, double z); /* a box of a kilogram, without weight */
void make_box(dBodyID body, double mass, double x, double y, double z);
void make_ball(dBodyID body, double mass, double radius);

/* Springs of 1000 N/m and 20 N s/m, as ERP and CFM at this step. */
double erp(void);
double cfm(void);
/* Stops at -0.1 and 0.1, which are such springs. */
void soften(dJointID joint, void (*set)(dJointID, int, dReal), int groups);

#endif
