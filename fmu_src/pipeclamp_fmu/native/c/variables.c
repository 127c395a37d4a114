/* Setting and getting an instance's variables, and their derivatives. */
#include "instance.h"

RARE static int refused(const Instance *instance, const char *name, unsigned reference)
{
    if (name)
        instance_say(instance, STATUS_ERROR, "%s is no input or parameter of this type; the value is ignored", name);
    else
        instance_say(instance, STATUS_ERROR,
                     "value reference %u is no input or parameter of this type; the value is ignored", reference);
    return 0;
}

static int is_state(unsigned reference)
{
    return reference >= FIRST_LOCAL && reference < FIRST_LOCAL + STATES;
}

/* Tell whether a variable may be set now, and complain where it may not. States have a function of their own, but some
 * importers (CasADi) set them as variables. */
static int settable(const Instance *instance, unsigned reference)
{
    if (reference < FIRST_OUTPUT || (is_state(reference) && instance->mode & (EVENT | CONTINUOUS)))
        return 1;
    if (reference < FIRST_FIXED || reference >= REALS)
        return refused(instance, reference < REALS ? REAL_NAMES[reference] : NULL, reference);
    if (instance->mode & (INSTANTIATED | INITIALIZATION))
        return 1;
    instance_say(instance, STATUS_ERROR, "%s is fixed after initialization; the value is ignored",
                 REAL_NAMES[reference]);
    return 0;
}

/* Set variables of which some unsettle the model, or may not be set. */
APART static Status set_others(Instance *instance, const unsigned references[], size_t count, const double values[])
{
    Model *model = &instance->done;
    Status status = STATUS_OK;
    size_t i;
    for (i = 0; i < count; i++) {
        const unsigned reference = references[i];
        if (!settable(instance, reference)) {
            status = STATUS_ERROR;
        } else if (is_state(reference)) {
            model_get_states(model, model->real + FIRST_LOCAL);
            model->real[reference] = values[i];
            model_set_states(model, model->real + FIRST_LOCAL);
            instance->stale = 1;
        } else if (model->real[reference] != values[i]) {
            model->real[reference] = values[i];
            model->settled = model->settled && reference < SIGNALS;
            instance->stale = 1;
        }
    }
    return status;
}

static Status instance_set_reals(Instance *instance, const unsigned references[], size_t count, const double values[])
{
    size_t i;
    if (count > 0 && (!references || !values))
        return instance_misses(instance, "an array of value references or values");
    for (i = 0; i < count; i++) {
        if (references[i] >= SIGNALS)
            return set_others(instance, references + i, count - i, values + i);
        if (instance->done.real[references[i]] != values[i]) {
            instance->done.real[references[i]] = values[i];
            instance->stale = 1;
        }
    }
    return STATUS_OK;
}

static Status instance_set_flag(Instance *instance, unsigned reference, int value)
{
    if (reference < REALS || reference >= REALS + FLAG_PARAMETERS) {
        const unsigned flag = reference - REALS;
        refused(instance, reference < REALS ? REAL_NAMES[reference] : flag < FLAGS ? FLAG_NAMES[flag] : NULL, reference);
        return STATUS_ERROR;
    }
    instance->done.flag[reference - REALS] = value != 0;
    instance->done.settled = 0;
    instance->stale = 1;
    return STATUS_OK;
}

/* Bring results up to date and give the model that shows them. */
APART static const Model *showing(Instance *instance, Status *status)
{
    if (instance->mode == INITIALIZATION)
        started(instance);
    if (instance->co_simulation || !(instance->mode & (EVENT | CONTINUOUS)))
        return &instance->done;
    *status = worse(*status, evaluated(instance));
    return &instance->shown;
}

RARE static Status expected(const Instance *instance, unsigned reference, const char *what, int place)
{
    instance_say(instance, STATUS_ERROR, "value reference %u: expected %s %d", reference, what, place);
    return STATUS_ERROR;
}

