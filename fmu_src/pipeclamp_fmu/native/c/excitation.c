/* An excitation: samples at equal steps, linear between them, zero after the last. Counterpart of excitation_slave.py. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "model.h"
#include "no_warnings.c"
#include "no_states.c"

static double sample(double index)
{
    return index < SAMPLES ? VALUES[(int)index] : 0.0;
}

static double interpolated(double time)
{
    const double place = fmax(time, 0.0) / STEP, nearest = floor(place + 0.5);
    const int on_sample = fabs(place - nearest) <= 1e-9 * place; /* but for the rounding of a sum of steps */
    const double index = on_sample ? nearest : floor(place), share = on_sample ? 0.0 : place - index;
    const double before = sample(index);
    return before + share * (sample(index + 1) - before);
}

static void model_reset(Model *model, const Values *values)
{
    (void)values;
    memset(model, 0, sizeof *model);
}

static int model_start(Model *model, const Values *values, double time, char reason[TEXT])
{
    (void)values;
    (void)reason;
    model->real[FIRST_OUTPUT] = interpolated(time);
    return 1;
}

static int model_step(Model *model, const Values *values, Scratch *scratch, double end, double h, char reason[TEXT])
{
    (void)values;
    (void)scratch;
    (void)h;
    if (!isfinite(end)) {
        snprintf(reason, TEXT, "expected a finite time");
        return 0;
    }
    model->real[FIRST_OUTPUT] = interpolated(end);
    return 1;
}

static int model_evaluate(Model *model, const Values *values, Scratch *scratch, double time, double h,
                          char reason[TEXT])
{
    return model_step(model, values, scratch, time, h, reason);
}

/* There is nothing that the signal depends on but the time. */
static void model_slopes(const Model *model, const Values *values, Scratch *scratch, int co_simulation,
                         const double direction[ROOM(COLUMNS)], double slopes[ROOM(ROWS)])
{
    (void)model;
    (void)values;
    (void)scratch;
    (void)co_simulation;
    (void)direction;
    slopes[0] = 0.0;
}
