/* Model exchange of a clamp whose memory is continuous states: an evaluation depends on nothing that was before it.
 *
 * The states are the law's and the dissipated energy. A state's derivative is that of the law's own step along the
 * motion, for its length towards 0. What an integrator carries beyond where a step of no length leaves it (a slip force)
 * counts no more in the force, and fades along the way.
 */
enum { DISSIPATED_STATE = FIRST_LOCAL + STATES - 1, RATES = FIRST_LOCAL + STATES };

static const double SPAN = 1e-7; /* of the shorter of two steps whose slopes are extrapolated to none, in periods */
static const double FADING = 0.1; /* way in which what lies beyond falls to 1/e, in amplitudes */

static void model_get_states(const Model *model, double states[])
{
    int i;
    for (i = 0; i < STATES; i++)
        states[i] = model->real[FIRST_LOCAL + i];
}

static void model_set_states(Model *model, const double states[])
{
    int i;
    for (i = 0; i < STATES; i++)
        model->real[FIRST_LOCAL + i] = states[i];
}

static void model_derivatives(const Model *model, double derivatives[])
{
    memcpy(derivatives, model->real + RATES, STATES * sizeof derivatives[0]);
}

/* Step ahead along the motion and give the changes per second of the states, then of the stored energy (N mm/s).
 * Returns the length of the step, which is such that the way is the velocity's to the last digit. */
static double slopes_ahead(const double k[], const Place *from, double h, double slopes[LAW_STATES + 1])
{
    const double ahead = from->y + h * from->v, way = ahead - from->y;
    double result[2], z[ROOM(LAW_STATES)];
    int i;
    if (way != 0.0)
        h = way / from->v;
    law_step(k, from->z, from->y, ahead, from->v, h, result, z);
    for (i = 0; i < LAW_STATES; i++)
        slopes[i] = (z[i] - from->z[i]) / h;
    slopes[LAW_STATES] = (result[1] - from->energy) / h;
    return h;
}

static void show_states(Model *model)
{
    const Memory *memory = &model->memory;
    const double *const k = memory->k, span = SPAN / memory->conditions.u[1];
    const Place *place = now(memory);
    double *const rates = model->real + RATES;
    double slopes[2][LAW_STATES + 1], result[2], h[2];
    Place from = *place;
    int i;
    law_step(k, place->z, place->y, place->y, place->v, 0.0, result, from.z);
    for (i = 0; i < 2; i++)
        h[i] = slopes_ahead(k, &from, (i + 1) * span, slopes[i]);
    for (i = 0; i <= LAW_STATES; i++) {
        rates[i] = slopes[1][i];
        if (h[1] > 1.5 * h[0]) /* not so where both ways are the last digit of the displacement */
            rates[i] = (h[1] * slopes[0][i] - h[0] * slopes[1][i]) / (h[1] - h[0]);
    }
    for (i = 0; i < LAW_STATES; i++)
        rates[i] -= (place->z[i] - from.z[i]) * fabs(place->v) / (FADING * MM * model->real[A_USED]);
    rates[LAW_STATES] = 0.001 * (place->force * place->v - rates[LAW_STATES]);
    model->real[DISSIPATED_STATE] = model->real[DISSIPATED];
}

/* Take the parameters that are set, where some have changed since the last completed step. */
static int take_conditions(Model *model, const Values *values, Place *place, char reason[TEXT])
{
    Conditions conditions = {{0}, 0, {0}};
    double k[ROOM(LAW_HELD)] = {0};
    if (model->flag[TRACK]) {
        snprintf(reason, TEXT, "track is true; expected false in model exchange with memory as states, which takes no "
                               "completed steps to average the motion over");
        return 0;
    }
    if (!take_settings(model, conditions.u, reason) || !put_under(place, k, &conditions, model, values, reason))
        return 0;
    memcpy(model->memory.k, k, sizeof k);
    take(model, &conditions, values);
    return 1;
}

static int model_evaluate(Model *model, const Values *values, Scratch *scratch, double time, double h,
                          char reason[TEXT])
{
    Memory *memory = &model->memory;
    Place *const place = &memory->places[memory->now != 0];
    double result[2], unused[ROOM(LAW_STATES)];
    int settled = model->settled && fabs(MM * model->real[S]) < HUGE_NUMBER && fabs(MM * model->real[V]) < HUGE_NUMBER;
    (void)scratch;
    (void)time;
    (void)h;
    place->y = MM * model->real[S];
    place->v = MM * model->real[V];
    memcpy(place->z, model->real + FIRST_LOCAL, LAW_STATES * sizeof place->z[0]);
    if (!settled && !take_conditions(model, values, place, reason))
        return 0;
    law_step(memory->k, place->z, place->y, place->y, place->v, 0.0, result, unused);
    if (!isfinite(result[0] + result[1])) {
        snprintf(reason, TEXT, "the law has no value there");
        return 0;
    }
    place->force = result[0];
    place->energy = result[1];
    model->real[DISSIPATED] = model->real[DISSIPATED_STATE];
    show_motion(model, values);
    return 1;
}
