/* FMI 3.0, co-simulation and model exchange, over `instance`. */
#include "fmi3.h"

#include "instance.h"

enum { RUNNING = STEPPING | EVENT | CONTINUOUS, SETTABLE = INSTANTIATED | INITIALIZATION | RUNNING,
       READABLE = INITIALIZATION | RUNNING | TERMINATED };

#define REQUIRE(modes)                                                                                                 \
    Instance *instance = handle;                                                                                       \
    if (!instance_may(instance, (modes), __func__))                                                                    \
    return fmi3Error

static void tell(const Instance *instance, Status status, const char *text)
{
    const fmi3LogMessageCallback logger = (fmi3LogMessageCallback)instance->logger;
    if (logger)
        logger(instance->environment, (fmi3Status)status, LOG_CATEGORIES[status], text);
}

FMU_API(fmi3Status, fmi3SetDebugLogging)(fmi3Instance handle, fmi3Boolean on, size_t count, const fmi3String names[])
{
    REQUIRE(ANY_MODE);
    (void)count;
    (void)names;
    instance->logging = on;
    return fmi3OK;
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
    Instance *instance = instance_new(name, token, folder, co_simulation, reason);
    if (!instance) {
        if (logger)
            logger(environment, fmi3Error, LOG_CATEGORIES[STATUS_ERROR], reason);
        return NULL;
    }
    instance->logging = logging;
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

FMU_API(void, fmi3FreeInstance)(fmi3Instance handle)
{
    instance_free(handle);
}

FMU_API(fmi3Status, fmi3EnterInitializationMode)(fmi3Instance handle, fmi3Boolean tolerance_defined,
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

FMU_API(fmi3Status, fmi3ExitInitializationMode)(fmi3Instance handle)
{
    REQUIRE(INITIALIZATION);
    return (fmi3Status)instance_initialised(instance);
}

FMU_API(fmi3Status, fmi3Terminate)(fmi3Instance handle)
{
    REQUIRE(RUNNING);
    instance->mode = TERMINATED;
    return fmi3OK;
}

FMU_API(fmi3Status, fmi3Reset)(fmi3Instance handle)
{
    REQUIRE(ANY_MODE);
    instance_reset(instance);
    return fmi3OK;
}

/* --- Variables */

FMU_API(fmi3Status, fmi3GetFloat64)(fmi3Instance handle, const fmi3ValueReference references[], size_t count,
                                    fmi3Float64 values[], size_t value_count)
{
    REQUIRE(READABLE);
    if (count != value_count)
        return (fmi3Status)instance_misses(instance, "a value reference or a value");
    return (fmi3Status)instance_get_reals(instance, references, count, values);
}

FMU_API(fmi3Status, fmi3SetFloat64)(fmi3Instance handle, const fmi3ValueReference references[], size_t count,
                                    const fmi3Float64 values[], size_t value_count)
{
    REQUIRE(SETTABLE);
    if (count != value_count)
        return (fmi3Status)instance_misses(instance, "a value reference or a value");
    return (fmi3Status)instance_set_reals(instance, references, count, values);
}

FMU_API(fmi3Status, fmi3GetBoolean)(fmi3Instance handle, const fmi3ValueReference references[], size_t count,
                                    fmi3Boolean values[], size_t value_count)
{
    Status status = STATUS_OK;
    size_t i;
    int value = 0;
    REQUIRE(READABLE);
    if (count != value_count || (count > 0 && (!references || !values)))
        return (fmi3Status)instance_misses(instance, "a value reference or a value");
    for (i = 0; i < count; i++) {
        status = worse(status, instance_get_flag(instance, references[i], &value));
        values[i] = value != 0;
    }
    return (fmi3Status)status;
}

FMU_API(fmi3Status, fmi3SetBoolean)(fmi3Instance handle, const fmi3ValueReference references[], size_t count,
                                    const fmi3Boolean values[], size_t value_count)
{
    Status status = STATUS_OK;
    size_t i;
    REQUIRE(SETTABLE);
    if (count != value_count || (count > 0 && (!references || !values)))
        return (fmi3Status)instance_misses(instance, "a value reference or a value");
    for (i = 0; i < count; i++)
        status = worse(status, instance_set_flag(instance, references[i], values[i]));
    return (fmi3Status)status;
}

/* There are no variables of the other types. */
#define NONE_OF_TYPE(name, type)                                                                                       \
    FMU_API(fmi3Status, fmi3Get##name)(fmi3Instance handle, const fmi3ValueReference references[], size_t count,       \
                                       type values[], size_t value_count)                                              \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)values;                                                                                                  \
        (void)value_count;                                                                                             \
        return (fmi3Status)instance_none(handle, READABLE, __func__, count);                                           \
    }                                                                                                                  \
    FMU_API(fmi3Status, fmi3Set##name)(fmi3Instance handle, const fmi3ValueReference references[], size_t count,       \
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

FMU_API(fmi3Status, fmi3GetBinary)(fmi3Instance handle, const fmi3ValueReference references[], size_t count,
                                   size_t sizes[], fmi3Binary values[], size_t value_count)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)value_count;
    return (fmi3Status)instance_none(handle, READABLE, __func__, count);
}

