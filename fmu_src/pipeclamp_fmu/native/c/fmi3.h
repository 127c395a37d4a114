/* The types of FMI 3.0 and the names under which its functions are exported. */
#ifndef FMI3_H
#define FMI3_H

#include "export.h"

#if !defined(FMU_SHARED_LIBRARY) && defined(__has_include)
#if __has_include("fmi3Functions.h")
#define STANDARD_HEADERS
#endif
#endif

#ifdef STANDARD_HEADERS /* whoever compiles the sources has them; they name and export the functions */
#if !defined(FMI3_FUNCTION_PREFIX)
#define FMI3_FUNCTION_PREFIX FUNCTION_PREFIX
#endif
#include "fmi3Functions.h"
#undef FMU_API
#define FMU_API(type, name) FMI3_Export type name
#else

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean, fmi3Boolean *, fmi3Float64 *);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

#endif

/* The names that fmi.c has for them, which states what is alike in both versions. */
#define FMI(name) fmi3##name
typedef fmi3Instance Handle;
typedef fmi3Status Answer;
typedef fmi3Boolean Boolean;
typedef fmi3FMUState State;
typedef fmi3Byte Byte;

#endif
