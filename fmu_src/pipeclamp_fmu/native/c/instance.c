/* What FMI 2.0 and FMI 3.0 share: an instance with its mode, its messages, its saved states. */
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "values.h"

static const uint64_t SAVED_MARK = 0x70697065636c6d70u;

struct Saved {
    uint64_t mark, structure, size;
    Model done, shown;
    double time, done_time;
    int32_t stale, mode, co_simulation, unused;
};

static Instance *instance_new(const char *name, const char *token, const char *folder, int co_simulation,
                              char reason[TEXT])
{
    Instance *instance = calloc(1, sizeof *instance);
    const size_t length = name ? strlen(name) : 0;
    char *copy = malloc(length + 1);
    if (!instance || !copy) {
        snprintf(reason, TEXT, "no memory for an instance");
    } else if (length == 0) {
        snprintf(reason, TEXT, "the instance has no name");
    } else if (!token) {
        snprintf(reason, TEXT, "no identifier of the model description was given");
    } else if (values_read(&instance->values, folder, token, reason)) {
        instance->name = memcpy(copy, name, length + 1);
        instance->co_simulation = co_simulation;
        instance_reset(instance);
        return instance;
    }
    free(instance);
    free(copy);
    return NULL;
}

static void instance_free(Instance *instance)
{
    if (instance)
        free(instance->name);
    free(instance);
}

static void instance_reset(Instance *instance)
{
    model_reset(&instance->done, &instance->values);
    instance->shown = instance->done;
    instance->mode = INSTANTIATED;
    instance->time = instance->done_time = 0.0;
    instance->stale = instance->warned = instance->refused = 0;
}

RARE static void instance_say(const Instance *instance, Status status, const char *format, ...)
{
    char text[TEXT + 128];
    va_list arguments;
    if (!(instance->logging >> status & 1))
        return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    instance->tell(instance, status, text);
}

static int instance_may(const Instance *instance, int modes, const char *function)
{
    if (!instance)
        return 0;
    if (instance->mode & modes)
        return 1;
    instance_say(instance, STATUS_ERROR, "%s can't be called in this mode", function);
    return 0;
}

RARE static Status instance_misses(const Instance *instance, const char *what)
{
    instance_say(instance, STATUS_ERROR, "%s is missing", what);
    return STATUS_ERROR;
}

/* A function of an ability that this FMU doesn't claim. */
static Status instance_lacks(const Instance *instance, const char *function)
{
    if (instance_may(instance, ANY_MODE, function))
        instance_say(instance, STATUS_ERROR, "%s: this FMU doesn't have that ability", function);
    return STATUS_ERROR;
}

/* A function of variables or states of which there are none: it may be called for none of them. */
static Status instance_none(const Instance *instance, int modes, const char *function, size_t count)
{
    if (!instance_may(instance, modes, function))
        return STATUS_ERROR;
    if (count == 0)
        return STATUS_OK;
    instance_say(instance, STATUS_ERROR, "%s: this FMU has none of these", function);
    return STATUS_ERROR;
}

static Status worse(Status first, Status second)
{
    return first > second ? first : second;
}

/* --- Steps */

RARE static void warn(Instance *instance, int warnings)
{
    char text[TEXT];
    int warning;
    instance->warned |= warnings;
    for (warning = 1; warning <= warnings; warning <<= 1)
        if (warnings & warning) {
            model_say_warning(&instance->done, &instance->values, warning, text);
            instance_say(instance, STATUS_WARNING, "%s", text);
        }
}

static void warn_once(Instance *instance)
{
    const int warnings = model_warnings(&instance->done) & ~instance->warned;
    if (warnings)
        warn(instance, warnings);
}

RARE static Status discarded(const Instance *instance, double time, double h, const char *reason)
{
    char step[32];
    snprintf(step, sizeof step, isnan(h) ? "nan" : "%g", h);
    instance_say(instance, STATUS_DISCARD, "step from %g s by %s s discarded: %s", time, step, reason);
    return STATUS_DISCARD;
}

static Status started(Instance *instance)
{
    char reason[TEXT];
    if (model_start(&instance->done, &instance->values, instance->time, reason))
        return STATUS_OK;
    instance_say(instance, STATUS_ERROR, "start values: %s", reason);
    return STATUS_WARNING;
}

static Status instance_begin(Instance *instance, double time)
{
    instance->time = instance->done_time = time;
    instance->mode = INITIALIZATION;
    return STATUS_OK;
}

static Status instance_initialised(Instance *instance)
{
    const Status status = started(instance);
    instance->shown = instance->done;
    instance->mode = instance->co_simulation ? STEPPING : EVENT;
    return status;
}

static Status instance_do_step(Instance *instance, double time, double h)
{
    char reason[TEXT];
    instance->refused = 1;
    if (!(h > 0.0 && h < INFINITY))
        return discarded(instance, time, h, "expected a finite step above 0 s");
    if (!model_step(&instance->done, &instance->values, &instance->scratch, time + h, h, reason))
        return discarded(instance, time, h, reason);
    instance->refused = 0;
    instance->time = instance->done_time = time + h;
    warn_once(instance);
    return STATUS_OK;
}

/* --- Model exchange: every evaluation is a step from the last completed one */

/* The time since the last completed step. Times that sums of steps give differ from one to the next by their rounding:
 * what lies before the step by no more than that is at its end. */
