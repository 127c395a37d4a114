/* Random calls of a native FMU, in any order, with any values: none may crash, each must answer with a status.
 *
 * Compiled together with the FMU's sources, so that sanitizers see all of it: cc -fsanitize=... -I sources fuzz.c
 * fuzz TOKEN RESOURCES CALLS SEED
 */
#include <stdio.h>

#include "fmu.c"

static uint64_t seed;

static unsigned random_below(unsigned limit)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (unsigned)(seed >> 33) % limit;
}

static double random_value(void)
{
    static const double odd[] = {NAN, INFINITY, -INFINITY, 0.0, -0.0, 5e-324, -1e-310, 1e300, -1e300, 1.7e308, -1.0};
    const unsigned count = sizeof odd / sizeof odd[0], choice = random_below(4 * count);
    const double scale[] = {1e-3, 1.0, 400.0};
    return choice < count ? odd[choice] : scale[random_below(3)] * ((double)random_below(2001) / 1000 - 1);
}

static unsigned random_reference(void)
{
    return random_below(8) ? random_below(REALS + FLAGS + 2) : random_below(2) ? 0xffffffffu : random_below(1000);
}

/* Up to four references and values; sometimes missing. */
static unsigned references[4];
static double values[4];
static size_t fill(void)
{
    size_t i;
    for (i = 0; i < 4; i++) {
        references[i] = random_reference();
        values[i] = random_value();
    }
    return random_below(5);
}

#if FMI_VERSION == 2
#define CALL(name) fmi2##name
#define Handle fmi2Component
#define State fmi2FMUstate
#define Bool int
#define COUNTED(array, count) array
static void logged(void *environment, const char *name, fmi2Status status, const char *category, const char *text, ...)
{
    (void)environment, (void)name, (void)category;
    if ((int)status > 4 || strlen(text) > 2 * TEXT)
        abort();
}
static Handle instantiate(const char *name, int type, const char *token, const char *resources)
{
    const fmi2CallbackFunctions functions = {logged, NULL, NULL, NULL, NULL};
    return fmi2Instantiate(name, (fmi2Type)type, token, resources, random_below(9) ? &functions : NULL, 0, random_below(2));
}
#else
#define CALL(name) fmi3##name
#define Handle fmi3Instance
#define State fmi3FMUState
#define Bool bool
#define COUNTED(array, count) array, count
static void logged(void *environment, fmi3Status status, const char *category, const char *text)
{
    (void)environment, (void)category;
    if ((int)status > 4 || strlen(text) > 2 * TEXT)
        abort();
}
static Handle instantiate(const char *name, int type, const char *token, const char *resources)
{
    const fmi3LogMessageCallback logger = random_below(9) ? logged : NULL;
    if (!type)
        return fmi3InstantiateModelExchange(name, token, resources, 0, random_below(2), NULL, logger);
    return fmi3InstantiateCoSimulation(name, token, resources, 0, random_below(2), !random_below(9), 0, NULL, 0, NULL,
                                       logger, NULL);
}
#endif

static int common_call(Handle clamp, State *state)
{
    static unsigned char bytes[2 * sizeof(Saved)];
    const size_t count = fill();
    const unsigned *known = random_below(20) ? references : NULL;
    double product[4], indicator[2];
    Bool flags[4] = {0};
    size_t size = 0, i;
    for (i = 0; i < count; i++)
        flags[i] = random_below(2);
    switch (random_below(24)) {
    case 0: case 1: case 2:
        return CALL(GetBoolean)(clamp, known, count, COUNTED(flags, count));
    case 3:
        return CALL(SetBoolean)(clamp, known, count, COUNTED(flags, count));
    case 4:
        return CALL(EnterEventMode)(clamp);
    case 5:
        return CALL(EnterContinuousTimeMode)(clamp);
    case 6: case 7:
        return CALL(SetTime)(clamp, random_value());
    case 8: case 9:
        return CALL(CompletedIntegratorStep)(clamp, 1, flags, random_below(9) ? flags + 1 : NULL);
    case 10:
        return CALL(GetEventIndicators)(clamp, random_below(9) ? indicator : NULL, random_below(3));
    case 11:
        return CALL(ExitInitializationMode)(clamp);
    case 12:
        return CALL(GetContinuousStates)(clamp, values, random_below(2));
    case 13: case 14:
        return CALL(GetDirectionalDerivative)(clamp, known, count, references, count, COUNTED(values, count),
                                              COUNTED(product, count));
    case 15:
        return random_below(20) ? 0 : CALL(Terminate)(clamp);
    case 16:
        return random_below(9) ? 0 : CALL(Reset)(clamp);
    case 17:
#if FMI_VERSION == 2
        return fmi2GetFMUstate(clamp, state);
    case 18:
        return fmi2SetFMUstate(clamp, *state);
    case 19:
        return fmi2FreeFMUstate(clamp, state);
    case 20:
        if (fmi2SerializedFMUstateSize(clamp, *state, &size) != fmi2OK)
            return 3;
        if (fmi2SerializeFMUstate(clamp, *state, (char *)bytes, size) != fmi2OK)
            return 3;
        if (random_below(2)) /* past the header: values that no instance ever had */
            bytes[24 + random_below((unsigned)size - 24)] = (unsigned char)random_below(256);
        return fmi2DeSerializeFMUstate(clamp, (char *)bytes, size - (random_below(9) ? 0 : 1), state);
#else
        return fmi3GetFMUState(clamp, state);
    case 18:
        return fmi3SetFMUState(clamp, *state);
    case 19:
        return fmi3FreeFMUState(clamp, state);
    case 20:
        if (fmi3SerializedFMUStateSize(clamp, *state, &size) != fmi3OK)
            return 3;
        if (fmi3SerializeFMUState(clamp, *state, bytes, size) != fmi3OK)
            return 3;
        if (random_below(2))
            bytes[24 + random_below((unsigned)size - 24)] = (unsigned char)random_below(256);
        return fmi3DeserializeFMUState(clamp, bytes, size - (random_below(9) ? 0 : 1), state);
#endif
    default:
        return CALL(SetDebugLogging)(clamp, random_below(2), 0, NULL);
    }
}

