/* What FMI 2.0 and 3.0 state alike, but for the names: see fmi2.h and fmi3.h for these. */
#include <stdlib.h>
#include <string.h>

#include "instance.h"

enum {
    RUNNING = STEPPING | EVENT | CONTINUOUS,
    SETTABLE = INSTANTIATED | INITIALIZATION | RUNNING,
    READABLE = INITIALIZATION | RUNNING | TERMINATED,
    EVALUATED = INITIALIZATION | EVENT | CONTINUOUS | TERMINATED
};

#define REQUIRE(modes)                                                                                                 \
    Instance *instance = handle;                                                                                       \
    if (!instance_may(instance, (modes), __func__))                                                                    \
    return (Answer)STATUS_ERROR

/* --- Where the FMU's files lie */

static int hexadecimal(char digit)
{
    return digit >= '0' && digit <= '9' ? digit - '0'
           : digit >= 'a' && digit <= 'f' ? digit - 'a' + 10
           : digit >= 'A' && digit <= 'F' ? digit - 'A' + 10
                                          : -1;
}

/* Write what a URI says behind its scheme. */
static void decode(char *text, const char *uri)
{
    for (; *uri; uri++) {
        if (uri[0] == '%' && hexadecimal(uri[1]) >= 0 && hexadecimal(uri[2]) >= 0) {
            *text++ = (char)(16 * hexadecimal(uri[1]) + hexadecimal(uri[2]));
            uri += 2;
        } else {
            *text++ = *uri;
        }
    }
    *text = '\0';
}

static int begins_with_drive(const char *path)
{
    return path[0] && path[1] == ':';
}

/* Give the path of a file URI, to be freed; what is no URI is taken for a path. 2.0 has a URI and 3.0 a path, but tools
 * that import both may give what is the other's. A host other than this one stays before the path: //host/folder is
 * what Windows calls it. */
static char *path_of(const char *uri)
{
    char *path, *begin;
    if (!uri || !(path = malloc(strlen(uri) + 1)))
        return NULL;
    if (strncmp(uri, "file:", 5) != 0)
        return strcpy(path, uri);
    decode(path, uri + 5); /* before it is looked at: a drive's colon may be %3A */
    begin = path;
    if (strncmp(begin, "//localhost/", 12) == 0)
        begin += 11;
    else if (strncmp(begin, "///", 3) == 0)
        begin += 2;
    if (begins_with_drive(begin + strspn(begin, "/\\"))) /* /C:/folder, or \\C:\folder */
        begin += strspn(begin, "/\\");
    memmove(path, begin, strlen(begin) + 1);
    return path;
}

/* --- What they have in common */

/* Give the statuses of categories that are named, as bits; all where none is. */
static int statuses_of(size_t count, const char *const names[])
{
    int statuses = count > 0 && names ? 0 : ALL_STATUSES, status;
    size_t i;
    for (i = 0; names && i < count; i++)
        for (status = STATUS_OK; status <= STATUS_FATAL; status++)
            if (names[i] && strcmp(names[i], LOG_CATEGORIES[status]) == 0)
                statuses |= status == STATUS_OK ? ALL_STATUSES : 1 << status;
    return statuses;
}

FMU_API(Answer, FMI(SetDebugLogging))(Handle handle, Boolean on, size_t count, const char *const names[])
{
    REQUIRE(ANY_MODE);
    instance->logging = on ? statuses_of(count, names) : 0;
    return (Answer)STATUS_OK;
}

FMU_API(void, FMI(FreeInstance))(Handle handle)
{
    instance_free(handle);
}

FMU_API(Answer, FMI(ExitInitializationMode))(Handle handle)
{
    REQUIRE(INITIALIZATION);
    return (Answer)instance_initialised(instance);
}

FMU_API(Answer, FMI(Terminate))(Handle handle)
{
    REQUIRE(RUNNING);
    instance->mode = TERMINATED;
    return (Answer)STATUS_OK;
}

FMU_API(Answer, FMI(Reset))(Handle handle)
{
    REQUIRE(ANY_MODE);
    instance_reset(instance);
    return (Answer)STATUS_OK;
}

/* --- Booleans, whose type is an int in 2.0 and a bool in 3.0 */

static Status get_flags(Instance *instance, const unsigned references[], size_t count, Boolean values[])
{
    Status status = STATUS_OK;
    size_t i;
    if (count > 0 && (!references || !values))
        return instance_misses(instance, "an array of value references or values");
    for (i = 0; i < count; i++) {
        int value = values[i];
        status = worse(status, instance_get_flag(instance, references[i], &value));
        values[i] = value;
    }
    return status;
}

