/*
 * The same algorithms as in the FMUs, written in plain C: what this arithmetic costs without Rust, without an FMU's checks and
 * without any parameter that could be something else. `benches/common/peer.rs` compiles it with the C compiler at hand and
 * measures it beside ours.
 *
 *   plant       the modal step of order 8 (grasp-plant/src/modal/): 16 blocks of equal arms, the rigid motion, 9 signals, travel and work
 *   paper       a step of NABFC with the paper's law (grasp-control/src/laws/nabfc/) and held inputs: 5^3, 5^3 and 29 nodes
 *
 * Vectors of four are those of GCC and Clang, which make what the processor has of them.
 */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#ifdef __AVX__
#include <immintrin.h>
#endif

typedef double four __attribute__((vector_size(32), aligned(8)));
typedef int64_t four_bits __attribute__((vector_size(32), aligned(8)));
/* How a call went, as an importer is told. */
enum { OK, DISCARD = 2 };
#define ALWAYS static inline __attribute__((always_inline))
/* Lanes of two vectors. Clang has only its own name for it, GCC before 12 only the other. */
#ifdef __clang__
#define SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (four_bits){__VA_ARGS__})
#endif

ALWAYS four all(double x) { return (four){x, x, x, x}; }
ALWAYS four choose(four_bits which, four yes, four no) {
    return (four)(((four_bits)yes & which) | ((four_bits)no & ~which));
}
#ifdef __AVX__
ALWAYS four within(four x, double limit) { return _mm256_min_pd(_mm256_max_pd(x, all(-limit)), all(limit)); }
#else
ALWAYS four within(four x, double limit) {
    x = choose(x < all(-limit), all(-limit), x);
    return choose(x > all(limit), all(limit), x);
}
#endif
ALWAYS four magnitude(four x) { return (four)((four_bits)x & ~(four_bits)all(-0.0)); }
ALWAYS four greater(four x, four y) {
#ifdef __AVX__
    return _mm256_max_pd(x, y);
#else
    return choose(x > y, x, y);
#endif
}
ALWAYS four least(four x, four y) {
#ifdef __AVX__
    return _mm256_min_pd(x, y);
#else
    return choose(x < y, x, y);
#endif
}
ALWAYS four last(four x, double y) {
    x[3] = y;
    return x;
}
ALWAYS double sum(four x) { return (x[0] + x[1]) + (x[2] + x[3]); }
ALWAYS double clamp(double x, double limit) { return x < -limit ? -limit : x > limit ? limit : x; }

/* ---- exponentials, four at a time ---- */

/* tanh x from e^y - 1 with y = -2|x|. */
ALWAYS four tanh4(four x) {
    const double round = 0x1.8p52;
    four y = within(-2.0 * magnitude(x), 708.0);
    four shifted = y * 1.4426950408889634 + round;
    four k = shifted - round;
    four r = (y - k * 6.931471803691238e-1) - k * 1.9082149292705877e-10;
    four r2 = r * r, r4 = r2 * r2;
    four even = (0.5 + r2 * (1.0 / 24)) + r4 * ((1.0 / 720 + r2 * (1.0 / 40320)) + r4 * (1.0 / 3628800 + r2 * (1.0 / 479001600)));
    four odd = (1.0 / 6 + r2 * (1.0 / 120)) + r4 * ((1.0 / 5040 + r2 * (1.0 / 362880)) + r4 * (1.0 / 39916800 + r2 * (1.0 / 6227020800.0)));
    four power = (four)(((four_bits)shifted << 52) + (four_bits)all(1.0));
    four rest = (power - 1.0) + power * (r + r2 * (even + r * odd));
    four size = magnitude(rest / (2.0 + rest));
    return (four)((four_bits)size | ((four_bits)x & (four_bits)all(-0.0)));
}

struct powers { four up, down; };

