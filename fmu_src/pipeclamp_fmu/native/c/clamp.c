/* A pipe clamp: force from displacement, velocity and temperature. The counterpart of clamp_slave.py.
 *
 * Inputs are the values at the end of the step; within_step.c says what the motion is between.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "model.h"

enum { S, V, T_IN, A, F, T };
enum { FORCE = FIRST_OUTPUT, A_USED, F_USED, T_USED, DISSIPATED, DEVIATION };
enum { KEPT_S = FIRST_LOCAL + 2 * STATES, KEPT_V };
enum { KEPT_Z = STATES > 0 ? (int)FIRST_LOCAL : KEPT_V + 1 }; /* continuous states come first among the locals */
enum { USE_T_IN, TRACK, IN_RANGE };

static const double MM = 1000.0; /* in a metre: the law is in mm, the FMU's boundary in m */
static const double HUGE_NUMBER = 1e30; /* beyond it a value is a mistake; below it, powers don't overflow */
static const double PI = 3.14159265358979323846;
static const double AVERAGING = 1.5; /* time constant of each of the tracker's averages, in periods */
static const double SLACK = 1e-9;    /* share by which a value may pass the end of its range: rounding of units */
static const double RIPPLE = 0.01;   /* and by which A and f may where they are followed: the averages' own ripple */

static const double *parameters(const Model *model)
{
    return model->real + FIRST_FIXED;
}

static int within(double value, const double range[2], double slack)
{
    return range[0] - slack * fabs(range[0]) <= value && value <= range[1] + slack * fabs(range[1]);
}

/* The share by which A (place 0), f (1) or a later condition may pass the end of its range. */
static double slack_of(int place, const Conditions *conditions)
{
    return place < 2 && conditions->tracking ? RIPPLE : SLACK;
}

static double held(double value, const double range[2])
{
    return fmin(fmax(value, range[0]), range[1]);
}

#include "own_motion.c"
#include "within_step.c"

/* Averages of a sinusoid of this amplitude (mm) and frequency (Hz). */
static void start_tracking(double averages[6], double amplitude, double frequency)
{
    const double square = amplitude * amplitude / 2;
    const double omega = 2 * PI * frequency;
    averages[0] = averages[1] = 0.0;
    averages[2] = averages[3] = square;
    averages[4] = averages[5] = omega * omega * square;
}

/* Move the averages towards the present motion: two one-pole filters in a row, of the same share per step. */
static void track_motion(double averages[6], double share, double y, double v)
{
    const double present[3] = {y, y * y, v * v};
    int i;
    for (i = 0; i < 3; i++) {
        averages[2 * i] += share * (present[i] - averages[2 * i]);
        averages[2 * i + 1] += share * (averages[2 * i] - averages[2 * i + 1]);
    }
}

/* A = sqrt(2 var), 2 pi f = sqrt(<v^2>/var), var = <y^2> - <y>^2; without motion the frequency stays. */
static void amplitude_and_frequency(const double averages[6], const Values *values, double *amplitude,
                                    double *frequency)
{
    const double variance = averages[3] - averages[1] * averages[1];
    const double least = SLACK * values->range[0][0];
    if (variance <= least * least) {
        *amplitude = 0.0;
        return;
    }
    *amplitude = sqrt(2 * variance);
    *frequency = sqrt(averages[5] / variance) / (2 * PI);
}

/* Conditions for the law: as set, or as tracked but held inside the law's range. */
static void in_use(const Conditions *conditions, const Values *values, double used[LAW_CONDITIONS])
{
    memcpy(used, conditions->u, sizeof conditions->u);
    if (conditions->tracking) {
        used[0] = held(used[0], values->range[0]);
        used[1] = held(used[1], values->range[1]);
    }
}

/* Take A (mm), f (Hz), T (K) and further conditions that are set, or say what is wrong with them. */
static int take_settings(const Model *model, double u[LAW_CONDITIONS], char reason[TEXT])
{
    const double *real = model->real;
    const int temperature = model->flag[USE_T_IN] ? T_IN : T;
    const char *const units[3] = {" m", " Hz", " K"};
    int i;
    for (i = 0; i < INPUTS + PARAMETERS; i++) {
        if (!(fabs(MM * real[i]) < HUGE_NUMBER)) {
            char text[32];
            snprintf(text, sizeof text, isnan(real[i]) ? "nan" : "%g", real[i]); /* without the sign of a NaN */
            snprintf(reason, TEXT, "%s is %s; expected a number between -%g and %g", REAL_NAMES[i], text,
                     HUGE_NUMBER / MM, HUGE_NUMBER / MM);
            return 0;
        }
    }
    for (i = 0; i < LAW_CONDITIONS; i++) {
        const int place = A + i == T ? temperature : A + i;
        const char *const unit = i < 3 ? units[i] : "";
        if (CONDITION_POSITIVE[i] && real[place] <= 0.0) {
            snprintf(reason, TEXT, "%s is %g%s; expected a value above 0%s", REAL_NAMES[place], real[place], unit,
                     unit);
            return 0;
        }
        u[i] = CONDITION_SCALES[i] * real[place];
        if (i == COUNTED)
            u[i] += model->memory.counted;
    }
    return 1;
}

