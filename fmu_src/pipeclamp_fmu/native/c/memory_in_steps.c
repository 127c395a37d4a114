/* Model exchange of a clamp whose memory moves on with completed steps: an evaluation is a step from the last of them. */
#include "no_states.c"

static void show_states(Model *model)
{
    (void)model;
}

static int model_evaluate(Model *model, const Values *values, Scratch *scratch, double time, double h,
                          char reason[TEXT])
{
    return model_step(model, values, scratch, time, h, reason);
}
