/* FMI 2.0, co-simulation and model exchange, over `instance`: what 3.0 has not, or has otherwise. */
#include "fmi2.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi.c"

/* --- Messages */

/* The logger takes a format as of printf: percent signs are doubled. */
static void hand_over(fmi2CallbackLogger logger, void *environment, const char *name, Status status, const char *text)
{
    char format[2 * TEXT];
    size_t length = 0;
    for (; *text && length + 2 < sizeof format; text++) {
        if (*text == '%')
            format[length++] = '%';
        format[length++] = *text;
    }
    format[length] = '\0';
    if (logger)
        logger(environment, name ? name : "", (fmi2Status)status, LOG_CATEGORIES[status], format);
}

static void tell(const Instance *instance, Status status, const char *text)
{
    hand_over((fmi2CallbackLogger)instance->logger, instance->environment, instance->name, status, text);
}

/* --- Making and ending an instance */

FMU_API(const char *, fmi2GetTypesPlatform)(void)
{
    return "default";
}

FMU_API(const char *, fmi2GetVersion)(void)
{
    return "2.0";
}

FMU_API(fmi2Component, fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                        const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    char reason[TEXT] = "";
    char *folder = path_of(resources);
    Instance *instance = instance_new(name, guid, folder, type == fmi2CoSimulation, reason);
    (void)visible;
    free(folder);
    if (!instance) {
        if (functions)
            hand_over(functions->logger, functions->componentEnvironment, name, STATUS_ERROR, reason);
        return NULL;
    }
    instance->logging = logging ? ALL_STATUSES : 0;
    instance->tell = tell;
    if (functions) {
        instance->logger = (void (*)(void))functions->logger;
        instance->environment = functions->componentEnvironment;
    }
    return instance;
}

FMU_API(fmi2Status, fmi2SetupExperiment)(Handle handle, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                                         fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    REQUIRE(INSTANTIATED);
    (void)tolerance_defined;
    (void)tolerance;
    (void)stop_defined;
    (void)stop;
    return (fmi2Status)instance_set_time(instance, start);
}

FMU_API(fmi2Status, fmi2EnterInitializationMode)(Handle handle)
{
    REQUIRE(INSTANTIATED);
    return (fmi2Status)instance_begin(instance, instance->time);
}

/* --- Variables */

FMU_API(fmi2Status, fmi2GetReal)(Handle handle, const fmi2ValueReference references[], size_t count,
                                 fmi2Real values[])
{
    REQUIRE(READABLE);
    return (fmi2Status)instance_get_reals(instance, references, count, values);
}

FMU_API(fmi2Status, fmi2SetReal)(Handle handle, const fmi2ValueReference references[], size_t count,
                                 const fmi2Real values[])
{
    REQUIRE(SETTABLE);
    return (fmi2Status)instance_set_reals(instance, references, count, values);
}

FMU_API(fmi2Status, fmi2GetBoolean)(Handle handle, const fmi2ValueReference references[], size_t count,
                                    fmi2Boolean values[])
{
    REQUIRE(READABLE);
    return (fmi2Status)get_flags(instance, references, count, values);
}

FMU_API(fmi2Status, fmi2SetBoolean)(Handle handle, const fmi2ValueReference references[], size_t count,
                                    const fmi2Boolean values[])
{
    REQUIRE(SETTABLE);
    return (fmi2Status)set_flags(instance, references, count, values);
}

#define NONE_OF_TYPE(function, value, modes)                                                                           \
    FMU_API(fmi2Status, function)(Handle handle, const fmi2ValueReference references[], size_t count,        \
                                  value values[])                                                                      \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)values;                                                                                                  \
        return (fmi2Status)instance_none(handle, (modes), __func__, count);                                         \
    }

NONE_OF_TYPE(fmi2GetInteger, fmi2Integer, READABLE)
NONE_OF_TYPE(fmi2GetString, fmi2String, READABLE)
NONE_OF_TYPE(fmi2SetInteger, const fmi2Integer, SETTABLE)
NONE_OF_TYPE(fmi2SetString, const fmi2String, SETTABLE)

FMU_API(fmi2Status, fmi2GetDirectionalDerivative)(Handle handle, const fmi2ValueReference unknowns[],
                                                  size_t unknown_count, const fmi2ValueReference knowns[],
                                                  size_t known_count, const fmi2Real seed[], fmi2Real product[])
{
    REQUIRE(READABLE);
    if ((unknown_count > 0 && (!unknowns || !product)) || (known_count > 0 && (!knowns || !seed)))
        return (fmi2Status)instance_misses(instance, "an array of value references or values");
    return (fmi2Status)instance_derivatives(instance, unknowns, unknown_count, knowns, known_count, 0, seed, product);
}

