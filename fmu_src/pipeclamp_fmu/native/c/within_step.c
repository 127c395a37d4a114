/* The way between two communication points: where it turns round, and the work on it. The counterpart of within_step.py.
 *
 * The motion is the cubic that has displacement and velocity of both ends (Hermite). Where the velocity changes sign it
 * turns round once, and is walked in two ways, so that memory unloads from where the motion did. The heat of a way takes
 * the law's force in its middle too, beside that of both ends; it is exact where the force is linear in the displacement.
 */
static const double EDGE = 1e-6; /* share of a step next to its ends in which it doesn't turn: see within_step.py */

/* Of a motion's velocity over the share x of its step: that at the beginning and b x + a x^2. */
typedef struct {
    double b, a;
} Bends;

static inline Bends bends(const Place *from, const Place *to, double h)
{
    const double mean = (to->y - from->y) / h;
    const Bends bent = {2.0 * (3.0 * mean - 2.0 * from->v - to->v), 3.0 * (from->v + to->v - 2.0 * mean)};
    return bent;
}

/* Give the displacement after a share of a step. */
static inline double part_of(const Place *from, Bends bent, double h, double share)
{
    return from->y + h * share * (from->v + share * (bent.b / 2.0 + share * (bent.a / 3.0)));
}

/* Give where a motion turns round whose velocity changes sign: returns the share of the step, and the displacement. */
APART static double turning(const Place *from, const Place *to, double h, double *turn)
{
    const double sign = from->v > 0.0 ? 1.0 : -1.0; /* so that it begins above 0 */
    const Bends bent = bends(from, to, h);
    const double c = sign * from->v, b = sign * bent.b, a = sign * bent.a;
    const double inside = b * b - 4.0 * a * c, root = inside > 0.0 ? sqrt(inside) : 0.0;
    const double share = b > 0.0 ? (b + root) / (-2.0 * a) : 2.0 * c / (root - b);
    *turn = part_of(from, bent, h, share);
    return share;
}

/* What the heat of a way takes of its middle. */
typedef struct {
    double y, v;   /* there */
    double share;  /* of the move that has been made there */
    double weight; /* of what the force is beyond a straight line there, mm; 0 where the middle counts for nothing */
} Middle;

static inline Middle middle_of(const Place *from, const Place *to, double h)
{
    const double move = to->y - from->y, bent = h * (from->v - to->v);
    Middle middle = {0.0, 0.0, 0.0, 0.0};
    if (!(fabs(bent) < 4.0 * fabs(move) && h > 0.0)) /* it doesn't lie between the ends */
        return middle;
    middle.y = 0.5 * (from->y + to->y) + 0.125 * bent;
    middle.v = 1.5 * move / h - 0.25 * (from->v + to->v);
    middle.share = (middle.y - from->y) / move;
    middle.weight = 0.8 * move - h * (from->v + to->v) / 15.0;
    return middle;
}

/* Walk a way on which the motion doesn't turn round, from a place to another's displacement and velocity; returns the
 * heat, N mm. */
WITHIN static inline double walk_on(const double k[], const Place *from, Place *to, double h)
{
    const Middle middle = middle_of(from, to, h);
    double result[2], unused[ROOM(LAW_STATES)], lost;
    law_step(k, from->z, from->y, to->y, to->v, h, result, to->z);
    to->force = result[0];
    to->energy = result[1];
    lost = 0.5 * (from->force + to->force) * (to->y - from->y) - (to->energy - from->energy);
    if (middle.weight != 0.0) {
        law_step(k, from->z, from->y, middle.y, middle.v, 0.5 * h, result, unused);
        lost += (result[0] - (from->force + (to->force - from->force) * middle.share)) * middle.weight;
    }
    return lost;
}

/* Give where a step turns round, at a share of it that is returned, with the law's answer and the heat (N mm) there. */
APART static double walk_to_turn(const double k[], const Place *from, const Place *to, double h, Place *turn,
                                 double *lost)
{
    const double at = turning(from, to, h, &turn->y);
    if (!(EDGE < at && at < 1.0 - EDGE))
        return 0.0;
    turn->v = 0.0;
    *lost = walk_on(k, from, turn, at * h);
    return at;
}

/* Walk a way on which the motion may turn round once, from a place to another's displacement and velocity; returns the
 * heat, N mm, with the length of the way in mm and whether it turned. */
WITHIN static inline double round_turn(const double k[], const Place *from, Place *to, double h, double *length,
                                       int *turned)
{
    Place turn;
    double lost = 0.0;
    *turned = 0;
    *length = 0.0;
    if (from->v * to->v < 0.0 && h > 0.0) {
        const double at = walk_to_turn(k, from, to, h, &turn, &lost);
        if (at > 0.0) {
            *turned = 1;
            *length = fabs(turn.y - from->y);
            from = &turn;
            h *= 1.0 - at;
        }
    }
    *length += fabs(to->y - from->y);
    return lost + walk_on(k, from, to, h);
}

/* Walk a step in parts along the cubic, for memory that jumps: it does so at the end of a way. */
static double in_parts(const double k[], const Place *from, Place *to, double h, double *length)
{
    const Bends bent = bends(from, to, h);
    Place at = *from;
    double lost = 0.0;
    int part;
    *length = 0.0;
    for (part = 1; part <= PARTS; part++) {
        const double share = (double)part / PARTS;
        Place next = *to;
        double way;
        int turned;
        if (part < PARTS) {
            next.y = part_of(from, bent, h, share);
            next.v = from->v + share * (bent.b + share * bent.a);
        }
        lost += round_turn(k, &at, &next, h / PARTS, &way, &turned);
        *length += way;
        at = next;
    }
    *to = at;
    return lost;
}

/* Walk a step from a place to another's displacement and velocity; returns the heat, N mm, with the length of the way in
 * mm and whether it was more ways than one. */
WITHIN static inline double walk(const double k[], const Place *from, Place *to, double h, double *length, int *turned)
{
    if (PARTS == 1 || !(h > 0.0) || (from->v == 0.0 && to->v == 0.0))
        return round_turn(k, from, to, h, length, turned);
    *turned = 1;
    return in_parts(k, from, to, h, length);
}
