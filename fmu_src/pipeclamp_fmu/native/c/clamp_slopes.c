/* Directional derivatives of a clamp's last step: exact, but where the motion turned round in it. */

/* Derivatives of the tracked A (mm) and f (Hz) by y (mm) and v (mm/s) at the end of the step, where they aren't held. */
static void tracker_slopes(const Memory *memory, const Values *values, double slope[2][2])
{
    const Conditions *conditions = &memory->conditions;
    const double *averages = conditions->averages;
    const double gain = memory->share * memory->share; /* of both stages */
    const double variance = averages[3] - averages[1] * averages[1];
    const double by_y = gain * 2 * (now(memory)->y - averages[1]), by_v = gain * 2 * now(memory)->v;
    memset(slope, 0, 4 * sizeof(double));
    if (conditions->u[0] > values->range[0][0] && conditions->u[0] < values->range[0][1])
        slope[0][0] = by_y / conditions->u[0];
    if (conditions->u[0] > 0 && conditions->u[1] > values->range[1][0] && conditions->u[1] < values->range[1][1]) {
        slope[1][0] = -0.5 * conditions->u[1] * by_y / variance;
        slope[1][1] = 0.5 * conditions->u[1] * by_v / averages[5];
    }
}

enum { BY = 2 + LAW_CONDITIONS }; /* y, v, conditions */

/* Force and heat (N, N mm) of the last step, or how they change. */
typedef struct {
    double force, heat;
} Answered;

static const double DIFFERENCE = 1e-6; /* share of their sizes by which inputs and conditions are moved at most */

static double along(const double slopes[BY], const double change[BY])
{
    double sum = 0.0;
    int i;
    for (i = 0; i < BY; i++)
        sum += slopes[i] * change[i];
    return sum;
}

/* Force and heat change as y, v and the conditions in use do, in a step without a turn. */
static Answered slopes_straight_on(const Model *model, const double used[LAW_CONDITIONS], const double change[BY])
{
    const Memory *memory = &model->memory;
    const Place *end = now(memory), *from = &memory->places[!memory->now];
    const double h = memory->h, move = end->y - from->y;
    const Middle middle = middle_of(from, end, h);
    double law[2 * BY], old[2 * BY], by[2 * BY], still[BY], there[BY], result[2], unused[ROOM(LAW_STATES)];
    double before, beyond, change_beyond;
    Answered changes;
    memcpy(still, change, sizeof still);
    still[0] = still[1] = 0.0; /* the place that the step began from stays where it is */
    law_slopes(parameters(model), used, from->z, from->y, end->y, end->v, h, law);
    law_slopes(parameters(model), used, from->z, from->y, from->y, from->v, 0.0, old);
    before = along(old, still);
    changes.force = along(law, change);
    changes.heat = 0.5 * ((before + changes.force) * move + (from->force + end->force) * change[0])
                   - (along(law + BY, change) - along(old + BY, still));
    if (middle.weight == 0.0)
        return changes;
    memcpy(there, change, sizeof there);
    there[0] = 0.5 * change[0] - 0.125 * h * change[1];
    there[1] = 1.5 * change[0] / h - 0.25 * change[1];
    law_step(memory->k, from->z, from->y, middle.y, middle.v, 0.5 * h, result, unused);
    law_slopes(parameters(model), used, from->z, from->y, middle.y, middle.v, 0.5 * h, by);
    beyond = result[0] - (from->force + (end->force - from->force) * middle.share);
    change_beyond = along(by, there) - before - (changes.force - before) * middle.share
                    - (end->force - from->force) * (there[0] - middle.share * change[0]) / move;
    changes.heat += change_beyond * middle.weight + beyond * (0.8 * change[0] - h * change[1] / 15.0);
    return changes;
}

