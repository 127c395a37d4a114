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
#include "no_warnings.c"

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

static void accelerations(double acceleration[MODES], const Motion *motion)
{
    double strain[MODES], damped[MODES];
    int i;
    forces(strain, STIFFNESS, motion->q);
    forces(damped, DAMPING, motion->p);
    for (i = 0; i < MODES; i++)
        acceleration[i] = motion->modal_loads[i] - damped[i] - strain[i];
}

/* Power of the excitation, and power done on the clamps, W: linear in the loads and in the velocities. */
static void powers(double power[2], const double loads[INPUTS], const double p[MODES])
{
    int i;
    power[0] = loads[0] * seen(PARTICIPATION, p);
    power[1] = 0.0;
    for (i = 0; i < CLAMPS; i++)
        power[1] += loads[1 + i] * seen(CLAMP_SHAPES[i], p);
}

/* Write the outputs that are linear in the motion; give where the others follow. */
static double *write_motion(double *output, const Motion *motion, const double acceleration[MODES])
{
    int i;
    for (i = 0; i < CLAMPS; i++)
        *output++ = seen(CLAMP_SHAPES[i], motion->q);
    for (i = 0; i < CLAMPS; i++)
        *output++ = seen(CLAMP_SHAPES[i], motion->p);
    for (i = 0; i < PROBES; i++)
        *output++ = seen(PROBE_SHAPES[i], motion->q);
    for (i = 0; i < PROBES; i++)
        *output++ = seen(PROBE_SHAPES[i], motion->p);
    for (i = 0; i < PROBES; i++)
        *output++ = CARRIED * motion->loads[0] + seen(PROBE_SHAPES[i], acceleration);
    return output;
}

/* Write the energies. The pipe starts at rest, and both works are exact: what is left is what damping has taken. */
static void write_energies(double *output, double energy, double excited, double on_clamps)
{
    output[0] = energy;
    output[1] = excited - on_clamps - energy;
    output[2] = excited;
    output[3] = on_clamps;
}

static void model_get_states(const Model *model, double states[])
{
    const Motion *motion = &model->memory.now;
    memcpy(states, motion->q, sizeof motion->q);
    memcpy(states + MODES, motion->p, sizeof motion->p);
    states[2 * MODES] = motion->excited;
    states[2 * MODES + 1] = motion->on_clamps;
}

static void take_states(Motion *motion, const double states[])
{
    memcpy(motion->q, states, sizeof motion->q);
    memcpy(motion->p, states + MODES, sizeof motion->p);
    motion->excited = states[2 * MODES];
    motion->on_clamps = states[2 * MODES + 1];
}

static void model_set_states(Model *model, const double states[])
{
    take_states(&model->memory.now, states);
}

static void model_derivatives(const Model *model, double derivatives[])
{
    const Motion *motion = &model->memory.now;
    memcpy(derivatives, motion->p, sizeof motion->p);
    accelerations(derivatives + MODES, motion);
    powers(derivatives + 2 * MODES, motion->loads, motion->p);
}

/* Write outputs, states and derivatives of the present motion. */
static void show(Model *model)
{
    const Motion *motion = &model->memory.now;
    double *const derivatives = model->real + FIRST_LOCAL + STATES;
    model_get_states(model, model->real + FIRST_LOCAL);
    model_derivatives(model, derivatives);
    write_energies(write_motion(model->real + FIRST_OUTPUT, motion, derivatives + MODES), stored(motion->q, motion->p),
                   motion->excited, motion->on_clamps);
}

static void model_reset(Model *model, const Values *values)
{
    memset(model, 0, sizeof *model);
    memcpy(model->real, values->start, sizeof values->start);
    memcpy(model->flag, values->flag, sizeof values->flag);
}

/* Take the inputs as those of the present time. */
static void take_loads(Model *model)
{
    Motion *motion = &model->memory.now;
    memcpy(motion->loads, model->real, sizeof motion->loads);
    modal_loads(motion->modal_loads, model->real);
    show(model);
}