/* 2^x and 2^-x, |x| <= 1020: with x = k + r, 2^r - 1 is the sum of an even and an odd polynomial, 2^-r - 1 their difference. */
ALWAYS struct powers powers(four x) {
    const double round = 0x1.8p52;
    four shifted = x + round;
    four r = x - (shifted - round);
    four r2 = r * r, r4 = r2 * r2;
    four even = r2 * ((0.24022650695910075 + r2 * 0.009618129107618665) +
                      r4 * ((0.00015403530424776529 + r2 * 1.3215451633221434e-06) + r4 * 7.070977866508138e-09));
    four odd = (0.6931471805599453 + r2 * 0.05550410866482158) + r4 * ((0.0013333558146423213 + r2 * 1.5252733820795803e-05) +
                                                        r4 * (1.0178067267449427e-07 + r2 * 4.45410341058704e-10));
    four_bits k = (four_bits)shifted << 52, one = (four_bits)all(1.0);
    odd *= r;
    return (struct powers){(1.0 + (even + odd)) * (four)(one + k), (1.0 + (even - odd)) * (four)(one - k)};
}

/* ---- plant ---- */

/* Fours of blocks: half the order. Of equal arms half of them move both arms alike, and the others each against the other. */
#ifndef GROUPS
#define GROUPS 4
#endif
enum { HALF = (GROUPS + 1) / 2 };
/* Signals that every step reads, by kind; steps without a look at the numbers, as many as ours makes of 0.1 ms; numbers far from being unusable. */
enum { EVEN_ROWS = 5, ODD_ROWS = 4, STEPS = 26 };
#define CALM 1e40

struct even { four increment[2][2], gain[2][2], travel[2][2]; };
struct odd { four increment[2][2], gain[2][1], travel[1][2]; };

/* Fours begin where registers do: `peer.rs` gives such memory. */
struct plant {
    struct even even[HALF];
    struct odd odd[HALF];
    four even_row[HALF][EVEN_ROWS][2], odd_row[HALF][ODD_ROWS][2], rigid_signal;
    four z[2][HALF][2];
    double in[3], out[12];
    four by_zeta, by_force[3], place, carry; /* Behind what is carried, the work. */
    double zeta, rigid_object, limit[3];
    unsigned calm;
};

static void block(four increment[2][2], int lane, double w, double h) {
    double decay = exp(-0.05 * w * h);
    increment[0][0][lane] = increment[1][1][lane] = decay * cos(w * h) - 1;
    increment[0][1][lane] = decay * sin(w * h);
    increment[1][0][lane] = -decay * sin(w * h);
}

/* Stable numbers of the right size: each block turns and decays. */
void *plant_new(struct plant *p, double h) {
    memset(p, 0, sizeof *p);
    for (int g = 0; g < HALF; g++)
        for (int lane = 0; lane < 4; lane++) {
            block(p->even[g].increment, lane, 20.0 * (1 + 8 * g + 2 * lane), h);
            block(p->odd[g].increment, lane, 20.0 * (2 + 8 * g + 2 * lane), h);
            for (int c = 0; c < 2; c++) {
                for (int f = 0; f < 2; f++) {
                    p->even[g].gain[c][f][lane] = 1e-3 * h * sin(1 + f + 3 * c + 5 * lane + 7 * g);
                    p->even[g].travel[f][c][lane] = 1e-2 * h * cos(1 + f + 3 * c + 5 * lane + 7 * g);
                }
                p->odd[g].gain[c][0][lane] = 1e-3 * h * sin(3 + 3 * c + 5 * lane + 7 * g);
                p->odd[g].travel[0][c][lane] = 1e-2 * h * cos(3 + 3 * c + 5 * lane + 7 * g);
                for (int row = 0; row < EVEN_ROWS; row++) p->even_row[g][row][c][lane] = cos(1 + row + 11 * c + 13 * lane + g);
                for (int row = 0; row < ODD_ROWS; row++) p->odd_row[g][row][c][lane] = cos(6 + row + 11 * c + 13 * lane + g);
            }
        }
    p->rigid_signal = (four){0.1, 0.1, 0, 0};
    p->rigid_object = 0.1;
    p->by_zeta = (four){0.5 * h, 0.1 * h, 0, 0};
    for (int f = 0; f < 3; f++) {
        p->by_force[f] = f == 2 ? (four){0, 0, 1e-6 * h, 0} : (four){1e-6 * h, 1e-6 * h, 0, 1e-2 * h};
        p->limit[f] = f == 2 ? 0.3 : 2.0;
    }
    return p;
}