/* Take the last step again, so far along a direction in y, v and the conditions in use. */
static Answered taken_again(const Model *model, const double used[LAW_CONDITIONS], const double change[BY], double far)
{
    const Memory *memory = &model->memory;
    const Place *end = now(memory);
    Place from = memory->places[!memory->now], to = {0.0, 0.0, 0.0, 0.0, {0.0}};
    double moved[LAW_CONDITIONS], k[ROOM(LAW_HELD)] = {0}, result[2], unused[ROOM(LAW_STATES)], length;
    Answered answer;
    int i, turned;
    to.y = end->y + far * change[0];
    to.v = end->v + far * change[1];
    for (i = 0; i < LAW_CONDITIONS; i++)
        moved[i] = used[i] + far * change[2 + i];
    law_coefficients(parameters(model), moved, k);
    law_step(k, from.z, from.y, from.y, from.v, 0.0, result, unused);
    from.force = result[0];
    from.energy = result[1];
    answer.heat = walk(k, &from, &to, memory->h, &length, &turned);
    answer.force = to.force;
    return answer;
}

/* The same where the motion turned round: the place of the turn moves with y and v, and the memory with that. Central
 * differences, which err by some 1e-9 of the force over the size of what is moved. */
static Answered slopes_round_a_turn(const Model *model, const double used[LAW_CONDITIONS], const double change[BY])
{
    const Memory *memory = &model->memory;
    const Place *end = now(memory), *from = &memory->places[!memory->now];
    const double speed = fabs(from->v) + fabs(end->v);
    double size[BY], most = 0.0;
    Answered ahead, behind, changes = {0.0, 0.0};
    int i;
    size[0] = fabs(end->y - from->y) + memory->h * speed;
    size[1] = speed;
    for (i = 0; i < LAW_CONDITIONS; i++)
        size[2 + i] = used[i] != 0.0 ? fabs(used[i]) : 1.0;
    for (i = 0; i < BY; i++)
        most = fmax(most, fabs(change[i]) / size[i]);
    if (most == 0.0)
        return changes;
    ahead = taken_again(model, used, change, DIFFERENCE / most);
    behind = taken_again(model, used, change, -DIFFERENCE / most);
    changes.force = (ahead.force - behind.force) * most / (2.0 * DIFFERENCE);
    changes.heat = (ahead.heat - behind.heat) * most / (2.0 * DIFFERENCE);
    return changes;
}

static void model_slopes(const Model *model, const Values *values, Scratch *scratch, int co_simulation,
                         const double direction[ROOM(COLUMNS)], double slopes[ROOM(ROWS)])
{
    const Memory *memory = &model->memory;
    double used[LAW_CONDITIONS], tracker[2][2], change[BY];
    Answered changes;
    int i;
    (void)scratch;
    (void)co_simulation;
    in_use(&memory->conditions, values, used);
    /* How y, v and the conditions in use change. */
    change[0] = MM * direction[S];
    change[1] = MM * direction[V];
    for (i = 0; i < LAW_CONDITIONS; i++)
        change[2 + i] = CONDITION_SCALES[i] * direction[A + i];
    if (model->flag[USE_T_IN])
        change[4] = direction[T_IN];
    if (memory->conditions.tracking) {
        tracker_slopes(memory, values, tracker);
        for (i = 0; i < 2; i++)
            change[2 + i] = tracker[i][0] * change[0] + tracker[i][1] * change[1];
    }
    changes = (memory->turned ? slopes_round_a_turn : slopes_straight_on)(model, used, change);
    slopes[FORCE - FIRST_OUTPUT] = changes.force;
    slopes[A_USED - FIRST_OUTPUT] = change[2] / MM;
    slopes[F_USED - FIRST_OUTPUT] = change[3];
    slopes[T_USED - FIRST_OUTPUT] = change[4];
    slopes[DISSIPATED - FIRST_OUTPUT] = 0.001 * changes.heat;
    slopes[DEVIATION - FIRST_OUTPUT] = 0.0; /* it stands still between reversals */
}
