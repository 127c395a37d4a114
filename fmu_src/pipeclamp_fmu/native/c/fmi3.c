/* FMI 3.0, co-simulation and model exchange, over `instance`: what 2.0 has not, or has otherwise. */
#include "fmi3.h"

#include "fmi.c"

static void tell(const Instance *instance, Status status, const char *text)
{
    const fmi3LogMessageCallback logger = (fmi3LogMessageCallback)instance->logger;
    if (logger)
        logger(instance->environment, (fmi3Status)status, LOG_CATEGORIES[status], text);
}

/* --- Making and ending an instance */

FMU_API(const char *, fmi3GetVersion)(void)
{
    return "3.0";
}

static fmi3Instance instantiated(fmi3String name, fmi3String token, fmi3String folder, int co_simulation, int logging,
                                 fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger)
{
    char reason[TEXT] = "";
    char *path = path_of(folder);
    Instance *instance = instance_new(name, token, path, co_simulation, reason);
    free(path);
    if (!instance) {
        if (logger)
            logger(environment, fmi3Error, LOG_CATEGORIES[STATUS_ERROR], reason);
        return NULL;
    }
    instance->logging = logging ? ALL_STATUSES : 0;
    instance->tell = tell;
    instance->logger = (void (*)(void))logger;
    instance->environment = environment;
    return instance;
}

FMU_API(fmi3Instance, fmi3InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String folder,
                                                    fmi3Boolean visible, fmi3Boolean logging,
                                                    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger)
{
    (void)visible;
    return instantiated(name, token, folder, 0, logging, environment, logger);
}

FMU_API(fmi3Instance, fmi3InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String folder,
                                                   fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean event_mode,
                                                   fmi3Boolean early_return, const fmi3ValueReference intermediate[],
                                                   size_t intermediate_count, fmi3InstanceEnvironment environment,
                                                   fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback update)
{
    (void)visible;
    (void)early_return;
    (void)intermediate;
    (void)intermediate_count;
    (void)update;
    if (event_mode) {
        if (logger)
            logger(environment, fmi3Error, LOG_CATEGORIES[STATUS_ERROR], "co-simulation has no event mode here");
        return NULL;
    }
    return instantiated(name, token, folder, 1, logging, environment, logger);
}

FMU_API(fmi3Instance, fmi3InstantiateScheduledExecution)(fmi3String name, fmi3String token, fmi3String folder,
                                                         fmi3Boolean visible, fmi3Boolean logging,
                                                         fmi3InstanceEnvironment environment,
                                                         fmi3LogMessageCallback logger, fmi3ClockUpdateCallback update,
                                                         fmi3LockPreemptionCallback lock,
                                                         fmi3UnlockPreemptionCallback unlock)
{
    (void)name;
    (void)token;
    (void)folder;
    (void)visible;
    (void)logging;
    (void)update;
    (void)lock;
    (void)unlock;
    if (logger)
        logger(environment, fmi3Error, LOG_CATEGORIES[STATUS_ERROR], "there is no scheduled execution");
    return NULL;
}

FMU_API(fmi3Status, fmi3EnterInitializationMode)(Handle handle, fmi3Boolean tolerance_defined,
                                                 fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean stop_defined,
                                                 fmi3Float64 stop)
{
    Status status;
    REQUIRE(INSTANTIATED);
    (void)tolerance_defined;
    (void)tolerance;
    (void)stop_defined;
    (void)stop;
    status = instance_set_time(instance, start);
    return (fmi3Status)(status == STATUS_OK ? instance_begin(instance, start) : status);
}

/* --- Variables */

FMU_API(fmi3Status, fmi3GetFloat64)(Handle handle, const fmi3ValueReference references[], size_t count,
                                    fmi3Float64 values[], size_t value_count)
{
    REQUIRE(READABLE);
    if (count != value_count)
        return (fmi3Status)instance_misses(instance, "a value reference or a value");
    return (fmi3Status)instance_get_reals(instance, references, count, values);
}

FMU_API(fmi3Status, fmi3SetFloat64)(Handle handle, const fmi3ValueReference references[], size_t count,
                                    const fmi3Float64 values[], size_t value_count)
{
    REQUIRE(SETTABLE);
    if (count != value_count)
        return (fmi3Status)instance_misses(instance, "a value reference or a value");
    return (fmi3Status)instance_set_reals(instance, references, count, values);
}

FMU_API(fmi3Status, fmi3GetBoolean)(Handle handle, const fmi3ValueReference references[], size_t count,
                                    fmi3Boolean values[], size_t value_count)
{
    REQUIRE(READABLE);
    if (count != value_count)
        return (fmi3Status)instance_misses(instance, "a value reference or a value");
    return (fmi3Status)get_flags(instance, references, count, values);
}

