/* A spring as another vendor's FMU of FMI 2.0: its logger gets a format and arguments, as the standard means it. */
#include <stdlib.h>

#include "fmi2FunctionTypes.h"

#if defined _WIN32
#define FMU_API __declspec(dllexport)
#else
#define FMU_API
#endif

enum { S, V, F, VARIABLES };

typedef struct {
    fmi2CallbackFunctions callbacks;
    double values[VARIABLES];
    int steps;
} Spring;

FMU_API fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String place,
                                      const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    Spring *spring = calloc(1, sizeof *spring);
    (void)name, (void)type, (void)guid, (void)place, (void)visible, (void)logging;
    spring->callbacks = *callbacks;
    return spring;
}

FMU_API void fmi2FreeInstance(fmi2Component spring)
{
    free(spring);
}

FMU_API fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t n, const double values[])
{
    size_t i;
    for (i = 0; i < n; i++)
        ((Spring *)c)->values[references[i]] = values[i];
    return fmi2OK;
}

FMU_API fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t n, double values[])
{
    size_t i;
    for (i = 0; i < n; i++)
        values[i] = ((Spring *)c)->values[references[i]];
    return fmi2OK;
}

FMU_API fmi2Status fmi2DoStep(fmi2Component c, double time, double h, fmi2Boolean without_rollback)
{
    Spring *spring = c;
    const fmi2Status status = spring->steps == REFUSED_STEP ? fmi2Error : fmi2Warning;
    (void)time, (void)h, (void)without_rollback;
    spring->values[F] = 4e3 * spring->values[S] + 5.0 * spring->values[V];
    if (spring->steps++ % REFUSED_STEP == 0)
        spring->callbacks.logger(spring->callbacks.componentEnvironment, "spring", status, "log",
                                 "%s with %.1f %% of %d N", "loaded", 12.5, 400);
    return status == fmi2Error ? fmi2Error : fmi2OK;
}

/* What importers look for, and this one's tests don't call, or need no answer to. */
#define STUB(name)                                                                                                     \
    FMU_API fmi2Status name(void)                                                                                      \
    {                                                                                                                  \
        return fmi2OK;                                                                                                 \
    }
STUB(fmi2SetupExperiment) STUB(fmi2EnterInitializationMode) STUB(fmi2ExitInitializationMode) STUB(fmi2Terminate)
STUB(fmi2Reset) STUB(fmi2SetDebugLogging) STUB(fmi2GetTypesPlatform) STUB(fmi2GetVersion)
STUB(fmi2GetInteger) STUB(fmi2GetBoolean) STUB(fmi2GetString) STUB(fmi2SetInteger) STUB(fmi2SetBoolean)
STUB(fmi2SetString) STUB(fmi2GetFMUstate) STUB(fmi2SetFMUstate) STUB(fmi2FreeFMUstate)
STUB(fmi2SerializedFMUstateSize) STUB(fmi2SerializeFMUstate) STUB(fmi2DeSerializeFMUstate)
STUB(fmi2GetDirectionalDerivative) STUB(fmi2SetRealInputDerivatives) STUB(fmi2GetRealOutputDerivatives)
STUB(fmi2CancelStep) STUB(fmi2GetStatus) STUB(fmi2GetRealStatus) STUB(fmi2GetIntegerStatus)
STUB(fmi2GetBooleanStatus) STUB(fmi2GetStringStatus)
