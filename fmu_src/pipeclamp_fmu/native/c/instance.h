/* What FMI 2.0 and FMI 3.0 share: an instance with its mode, its messages, its saved states. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stddef.h>

#include "model.h"

typedef enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR, STATUS_FATAL } Status; /* as in both standards */

/* Modes, as bits, so that a function can name all in which it may be called. */
typedef enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEPPING = 4,    /* co-simulation, between steps */
    EVENT = 8,       /* model exchange */
    CONTINUOUS = 16, /* model exchange */
    TERMINATED = 32,
    ANY_MODE = 63
} Mode;

static const char *const LOG_CATEGORIES[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError",
                                             "logStatusFatal"};

enum { ALL_STATUSES = (2 << STATUS_FATAL) - 1 };

typedef struct Instance Instance;

struct Instance {
    Model done;  /* at the end of the last completed step */
    Model shown; /* in model exchange: at the present time and inputs, a step from `done` */
    int stale;   /* `shown` has yet to be evaluated */
    double time, done_time;
    Mode mode;
    int co_simulation;
    int warned; /* what was warned of; not part of a saved state: what was said stays said */
    int refused; /* the last step was discarded: at that, the run should end */
    int logging; /* the statuses that the importer wants to be told of, as bits */
    Values values;
    Scratch scratch;
    char *name;
    void *environment;
    void (*logger)(void); /* the importer's, of a type that `tell` knows */
    void (*tell)(const Instance *instance, Status status, const char *text);
};

/* Make an instance with the values in the file of that folder (UTF-8); NULL, with the reason, where it can't be. */
static Instance *instance_new(const char *name, const char *token, const char *folder, int co_simulation,
                              char reason[TEXT]);
static void instance_free(Instance *instance);
static void instance_reset(Instance *instance);

/* Tell the importer, where logging is on. */
static void instance_say(const Instance *instance, Status status, const char *format, ...);

/* Tell whether a function may be called now, and complain where it may not. */
static int instance_may(const Instance *instance, int modes, const char *function);

/* Answers to calls that can't be served. */
static Status instance_misses(const Instance *instance, const char *what);
static Status instance_lacks(const Instance *instance, const char *function);
static Status instance_none(const Instance *instance, int modes, const char *function, size_t count);

static Status worse(Status first, Status second);

static Status instance_set_reals(Instance *instance, const unsigned references[], size_t count, const double values[]);
static Status instance_get_reals(Instance *instance, const unsigned references[], size_t count, double values[]);
static int instance_may_set_flag(const Instance *instance, unsigned reference); /* complains where it may not */
static void instance_set_flag(Instance *instance, unsigned reference, int value);
static Status instance_get_flag(Instance *instance, unsigned reference, int *value);

static Status instance_begin(Instance *instance, double time);
static Status instance_initialised(Instance *instance);
static Status instance_do_step(Instance *instance, double time, double h);

/* Model exchange: take the present time and inputs as the end of a completed step. */
static Status instance_complete_step(Instance *instance);
static Status instance_set_time(Instance *instance, double time);
static Status instance_set_states(Instance *instance, const double states[], size_t count);
static Status instance_get_states(const Instance *instance, double states[], size_t count);
static Status instance_state_derivatives(Instance *instance, double derivatives[], size_t count);
static Status instance_nominals(const Instance *instance, double nominals[], size_t count);
static Status instance_indicators(Instance *instance, double indicators[], size_t count);

/* Products of the Jacobian with a seed, forwards, or transposed. */
static Status instance_derivatives(Instance *instance, const unsigned unknowns[], size_t unknown_count,
                                   const unsigned knowns[], size_t known_count, int transposed, const double seed[],
                                   double product[]);

/* A saved state: all that is needed to go on from here, in this instance or in another of the same FMU. */
typedef struct Saved Saved;
static Status instance_save(const Instance *instance, Saved **saved);
static Status instance_restore(Instance *instance, const Saved *saved);
static Status instance_deserialise(const Instance *instance, const unsigned char bytes[], size_t size, Saved **saved);
static void saved_free(Saved *saved);
static size_t saved_size(void);
static void saved_serialise(const Saved *saved, unsigned char bytes[]);

#endif
