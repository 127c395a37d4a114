/* Setting and getting an instance's variables, and their derivatives. */
#include "instance.h"

/* Value references count variables from 1; places count them from 0, and what is no reference has a place beyond all. */
static unsigned place_of(unsigned reference)
{
    return reference - 1u;
}

RARE static int refused(const Instance *instance, const char *name, unsigned place)
{
    if (name)
        instance_say(instance, STATUS_ERROR, "%s is no input or parameter of this type; the value is ignored", name);
    else
        instance_say(instance, STATUS_ERROR,
                     "value reference %u is no input or parameter of this type; the value is ignored", place + 1u);
    return 0;
}

static int is_state(unsigned place)
{
    return place >= FIRST_LOCAL && place < FIRST_LOCAL + STATES;
}

/* Tell whether a variable may be set now, and complain where it may not. States have a function of their own, but some
 * importers (CasADi) set them as variables. */
static int settable(const Instance *instance, unsigned place)
{
    if (place < FIRST_OUTPUT || (is_state(place) && instance->mode & (EVENT | CONTINUOUS)))
        return 1;
    if (place < FIRST_FIXED || place >= REALS)
        return refused(instance, place < REALS ? REAL_NAMES[place] : NULL, place);
    if (instance->mode & (INSTANTIATED | INITIALIZATION))
        return 1;
    instance_say(instance, STATUS_ERROR, "%s is fixed after initialization; the value is ignored", REAL_NAMES[place]);
    return 0;
}

/* Set variables of which some unsettle the model, or none where one of them may not be set. */
APART static Status set_others(Instance *instance, const unsigned references[], size_t count, const double values[])
{
    Model *model = &instance->done;
    size_t i;
    for (i = 0; i < count; i++)
        if (!settable(instance, place_of(references[i])))
            return STATUS_ERROR;
    for (i = 0; i < count; i++) {
        const unsigned place = place_of(references[i]);
        if (is_state(place)) {
            model_get_states(model, model->real + FIRST_LOCAL);
            model->real[place] = values[i];
            model_set_states(model, model->real + FIRST_LOCAL);
            instance->stale = 1;
        } else if (model->real[place] != values[i]) {
            model->real[place] = values[i];
            model->settled = model->settled && place < SIGNALS;
            instance->stale = 1;
        }
    }
    return STATUS_OK;
}

static Status instance_set_reals(Instance *instance, const unsigned references[], size_t count, const double values[])
{
    size_t i;
    if (count > 0 && (!references || !values))
        return instance_misses(instance, "an array of value references or values");
    for (i = 0; i < count; i++)
        if (place_of(references[i]) >= SIGNALS)
            return set_others(instance, references, count, values);
    for (i = 0; i < count; i++) {
        double *const signal = &instance->done.real[place_of(references[i])];
        if (*signal != values[i]) {
            *signal = values[i];
            instance->stale = 1;
        }
    }
    return STATUS_OK;
}

static int instance_may_set_flag(const Instance *instance, unsigned reference)
{
    const unsigned place = place_of(reference), flag = place - REALS;
    if (place >= REALS && flag < FLAG_PARAMETERS)
        return 1;
    return refused(instance, place < REALS ? REAL_NAMES[place] : flag < FLAGS ? FLAG_NAMES[flag] : NULL, place);
}

static void instance_set_flag(Instance *instance, unsigned reference, int value)
{
    instance->done.flag[place_of(reference) - REALS] = value != 0;
    instance->done.settled = 0;
    instance->stale = 1;
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
        const unsigned place = place_of(references[i]);
        if (place < FIRST_OUTPUT || (place >= FIRST_FIXED && place < REALS)) {
            values[i] = instance->done.real[place];
        } else if (place < REALS) {
            if (!shown)
                shown = showing(instance, &status);
            values[i] = shown->real[place];
        } else if (FMI_VERSION == 3 && place == TIME) {
            values[i] = instance->time;
        } else {
            status = expected(instance, references[i], "a real variable, from 1 to", REALS);
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
        const unsigned place = place_of(references[i]);
        if (instance->mode != STEPPING || place >= REALS)
            return get_evaluated(instance, references, count, values);
        values[i] = instance->done.real[place];
    }
    return STATUS_OK;
}

static Status instance_get_flag(Instance *instance, unsigned reference, int *value)
{
    Status status = STATUS_OK;
    const Model *model = &instance->done;
    const unsigned place = place_of(reference);
    if (place < REALS || place >= REALS + FLAGS)
        return expected(instance, reference, "a Boolean variable, from", REALS + 1);
    if (place >= REALS + FLAG_PARAMETERS)
        model = showing(instance, &status);
    *value = model->flag[place - REALS];
    return status;
}

/* Where a variable stands among what has derivatives, or among what they are taken by; -1 for nowhere. */
static int row_of(const Instance *instance, unsigned reference)
{
    const unsigned place = place_of(reference);
    if (place >= FIRST_OUTPUT && place < FIRST_LOCAL)
        return (int)place - FIRST_OUTPUT;
    if (!instance->co_simulation && place >= FIRST_LOCAL + STATES && place < FIRST_LOCAL + 2 * STATES)
        return (int)place - FIRST_LOCAL - STATES + OUTPUTS;
    return -1;
}

static int column_of(const Instance *instance, unsigned reference)
{
    const unsigned place = place_of(reference);
    if (place < FIRST_OUTPUT)
        return (int)place;
    if (!instance->co_simulation && is_state(place))
        return (int)place - FIRST_LOCAL + FIRST_OUTPUT;
    return -1;
}

static Status instance_derivatives(Instance *instance, const unsigned unknowns[], size_t unknown_count,
                                   const unsigned knowns[], size_t known_count, int transposed, const double seed[],
                                   double product[])
{
    double direction[ROOM(COLUMNS)] = {0}, slopes[ROOM(ROWS)];
    Status status = STATUS_OK;
    const Model *model;
    size_t row, column;
    if (!EXCHANGE_SLOPES && !instance->co_simulation)
        return instance_lacks(instance, "the derivatives' function");
    model = showing(instance, &status);
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
