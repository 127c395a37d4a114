/* What a pipe clamp remembers; see clamp.c. Lengths in mm, forces in N, as the law has them. */
#ifndef CLAMP_H
#define CLAMP_H

#define ROOM(count) ((count) > 0 ? (count) : 1)

/* Coefficients, and what they make of a place. */
typedef struct {
    double k[ROOM(LAW_COEFFICIENTS)];
    double y, v, force, energy;
    double z[ROOM(LAW_STATES)];
} Motion;

/* A (mm), f (Hz), T (K) and further conditions of the motion, before A and f are held inside the range. */
typedef struct {
    double u[LAW_CONDITIONS];
    int tracking;
    double averages[6]; /* of y, y^2, v^2, two stages each */
} Conditions;

typedef struct {
    Motion now;  /* at the end of the last step */
    Motion from; /* where that step began, under its coefficients */
    double h;    /* how long it was, s */
    double share; /* by which the tracker's averages moved in it */
    Conditions conditions;
    int inside; /* whether the conditions are inside the law's range */
} Memory;

#endif