ALWAYS four kept(four x) { return (four)((four_bits)x & (magnitude(x) >= all(0x1p-511))); }

/* The sum of the lanes of each. */
ALWAYS four sums(four a, four b, four c, four d) {
#ifdef __AVX__
    four left = _mm256_hadd_pd(a, b), right = _mm256_hadd_pd(c, d);
    return (four)_mm256_permute2f128_pd(left, right, 0x20) + (four)_mm256_permute2f128_pd(left, right, 0x31);
#else
    return (four){sum(a), sum(b), sum(c), sum(d)};
#endif
}

/* Whether all numbers of the state are far from being unusable. */
static __attribute__((noinline)) int calm(const struct plant *p) {
    four size = magnitude((four){p->zeta, 0, 0, 0}) + magnitude(p->place) + magnitude(p->carry);
    for (int kind = 0; kind < 2; kind++)
        for (int g = 0; g < HALF; g++) size += magnitude(p->z[kind][g][0]) + magnitude(p->z[kind][g][1]);
    return sum(size) < CALM;
}

/* One coordinate of four blocks after the step; what all numbers have in common is kept. */
ALWAYS void move(four *z, four change, four_bits *common) {
    *z += change;
    *common &= (four_bits)*z;
}

int plant_step(struct plant *p, double time, double h) {
    (void)time;
    double force[3];
    if (!(fabs(p->in[0]) + fabs(p->in[1]) + fabs(p->in[2]) < CALM)) return DISCARD;
    if (p->calm == 0) {
        if (!calm(p)) return DISCARD;
        p->calm = STEPS;
    }
    p->calm--;
    for (int f = 0; f < 3; f++) force[f] = clamp(p->in[f], p->limit[f]);
    four f0 = all(force[0]), f1 = all(force[1]), f2 = all(force[2]), both = f0 + f1, opposite = f0 - f1;
    four turn = all(0), rise = all(0), apart = all(0), even[EVEN_ROWS], odd[ODD_ROWS];
    four_bits common = ~(four_bits)all(0);
    for (int g = 0; g < HALF; g++) {
        four *z = p->z[0][g], x = z[0], y = z[1];
        const struct even *e = &p->even[g];
        turn += e->travel[0][0] * x + e->travel[0][1] * y;
        rise += e->travel[1][0] * x + e->travel[1][1] * y;
        for (int c = 0; c < 2; c++)
            move(z + c, (e->increment[c][0] * x + e->increment[c][1] * y) + (e->gain[c][0] * both + e->gain[c][1] * f2), &common);
    }
    for (int g = 0; g < HALF; g++) {
        four *z = p->z[1][g], x = z[0], y = z[1];
        const struct odd *o = &p->odd[g];
        apart += o->travel[0][0] * x + o->travel[0][1] * y;
        for (int c = 0; c < 2; c++) move(z + c, (o->increment[c][0] * x + o->increment[c][1] * y) + o->gain[c][0] * opposite, &common);
    }
    /* Half the sum of both hubs, the object, half their difference; zeta. */
    four travel = sums(turn, rise, apart, all(0)) +
                  ((p->by_zeta * p->zeta + p->by_force[0] * both) + (p->by_force[1] * f2 + p->by_force[2] * opposite));
    /* Of both hubs and the object; zeta; work. */
    travel = SHUFFLE(travel, travel, 0, 0, 1, 3) + SHUFFLE(travel, travel, 2, 2, 2, 2) * (four){1, -1, 0, 0};
    p->zeta += travel[3];
    double work = (force[0] * travel[0] + force[1] * travel[1]) + force[2] * travel[2];
    four by = p->carry + last(travel, work), place = p->place + by;
    p->carry = last(by - (place - p->place), by[3]);
    p->place = place;
    /* A number that has this bit is not negligible. */
    common &= (four_bits){1LL << 61, 1LL << 61, 1LL << 61, 1LL << 61};
    if (!(common[0] & common[1] & common[2] & common[3]))
        for (int kind = 0; kind < 2; kind++)
            for (int g = 0; g < HALF; g++) p->z[kind][g][0] = kept(p->z[kind][g][0]), p->z[kind][g][1] = kept(p->z[kind][g][1]);
    for (int r = 0; r < EVEN_ROWS; r++) even[r] = all(0);
    for (int r = 0; r < ODD_ROWS; r++) odd[r] = all(0);
    for (int g = 0; g < HALF; g++) {
        four x = p->z[0][g][0], y = p->z[0][g][1];
        for (int r = 0; r < EVEN_ROWS; r++) even[r] += p->even_row[g][r][0] * x + p->even_row[g][r][1] * y;
    }
    for (int g = 0; g < HALF; g++) {
        four x = p->z[1][g][0], y = p->z[1][g][1];
        for (int r = 0; r < ODD_ROWS; r++) odd[r] += p->odd_row[g][r][0] * x + p->odd_row[g][r][1] * y;
    }
    four alike = sums(even[0], even[1], even[2], even[3]), against = sums(odd[0], odd[1], odd[2], odd[3]);
    four one = alike + against, other = alike - against;
    four first = SHUFFLE(one, other, 0, 4, 2, 6) + p->rigid_signal * p->zeta, last = SHUFFLE(one, other, 1, 5, 3, 7);
    p->out[0] = p->place[0], p->out[1] = p->place[1], p->out[4] = p->place[2];
    p->out[2] = first[0], p->out[3] = first[1], p->out[10] = first[2], p->out[11] = first[3];
    p->out[5] = sum(even[4]) + p->rigid_object * p->zeta;
    for (int i = 0; i < 4; i++) p->out[6 + i] = last[i];
    return OK;
}

