/* A model that warns of nothing, and without zero crossings at which steps must end. */

static int model_warnings(const Model *model)
{
    (void)model;
    return 0;
}

static void model_say_warning(const Model *model, const Values *values, int warning, char text[TEXT])
{
    (void)model;
    (void)values;
    (void)warning;
    (void)text;
}

static void model_indicators(const Model *model, double indicators[])
{
    (void)model;
    (void)indicators;
}