static Status set_flags(Instance *instance, const unsigned references[], size_t count, const Boolean values[])
{
    size_t i;
    if (count > 0 && (!references || !values))
        return instance_misses(instance, "an array of value references or values");
    for (i = 0; i < count; i++)
        if (!instance_may_set_flag(instance, references[i]))
            return STATUS_ERROR;
    for (i = 0; i < count; i++)
        instance_set_flag(instance, references[i], values[i]);
    return STATUS_OK;
}

/* --- Saved states; the versions write these functions' names in ways of their own */

static Answer get_state(Handle handle, const char *function, State *state)
{
    Instance *instance = handle;
    if (!instance_may(instance, ANY_MODE, function))
        return (Answer)STATUS_ERROR;
    return (Answer)(state ? instance_save(instance, (Saved **)state) : instance_misses(instance, "the state's place"));
}

static Answer set_state(Handle handle, const char *function, State state)
{
    Instance *instance = handle;
    if (!instance_may(instance, ANY_MODE, function))
        return (Answer)STATUS_ERROR;
    return (Answer)instance_restore(instance, state);
}

static Answer free_state(Handle handle, const char *function, State *state)
{
    if (!instance_may(handle, ANY_MODE, function))
        return (Answer)STATUS_ERROR;
    if (state) {
        saved_free(*state);
        *state = NULL;
    }
    return (Answer)STATUS_OK;
}

static Answer size_of_state(Handle handle, const char *function, State state, size_t *size)
{
    if (!instance_may(handle, ANY_MODE, function))
        return (Answer)STATUS_ERROR;
    if (!state || !size)
        return (Answer)instance_misses(handle, "the state or its size's place");
    *size = saved_size();
    return (Answer)STATUS_OK;
}

static Answer serialise_state(Handle handle, const char *function, State state, Byte bytes[], size_t size)
{
    if (!instance_may(handle, ANY_MODE, function))
        return (Answer)STATUS_ERROR;
    if (!state || !bytes || size < saved_size())
        return (Answer)instance_misses(handle, "the state or room for its bytes");
    saved_serialise(state, (unsigned char *)bytes);
    return (Answer)STATUS_OK;
}

static Answer deserialise_state(Handle handle, const char *function, const Byte bytes[], size_t size, State *state)
{
    if (!instance_may(handle, ANY_MODE, function))
        return (Answer)STATUS_ERROR;
    if (!state)
        return (Answer)instance_misses(handle, "the state's place");
    return (Answer)instance_deserialise(handle, (const unsigned char *)bytes, size, (Saved **)state);
}

/* --- Model exchange: a clamp has no continuous states, its memory turns at completed steps and events */

FMU_API(Answer, FMI(EnterEventMode))(Handle handle)
{
    REQUIRE(EVENT | CONTINUOUS);
    instance->mode = EVENT;
    return (Answer)instance_complete_step(instance);
}

FMU_API(Answer, FMI(EnterContinuousTimeMode))(Handle handle)
{
    REQUIRE(EVENT);
    instance->mode = CONTINUOUS;
    return (Answer)STATUS_OK;
}

FMU_API(Answer, FMI(CompletedIntegratorStep))(Handle handle, Boolean no_earlier_state, Boolean *enter_event_mode,
                                              Boolean *terminate)
{
    REQUIRE(CONTINUOUS);
    (void)no_earlier_state;
    if (enter_event_mode)
        *enter_event_mode = 0;
    if (terminate)
        *terminate = 0;
    return (Answer)instance_complete_step(instance);
}

FMU_API(Answer, FMI(SetTime))(Handle handle, double time)
{
    REQUIRE(EVENT | CONTINUOUS);
    return (Answer)instance_set_time(instance, time);
}

FMU_API(Answer, FMI(GetEventIndicators))(Handle handle, double indicators[], size_t count)
{
    REQUIRE(EVALUATED);
    return (Answer)instance_indicators(instance, indicators, count);
}

FMU_API(Answer, FMI(SetContinuousStates))(Handle handle, const double states[], size_t count)
{
    REQUIRE(CONTINUOUS);
    return (Answer)instance_set_states(instance, states, count);
}

FMU_API(Answer, FMI(GetContinuousStates))(Handle handle, double states[], size_t count)
{
    REQUIRE(EVALUATED);
    return (Answer)instance_get_states(instance, states, count);
}

FMU_API(Answer, FMI(GetNominalsOfContinuousStates))(Handle handle, double nominals[], size_t count)
{
    REQUIRE(EVALUATED);
    return (Answer)instance_nominals(instance, nominals, count);
}