/* ---- controller, the paper's law ---- */

enum { NODES = 5, ROW = 6 };

/* decay and weights of dx/dt = a phi - a sigma x: held, and sampled at two points. */
struct law { double decay, held, sampled[2]; };

static const double node[2] = {0.2113248654051871, 0.7886751345948129};

static double phi1(double z) { return z == 0 ? 1 : -expm1(-z) / z; }
static double phi2(double z) {
    if (z > 0.5) return (1 - phi1(z)) / z;
    double sum = 0;
    for (int n = 13; n >= 0; n--) sum = (1 - z * sum) / (n + 2);
    return sum;
}
static struct law law(double gain, double leakage, double h) {
    double z = gain * leakage * h, mean = phi1(z), moment = phi2(z), scale = gain * h / (node[1] - node[0]);
    return (struct law){exp(-z), gain * h * mean, {scale * (node[1] * mean - moment), scale * (moment - node[0] * mean)}};
}

/* Gains of a loop: switching, k, slope (sum of two), virtual control, width of tanh. */
struct loop {
    double xi, k, slope, c, steep, inertia;
    struct law weights, bounds, inertias;
};

/* Lanes are the loops: hub 1, hub 2, nothing, object; of `follow` the points of a step. A law's second weight is zero for the hubs. */
struct lanes {
    four xi, k, slope, steep, error, surface, alpha, reach, step, square, follow;
    four bounds[3], inertias[3];
    four target;
};

/* Heights of the Gaussians beside the middle and beyond, where there is an axis; reach, and in powers of two 1/b^2 and 2 spacing/b^2. */
struct axis { four near[2], far[2]; double reach, least, sharpness, step; };

struct hub {
    struct loop loop;
    four w[NODES][ROW], w_line;
    double w_middle;
};

