/* A model of which nothing is beyond its range, and without zero crossings at which steps must end. */

static int model_within_range(const Model *model)
{
    (void)model;
    return 1;
}

static void model_say_range(const Model *model, const Values *values, char text[TEXT])
{
    (void)model;
    (void)values;
    (void)text;
}

static void model_indicators(const Model *model, double indicators[])
{
    (void)model;
    (void)indicators;
}
