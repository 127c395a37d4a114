/* Amplitude and frequency of a clamp's own motion, cycle by cycle, and how far the force is off if it was told others.
 * The counterpart of own_motion.py, which says what the numbers are for.
 */
enum { SAMPLES = 16, LASTING = 20 };
static const double LIMIT = 0.05;   /* share of the force by which A and f may be off before it is said */
static const double WHOLE = 0.75;   /* periods of its own frequency after which a reversal ends a cycle */
static const double LONGEST = 3.0;  /* such periods; in a longer cycle the clamp stood still */
static const double REST = 0.01;    /* share of the law's smallest amplitude below which a motion passes for rest */
static const double STEADY = 0.05;  /* share by which A and f of a steady motion change from cycle to cycle */

static int near(double value, double other, double share, double size)
{
    return fabs(value - other) <= share * size;
}

/* Whether the law's coefficients differ at the corners of its range of A and f from the present ones. */
static int depends_on_motion(const Model *model, const Values *values)
{
    double used[LAW_CONDITIONS], k[ROOM(LAW_HELD)] = {0};
    int corner, i;
    memcpy(used, model->memory.conditions.u, sizeof used);
    for (corner = 0; corner < 4; corner++) {
        used[0] = values->range[0][corner & 1];
        used[1] = values->range[1][corner >> 1];
        law_coefficients(parameters(model), used, k);
        for (i = 0; i < LAW_HELD; i++)
            if (k[i] != model->memory.k[i])
                return 1;
    }
    return 0;
}

/* Begin to look at the motion anew. */
static void forget_motion(Model *model)
{
    memset(&model->memory.own, 0, sizeof model->memory.own);
    model->real[DEVIATION] = 0.0;
}

/* Give A (mm), f (Hz) and mean (mm) of a cycle that ends at this reversal; 0 where it goes on. f is 0 where the clamp
 * stood still in it. */
static int ended(const OwnMotion *own, double *amplitude, double *frequency, double *mean)
{
    double variance, periods;
    *mean = own->y / own->time;
    variance = own->square / own->time - *mean * *mean;
    if (!(variance > 0.0))
        return 0;
    *amplitude = sqrt(2.0 * variance);
    *frequency = sqrt(own->speed / (own->time * variance)) / (2.0 * PI);
    periods = own->time * *frequency;
    if (periods * *amplitude < WHOLE * fmax(*amplitude, own->amplitude / 2.0))
        return 0;
    if (!(periods <= LONGEST))
        *frequency = 0.0;
    return 1;
}

/* Whether forces were last compared for the present coefficients along this motion, to a fifth of the limit. */
static int compared_already(const Memory *memory, double amplitude, double frequency, double mean)
{
    const OwnMotion *own = &memory->own;
    const double share = 0.2 * LIMIT;
    int i, same = own->compared;
    for (i = 0; i < LAW_HELD; i++)
        same = same && own->compared_k[i] == memory->k[i];
    return same && near(amplitude, own->compared_with[0], share, amplitude)
           && near(frequency, own->compared_with[1], share, frequency)
           && near(mean, own->compared_with[2], share, amplitude);
}

/* The rms difference of the whole force with coefficients k from that with those of the motion's A and f, as a share of
 * the latter's rms, along the second cycle from rest of the motion's sinusoid; 0 where the law has no value on it. */
static double force_deviation(const Model *model, const Values *values, double amplitude, double frequency, double mean)
{
    const double h = 1.0 / (SAMPLES * frequency), speed = 2.0 * PI * frequency * amplitude;
    const double *const k[2] = {model->memory.k, NULL};
    double used[LAW_CONDITIONS], own[ROOM(LAW_HELD)], z[2][ROOM(LAW_STATES)], after[ROOM(LAW_STATES)], result[2][2];
    double before = mean, difference = 0.0, size = 0.0;
    int n, i;
    memcpy(used, model->memory.conditions.u, sizeof used);
    used[0] = held(amplitude, values->range[0]);
    used[1] = held(frequency, values->range[1]);
    law_coefficients(parameters(model), used, own);
    for (i = 0; i < 2; i++)
        memcpy(z[i], law_rest, LAW_STATES * sizeof law_rest[0]);
    for (n = 1; n <= 2 * SAMPLES; n++) {
        const double theta = 2.0 * PI * n / SAMPLES;
        const double y = mean + amplitude * sin(theta), v = speed * cos(theta);
        for (i = 0; i < 2; i++) {
            law_step(k[i] ? k[i] : own, z[i], before, y, v, h, result[i], after);
            memcpy(z[i], after, LAW_STATES * sizeof after[0]);
        }
        before = y;
        if (n > SAMPLES) {
            difference += (result[0][0] - result[1][0]) * (result[0][0] - result[1][0]);
            size += result[1][0] * result[1][0];
        }
    }
    return size > 0.0 && difference < INFINITY ? sqrt(difference / size) : 0.0;
}

/* At a reversal of the motion: where it ends a cycle, tell how far the force is off for the A and f told. */
APART static void turn_round(Model *model, const Values *values)
{
    OwnMotion *own = &model->memory.own;
    const double amplitude_before = own->amplitude, frequency_before = own->frequency;
    double amplitude = 0.0, frequency = 0.0, mean = 0.0;
    int steady;
    if (own->begun && !ended(own, &amplitude, &frequency, &mean))
        return;
    own->begun = 1;
    own->time = own->y = own->square = own->speed = 0.0;
    own->amplitude = amplitude;
    if (!(frequency > 0.0 && amplitude >= REST * values->range[0][0])) {
        own->frequency = 0.0;
        own->off = own->compared = own->said = 0;
        model->real[DEVIATION] = 0.0;
        return;
    }
    own->frequency = frequency;
    if (!compared_already(&model->memory, amplitude, frequency, mean)) {
        own->compared = 1;
        own->compared_with[0] = amplitude;
        own->compared_with[1] = frequency;
        own->compared_with[2] = mean;
        memcpy(own->compared_k, model->memory.k, sizeof own->compared_k);
        model->real[DEVIATION] = force_deviation(model, values, amplitude, frequency, mean);
    }
    own->off = model->real[DEVIATION] > LIMIT ? own->off + 1 : 0;
    steady = near(amplitude, amplitude_before, STEADY, amplitude) && near(frequency, frequency_before, STEADY, frequency);
    own->said = (own->off >= 2 && steady) || own->off >= LASTING;
}

/* Look at a step of the motion that has ended at y and v. */
static inline void look_at_motion(Model *model, const Values *values, double y, double v, double v_before, double h)
{
    OwnMotion *own = &model->memory.own;
    own->time += h;
    own->y += h * y;
    own->square += h * (y * y);
    own->speed += h * (v * v);
    if ((v < 0.0) != (v_before < 0.0))
        turn_round(model, values);
}

static void say_motion(const Model *model, const Values *values, char text[TEXT])
{
    const OwnMotion *own = &model->memory.own;
    const double *told = model->memory.conditions.u;
    snprintf(text, TEXT,
             "law %s is told A = %.3g mm, f = %.3g Hz, and the motion has A = %.3g mm, f = %.3g Hz: the force is off by "
             "%.1f percent; set A = %.3g m and f = %.3g Hz, or track = true",
             values->name, told[0], told[1], own->amplitude, own->frequency, 100.0 * model->real[DEVIATION],
             held(own->amplitude, values->range[0]) / MM, held(own->frequency, values->range[1]));
}
