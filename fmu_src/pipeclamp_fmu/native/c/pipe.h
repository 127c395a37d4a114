/* What a pipe remembers, and what its steps are made of; see pipe.c. SI units. */
#ifndef PIPE_H
#define PIPE_H

typedef struct {
    double q[MODES], p[MODES]; /* modal displacements and velocities */
    double excited, on_clamps; /* work of the excitation, and work done on the clamps, J */
    double loads[INPUTS], modal_loads[MODES];
} Motion;

typedef struct {
    Motion now, before; /* at the ends of the last step */
    double h;           /* how long it was, s; 0 before the first */
    int held;           /* whether its loads were held over it */
} Memory;

enum { WIDE = 2 * BLOCK, MATRICES = 9 };
typedef double Matrix[WIDE][WIDE];

/* Not part of a saved state: the matrices of steps of one length, and room to find them. */
typedef struct {
    double h;
    double rows[BLOCKS][3 * BLOCK][4 * BLOCK]; /* (q, p, g0, g1) -> (q, p, integral of q) */
    Matrix room[MATRICES];
} Scratch;

#endif
