/* An FMU of FMI 2.0 co-simulation with the clamp's variables that does nothing: what an FMU costs at the least. */
#include <stdlib.h>

#include "fmi2.h"

typedef struct {
    double real[16];
} Empty;

FMU_API(fmi2Component, fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                        const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)type, (void)guid, (void)resources, (void)functions, (void)visible, (void)logging;
    return calloc(1, sizeof(Empty));
}

FMU_API(void, fmi2FreeInstance)(fmi2Component component)
{
    free(component);
}

FMU_API(fmi2Status, fmi2SetupExperiment)(fmi2Component component, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                                         fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    (void)component, (void)tolerance_defined, (void)tolerance, (void)start, (void)stop_defined, (void)stop;
    return fmi2OK;
}

FMU_API(fmi2Status, fmi2EnterInitializationMode)(fmi2Component component)
{
    (void)component;
    return fmi2OK;
}

FMU_API(fmi2Status, fmi2ExitInitializationMode)(fmi2Component component)
{
    (void)component;
    return fmi2OK;
}

FMU_API(fmi2Status, fmi2GetReal)(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                 fmi2Real values[])
{
    size_t i;
    for (i = 0; i < count; i++) {
        if (references[i] >= 16)
            return fmi2Error;
        values[i] = ((Empty *)component)->real[references[i]];
    }
    return fmi2OK;
}

FMU_API(fmi2Status, fmi2SetReal)(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                 const fmi2Real values[])
{
    size_t i;
    for (i = 0; i < count; i++) {
        if (references[i] >= 16)
            return fmi2Error;
        ((Empty *)component)->real[references[i]] = values[i];
    }
    return fmi2OK;
}

FMU_API(fmi2Status, fmi2DoStep)(fmi2Component component, fmi2Real time, fmi2Real h, fmi2Boolean no_return)
{
    (void)component, (void)time, (void)h, (void)no_return;
    return fmi2OK;
}