/* Give the coefficients of other conditions and put a place under them, or say that the law has no value there.
 *
 * Force and stored energy at the old place become those of the new coefficients, so that what a change of conditions
 * does to the stored energy is not taken for dissipation.
 */
static int put_under(Place *place, double k[], const Conditions *conditions, const Model *model, const Values *values,
                     char reason[TEXT])
{
    double used[LAW_CONDITIONS], unused[ROOM(LAW_STATES)], result[2];
    int i, same = 1, finite = 1;
    in_use(conditions, values, used);
    law_coefficients(parameters(model), used, k);
    for (i = 0; i < LAW_HELD; i++) {
        finite = finite && isfinite(k[i]);
        same = same && k[i] == model->memory.k[i];
    }
    if (same)
        return 1;
    law_step(k, place->z, place->y, place->y, place->v, 0.0, result, unused);
    if (!finite || !isfinite(result[0] + result[1])) {
        snprintf(reason, TEXT, "the law has no value at A = %g mm, f = %g Hz", conditions->u[0], conditions->u[1]);
        return 0;
    }
    place->force = result[0];
    place->energy = result[1];
    return 1;
}

/* Keep the conditions and show what is used of them. */
static void take(Model *model, const Conditions *conditions, const Values *values)
{
    double used[LAW_CONDITIONS];
    int i;
    in_use(conditions, values, used);
    model->real[A_USED] = used[0] / MM;
    model->real[F_USED] = used[1];
    model->real[T_USED] = used[2];
    model->memory.conditions = *conditions;
    model->memory.inside = 1;
    for (i = 0; i < RANGES; i++)
        model->memory.inside = model->memory.inside && within(conditions->u[i], values->range[i], slack_of(i, conditions));
    model->settled = !conditions->tracking && COUNTED < 0; /* else the next step is under other conditions */
    if (conditions->tracking)
        forget_motion(model);
}

static const Place *now(const Memory *memory)
{
    return &memory->places[memory->now != 0];
}

/* Show what continuous states there are, and their derivatives. */
static void show_states(Model *model);

static void show_motion(Model *model, const Values *values)
{
    const Place *place = now(&model->memory);
    int i;
    model->real[FORCE] = place->force;
    model->real[KEPT_S] = model->real[S];
    model->real[KEPT_V] = model->real[V];
    for (i = 0; i < LAW_STATES; i++)
        model->real[KEPT_Z + i] = place->z[i];
    model->flag[IN_RANGE] = model->memory.inside && fabs(place->y) <= values->range[0][1] * (1 + SLACK);
    show_states(model);
}

static void model_reset(Model *model, const Values *values)
{
    Memory *memory = &model->memory;
    int i;
    memset(model, 0, sizeof *model);
    memcpy(model->real, values->start, sizeof values->start);
    memcpy(model->real + FIRST_FIXED, values->fixed, sizeof values->fixed);
    memcpy(model->flag, values->flag, sizeof values->flag);
    memcpy(memory->places[0].z, law_rest, LAW_STATES * sizeof law_rest[0]);
    for (i = 0; i < LAW_CONDITIONS; i++)
        memory->conditions.u[i] = CONDITION_SCALES[i] * values->start[A + i];
    memory->inside = model->flag[IN_RANGE] = 1;
}

static int model_start(Model *model, const Values *values, double time, char reason[TEXT])
{
    Memory *memory = &model->memory;
    Conditions conditions = {{0}, 0, {0}};
    Place place;
    double k[ROOM(LAW_HELD)] = {0};
    (void)time;
    if (!take_settings(model, conditions.u, reason))
        return 0;
    conditions.tracking = model->flag[TRACK];
    if (conditions.tracking)
        start_tracking(conditions.averages, conditions.u[0], conditions.u[1]);
    memset(&place, 0, sizeof place);
    place.y = MM * model->real[S];
    place.v = MM * model->real[V];
    memcpy(place.z, law_rest, LAW_STATES * sizeof law_rest[0]);
    memory->k[0] = NAN; /* unlike any coefficients, so that force and energy are evaluated */
    if (!put_under(&place, k, &conditions, model, values, reason))
        return 0;
    memcpy(memory->k, k, sizeof k);
    memory->places[0] = memory->places[1] = place;
    memory->h = memory->share = 0.0;
    memory->turned = 0;
    take(model, &conditions, values);
    forget_motion(model);
    memory->follows = depends_on_motion(model, values);
    show_motion(model, values);
    return 1;
}

/* What a step under new conditions starts from. */
typedef struct {
    Conditions conditions;
    double k[ROOM(LAW_HELD)];
    Place from;
    double share; /* by which the tracker's averages moved */
} Prepared;