/* Get variables of which some may have to be evaluated. */
APART static Status get_evaluated(Instance *instance, const unsigned references[], size_t count, double values[])
{
    const Model *shown = NULL;
    Status status = STATUS_OK;
    size_t i;
    for (i = 0; i < count; i++) {
        const unsigned reference = references[i];
        if (reference < FIRST_OUTPUT || (reference >= FIRST_FIXED && reference < REALS)) {
            values[i] = instance->done.real[reference];
        } else if (reference < REALS) {
            if (!shown)
                shown = showing(instance, &status);
            values[i] = shown->real[reference];
        } else if (FMI_VERSION == 3 && reference == TIME) {
            values[i] = instance->time;
        } else {
            status = expected(instance, reference, "a real variable, below", REALS);
        }
    }
    return status;
}

static Status instance_get_reals(Instance *instance, const unsigned references[], size_t count, double values[])
{
    size_t i;
    if (count > 0 && (!references || !values))
        return instance_misses(instance, "an array of value references or values");
    for (i = 0; i < count; i++) {
        if (instance->mode != STEPPING || references[i] >= REALS)
            return get_evaluated(instance, references, count, values);
        values[i] = instance->done.real[references[i]];
    }
    return STATUS_OK;
}

static Status instance_get_flag(Instance *instance, unsigned reference, int *value)
{
    Status status = STATUS_OK;
    const Model *model = &instance->done;
    if (reference < REALS || reference >= REALS + FLAGS)
        return expected(instance, reference, "a Boolean variable, from", REALS);
    if (reference >= REALS + FLAG_PARAMETERS)
        model = showing(instance, &status);
    *value = model->flag[reference - REALS];
    return status;
}

/* The place of a variable among what has derivatives, or among what they are taken by; -1 for none. */
static int row_of(const Instance *instance, unsigned reference)
{
    if (reference >= FIRST_OUTPUT && reference < FIRST_LOCAL)
        return (int)reference - FIRST_OUTPUT;
    if (!instance->co_simulation && reference >= FIRST_LOCAL + STATES && reference < FIRST_LOCAL + 2 * STATES)
        return (int)reference - FIRST_LOCAL - STATES + OUTPUTS;
    return -1;
}

static int column_of(const Instance *instance, unsigned reference)
{
    if (reference < FIRST_OUTPUT)
        return (int)reference;
    if (!instance->co_simulation && is_state(reference))
        return (int)reference - FIRST_LOCAL + FIRST_OUTPUT;
    return -1;
}

static Status instance_derivatives(Instance *instance, const unsigned unknowns[], size_t unknown_count,
                                   const unsigned knowns[], size_t known_count, int transposed, const double seed[],
                                   double product[])
{
    double direction[ROOM(COLUMNS)] = {0}, slopes[ROOM(ROWS)];
    Status status = STATUS_OK;
    const Model *model = showing(instance, &status);
    size_t row, column;
    if (status != STATUS_OK)
        return status;
    for (row = 0; row < unknown_count; row++)
        if (row_of(instance, unknowns[row]) < 0) {
            instance_say(instance, STATUS_ERROR, "value reference %u: expected a real output or a state's derivative",
                         unknowns[row]);
            return STATUS_ERROR;
        }
    for (column = 0; column < known_count; column++)
        if (column_of(instance, knowns[column]) < 0) {
            instance_say(instance, STATUS_ERROR,
                         "value reference %u: expected a real input, a tunable parameter or a state", knowns[column]);
            return STATUS_ERROR;
        }
    if (!transposed) {
        for (column = 0; column < known_count; column++)
            direction[column_of(instance, knowns[column])] += seed[column];
        model_slopes(model, &instance->values, &instance->scratch, instance->co_simulation, direction, slopes);
        for (row = 0; row < unknown_count; row++)
            product[row] = slopes[row_of(instance, unknowns[row])];
        return STATUS_OK;
    }
    for (column = 0; column < known_count; column++) {
        double *const along = &direction[column_of(instance, knowns[column])];
        *along = 1.0;
        model_slopes(model, &instance->values, &instance->scratch, instance->co_simulation, direction, slopes);
        *along = 0.0;
        product[column] = 0.0;
        for (row = 0; row < unknown_count; row++)
            product[column] += seed[row] * slopes[row_of(instance, unknowns[row])];
    }
    return STATUS_OK;
}