static int call(Handle clamp, State *state)
{
    const size_t count = fill();
    const double h = random_below(4) ? 1e-3 : random_value();
    switch (random_below(12)) {
#if FMI_VERSION == 2
    case 0: case 1: case 2:
        return fmi2GetReal(clamp, random_below(20) ? references : NULL, count, values);
    case 3: case 4:
        return fmi2SetReal(clamp, references, count, random_below(20) ? values : NULL);
    case 5: case 6: case 7:
        return fmi2DoStep(clamp, random_value(), h, 1);
    case 8:
        return random_below(2) ? fmi2SetupExperiment(clamp, 0, 0, h, 0, 0) : fmi2EnterInitializationMode(clamp);
    case 9: {
        fmi2EventInfo info;
        return random_below(2) ? fmi2NewDiscreteStates(clamp, random_below(9) ? &info : NULL)
                               : fmi2GetInteger(clamp, references, count, NULL);
    }
#else
    case 0: case 1: case 2:
        return fmi3GetFloat64(clamp, random_below(20) ? references : NULL, count, values, count + !random_below(20));
    case 3: case 4:
        return fmi3SetFloat64(clamp, references, count, random_below(20) ? values : NULL, count);
    case 5: case 6: case 7: {
        bool answer;
        double last;
        return fmi3DoStep(clamp, random_value(), h, 1, &answer, &answer, random_below(9) ? &answer : NULL, &last);
    }
    case 8:
        return random_below(2) ? fmi3EnterInitializationMode(clamp, 0, 0, random_value(), 0, 0)
                               : fmi3EnterConfigurationMode(clamp);
    case 9: {
        double product[4];
        return random_below(2) ? fmi3UpdateDiscreteStates(clamp, NULL, NULL, NULL, NULL, NULL, random_below(2) ? product : NULL)
                               : fmi3GetAdjointDerivative(clamp, references, count, references, count, values, count, product, count);
    }
#endif
    default:
        return common_call(clamp, state);
    }
}

/* Bring an instance to where steps can be made, so that most calls find it in a mode that serves them. */
static void ready(Handle clamp)
{
#if FMI_VERSION == 2
    fmi2EnterInitializationMode(clamp);
    fmi2ExitInitializationMode(clamp);
#else
    fmi3EnterInitializationMode(clamp, 0, 0, 0, 0, 0);
    fmi3ExitInitializationMode(clamp);
#endif
    CALL(EnterContinuousTimeMode)(clamp);
}

int main(int count, char **arguments)
{
    const char *token = arguments[1], *resources = arguments[2];
    long calls = count == 5 ? atol(arguments[3]) : 0, answers[5] = {0}, made = 0;
    seed = count == 5 ? strtoull(arguments[4], NULL, 10) * 2654435761u + 88172645463325252u : 1;
    while (calls > 0) {
        const unsigned odd = random_below(12);
        State state = NULL;
        Handle clamp = instantiate(odd == 1 ? NULL : "clamp", (int)random_below(2), odd == 2 ? "other" : odd == 3 ? NULL : token,
                                   odd == 4 ? "file:///nowhere%2" : odd == 5 ? NULL : resources);
        int length = (int)random_below(400);
        made += clamp != NULL;
        if (clamp && odd != 6)
            ready(clamp);
        for (; length > 0; length--, calls--) {
            const int status = call(clamp, &state);
            if (status < 0 || status > 3)
                return 1;
            answers[status]++;
        }
        if (clamp) {
            CALL(Reset)(clamp);
#if FMI_VERSION == 2
            fmi2FreeFMUstate(clamp, &state);
#else
            fmi3FreeFMUState(clamp, &state);
#endif
        }
        CALL(FreeInstance)(clamp);
        calls--;
    }
    printf("%ld instances; ok %ld, warning %ld, discard %ld, error %ld\n", made, answers[0], answers[1], answers[2],
           answers[3]);
    return made > 0 && answers[0] > 0 && answers[2] > 0 && answers[3] > 0 ? 0 : 1;
}
