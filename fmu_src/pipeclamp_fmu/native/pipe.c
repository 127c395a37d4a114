/* A straight pipe in modes, shaken by its base or by a force, with ports for clamps. The counterpart of pipe_slave.py.
 *
 * q'' + C q' + K q = participation u - sum over clamps of shape f, stepped exactly for inputs that are held over the
 * step, or linear from the last communication point's to those set (inputsAtStepEnd). Modes that axial force and flow
 * couple are one block of K and C; else each mode is a block of its own.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "model.h"

enum { INPUTS_AT_STEP_END };
enum { TERMS = 16 }; /* of the power series; with the matrix' norm times the step up to 1/2, the first left out is 1e-18 */

/* --- Matrices */

static void product(Matrix result, Matrix a, Matrix b)
{
    int i, j, k;
    for (i = 0; i < WIDE; i++)
        for (j = 0; j < WIDE; j++) {
            double sum = 0.0;
            for (k = 0; k < WIDE; k++)
                sum += a[i][k] * b[k][j];
            result[i][j] = sum;
        }
}

/* Add a share of a matrix. */
static void add(Matrix result, double share, Matrix a)
{
    int i, j;
    for (i = 0; i < WIDE; i++)
        for (j = 0; j < WIDE; j++)
            result[i][j] += share * a[i][j];
}

static double norm_of(Matrix a)
{
    double largest = 0.0;
    int i, j;
    for (i = 0; i < WIDE; i++) {
        double sum = 0.0;
        for (j = 0; j < WIDE; j++)
            sum += fabs(a[i][j]);
        largest = fmax(largest, sum);
    }
    return largest;
}

/* e^(A h) and its first three integrals over time from 0 to h, into room[0] to room[3]; A in room[4].
 *
 * The power series at h/2^n is exact to rounding; from the integrals E_j at t those at 2 t follow, because the state at
 * t is the start of the second half: E_j(2t) = sum over i of t^i/i! E_(j-i)(t) + E_0 E_j, i below j.
 */
static void integrals(Matrix room[MATRICES], double h)
{
    Matrix *const sums = room, *const scaled = &room[5], *const power = &room[6], *const next = &room[7];
    double t = h, factorial = 1.0;
    int doublings = 0, n, j, i;
    for (; t * norm_of(room[4]) > 0.5; doublings++)
        t *= 0.5;
    memset(sums, 0, 4 * sizeof(Matrix));
    memset(scaled, 0, sizeof(Matrix));
    memset(power, 0, sizeof(Matrix));
    add(*scaled, t, room[4]);
    for (i = 0; i < WIDE; i++)
        (*power)[i][i] = 1.0;
    for (n = 0; n <= TERMS; n++) {
        double weight;
        factorial *= n > 1 ? n : 1;
        weight = 1.0 / factorial;
        for (j = 0; j < 4; j++) {
            add(sums[j], weight, *power);
            weight *= t / (n + j + 1);
        }
        product(*next, *power, *scaled);
        memcpy(power, next, sizeof(Matrix));
    }
    for (; doublings > 0; doublings--) {
        for (j = 3; j >= 0; j--) {
            product(*next, sums[0], sums[j]);
            if (j == 0) {
                memcpy(sums, next, sizeof(Matrix));
            } else {
                double weight = 1.0;
                for (i = 1; i < j; i++) {
                    weight *= t / i;
                    add(*next, weight, sums[j - i]);
                }
                add(sums[j], 1.0, *next);
            }
        }
        t *= 2.0;
    }
}

/* Rows over (q, p, g0, g1) from matrices over (w q, p): the response to the start, to a held load, to its ramp. */
static void write_row(double row[4 * BLOCK], double scale, double w, const double start[WIDE], const double held[WIDE],
                      const double ramp[WIDE])
{
    int j;
    for (j = 0; j < BLOCK; j++) {
        row[j] = scale * w * start[j];
        row[BLOCK + j] = scale * start[BLOCK + j];
        row[2 * BLOCK + j] = scale * (held[BLOCK + j] - ramp[BLOCK + j]);
        row[3 * BLOCK + j] = scale * ramp[BLOCK + j];
    }
}

