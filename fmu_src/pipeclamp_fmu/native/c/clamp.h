/* What a pipe clamp remembers; see clamp.c. Lengths in mm, forces in N, as the law has them. */
#ifndef CLAMP_H
#define CLAMP_H

/* A place on the way, with what the law makes of it. */
typedef struct {
    double y, v, force, energy;
    double z[ROOM(LAW_STATES)];
} Place;

/* A (mm), f (Hz), T (K) and further conditions of the motion, before A and f are held inside the range. */
typedef struct {
    double u[LAW_CONDITIONS];
    int tracking;
    double averages[6]; /* of y, y^2, v^2, two stages each */
} Conditions;

/* The clamp's own motion, where A and f are told and the law depends on them; all 0 at first. */
typedef struct {
    double time, y, square, speed;     /* of a cycle so far: its time, integrals of y, y^2, v^2 over it */
    double amplitude, frequency;       /* of the last cycle */
    double compared_with[3];           /* A, f, mean of the motion along which forces were compared last */
    double compared_k[ROOM(LAW_HELD)]; /* coefficients that they were compared for */
    int begun;                         /* a first reversal was seen */
    int off;                           /* how many cycles in a row were off */
    int compared, said;                /* whether forces were compared; whether it is to be said that they are off */
} OwnMotion;

typedef struct {
    double k[ROOM(LAW_HELD)]; /* what the law's step takes of conditions and coefficients */
    Place places[2]; /* the ends of the last step, the earlier one under its coefficients */
    int now; /* whether the later one is the second; its bytes may come from anywhere */
    double h;     /* how long the step was, s */
    int turned;   /* whether the motion turned round in it, or it was walked in parts */
    double share; /* by which the tracker's averages moved in it */
    Conditions conditions;
    double counted; /* load cycles since the start: a cycle is a way of four amplitudes, there and back */
    int inside; /* whether the conditions are inside the law's range */
    int follows; /* whether the law depends on A or f */
    OwnMotion own;
} Memory;

typedef struct {
    char unused;
} Scratch;

#endif
