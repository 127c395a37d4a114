/* A model without continuous states. */

static void model_get_states(const Model *model, double states[])
{
    (void)model;
    (void)states;
}

static void model_set_states(Model *model, const double states[])
{
    (void)model;
    (void)states;
}

static void model_derivatives(const Model *model, double derivatives[])
{
    (void)model;
    (void)derivatives;
}