static double since_done(const Instance *instance)
{
    const double h = instance->time - instance->done_time;
    return h < 0.0 && -h <= 1e-9 * fabs(instance->done_time) ? 0.0 : h;
}

static Status evaluated(Instance *instance)
{
    const double h = since_done(instance);
    char reason[TEXT];
    if (instance->co_simulation || !instance->stale)
        return STATUS_OK;
    if (!(h >= 0.0 && isfinite(h))) {
        instance_say(instance, STATUS_ERROR, "the time %g s lies before the last completed step, at %g s",
                     instance->time, instance->done_time);
        return STATUS_DISCARD;
    }
    instance->shown = instance->done;
    if (!model_evaluate(&instance->shown, &instance->values, &instance->scratch, instance->time, h, reason))
        return discarded(instance, instance->done_time, h, reason);
    instance->stale = 0;
    return STATUS_OK;
}

static Status instance_complete_step(Instance *instance)
{
    const Status status = evaluated(instance);
    if (status != STATUS_OK)
        return status;
    instance->done = instance->shown;
    instance->done_time = fmax(instance->done_time, instance->time);
    warn_once(instance);
    return STATUS_OK;
}

static Status instance_set_time(Instance *instance, double time)
{
    if (!isfinite(time)) {
        instance_say(instance, STATUS_ERROR, "the time is not a finite number");
        return STATUS_ERROR;
    }
    if (time != instance->time) {
        instance->time = time;
        instance->stale = 1;
    }
    return STATUS_OK;
}

static Status instance_set_states(Instance *instance, const double states[], size_t count)
{
    if (count != STATES || (count > 0 && !states))
        return instance_misses(instance, "a continuous state");
    model_set_states(&instance->done, states);
    instance->stale = 1;
    return STATUS_OK;
}

static Status instance_get_states(const Instance *instance, double states[], size_t count)
{
    if (count != STATES || (count > 0 && !states))
        return instance_misses(instance, "a continuous state");
    model_get_states(&instance->done, states);
    return STATUS_OK;
}

static Status instance_state_derivatives(Instance *instance, double derivatives[], size_t count)
{
    const Status status = evaluated(instance);
    if (count != STATES || (count > 0 && !derivatives))
        return instance_misses(instance, "a derivative of a continuous state");
    if (status == STATUS_OK)
        model_derivatives(&instance->shown, derivatives);
    return status;
}

static Status instance_nominals(const Instance *instance, double nominals[], size_t count)
{
    size_t i;
    if (count != STATES || (count > 0 && !nominals))
        return instance_misses(instance, "a nominal value of a continuous state");
    for (i = 0; i < count; i++)
        nominals[i] = STATE_NOMINALS[i];
    return STATUS_OK;
}

static Status instance_indicators(Instance *instance, double indicators[], size_t count)
{
    if (count != INDICATORS || (count > 0 && !indicators)) {
        instance_say(instance, STATUS_ERROR, "expected room for %d event indicators", INDICATORS);
        return STATUS_ERROR;
    }
    model_indicators(&instance->done, indicators);
    return STATUS_OK;
}

/* --- Saved states */

static Status instance_save(const Instance *instance, Saved **saved)
{
    Saved *state = *saved ? *saved : calloc(1, sizeof *state);
    if (!state)
        return STATUS_ERROR;
    state->mark = SAVED_MARK;
    state->structure = STRUCTURE;
    state->size = sizeof *state;
    state->done = instance->done;
    state->shown = instance->shown;
    state->time = instance->time;
    state->done_time = instance->done_time;
    state->stale = instance->stale;
    state->mode = (int32_t)instance->mode;
    state->co_simulation = instance->co_simulation;
    *saved = state;
    return STATUS_OK;
}

static int fits(const Instance *instance, const Saved *state)
{
    const int32_t mode = state->mode;
    return state->mark == SAVED_MARK && state->structure == STRUCTURE && state->size == sizeof *state
           && state->co_simulation == instance->co_simulation && mode > 0 && mode <= ANY_MODE && !(mode & (mode - 1));
}

static Status instance_restore(Instance *instance, const Saved *saved)
{
    if (!saved || !fits(instance, saved)) {
        instance_say(instance, STATUS_ERROR, "the state that was set is not one of %s", instance->name);
        return STATUS_ERROR;
    }
    instance->done = saved->done;
    instance->shown = saved->shown;
    instance->time = saved->time;
    instance->done_time = saved->done_time;
    instance->stale = saved->stale;
    instance->mode = (Mode)saved->mode;
    instance->refused = 0;
    return STATUS_OK;
}

static Status instance_deserialise(const Instance *instance, const unsigned char bytes[], size_t size, Saved **saved)
{
    Saved *state = size == sizeof *state && bytes ? malloc(sizeof *state) : NULL;
    if (state)
        memcpy(state, bytes, sizeof *state);
    if (!state || !fits(instance, state)) {
        free(state);
        instance_say(instance, STATUS_ERROR, "the bytes are not a state of %s", instance->name);
        return STATUS_ERROR;
    }
    saved_free(*saved);
    *saved = state;
    return STATUS_OK;
}

static void saved_free(Saved *saved)
{
    free(saved);
}

static size_t saved_size(void)
{
    return sizeof(Saved);
}

static void saved_serialise(const Saved *saved, unsigned char bytes[])
{
    memcpy(bytes, saved, sizeof *saved);
}
