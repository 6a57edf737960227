/* What touches: hard and soft, with friction, felt by its feedback. */
#include "plain.h"

static void bouncing_ball(void) {
  bounce = 0.7;
  dCreatePlane(space, 0, 0, 1, 0);
  make_ball(add(0, 0, 1.1), 1, 0.1);
}

static void friction_slide(void) {
  friction = 0.3;
  dCreatePlane(space, 0, 0, 1, 0);
  make_box(add(0, 0, 0.05), 2, 0.4, 0.4, 0.1);
  dBodySetLinearVel(bodies[0], 2, 0, 0);
}

/* The same box, askew, with a third of the friction along the second of ODE's directions, x, or across a slope's. */
static void two_frictions(void) {
  friction_slide();
  friction2 = 0.1;
  dBodySetLinearVel(bodies[0], 2, 1, 0);
}

static void directed_frictions(void) {
  static const dVector3 slope = {0.6, 0.8, 0};
  two_frictions();
  first_direction = slope;
}

/* The same box, with a coefficient along the first of ODE's directions, y, and half a newton a contact along x. */
static void mixed_frictions(void) {
  two_frictions();
  coefficients = dContactApprox1_1;
  friction2 = 0.5;
}

/* A ball on soft ground. */
static void soft_contact(void) {
  contact_is = soft;
  dCreatePlane(space, 0, 0, 1, 0);
  make_ball(add(0, 0, 0.2), 1, 0.1);
}

/* The same, where the contact has the one number and the world the other. */
static void soft_erp_contact(void) {
  soft_contact();
  contact_is = only_soft_erp;
  dWorldSetCFM(world, cfm());
}

static void soft_cfm_contact(void) {
  soft_contact();
  contact_is = only_soft_cfm;
  dWorldSetERP(world, erp());
}

static dJointFeedback touched[8];
static int touches;
static void push_as_touched(void) {
  double sum = 0;
  for (int i = 0; i < touches; ++i) sum += touched[i].f1[2];
  dBodyAddForce(bodies[0], 0.05 * sum, 0, 0);
  touches = 0;
}

/* A ball that falls on the ground and stays there, pushed along by a part of what its contacts, one after the other,
 * were felt to do in the step before. */
static void feel_one_more(dJointID touch) {
  if (touches < 8) dJointSetFeedback(touch, &touched[touches++]);
}
static void touchy(void) {
  bouncing_ball();
  bounce = 0;
  control = push_as_touched;
  feel = feel_one_more;
}

/* A box that rests on four contacts, all of which are felt at one place, pushed by a part of that. */
static void push_as_touched_last(void) { dBodyAddForce(bodies[0], 0.2 * touched[0].f1[2], 0, 0); }
static void feel_in_one_place(dJointID touch) { dJointSetFeedback(touch, &touched[0]); }
static void shared(void) {
  dCreatePlane(space, 0, 0, 1, 0);
  make_box(add(0, 0, 0.05), 1, 0.4, 0.4, 0.1);
  control = push_as_touched_last;
  feel = feel_in_one_place;
}

/* Of a heavy plate and a ball on it, that floats but for the force that presses it down, what the second of the two
 * feels: it is pushed along by a part of it, and of the torque that it feels another way. */
static void push_as_the_second_touched(void) {
  double force = 0, torque = 0;
  for (int i = 0; i < touches; ++i) force += touched[i].f2[2], torque += touched[i].t2[1];
  dBodyAddForce(bodies[0], 0.05 * force, 0.5 * torque, -9.81);
  touches = 0;
}
static void second_touch(void) {
  friction = 0.1;
  dBodyID plate = dBodyCreate(world); /* in the space before the ball */
  dBodySetGravityMode(plate, 0);
  make_box(plate, 1000, 4, 4, 0.1);
  make_ball(add(0, 0, 0.15), 1, 0.1);
  dBodySetGravityMode(bodies[0], 0);
  control = push_as_the_second_touched;
  feel = feel_one_more;
}

/* A ball that rests, pushed as ODE's random numbers say, of which its callback draws as well. */
static void push_at_random(void) { dBodyAddForce(bodies[0], 10 * dRandReal() - 5, 0, 0); }
static void draw_one_more(dJointID touch) {
  (void)touch;
  dRand();
}
static void drawn(void) {
  dCreatePlane(space, 0, 0, 1, 0);
  make_ball(add(0, 0, 0.1), 1, 0.1);
  control = push_at_random;
  feel = draw_one_more;
}

/* A ball that slides, on one contact. */
static void skid(void) {
  friction = 0.3;
  dCreatePlane(space, 0, 0, 1, 0);
  make_ball(add(0, 0, 0.1), 1, 0.1);
  dBodySetLinearVel(bodies[0], 5, 0, 0);
}

const Scenario of_contacts[] = {
    {"bouncing_ball", bouncing_ball, 1},
    {"friction_slide", friction_slide, 1},
    {"two_frictions", two_frictions, 1},
    {"directed_frictions", directed_frictions, 1},
    {"mixed_frictions", mixed_frictions, 1},
    {"soft_contact", soft_contact, 1},
    {"soft_erp_contact", soft_erp_contact, 1},
    {"soft_cfm_contact", soft_cfm_contact, 1},
    {"touchy", touchy, 1},
    {"shared", shared, 1},
    {"second_touch", second_touch, 1},
    {"drawn", drawn, 1},
    {"skid", skid, 1},
    {0, 0, 0},
};
