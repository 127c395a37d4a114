/* The types of FMI 2.0 and the names under which its functions are exported. */
#ifndef FMI2_H
#define FMI2_H

#include "export.h"

#if !defined(FMU_SHARED_LIBRARY) && defined(__has_include)
#if __has_include("fmi2Functions.h")
#define STANDARD_HEADERS
#endif
#endif

#ifdef STANDARD_HEADERS /* whoever compiles the sources has them; they name and export the functions */
/* The first headers of FMI 2.0 don't know FMI2_OVERRIDE_FUNCTION_PREFIX: they take any prefix that is defined. */
#if !defined(FMI2_FUNCTION_PREFIX) && !defined(FMI2_OVERRIDE_FUNCTION_PREFIX)
#define FMI2_FUNCTION_PREFIX FUNCTION_PREFIX
#endif
#include "fmi2Functions.h"
#undef FMU_API
#define FMU_API(type, name) FMI2_Export type name
#else

#include <stddef.h>

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;

enum { fmi2False, fmi2True };
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);

typedef struct {
    fmi2CallbackLogger logger;
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

typedef struct {
    fmi2Boolean newDiscreteStatesNeeded;
    fmi2Boolean terminateSimulation;
    fmi2Boolean nominalsOfContinuousStatesChanged;
    fmi2Boolean valuesOfContinuousStatesChanged;
    fmi2Boolean nextEventTimeDefined;
    fmi2Real nextEventTime;
} fmi2EventInfo;

#endif

/* The names that fmi.c has for them, which states what is alike in both versions. */
#define FMI(name) fmi2##name
typedef fmi2Component Handle;
typedef fmi2Status Answer;
typedef fmi2Boolean Boolean;
typedef fmi2FMUstate State;
typedef fmi2Byte Byte;

#endif