/* Give the conditions of a step, their coefficients and the place that it starts from; nothing is changed. */
static int prepare(const Model *model, const Values *values, double h, Prepared *prepared, char reason[TEXT])
{
    const Conditions *before = &model->memory.conditions;
    Conditions *conditions = &prepared->conditions;
    if (!take_settings(model, conditions->u, reason))
        return 0;
    prepared->share = 0.0;
    conditions->tracking = model->flag[TRACK];
    if (conditions->tracking) {
        if (before->tracking)
            memcpy(conditions->averages, before->averages, sizeof before->averages);
        else
            start_tracking(conditions->averages, conditions->u[0], conditions->u[1]);
        prepared->share = -expm1(-h * held(before->u[1], values->range[1]) / AVERAGING);
        track_motion(conditions->averages, prepared->share, MM * model->real[S], MM * model->real[V]);
        conditions->u[1] = before->u[1];
        amplitude_and_frequency(conditions->averages, values, &conditions->u[0], &conditions->u[1]);
    }
    prepared->from = *now(&model->memory);
    return put_under(&prepared->from, prepared->k, conditions, model, values, reason);
}

/* Move from a place to the inputs' under its coefficients; where they are new, keep them with their conditions. */
WITHIN static inline int move(Model *model, const Values *values, const Place *from, const double k[],
                       const Prepared *prepared, double h, char reason[TEXT])
{
    Memory *memory = &model->memory;
    const double y = MM * model->real[S], v = MM * model->real[V], v_before = from->v;
    Place to = {y, v, 0.0, 0.0, {0.0}};
    double length;
    int turned;
    const double lost = walk(k, from, &to, h, &length, &turned);
    if (!isfinite(to.force + to.energy + lost)) {
        snprintf(reason, TEXT, "the law has no value there");
        return 0;
    }
    model->real[DISSIPATED] += 0.001 * lost; /* N mm to J */
    memory->share = 0.0;
    if (prepared) {
        take(model, &prepared->conditions, values);
        memory->places[memory->now != 0] = prepared->from;
        memcpy(memory->k, prepared->k, sizeof prepared->k);
        memory->share = prepared->share;
    }
    memory->h = h;
    memory->turned = turned;
    if (COUNTED >= 0)
        memory->counted += length / (4 * MM * model->real[A_USED]);
    memory->now = !memory->now;
    memory->places[memory->now != 0] = to;
    show_motion(model, values);
    if (memory->follows && !memory->conditions.tracking)
        look_at_motion(model, values, y, v, v_before, h);
    return 1;
}

APART static int move_anew(Model *model, const Values *values, double h, char reason[TEXT])
{
    Prepared prepared;
    memset(&prepared, 0, sizeof prepared); /* all of it becomes part of the state, averages that aren't used too */
    return prepare(model, values, h, &prepared, reason)
           && move(model, values, &prepared.from, prepared.k, &prepared, h, reason);
}

static int model_step(Model *model, const Values *values, Scratch *scratch, double end, double h, char reason[TEXT])
{
    const int sound = fabs(MM * model->real[S]) < HUGE_NUMBER && fabs(MM * model->real[V]) < HUGE_NUMBER;
    (void)scratch;
    (void)end;
    if (model->settled && sound)
        return move(model, values, now(&model->memory), model->memory.k, NULL, h, reason);
    return move_anew(model, values, h, reason);
}

#include STATES_SOURCE

#include "clamp_slopes.c"

enum { BEYOND_RANGE = 1, FORCE_OFF = 2 }; /* what is warned of */

static int model_warnings(const Model *model)
{
    return (model->flag[IN_RANGE] ? 0 : BEYOND_RANGE) | (model->memory.own.said ? FORCE_OFF : 0);
}

static void say_range(const Model *model, const Values *values, char text[TEXT])
{
    const Memory *memory = &model->memory;
    const double end[2] = {0.0, values->range[0][1]};
    int i, length;
    length = snprintf(text, TEXT, "law %s is used beyond its range: ", values->name);
    for (i = 0; i <= RANGES; i++) {
        const double value = i < RANGES ? memory->conditions.u[i] : fabs(now(memory)->y);
        const double *range = i < RANGES ? values->range[i] : end;
        const char *name = i < RANGES ? REAL_NAMES[A + i] : "|flange.s|";
        const char *unit = i < RANGES ? RANGE_UNITS[i] : RANGE_UNITS[0], *space = *unit ? " " : "";
        if (within(value, range, slack_of(i, &memory->conditions)) || length < 0 || length >= TEXT)
            continue;
        length += snprintf(text + length, (size_t)(TEXT - length), "%s%s = %.6g%s%s is outside %g to %g%s%s",
                           text[length - 2] == ':' ? "" : "; ", name, value, space, unit, range[0], range[1], space,
                           unit);
    }
}

static void model_say_warning(const Model *model, const Values *values, int warning, char text[TEXT])
{
    if (warning == BEYOND_RANGE)
        say_range(model, values, text);
    else
        say_motion(model, values, text);
}

/* A reversal of the motion ends a step, so that memory turns round where the motion does. */
static void model_indicators(const Model *model, double indicators[])
{
    if (INDICATORS > 0)
        indicators[0] = model->real[V];
}