struct object {
    struct loop loop;
    double scale[7], compliance[2], by_alpha[2], by_own[2], origin;
    four w_still[4], w_moving[4];
};

struct paper {
    double in[12], out[3];
    struct lanes lanes;
    four bound, inertia;
    struct axis grid, star;
    struct hub hub[2];
    struct object object;
    double lambda, sat, filter[2], bandwidth;
};

static struct axis axis(double width, double farthest) {
    double sharpness = 1 / (width * width), near = exp(-0.25 * sharpness), far = exp(-sharpness);
    four three = {1, 1, 1, 0};
    return (struct axis){{all(near), near * three}, {all(far), far * three}, farthest + 8.4 * width, exp(-pow(farthest / width + 8.4, 2)),
                         1.4426950408889634 * sharpness, 1.4426950408889634 * sharpness};
}

static struct loop loop(const double **g, double h) {
    const double *v = *g;
    struct loop l = {v[0], v[1], v[2] + v[3], v[3], 1 / v[4], v[11], law(v[5], v[6], h), law(v[7], v[8], h), law(v[9], v[10], h)};
    *g += 12;
    return l;
}

/* Gains: object, hub 1, hub 2 (12 each), then what `peer.rs` lists. */
void *paper_new(struct paper *p, double h, const double *g) {
    memset(p, 0, sizeof *p);
    p->object.loop = loop(&g, h);
    for (int i = 0; i < 2; i++) p->hub[i].loop = loop(&g, h);
    p->sat = *g++;
    p->bandwidth = *g++;
    p->grid = axis(*g++, sqrt(3));
    p->star = axis(*g++, 1);
    const int which[7] = {0, 1, 2, 3, 3, 4, 4};
    for (int i = 0; i < 7; i++) p->object.scale[i] = 1 / g[which[i]];
    struct lanes *l = &p->lanes;
    const double *scale = p->object.scale;
    struct loop *loops[4] = {&p->hub[0].loop, &p->hub[1].loop, &p->object.loop, &p->object.loop};
    for (int i = 0; i < 4; i++) {
        struct loop *loop = loops[i];
        int hub = i < 2;
        struct axis *axis = hub ? &p->grid : &p->star;
        l->xi[i] = loop->xi, l->k[i] = loop->k, l->slope[i] = loop->slope, l->steep[i] = loop->steep, p->inertia[i] = loop->inertia;
        l->error[i] = hub ? 1 / g[5] : scale[0], l->surface[i] = hub ? 1 / g[6] : scale[1], l->alpha[i] = hub ? -loop->c / g[7] : 0;
        l->reach[i] = axis->reach, l->step[i] = axis->step, l->square[i] = hub ? -axis->sharpness : 0;
        for (int k = 0; k < 2; k++) {
            struct law *law = k ? &loop->inertias : &loop->bounds;
            four *to = k ? l->inertias : l->bounds;
            to[0][i] = law->decay, to[1][i] = hub ? law->held : law->sampled[0], to[2][i] = hub ? 0 : law->sampled[1];
        }
    }
    g += 8;
    double ei1 = g[0], ei2 = g[1], length = g[2], width = g[3], theta = g[5];
    p->lambda = g[4];
    for (int i = 0; i < 2; i++) {
        double compliance = 1 / g[i];
        p->object.compliance[i] = compliance, p->object.by_alpha[i] = -compliance * scale[2], p->object.by_own[i] = compliance * scale[5 + i];
    }
    four target = {theta, theta + length * length / 3 * (ei1 + ei2) / (ei1 * ei2) * p->lambda, 0,
                   length * theta + length * length * length / (3 * ei1) * p->lambda + 0.5 * width};
    l->target = target;
    for (int i = 0; i < 4; i++) l->follow[i] = -expm1(-p->bandwidth * h * (i < 2 ? node[i] : 1));
    return p;
}