/* Find the matrices of steps of a length. */
static void prepare_length(Scratch *scratch, double h)
{
    Matrix *const room = scratch->room;
    int block, i, j;
    for (block = 0; block < BLOCKS; block++) {
        double largest = 1.0, w;
        for (i = 0; i < BLOCK; i++) {
            double sum = 0.0;
            for (j = 0; j < BLOCK; j++)
                sum += fabs(STIFFNESS[block][i][j]);
            largest = fmax(largest, sum);
        }
        /* Over (w q, p) with w about the highest frequency the generator's entries are alike, which saves doublings. */
        w = sqrt(largest);
        memset(room[4], 0, sizeof(Matrix));
        for (i = 0; i < BLOCK; i++) {
            room[4][i][BLOCK + i] = w;
            for (j = 0; j < BLOCK; j++) {
                room[4][BLOCK + i][j] = -STIFFNESS[block][i][j] / w;
                room[4][BLOCK + i][BLOCK + j] = -DAMPING[block][i][j];
            }
        }
        integrals(room, h);
        for (j = 2; j <= 3; j++) { /* the ramps: second and third integral over h */
            memset(room[3 + j], 0, sizeof(Matrix));
            add(room[3 + j], 1 / h, room[j]);
        }
        for (i = 0; i < BLOCK; i++) {
            double(*const rows)[4 * BLOCK] = scratch->rows[block];
            write_row(rows[i], 1 / w, w, room[0][i], room[1][i], room[5][i]);
            write_row(rows[BLOCK + i], 1.0, w, room[0][BLOCK + i], room[1][BLOCK + i], room[5][BLOCK + i]);
            write_row(rows[2 * BLOCK + i], 1 / w, w, room[1][i], room[2][i], room[6][i]);
        }
    }
    scratch->h = h;
}

/* --- The pipe */

/* Modal loads: clamps' forces act on the pipe with the opposite sign. */
static void modal_loads(double g[MODES], const double loads[INPUTS])
{
    int mode, clamp;
    for (mode = 0; mode < MODES; mode++) {
        g[mode] = PARTICIPATION[mode] * loads[0];
        for (clamp = 0; clamp < CLAMPS; clamp++)
            g[mode] -= CLAMP_SHAPES[clamp][mode] * loads[1 + clamp];
    }
}

static double seen(const double shape[MODES], const double modal[MODES])
{
    double sum = 0.0;
    int mode;
    for (mode = 0; mode < MODES; mode++)
        sum += shape[mode] * modal[mode];
    return sum;
}

/* A block matrix times modal values. */
static void forces(double result[MODES], const double matrices[BLOCKS][BLOCK][BLOCK], const double modal[MODES])
{
    int block, i, j;
    for (block = 0; block < BLOCKS; block++)
        for (i = 0; i < BLOCK; i++) {
            double sum = 0.0;
            for (j = 0; j < BLOCK; j++)
                sum += matrices[block][i][j] * modal[block * BLOCK + j];
            result[block * BLOCK + i] = sum;
        }
}

/* Kinetic and strain energy, J. */
static double stored(const double q[MODES], const double p[MODES])
{
    double strain[MODES];
    forces(strain, STIFFNESS, q);
    return (seen(p, p) + seen(q, strain)) / 2;
}

static void accelerations(double acceleration[MODES], const Memory *memory)
{
    double strain[MODES], damped[MODES];
    int i;
    forces(strain, STIFFNESS, memory->q);
    forces(damped, DAMPING, memory->p);
    for (i = 0; i < MODES; i++)
        acceleration[i] = memory->modal_loads[i] - damped[i] - strain[i];
}

static void model_get_states(const Model *model, double states[])
{
    const Memory *memory = &model->memory;
    memcpy(states, memory->q, sizeof memory->q);
    memcpy(states + MODES, memory->p, sizeof memory->p);
    states[2 * MODES] = memory->excited;
    states[2 * MODES + 1] = memory->on_clamps;
}

static void model_set_states(Model *model, const double states[])
{
    Memory *memory = &model->memory;
    memcpy(memory->q, states, sizeof memory->q);
    memcpy(memory->p, states + MODES, sizeof memory->p);
    memory->excited = states[2 * MODES];
    memory->on_clamps = states[2 * MODES + 1];
}

static void model_derivatives(const Model *model, double derivatives[])
{
    const Memory *memory = &model->memory;
    int i;
    memcpy(derivatives, memory->p, sizeof memory->p);
    accelerations(derivatives + MODES, memory);
    derivatives[2 * MODES] = memory->loads[0] * seen(PARTICIPATION, memory->p);
    derivatives[2 * MODES + 1] = 0.0;
    for (i = 0; i < CLAMPS; i++)
        derivatives[2 * MODES + 1] += memory->loads[1 + i] * seen(CLAMP_SHAPES[i], memory->p);
}

/* Write outputs, states and derivatives of the present motion. */
static void show(Model *model)
{
    const Memory *memory = &model->memory;
    double *output = model->real + FIRST_OUTPUT, *acceleration = model->real + FIRST_LOCAL + STATES + MODES;
    const double energy = stored(memory->q, memory->p);
    int i;
    model_get_states(model, model->real + FIRST_LOCAL);
    model_derivatives(model, model->real + FIRST_LOCAL + STATES);
    for (i = 0; i < CLAMPS; i++)
        *output++ = seen(CLAMP_SHAPES[i], memory->q);
    for (i = 0; i < CLAMPS; i++)
        *output++ = seen(CLAMP_SHAPES[i], memory->p);
    for (i = 0; i < PROBES; i++)
        *output++ = seen(PROBE_SHAPES[i], memory->q);
    for (i = 0; i < PROBES; i++)
        *output++ = seen(PROBE_SHAPES[i], memory->p);
    for (i = 0; i < PROBES; i++)
        *output++ = CARRIED * memory->loads[0] + seen(PROBE_SHAPES[i], acceleration);
    *output++ = energy;
    /* The pipe starts at rest, and both works are exact: what is left is what damping has taken. */
    *output++ = memory->excited - memory->on_clamps - energy;
    *output++ = memory->excited;
    *output++ = memory->on_clamps;
}