static int model_start(Model *model, const Values *values, double time, char reason[TEXT])
{
    (void)values;
    (void)time;
    (void)reason;
    take_loads(model);
    return 1;
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

/* What a step moves to: modal displacements, velocities and mean displacements, linear in where it starts and the loads
 * at its ends. */
typedef struct {
    double q[MODES], p[MODES], mean[MODES];
} Moved;

static void moved(Moved *end, const Scratch *scratch, const double q[MODES], const double p[MODES],
                  const double g0[MODES], const double g1[MODES])
{
    int block, i, j;
    for (block = 0; block < BLOCKS; block++) {
        const int first = block * BLOCK;
        double *const ends[3] = {end->q + first, end->p + first, end->mean + first};
        for (i = 0; i < 3 * BLOCK; i++) {
            const double *row = scratch->rows[block][i];
            double sum = 0.0;
            for (j = 0; j < BLOCK; j++)
                sum += row[j] * q[first + j] + row[BLOCK + j] * p[first + j] + row[2 * BLOCK + j] * g0[first + j]
                       + row[3 * BLOCK + j] * g1[first + j];
            ends[i / BLOCK][i % BLOCK] = i < 2 * BLOCK ? sum : sum / scratch->h;
        }
    }
}

/* Work of a load that is linear over a step: the integral of load times velocity, by parts. */
static double work(const double shape[MODES], double load0, double load1, const double q0[MODES], const Moved *end)
{
    const double s0 = seen(shape, q0), s1 = seen(shape, end->q);
    return load0 * (s1 - s0) + (load1 - load0) * (s1 - seen(shape, end->mean));
}

/* Add the works of a step: of the excitation, and done on the clamps; linear in the loads and in the motion. */
static void add_works(Motion *motion, const double loads0[INPUTS], const double loads1[INPUTS], const double q0[MODES],
                      const Moved *end)
{
    int i;
    motion->excited += work(PARTICIPATION, loads0[0], loads1[0], q0, end);
    for (i = 0; i < CLAMPS; i++)
        motion->on_clamps += work(CLAMP_SHAPES[i], loads0[1 + i], loads1[1 + i], q0, end);
}

static int model_step(Model *model, const Values *values, Scratch *scratch, double end, double h, char reason[TEXT])
{
    Memory *memory = &model->memory;
    Motion next = memory->now;
    const int held = !model->flag[INPUTS_AT_STEP_END];
    const Motion *const load_before = held ? &next : &memory->now;
    Moved to;
    (void)values;
    (void)end;
    if (!finite_inputs(model->real, reason))
        return 0;
    if (h != scratch->h)
        prepare_length(scratch, h);
    memcpy(next.loads, model->real, sizeof next.loads);
    modal_loads(next.modal_loads, next.loads);
    moved(&to, scratch, memory->now.q, memory->now.p, load_before->modal_loads, next.modal_loads);
    if (!isfinite(stored(to.q, to.p))) {
        snprintf(reason, TEXT, "the motion would not be finite");
        return 0;
    }
    add_works(&next, load_before->loads, next.loads, memory->now.q, &to);
    memcpy(next.q, to.q, sizeof next.q);
    memcpy(next.p, to.p, sizeof next.p);
    memory->before = memory->now;
    memory->now = next;
    memory->h = h;
    memory->held = held;
    show(model);
    return 1;
}

/* How a step's end changes with the loads that it was given. */
static void change_of_step(Motion *change, const Memory *memory, Scratch *scratch)
{
    static const Motion still = {{0}, {0}, 0, 0, {0}, {0}};
    const Motion *const load_before = memory->held ? &memory->now : &memory->before;
    const Motion *const change_before = memory->held ? change : &still;
    Moved to, change_of_end;
    if (!(memory->h > 0.0 && memory->h < INFINITY))
        return;
    if (memory->h != scratch->h)
        prepare_length(scratch, memory->h);
    moved(&to, scratch, memory->before.q, memory->before.p, load_before->modal_loads, memory->now.modal_loads);
    moved(&change_of_end, scratch, still.q, still.p, change_before->modal_loads, change->modal_loads);
    add_works(change, change_before->loads, change->loads, memory->before.q, &to);
    add_works(change, load_before->loads, memory->now.loads, still.q, &change_of_end);
    memcpy(change->q, change_of_end.q, sizeof change->q);
    memcpy(change->p, change_of_end.p, sizeof change->p);
}

static void model_slopes(const Model *model, const Values *values, Scratch *scratch, int co_simulation,
                         const double direction[ROOM(COLUMNS)], double slopes[ROOM(ROWS)])
{
    const Motion *now = &model->memory.now;
    double *const rates = slopes + OUTPUTS, strain[MODES], change_of_strain[MODES], power[2];
    Motion change = {{0}, {0}, 0, 0, {0}, {0}};
    (void)values;
    memcpy(change.loads, direction, sizeof change.loads);
    modal_loads(change.modal_loads, change.loads);
    if (co_simulation)
        change_of_step(&change, &model->memory, scratch);
    else
        take_states(&change, direction + FIRST_OUTPUT);
    memcpy(rates, change.p, sizeof change.p);
    accelerations(rates + MODES, &change);
    powers(rates + 2 * MODES, change.loads, now->p);
    powers(power, now->loads, change.p);
    rates[2 * MODES] += power[0];
    rates[2 * MODES + 1] += power[1];
    forces(strain, STIFFNESS, now->q);
    forces(change_of_strain, STIFFNESS, change.q);
    write_energies(write_motion(slopes, &change, rates + MODES),
                   seen(now->p, change.p) + (seen(strain, change.q) + seen(now->q, change_of_strain)) / 2,
                   change.excited, change.on_clamps);
}
