/* A host without Python: loads a clamp FMU of FMI 2.0 co-simulation with dlopen and drives it.
 *
 * host LIBRARY GUID RESOURCES forces N     prints N forces along a motion
 * host LIBRARY GUID RESOURCES cycles N     instantiates and frees N times; prints the growth of memory in kB
 * host LIBRARY GUID RESOURCES threads N    steps N instances in threads of their own; prints how many differ
 * host LIBRARY GUID RESOURCES speed N      prints nanoseconds per set (2 Real) + step + get (1 Real), best of 15 rounds
 */
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "fmi2.h"

typedef struct {
    fmi2Component (*instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *, fmi2Boolean,
                                 fmi2Boolean);
    void (*free_instance)(fmi2Component);
    fmi2Status (*setup)(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
    fmi2Status (*enter)(fmi2Component);
    fmi2Status (*leave)(fmi2Component);
    fmi2Status (*step)(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
    fmi2Status (*set)(fmi2Component, const fmi2ValueReference[], size_t, const fmi2Real[]);
    fmi2Status (*get)(fmi2Component, const fmi2ValueReference[], size_t, fmi2Real[]);
} Functions;

static Functions fmu;
static const char *guid, *resources;
static const fmi2ValueReference INPUTS_[2] = {1, 2}, FORCE[1] = {7};
static const double H = 1e-3;

static void logged(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    (void)environment;
    fprintf(stderr, "%s %d %s: %s\n", name, (int)status, category, message);
}

static void *zeroed(size_t count, size_t size)
{
    return calloc(count, size);
}

static fmi2Component ready(void)
{
    static const fmi2CallbackFunctions functions = {logged, zeroed, free, NULL, NULL};
    fmi2Component clamp = fmu.instantiate("clamp", fmi2CoSimulation, guid, resources, &functions, 0, 0);
    if (!clamp || fmu.setup(clamp, 0, 0, 0, 0, 0) || fmu.enter(clamp) || fmu.leave(clamp))
        exit(2);
    return clamp;
}

static double force_after(fmi2Component clamp, int n)
{
    const double theta = 6 * 3.14159265358979323846 * H * (n + 1);
    const double motion[2] = {5e-4 * sin(theta), 5e-4 * 6 * 3.14159265358979323846 * cos(theta)};
    double force = NAN;
    if (fmu.set(clamp, INPUTS_, 2, motion) || fmu.step(clamp, n * H, H, 1) || fmu.get(clamp, FORCE, 1, &force))
        exit(3);
    return force;
}

static int print_forces(int count)
{
    fmi2Component clamp = ready();
    int n;
    for (n = 0; n < count; n++)
        printf("%.17g\n", force_after(clamp, n));
    fmu.free_instance(clamp);
    return 0;
}

static long peak(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

static int print_growth(int count)
{
    long before = 0;
    int n;
    for (n = 0; n < count; n++) {
        fmi2Component clamp = ready();
        force_after(clamp, 0);
        fmu.free_instance(clamp);
        if (n == count / 100)
            before = peak();
    }
    printf("%ld\n", peak() - before);
    return 0;
}

enum { STEPS = 2000 };
static double expected[STEPS];

static void *in_thread(void *argument)
{
    fmi2Component clamp = ready();
    int n;
    for (n = 0; n < STEPS; n++)
        if (force_after(clamp, n) != expected[n])
            *(int *)argument = 1;
    fmu.free_instance(clamp);
    return NULL;
}

static int print_differing(int count)
{
    pthread_t threads[64];
    int differs[64] = {0}, sum = 0, n;
    fmi2Component clamp = ready();
    if (count > 64)
        return 2;
    for (n = 0; n < STEPS; n++)
        expected[n] = force_after(clamp, n);
    fmu.free_instance(clamp);
    for (n = 0; n < count; n++)
        pthread_create(&threads[n], NULL, in_thread, &differs[n]);
    for (n = 0; n < count; n++) {
        pthread_join(threads[n], NULL);
        sum += differs[n];
    }
    printf("%d\n", sum);
    return 0;
}

static int print_speed(int count)
{
    fmi2Component clamp = ready();
    double *motion = malloc(2 * (size_t)count * sizeof *motion), best = INFINITY, force;
    int n, round;
    for (n = 0; n < count; n++) {
        const double theta = 0.01 * n;
        motion[2 * n] = 5e-4 * sin(theta);
        motion[2 * n + 1] = 5e-3 * cos(theta);
    }
    for (round = 0; round < 15; round++) {
        struct timespec start, end;
        double took;
        clock_gettime(CLOCK_MONOTONIC, &start);
        for (n = 0; n < count; n++) {
            fmu.set(clamp, INPUTS_, 2, motion + 2 * n);
            fmu.step(clamp, n * H, H, 1);
            fmu.get(clamp, FORCE, 1, &force);
        }
        clock_gettime(CLOCK_MONOTONIC, &end);
        took = 1e9 * (double)(end.tv_sec - start.tv_sec) + (double)(end.tv_nsec - start.tv_nsec);
        best = took / count < best ? took / count : best;
    }
    printf("%.2f\n", best);
    free(motion);
    fmu.free_instance(clamp);
    return 0;
}

int main(int count, char **arguments)
{
    const struct {
        const char *name;
        void **place;
    } symbols[] = {{"fmi2Instantiate", (void **)&fmu.instantiate},
                   {"fmi2FreeInstance", (void **)&fmu.free_instance},
                   {"fmi2SetupExperiment", (void **)&fmu.setup},
                   {"fmi2EnterInitializationMode", (void **)&fmu.enter},
                   {"fmi2ExitInitializationMode", (void **)&fmu.leave},
                   {"fmi2DoStep", (void **)&fmu.step},
                   {"fmi2SetReal", (void **)&fmu.set},
                   {"fmi2GetReal", (void **)&fmu.get}};
    void *library;
    size_t i;
    int number;
    if (count != 6 || !(library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL)))
        return 2;
    for (i = 0; i < sizeof symbols / sizeof symbols[0]; i++)
        if (!(*symbols[i].place = dlsym(library, symbols[i].name)))
            return 2;
    guid = arguments[2];
    resources = arguments[3];
    number = atoi(arguments[5]);
    if (!strcmp(arguments[4], "forces"))
        return print_forces(number);
    if (!strcmp(arguments[4], "cycles"))
        return print_growth(number);
    if (!strcmp(arguments[4], "threads"))
        return print_differing(number);
    return print_speed(number);
}