FMU_API(fmi3Status, fmi3SetBinary)(fmi3Instance handle, const fmi3ValueReference references[], size_t count,
                                   const size_t sizes[], const fmi3Binary values[], size_t value_count)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)value_count;
    return (fmi3Status)instance_none(handle, SETTABLE, __func__, count);
}

/* --- Derivatives */

static fmi3Status derivatives(fmi3Instance handle, const char *function, const fmi3ValueReference unknowns[],
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

FMU_API(fmi3Status, fmi3GetDirectionalDerivative)(fmi3Instance handle, const fmi3ValueReference unknowns[],
                                                  size_t unknown_count, const fmi3ValueReference knowns[],
                                                  size_t known_count, const fmi3Float64 seed[], size_t seed_count,
                                                  fmi3Float64 product[], size_t product_count)
{
    return derivatives(handle, __func__, unknowns, unknown_count, knowns, known_count, 0, seed, seed_count, product,
                       product_count);
}

FMU_API(fmi3Status, fmi3GetAdjointDerivative)(fmi3Instance handle, const fmi3ValueReference unknowns[],
                                              size_t unknown_count, const fmi3ValueReference knowns[],
                                              size_t known_count, const fmi3Float64 seed[], size_t seed_count,
                                              fmi3Float64 product[], size_t product_count)
{
    return derivatives(handle, __func__, unknowns, unknown_count, knowns, known_count, 1, seed, seed_count, product,
                       product_count);
}

/* --- Saved states */

FMU_API(fmi3Status, fmi3GetFMUState)(fmi3Instance handle, fmi3FMUState *state)
{
    REQUIRE(ANY_MODE);
    return (fmi3Status)(state ? instance_save(instance, (Saved **)state)
                              : instance_misses(instance, "the state's place"));
}

FMU_API(fmi3Status, fmi3SetFMUState)(fmi3Instance handle, fmi3FMUState state)
{
    REQUIRE(ANY_MODE);
    return (fmi3Status)instance_restore(instance, state);
}

FMU_API(fmi3Status, fmi3FreeFMUState)(fmi3Instance handle, fmi3FMUState *state)
{
    REQUIRE(ANY_MODE);
    if (state) {
        saved_free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

FMU_API(fmi3Status, fmi3SerializedFMUStateSize)(fmi3Instance handle, fmi3FMUState state, size_t *size)
{
    REQUIRE(ANY_MODE);
    if (!state || !size)
        return (fmi3Status)instance_misses(instance, "the state or its size's place");
    *size = saved_size();
    return fmi3OK;
}

FMU_API(fmi3Status, fmi3SerializeFMUState)(fmi3Instance handle, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    REQUIRE(ANY_MODE);
    if (!state || !bytes || size < saved_size())
        return (fmi3Status)instance_misses(instance, "the state or room for its bytes");
    saved_serialise(state, bytes);
    return fmi3OK;
}

FMU_API(fmi3Status, fmi3DeserializeFMUState)(fmi3Instance handle, const fmi3Byte bytes[], size_t size,
                                             fmi3FMUState *state)
{
    REQUIRE(ANY_MODE);
    if (!state)
        return (fmi3Status)instance_misses(instance, "the state's place");
    return (fmi3Status)instance_deserialise(instance, bytes, size, (Saved **)state);
}

/* --- Co-simulation */

FMU_API(fmi3Status, fmi3DoStep)(fmi3Instance handle, fmi3Float64 time, fmi3Float64 h, fmi3Boolean no_earlier_state,
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
        *terminate = false;
    if (early_return)
        *early_return = false;
    if (last_time)
        *last_time = instance->done_time;
    return (fmi3Status)status;
}

/* --- Model exchange: a clamp has no continuous states, its memory turns at completed steps and events */

FMU_API(fmi3Status, fmi3EnterEventMode)(fmi3Instance handle)
{
    REQUIRE(EVENT | CONTINUOUS);
    instance->mode = EVENT;
    return (fmi3Status)instance_complete_step(instance);
}

FMU_API(fmi3Status, fmi3EvaluateDiscreteStates)(fmi3Instance handle)
{
    REQUIRE(INITIALIZATION | EVENT);
    return fmi3OK;
}

FMU_API(fmi3Status, fmi3UpdateDiscreteStates)(fmi3Instance handle, fmi3Boolean *needed, fmi3Boolean *terminate,
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

FMU_API(fmi3Status, fmi3EnterContinuousTimeMode)(fmi3Instance handle)
{
    REQUIRE(EVENT);
    instance->mode = CONTINUOUS;
    return fmi3OK;
}

FMU_API(fmi3Status, fmi3CompletedIntegratorStep)(fmi3Instance handle, fmi3Boolean no_earlier_state,
                                                 fmi3Boolean *enter_event_mode, fmi3Boolean *terminate)
{
    REQUIRE(CONTINUOUS);
    (void)no_earlier_state;
    if (enter_event_mode)
        *enter_event_mode = false;
    if (terminate)
        *terminate = false;
    return (fmi3Status)instance_complete_step(instance);
}

FMU_API(fmi3Status, fmi3SetTime)(fmi3Instance handle, fmi3Float64 time)
{
    REQUIRE(EVENT | CONTINUOUS);
    return (fmi3Status)instance_set_time(instance, time);
}

FMU_API(fmi3Status, fmi3GetEventIndicators)(fmi3Instance handle, fmi3Float64 indicators[], size_t count)
{
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    return (fmi3Status)instance_indicators(instance, indicators, count);
}

static fmi3Status count_of(fmi3Instance handle, const char *function, size_t is, size_t *count)
{
    const Instance *instance = handle;
    if (!instance_may(instance, ANY_MODE, function))
        return fmi3Error;
    if (!count)
        return (fmi3Status)instance_misses(instance, "the number's place");
    *count = is;
    return fmi3OK;
}

FMU_API(fmi3Status, fmi3GetNumberOfEventIndicators)(fmi3Instance handle, size_t *count)
{
    return count_of(handle, __func__, INDICATORS, count);
}

FMU_API(fmi3Status, fmi3GetNumberOfContinuousStates)(fmi3Instance handle, size_t *count)
{
    return count_of(handle, __func__, STATES, count);
}

FMU_API(fmi3Status, fmi3SetContinuousStates)(fmi3Instance handle, const fmi3Float64 states[], size_t count)
{
    REQUIRE(CONTINUOUS);
    return (fmi3Status)instance_set_states(instance, states, count);
}

FMU_API(fmi3Status, fmi3GetContinuousStates)(fmi3Instance handle, fmi3Float64 states[], size_t count)
{
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    return (fmi3Status)instance_get_states(instance, states, count);
}

FMU_API(fmi3Status, fmi3GetContinuousStateDerivatives)(fmi3Instance handle, fmi3Float64 derivatives[], size_t count)
{
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    return (fmi3Status)instance_state_derivatives(instance, derivatives, count);
}

FMU_API(fmi3Status, fmi3GetNominalsOfContinuousStates)(fmi3Instance handle, fmi3Float64 nominals[], size_t count)
{
    REQUIRE(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    return (fmi3Status)instance_nominals(instance, nominals, count);
}

/* --- What this FMU doesn't have: clocks, arrays of varying size, derivatives in time, an event mode in co-simulation */

#define LACKING(function, ...)                                                                                         \
    FMU_API(fmi3Status, function)(fmi3Instance handle __VA_ARGS__)                                                     \
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
