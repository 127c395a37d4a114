/* A model that is stepped, as the FMI layers see it. It knows nothing of FMI.
 *
 * All sources are compiled as one file, `fmu.c`, so that several FMUs can be linked into one program.
 *
 * `layout.h` is generated: it counts and names the variables and says what memory the model has. Variables of type Real
 * are, in this order: inputs, tunable parameters, outputs, locals, fixed parameters. Booleans: parameters, locals.
 */
#ifndef MODEL_H
#define MODEL_H

#include "export.h"
#include "layout.h"

enum {
    FIRST_OUTPUT = INPUTS + PARAMETERS,
    FIRST_LOCAL = FIRST_OUTPUT + OUTPUTS,
    FIRST_FIXED = FIRST_LOCAL + LOCALS,
    REALS = FIRST_FIXED + FIXED,
    FLAGS = FLAG_PARAMETERS + FLAG_LOCALS,
    ROWS = OUTPUTS + STATES,
    COLUMNS = FIRST_OUTPUT + STATES,
    TIME = REALS + FLAGS, /* in FMI 3.0, the place after all others */
    TEXT = 512
};

/* What the file of values says; the same for the life of an instance. */
typedef struct {
    char name[TEXT / 2];
    double start[ROOM(INPUTS + PARAMETERS)];
    double fixed[ROOM(FIXED)];
    int flag[ROOM(FLAG_PARAMETERS)];
    double range[ROOM(RANGES)][2];
} Values;

/* All that changes. It holds no pointers, so that a copy of it is an exact saved state. */
typedef struct {
    double real[REALS];
    int flag[ROOM(FLAGS)];
    int settled; /* no parameter has changed since the last step */
    Memory memory;
} Model;

/* A step ends at the time `end` after `h` seconds.
 * Functions that can't do what they are asked say why in `reason` and return 0, the model untouched. What a model keeps
 * in `scratch` is no part of its state: it only saves work. */

static void model_reset(Model *model, const Values *values);
static int model_start(Model *model, const Values *values, double time, char reason[TEXT]);
static int model_step(Model *model, const Values *values, Scratch *scratch, double end, double h, char reason[TEXT]);

/* Model exchange: bring the model to the present time and inputs, `h` after the last completed step. */
static int model_evaluate(Model *model, const Values *values, Scratch *scratch, double time, double h,
                          char reason[TEXT]);

/* Continuous states, `STATES` of them; their derivatives are those of a model that is evaluated. */
static void model_get_states(const Model *model, double states[]);
static void model_set_states(Model *model, const double states[]);
static void model_derivatives(const Model *model, double derivatives[]);

/* Slopes of the Real outputs, then of the states' derivatives, along a direction in inputs, tunable parameters, then
 * states. In co-simulation they are those of the last step as it ended, and states are no variables of their own. */
static void model_slopes(const Model *model, const Values *values, Scratch *scratch, int co_simulation,
                         const double direction[ROOM(COLUMNS)], double slopes[ROOM(ROWS)]);

/* What there is to warn of, as bits, and the text of one of them. */
static int model_warnings(const Model *model);
static void model_say_warning(const Model *model, const Values *values, int warning, char text[TEXT]);

/* Zero crossings at which model exchange must end a step, `INDICATORS` of them. */
static void model_indicators(const Model *model, double indicators[]);

#endif