/* exp(-(x - c)^2/b^2)/exp(-x^2/b^2) of the nodes but for the middle, from exp(2x spacing/b^2). */
ALWAYS void ratios(const struct axis *a, int last, struct powers e, four ratio[4]) {
    ratio[0] = a->far[last] * e.down * e.down;
    ratio[1] = a->near[last] * e.down;
    ratio[2] = a->near[last] * e.up;
    ratio[3] = a->far[last] * e.up * e.up;
}

/* Rows to columns. */
ALWAYS void turn(const four r[4], four c[4]) {
    four lo = SHUFFLE(r[0], r[1], 0, 4, 2, 6), hi = SHUFFLE(r[0], r[1], 1, 5, 3, 7);
    four lo2 = SHUFFLE(r[2], r[3], 0, 4, 2, 6), hi2 = SHUFFLE(r[2], r[3], 1, 5, 3, 7);
    c[0] = SHUFFLE(lo, lo2, 0, 1, 4, 5), c[1] = SHUFFLE(hi, hi2, 0, 1, 4, 5);
    c[2] = SHUFFLE(lo, lo2, 2, 3, 6, 7), c[3] = SHUFFLE(hi, hi2, 2, 3, 6, 7);
}

ALWAYS double common(const struct axis *a, struct powers e) { return e.up[3] > a->least ? e.up[3] : 0; }

/* A grid learns; four sums that make up its output. */
ALWAYS four grid(struct hub *hub, const struct axis *a, double s, struct powers e) {
    four r[4], c[4], inner[ROW];
    ratios(a, 1, e, r);
    double middle = common(a, e), decay = hub->loop.weights.decay, gain = hub->loop.weights.held * s;
    /* Nodes 0, 1, 3, 4 of each axis side by side. */
    turn(r, c);
    four outer = c[0] * middle;
    for (int i = 0; i < 4; i++) inner[i] = c[1][i] * c[2];
    inner[4] = c[2], inner[5] = c[1];
    hub->w_line = decay * hub->w_line + gain * outer;
    hub->w_middle = decay * hub->w_middle + gain * middle;
    four sums = hub->w_line * outer;
    sums[0] += hub->w_middle * middle;
    for (int row = 0; row < NODES; row++) {
        double factor = row < 4 ? outer[row] : middle;
        four by = all(gain * factor), of_row = all(0);
        for (int j = 0; j < ROW; j++) {
            four w = decay * hub->w[row][j] + by * inner[j];
            hub->w[row][j] = w;
            of_row += w * inner[j];
        }
        sums += factor * of_row;
    }
    return sums;
}