FMU_API(fmi3Status, fmi3SetBoolean)(Handle handle, const fmi3ValueReference references[], size_t count,
                                    const fmi3Boolean values[], size_t value_count)
{
    REQUIRE(SETTABLE);
    if (count != value_count)
        return (fmi3Status)instance_misses(instance, "a value reference or a value");
    return (fmi3Status)set_flags(instance, references, count, values);
}

/* There are no variables of the other types. */
#define NONE_OF_TYPE(name, type)                                                                                       \
    FMU_API(fmi3Status, fmi3Get##name)(Handle handle, const fmi3ValueReference references[], size_t count,       \
                                       type values[], size_t value_count)                                              \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)values;                                                                                                  \
        (void)value_count;                                                                                             \
        return (fmi3Status)instance_none(handle, READABLE, __func__, count);                                           \
    }                                                                                                                  \
    FMU_API(fmi3Status, fmi3Set##name)(Handle handle, const fmi3ValueReference references[], size_t count,       \
                                       const type values[], size_t value_count)                                        \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)values;                                                                                                  \
        (void)value_count;                                                                                             \
        return (fmi3Status)instance_none(handle, SETTABLE, __func__, count);                                           \
    }

NONE_OF_TYPE(Float32, fmi3Float32)
NONE_OF_TYPE(Int8, int8_t)
NONE_OF_TYPE(UInt8, uint8_t)
NONE_OF_TYPE(Int16, int16_t)
NONE_OF_TYPE(UInt16, uint16_t)
NONE_OF_TYPE(Int32, int32_t)
NONE_OF_TYPE(UInt32, uint32_t)
NONE_OF_TYPE(Int64, int64_t)
NONE_OF_TYPE(UInt64, uint64_t)
NONE_OF_TYPE(String, fmi3String)

FMU_API(fmi3Status, fmi3GetBinary)(Handle handle, const fmi3ValueReference references[], size_t count,
                                   size_t sizes[], fmi3Binary values[], size_t value_count)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)value_count;
    return (fmi3Status)instance_none(handle, READABLE, __func__, count);
}

FMU_API(fmi3Status, fmi3SetBinary)(Handle handle, const fmi3ValueReference references[], size_t count,
                                   const size_t sizes[], const fmi3Binary values[], size_t value_count)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)value_count;
    return (fmi3Status)instance_none(handle, SETTABLE, __func__, count);
}

/* --- Derivatives */

static fmi3Status derivatives(Handle handle, const char *function, const fmi3ValueReference unknowns[],
                              size_t unknown_count, const fmi3ValueReference knowns[], size_t known_count,
                              int transposed, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 product[],
                              size_t product_count)
{
    Instance *instance = handle;
    if (!instance_may(instance, READABLE, function))
        return fmi3Error;
    if ((unknown_count > 0 && !unknowns) || (known_count > 0 && !knowns) || (seed_count > 0 && !seed)
        || (product_count > 0 && !product) || seed_count != (transposed ? unknown_count : known_count)
        || product_count != (transposed ? known_count : unknown_count))
        return (fmi3Status)instance_misses(instance, "a value reference or a value");
    return (fmi3Status)instance_derivatives(instance, unknowns, unknown_count, knowns, known_count, transposed, seed,
                                            product);
}

#define DERIVATIVE(function, transposed)                                                                               \
    FMU_API(fmi3Status, function)(Handle handle, const fmi3ValueReference unknowns[], size_t unknown_count,            \
                                  const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[],     \
                                  size_t seed_count, fmi3Float64 product[], size_t product_count)                      \
    {                                                                                                                  \
        return derivatives(handle, __func__, unknowns, unknown_count, knowns, known_count, (transposed), seed,         \
                           seed_count, product, product_count);                                                        \
    }

DERIVATIVE(fmi3GetDirectionalDerivative, 0)
DERIVATIVE(fmi3GetAdjointDerivative, 1)

/* --- Saved states */

FMU_API(fmi3Status, fmi3GetFMUState)(Handle handle, fmi3FMUState *state)
{
    return get_state(handle, __func__, state);
}

FMU_API(fmi3Status, fmi3SetFMUState)(Handle handle, fmi3FMUState state)
{
    return set_state(handle, __func__, state);
}

FMU_API(fmi3Status, fmi3FreeFMUState)(Handle handle, fmi3FMUState *state)
{
    return free_state(handle, __func__, state);
}

FMU_API(fmi3Status, fmi3SerializedFMUStateSize)(Handle handle, fmi3FMUState state, size_t *size)
{
    return size_of_state(handle, __func__, state, size);
}

FMU_API(fmi3Status, fmi3SerializeFMUState)(Handle handle, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    return serialise_state(handle, __func__, state, bytes, size);
}

FMU_API(fmi3Status, fmi3DeserializeFMUState)(Handle handle, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    return deserialise_state(handle, __func__, bytes, size, state);
}

/* --- Co-simulation */

