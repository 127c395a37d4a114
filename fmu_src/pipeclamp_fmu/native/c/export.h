/* How the functions of an FMU are exported. Linked statically from sources, they begin with the model identifier. */
#ifndef EXPORT_H
#define EXPORT_H

#if defined(DISABLE_PREFIX) && !defined(FMI2_OVERRIDE_FUNCTION_PREFIX) /* its older name, which fmutool gives */
#define FMI2_OVERRIDE_FUNCTION_PREFIX
#endif

#if defined(FMU_SHARED_LIBRARY) || defined(FMI2_OVERRIDE_FUNCTION_PREFIX) || defined(FMI3_OVERRIDE_FUNCTION_PREFIX)
#define NAMED(name) name
#else
#define JOINED(prefix, name) prefix##name
#define EXPANDED(prefix, name) JOINED(prefix, name)
#define NAMED(name) EXPANDED(FUNCTION_PREFIX, name)
#endif

#if defined(_WIN32)
#define FMU_API(type, name) __declspec(dllexport) type NAMED(name)
#elif defined(__GNUC__)
#define FMU_API(type, name) __attribute__((visibility("default"))) type NAMED(name)
#else
#define FMU_API(type, name) type NAMED(name)
#endif

/* What is called for messages alone is kept apart, so that the ways past it are short; what a common case doesn't need
 * is kept out of the functions that do need it; what every step goes through is part of it. */
#if defined(__GNUC__)
#define RARE __attribute__((cold, noinline))
#define APART __attribute__((noinline))
#define WITHIN __attribute__((always_inline))
#else
#define RARE
#define APART
#define WITHIN
#endif

#endif