int paper_step(struct paper *p, double time, double h) {
    (void)time;
    /* One by one, as they have just been set: where two are read at once, a processor waits until both are in its cache. */
    double in[12];
    for (int i = 0; i < 12; i++) in[i] = ((const volatile double *)p->in)[i];
    const struct lanes *l = &p->lanes;
    struct object *o = &p->object;
    four error = (four){in[0], in[1], 0, in[4]} - l->target, velocity = {in[2], in[3], 0, in[5]};
    four s = l->slope * error + velocity, regressor = l->slope * velocity;
    s = last(s, s[3] + ((in[8] - p->lambda) * o->compliance[0] + (in[9] + p->lambda) * o->compliance[1]));

    /* Inputs of the networks by component: clamped, squares, exponents; then turned into one column for each. */
    four row[4] = {error * l->error, s * l->surface, last(l->alpha * velocity, in[8] * o->compliance[0] * o->scale[3]),
                   {0, 0, 0, in[9] * o->compliance[1] * o->scale[4]}}, column[4];
    for (int i = 0; i < 4; i++) row[i] = greater(least(row[i], l->reach), -l->reach);
    four square = (row[0] * row[0] + row[1] * row[1]) + (row[2] * row[2] + row[3] * row[3]);
    for (int i = 0; i < 4; i++) row[i] *= l->step;
    row[3] += greater(square * l->square, all(-1020));
    turn(row, column);
    /* Both before the weights, of which there are too many for a processor to look beyond them. */
    struct powers e1 = powers(column[0]), e2 = powers(column[1]);
    four of_hub[2] = {grid(&p->hub[0], &p->grid, s[0], e1), grid(&p->hub[1], &p->grid, s[1], e2)};

    /* What the shear rates move, with the two points of the step and its end in lanes. */
    four rate[2], turned[4];
    for (int k = 0; k < 2; k++) rate[k] = p->filter[k] + (in[10 + k] - p->filter[k]) * l->follow;
    p->filter[0] = rate[0][2], p->filter[1] = rate[1][2];
    four regressors = l->slope[3] * in[5] + (o->compliance[0] * rate[0] + o->compliance[1] * rate[1]);
    row[0] = -o->loop.c * in[5] * o->scale[2] + (o->by_alpha[0] * rate[0] + o->by_alpha[1] * rate[1]);
    row[1] = o->by_own[0] * rate[0], row[2] = o->by_own[1] * rate[1];
    for (int i = 0; i < 3; i++) row[i] = within(row[i], p->star.reach);
    row[3] = greater(-p->star.sharpness * (square[3] + ((row[0] * row[0] + row[1] * row[1]) + row[2] * row[2])), all(-1020));
    for (int i = 0; i < 3; i++) row[i] *= p->star.step;
    turn(row, turned);
    four still[4], moving[3][4];
    double factor[3];
    ratios(&p->star, 0, powers(column[3]), still);
    for (int i = 0; i < 3; i++) {
        struct powers e = powers(turned[i]);
        factor[i] = common(&p->star, e);
        ratios(&p->star, 1, e, moving[i]);
    }
    const struct law *w = &o->loop.weights;
    double first = w->sampled[0] * s[3] * factor[0], second = w->sampled[1] * s[3] * factor[1];
    o->origin = w->decay * o->origin + (first + second);
    four of_star = {o->origin, 0, 0, 0};
    for (int j = 0; j < 4; j++) {
        o->w_still[j] = w->decay * o->w_still[j] + (first + second) * still[j];
        o->w_moving[j] = w->decay * o->w_moving[j] + (first * moving[0][j] + second * moving[1][j]);
        of_star += o->w_still[j] * still[j] + o->w_moving[j] * moving[2][j];
    }
    four output = sums(of_hub[0], of_hub[1], all(0), factor[2] * of_star);

    /* Estimates and commands. */
    four t = tanh4(s * l->steep), drive = s * t;
    p->bound = l->bounds[0] * p->bound + l->bounds[1] * drive + l->bounds[2] * drive;
    p->inertia = l->inertias[0] * p->inertia + l->inertias[1] * (s * last(regressor, regressors[0])) +
                 l->inertias[2] * (s * last(regressor, regressors[1]));
    four command = -l->xi * within(s, p->sat) - l->k * s - error + (four){in[6], in[7], 0, in[8] + in[9]} - output - p->bound * t -
                   p->inertia * last(regressor, regressors[2]);
    p->out[0] = command[0], p->out[1] = command[1], p->out[2] = command[3];
    return OK;
}

/* ---- access by value reference, as an importer asks for it ---- */

int plant_set(struct plant *p, const unsigned *vr, size_t n, const double *x) { for (size_t i = 0; i < n; i++) p->in[vr[i]] = x[i]; return OK; }
int plant_get(struct plant *p, const unsigned *vr, size_t n, double *x) { for (size_t i = 0; i < n; i++) x[i] = p->out[vr[i]]; return OK; }
int paper_set(struct paper *p, const unsigned *vr, size_t n, const double *x) { for (size_t i = 0; i < n; i++) p->in[vr[i]] = x[i]; return OK; }
int paper_get(struct paper *p, const unsigned *vr, size_t n, double *x) { for (size_t i = 0; i < n; i++) x[i] = p->out[vr[i]]; return OK; }
size_t plant_size(void) { return sizeof(struct plant); }
size_t paper_size(void) { return sizeof(struct paper); }
