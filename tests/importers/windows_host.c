/* A host that loads a co-simulation FMU's library, of FMI 2.0, on Linux and on Windows.
 *
 * host LIBRARY GUID RESOURCES STEP INPUTS OUTPUTS < MOTION
 *
 * INPUTS and OUTPUTS are value references of Reals, with commas between them. MOTION holds the inputs of each step, as
 * text; each line of what is printed holds the outputs after a step.
 */
#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) (void *)LoadLibraryA(path)
#define FIND(library, name) (void *)GetProcAddress((HMODULE)(library), name)
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
#endif

#include "fmi2Functions.h"

enum { MOST = 64 };

static void logged(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    (void)environment;
    fprintf(stderr, "%s %d %s: %s\n", name, (int)status, category, message);
}

static size_t read_references(char *text, fmi2ValueReference *references)
{
    size_t count = 0;
    while (*text && count < MOST) {
        references[count++] = (fmi2ValueReference)strtoul(text, &text, 10);
        if (*text == ',')
            text++;
    }
    return count;
}

int main(int count, char **arguments)
{
    static const fmi2CallbackFunctions callbacks = {logged, calloc, free, NULL, NULL};
    fmi2ValueReference inputs[MOST], outputs[MOST];
    fmi2Real values[MOST];
    size_t given, wanted, i;
    double time = 0, step;
    void *library;
    fmi2Component fmu;
    if (count != 7 || !(library = OPEN(arguments[1])))
        return 2;
    step = strtod(arguments[4], NULL);
    given = read_references(arguments[5], inputs);
    wanted = read_references(arguments[6], outputs);
#define FUNCTION(name) name##TYPE *name = (name##TYPE *)FIND(library, #name)
    FUNCTION(fmi2Instantiate);
    FUNCTION(fmi2SetupExperiment);
    FUNCTION(fmi2EnterInitializationMode);
    FUNCTION(fmi2ExitInitializationMode);
    FUNCTION(fmi2SetReal);
    FUNCTION(fmi2GetReal);
    FUNCTION(fmi2DoStep);
    FUNCTION(fmi2FreeInstance);
    fmu = fmi2Instantiate("fmu", fmi2CoSimulation, arguments[2], arguments[3], &callbacks, fmi2False, fmi2False);
    if (!fmu || fmi2SetupExperiment(fmu, fmi2False, 0, 0, fmi2False, 0) || fmi2EnterInitializationMode(fmu) ||
        fmi2ExitInitializationMode(fmu))
        return 3;
    for (;;) {
        for (i = 0; i < given; i++)
            if (scanf("%lf", &values[i]) != 1) {
                fmi2FreeInstance(fmu);
                return i ? 4 : 0;
            }
        if (fmi2SetReal(fmu, inputs, given, values) || fmi2DoStep(fmu, time, step, fmi2True) ||
            fmi2GetReal(fmu, outputs, wanted, values))
            return 5;
        time += step;
        for (i = 0; i < wanted; i++)
            printf("%.17g%c", values[i], i + 1 < wanted ? ' ' : '\n');
    }
}