/* --- Saved states */

FMU_API(fmi2Status, fmi2GetFMUstate)(Handle handle, fmi2FMUstate *state)
{
    return get_state(handle, __func__, state);
}

FMU_API(fmi2Status, fmi2SetFMUstate)(Handle handle, fmi2FMUstate state)
{
    return set_state(handle, __func__, state);
}

FMU_API(fmi2Status, fmi2FreeFMUstate)(Handle handle, fmi2FMUstate *state)
{
    return free_state(handle, __func__, state);
}

FMU_API(fmi2Status, fmi2SerializedFMUstateSize)(Handle handle, fmi2FMUstate state, size_t *size)
{
    return size_of_state(handle, __func__, state, size);
}

FMU_API(fmi2Status, fmi2SerializeFMUstate)(Handle handle, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    return serialise_state(handle, __func__, state, bytes, size);
}

FMU_API(fmi2Status, fmi2DeSerializeFMUstate)(Handle handle, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    return deserialise_state(handle, __func__, bytes, size, state);
}

/* --- Co-simulation */

FMU_API(fmi2Status, fmi2DoStep)(Handle handle, fmi2Real time, fmi2Real h, fmi2Boolean no_return)
{
    REQUIRE(STEPPING);
    (void)no_return;
    return (fmi2Status)instance_do_step(instance, time, h);
}

/* A step is done when fmi2DoStep returns: nothing can be cancelled, and inputs and outputs have no derivatives. */
FMU_API(fmi2Status, fmi2CancelStep)(Handle handle)
{
    return (fmi2Status)instance_lacks(handle, __func__);
}

FMU_API(fmi2Status, fmi2SetRealInputDerivatives)(Handle handle, const fmi2ValueReference references[],
                                                 size_t count, const fmi2Integer order[], const fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)order;
    (void)values;
    return (fmi2Status)instance_lacks(handle, __func__);
}

FMU_API(fmi2Status, fmi2GetRealOutputDerivatives)(Handle handle, const fmi2ValueReference references[],
                                                  size_t count, const fmi2Integer order[], fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)order;
    (void)values;
    return (fmi2Status)instance_lacks(handle, __func__);
}

/* Steps are never pending: only the last successful time, and whether the run should end, have an answer. */
FMU_API(fmi2Status, fmi2GetRealStatus)(Handle handle, const fmi2StatusKind kind, fmi2Real *value)
{
    REQUIRE(STEPPING | TERMINATED);
    if (kind != fmi2LastSuccessfulTime || !value)
        return fmi2Discard;
    *value = instance->done_time;
    return fmi2OK;
}

FMU_API(fmi2Status, fmi2GetBooleanStatus)(Handle handle, const fmi2StatusKind kind, fmi2Boolean *value)
{
    REQUIRE(STEPPING | TERMINATED);
    if (kind != fmi2Terminated || !value)
        return fmi2Discard;
    *value = instance->refused;
    return fmi2OK;
}

#define NEVER_PENDING(function, type)                                                                                  \
    FMU_API(fmi2Status, function)(Handle handle, const fmi2StatusKind kind, type *value)                     \
    {                                                                                                                  \
        REQUIRE(STEPPING | TERMINATED);                                                                                \
        (void)kind;                                                                                                    \
        (void)value;                                                                                                   \
        return fmi2Discard;                                                                                            \
    }

NEVER_PENDING(fmi2GetStatus, fmi2Status)
NEVER_PENDING(fmi2GetIntegerStatus, fmi2Integer)
NEVER_PENDING(fmi2GetStringStatus, fmi2String)

/* --- Model exchange */

FMU_API(fmi2Status, fmi2NewDiscreteStates)(Handle handle, fmi2EventInfo *info)
{
    REQUIRE(EVENT);
    if (!info)
        return (fmi2Status)instance_misses(instance, "the event's information");
    memset(info, 0, sizeof *info);
    return fmi2OK;
}

FMU_API(fmi2Status, fmi2GetDerivatives)(Handle handle, fmi2Real derivatives[], size_t count)
{
    REQUIRE(EVALUATED);
    return (fmi2Status)instance_state_derivatives(instance, derivatives, count);
}