FMU_API(fmi3Status, fmi3DoStep)(Handle handle, fmi3Float64 time, fmi3Float64 h, fmi3Boolean no_earlier_state,
                                fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                                fmi3Float64 *last_time)
{
    Status status;
    REQUIRE(STEPPING);
    (void)no_earlier_state;
    status = instance_do_step(instance, time, h);
    if (event_needed)
        *event_needed = false;
    if (terminate)
        *terminate = instance->refused;
    if (early_return)
        *early_return = false;
    if (last_time)
        *last_time = instance->done_time;
    return (fmi3Status)status;
}

/* --- Model exchange */

FMU_API(fmi3Status, fmi3EvaluateDiscreteStates)(Handle handle)
{
    REQUIRE(INITIALIZATION | EVENT);
    return fmi3OK;
}

FMU_API(fmi3Status, fmi3UpdateDiscreteStates)(Handle handle, fmi3Boolean *needed, fmi3Boolean *terminate,
                                              fmi3Boolean *nominals_changed, fmi3Boolean *values_changed,
                                              fmi3Boolean *next_event_defined, fmi3Float64 *next_event)
{
    fmi3Boolean *const answers[] = {needed, terminate, nominals_changed, values_changed, next_event_defined};
    size_t i;
    REQUIRE(EVENT);
    for (i = 0; i < sizeof answers / sizeof answers[0]; i++)
        if (answers[i])
            *answers[i] = false;
    if (next_event)
        *next_event = 0.0;
    return fmi3OK;
}

static fmi3Status count_of(Handle handle, const char *function, size_t is, size_t *count)
{
    const Instance *instance = handle;
    if (!instance_may(instance, ANY_MODE, function))
        return fmi3Error;
    if (!count)
        return (fmi3Status)instance_misses(instance, "the number's place");
    *count = is;
    return fmi3OK;
}

FMU_API(fmi3Status, fmi3GetNumberOfEventIndicators)(Handle handle, size_t *count)
{
    return count_of(handle, __func__, INDICATORS, count);
}

FMU_API(fmi3Status, fmi3GetNumberOfContinuousStates)(Handle handle, size_t *count)
{
    return count_of(handle, __func__, STATES, count);
}

FMU_API(fmi3Status, fmi3GetContinuousStateDerivatives)(Handle handle, fmi3Float64 derivatives[], size_t count)
{
    REQUIRE(EVALUATED);
    return (fmi3Status)instance_state_derivatives(instance, derivatives, count);
}

/* --- What this FMU doesn't have: clocks, arrays of varying size, derivatives in time, an event mode in co-simulation */

#define LACKING(function, ...)                                                                                         \
    FMU_API(fmi3Status, function)(Handle handle __VA_ARGS__)                                                     \
    {                                                                                                                  \
        return (fmi3Status)instance_lacks(handle, __func__);                                                           \
    }

#ifdef __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

LACKING(fmi3EnterConfigurationMode, )
LACKING(fmi3ExitConfigurationMode, )
LACKING(fmi3EnterStepMode, )
LACKING(fmi3GetNumberOfVariableDependencies, , fmi3ValueReference reference, size_t *count)
LACKING(fmi3GetVariableDependencies, , fmi3ValueReference dependent, size_t elements[],
        fmi3ValueReference independents[], size_t independent_elements[], fmi3DependencyKind kinds[], size_t count)
LACKING(fmi3GetOutputDerivatives, , const fmi3ValueReference references[], size_t count, const int32_t orders[],
        fmi3Float64 values[], size_t value_count)
LACKING(fmi3GetClock, , const fmi3ValueReference references[], size_t count, fmi3Clock values[])
LACKING(fmi3SetClock, , const fmi3ValueReference references[], size_t count, const fmi3Clock values[])
LACKING(fmi3GetIntervalDecimal, , const fmi3ValueReference references[], size_t count, fmi3Float64 intervals[],
        fmi3IntervalQualifier qualifiers[])
LACKING(fmi3GetIntervalFraction, , const fmi3ValueReference references[], size_t count, uint64_t counters[],
        uint64_t resolutions[], fmi3IntervalQualifier qualifiers[])
LACKING(fmi3GetShiftDecimal, , const fmi3ValueReference references[], size_t count, fmi3Float64 shifts[])
LACKING(fmi3GetShiftFraction, , const fmi3ValueReference references[], size_t count, uint64_t counters[],
        uint64_t resolutions[])
LACKING(fmi3SetIntervalDecimal, , const fmi3ValueReference references[], size_t count, const fmi3Float64 intervals[])
LACKING(fmi3SetIntervalFraction, , const fmi3ValueReference references[], size_t count, const uint64_t counters[],
        const uint64_t resolutions[])
LACKING(fmi3SetShiftDecimal, , const fmi3ValueReference references[], size_t count, const fmi3Float64 shifts[])
LACKING(fmi3SetShiftFraction, , const fmi3ValueReference references[], size_t count, const uint64_t counters[],
        const uint64_t resolutions[])
LACKING(fmi3ActivateModelPartition, , fmi3ValueReference clock, fmi3Float64 time)

#ifdef __GNUC__
#pragma GCC diagnostic pop
#endif