static void model_reset(Model *model, const Values *values)
{
    memset(model, 0, sizeof *model);
    memcpy(model->real, values->start, sizeof values->start);
}

/* Take the inputs as those of the present time. */
static void take_loads(Model *model)
{
    memcpy(model->memory.loads, model->real, sizeof model->memory.loads);
    modal_loads(model->memory.modal_loads, model->real);
    show(model);
}

static int model_start(Model *model, const Values *values, char reason[TEXT])
{
    (void)values;
    (void)reason;
    take_loads(model);
    return 1;
}

/* Work of a load that is linear over a step: the integral of load times velocity, by parts. */
static double work(const double shape[MODES], double load0, double load1, const double q0[MODES], const double q1[MODES],
                   const double mean[MODES])
{
    const double s0 = seen(shape, q0), s1 = seen(shape, q1);
    return load0 * (s1 - s0) + (load1 - load0) * (s1 - seen(shape, mean));
}

static int finite_inputs(const double loads[INPUTS], char reason[TEXT])
{
    double sum = 0.0;
    int i;
    for (i = 0; i < INPUTS; i++)
        sum += loads[i];
    if (isfinite(sum))
        return 1;
    for (i = 0; i < INPUTS; i++)
        if (!isfinite(loads[i])) {
            const char *text = isnan(loads[i]) ? "nan" : loads[i] > 0 ? "inf" : "-inf";
            snprintf(reason, TEXT, "%s is %s; expected a finite number", REAL_NAMES[i], text);
            return 0;
        }
    snprintf(reason, TEXT, "the inputs are too large");
    return 0;
}

static int model_evaluate(Model *model, const Values *values, Scratch *scratch, double time, double h,
                          char reason[TEXT])
{
    (void)values;
    (void)scratch;
    (void)time;
    (void)h;
    if (!finite_inputs(model->real, reason))
        return 0;
    take_loads(model);
    return 1;
}

static int model_step(Model *model, const Values *values, Scratch *scratch, double end, double h, char reason[TEXT])
{
    Memory *memory = &model->memory;
    const double *loads = model->real, *loads_before = loads, *g0;
    double g1[MODES], q[MODES], p[MODES], mean[MODES], energy;
    int block, i, j;
    (void)values;
    (void)end;
    if (!finite_inputs(loads, reason))
        return 0;
    modal_loads(g1, loads);
    g0 = g1;
    if (model->flag[INPUTS_AT_STEP_END]) {
        loads_before = memory->loads;
        g0 = memory->modal_loads;
    }
    if (h != scratch->h)
        prepare_length(scratch, h);
    for (block = 0; block < BLOCKS; block++) {
        const int first = block * BLOCK;
        double *const ends[3] = {q + first, p + first, mean + first};
        for (i = 0; i < 3 * BLOCK; i++) {
            const double *row = scratch->rows[block][i];
            double sum = 0.0;
            for (j = 0; j < BLOCK; j++)
                sum += row[j] * memory->q[first + j] + row[BLOCK + j] * memory->p[first + j]
                       + row[2 * BLOCK + j] * g0[first + j] + row[3 * BLOCK + j] * g1[first + j];
            ends[i / BLOCK][i % BLOCK] = i < 2 * BLOCK ? sum : sum / h;
        }
    }
    energy = stored(q, p);
    if (!isfinite(energy)) {
        snprintf(reason, TEXT, "the motion would not be finite");
        return 0;
    }
    memory->excited += work(PARTICIPATION, loads_before[0], loads[0], memory->q, q, mean);
    for (i = 0; i < CLAMPS; i++)
        memory->on_clamps += work(CLAMP_SHAPES[i], loads_before[1 + i], loads[1 + i], memory->q, q, mean);
    memcpy(memory->q, q, sizeof q);
    memcpy(memory->p, p, sizeof p);
    memcpy(memory->loads, loads, sizeof memory->loads);
    memcpy(memory->modal_loads, g1, sizeof g1);
    show(model);
    return 1;
}

static int model_within_range(const Model *model)
{
    (void)model;
    return 1;
}

static void model_say_range(const Model *model, const Values *values, char text[TEXT])
{
    (void)model;
    (void)values;
    (void)text;
}

static void model_jacobian(const Model *model, const Values *values, double jacobian[OUTPUTS][ROOM(FIRST_OUTPUT)])
{
    (void)model;
    (void)values;
    memset(jacobian, 0, OUTPUTS * FIRST_OUTPUT * sizeof(double));
}

static void model_indicators(const Model *model, double indicators[])
{
    (void)model;
    (void)indicators;
}
