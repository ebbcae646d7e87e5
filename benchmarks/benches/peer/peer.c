/*
 * The same algorithms as in the FMUs, written in plain C: what this arithmetic costs without Rust, without an FMU's checks and
 * without any parameter that could be something else. `benches/common/peer.rs` compiles it with the C compiler at hand and
 * measures it beside ours.
 *
 *   plant       the modal step of order 8 (grasp-plant/src/modal/): 16 blocks, the rigid motion, 12 signals, travel and work
 *   paper       a step of NABFC with the paper's law (grasp-control/src/laws/nabfc/) and held inputs: 5^3, 5^3 and 29 nodes
 *
 * Vectors of four are those of GCC and Clang, which make what the processor has of them.
 */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef double four __attribute__((vector_size(32), aligned(8)));
typedef int64_t four_bits __attribute__((vector_size(32), aligned(8)));
#define ALWAYS static inline __attribute__((always_inline))

ALWAYS four all(double x) { return (four){x, x, x, x}; }
ALWAYS four above(four x, double least) { return (four)((four_bits)x & (x > all(least))); }
ALWAYS four choose(four_bits which, four yes, four no) {
    return (four)(((four_bits)yes & which) | ((four_bits)no & ~which));
}
ALWAYS four within(four x, double limit) {
    x = choose(x < all(-limit), all(-limit), x);
    return choose(x > all(limit), all(limit), x);
}
ALWAYS four magnitude(four x) { return (four)((four_bits)x & ~(four_bits)all(-0.0)); }
ALWAYS double sum(four x) { return (x[0] + x[1]) + (x[2] + x[3]); }
ALWAYS double clamp(double x, double limit) { return x < -limit ? -limit : x > limit ? limit : x; }

/* ---- exponentials, four at a time ---- */

struct parts { four power, rest; };

ALWAYS struct parts parts(four x) {
    const double round = 0x1.8p52;
    x = within(x, 708.0);
    four shifted = x * 1.4426950408889634 + round;
    four k = shifted - round;
    four r = (x - k * 6.931471803691238e-1) - k * 1.9082149292705877e-10;
    four r2 = r * r, r4 = r2 * r2;
    four even = (0.5 + r2 * (1.0 / 24)) + r4 * ((1.0 / 720 + r2 * (1.0 / 40320)) + r4 * (1.0 / 3628800 + r2 * (1.0 / 479001600)));
    four odd = (1.0 / 6 + r2 * (1.0 / 120)) + r4 * ((1.0 / 5040 + r2 * (1.0 / 362880)) + r4 * (1.0 / 39916800 + r2 * (1.0 / 6227020800.0)));
    four power = (four)(((four_bits)shifted << 52) + (four_bits)all(1.0));
    return (struct parts){power, r + r2 * (even + r * odd)};
}
ALWAYS four exp4(four x) {
    struct parts p = parts(x);
    return p.power + p.power * p.rest;
}
ALWAYS four tanh4(four x) {
    struct parts p = parts(-2.0 * magnitude(x));
    four rest = (p.power - 1.0) + p.power * p.rest;
    four size = magnitude(rest / (2.0 + rest));
    return (four)((four_bits)size | ((four_bits)x & (four_bits)all(-0.0)));
}

/* ---- plant ---- */

/* Fours of blocks: half the order. */
#ifndef GROUPS
#define GROUPS 4
#endif
enum { SIGNALS = 3 };

struct plant {
    double in[3], out[12];
    four increment[GROUPS][2][2], gain[GROUPS][2][3], position[GROUPS][2][3];
    four signal[GROUPS][8][SIGNALS], rigid_signal[SIGNALS];
    four z[GROUPS][2];
    double zeta, rigid_gain[3], rigid_velocity, rigid_drift[3], length, place[3], work, limit[3];
};

/* Stable numbers of the right size: each block turns and decays. */
void *plant_new(struct plant *p, double h) {
    memset(p, 0, sizeof *p);
    for (int g = 0; g < GROUPS; g++)
        for (int lane = 0; lane < 4; lane++) {
            double w = 20.0 * (1 + 4 * g + lane) * h, decay = exp(-0.05 * w);
            p->increment[g][0][0][lane] = decay * cos(w) - 1;
            p->increment[g][0][1][lane] = decay * sin(w);
            p->increment[g][1][0][lane] = -decay * sin(w);
            p->increment[g][1][1][lane] = decay * cos(w) - 1;
            for (int f = 0; f < 3; f++)
                for (int c = 0; c < 2; c++) {
                    p->gain[g][c][f][lane] = 1e-3 * h * sin(1 + f + 3 * c + 5 * lane + 7 * g);
                    p->position[g][c][f][lane] = 1e-2 * cos(1 + f + 3 * c + 5 * lane + 7 * g);
                }
            for (int c = 0; c < 2; c++)
                for (int row = 0; row < SIGNALS; row++)
                    for (int s = 0; s < 4; s++) p->signal[g][4 * c + lane][row][s] = cos(1 + s + 4 * row + 11 * c + 13 * lane + g);
        }
    for (int row = 0; row < SIGNALS; row++) p->rigid_signal[row] = all(0.1);
    for (int f = 0; f < 3; f++) p->rigid_gain[f] = 1e-2, p->rigid_drift[f] = 1e-6, p->limit[f] = f == 2 ? 0.3 : 2.0;
    p->rigid_velocity = 0.1;
    p->length = 0.2;
    return p;
}

ALWAYS four kept(four x) { return (four)((four_bits)x & (magnitude(x) >= all(1e-150))); }

void plant_step(struct plant *p, double h) {
    double force[3], total[3], turned[3];
    for (int f = 0; f < 3; f++) force[f] = clamp(p->in[f], p->limit[f]);
    four f0 = all(force[0]), f1 = all(force[1]), f2 = all(force[2]);
    four rise[3] = {all(0), all(0), all(0)}, left[SIGNALS], right[SIGNALS], usable = all(0);
    for (int row = 0; row < SIGNALS; row++) left[row] = right[row] = all(0);
    for (int g = 0; g < GROUPS; g++) {
        four z0 = p->z[g][0], z1 = p->z[g][1];
        for (int c = 0; c < 2; c++) {
            four change = (p->increment[g][c][0] * z0 + p->increment[g][c][1] * z1) +
                          ((p->gain[g][c][0] * f0 + p->gain[g][c][1] * f1) + p->gain[g][c][2] * f2);
            four next = kept((c ? z1 : z0) + change);
            p->z[g][c] = next;
            usable += 1e208 * next;
            for (int f = 0; f < 3; f++) rise[f] += p->position[g][c][f] * change;
        }
        for (int lane = 0; lane < 4; lane++) {
            four x = all(p->z[g][0][lane]), y = all(p->z[g][1][lane]);
            for (int row = 0; row < SIGNALS; row++) {
                left[row] += p->signal[g][lane][row] * x;
                right[row] += p->signal[g][4 + lane][row] * y;
            }
        }
    }
    for (int f = 0; f < 3; f++) total[f] = sum(rise[f]);
    double push = p->rigid_gain[0] * force[0] + p->rigid_gain[1] * force[1] + p->rigid_gain[2] * force[2];
    double drift = p->rigid_drift[0] * force[0] + p->rigid_drift[1] * force[1] + p->rigid_drift[2] * force[2];
    total[2] += h * (p->rigid_velocity * (p->zeta + 0.5 * h * push) + drift);
    p->zeta += h * push;
    turned[0] = (total[0] + total[2]) / p->length;
    turned[1] = (total[1] + total[2]) / p->length;
    turned[2] = total[2];
    four zeta = all(p->zeta), signal[SIGNALS];
    for (int row = 0; row < SIGNALS; row++) {
        signal[row] = (left[row] + right[row]) + p->rigid_signal[row] * zeta;
        usable += 1e208 * signal[row];
    }
    for (int f = 0; f < 3; f++) {
        p->work += force[f] * turned[f];
        p->place[f] += turned[f];
    }
    if (!isfinite(sum(usable) + p->work)) return;
    p->out[0] = p->place[0], p->out[1] = p->place[1], p->out[4] = p->place[2];
    p->out[2] = signal[0][0], p->out[3] = signal[0][1], p->out[5] = signal[0][2];
    for (int i = 0; i < 6; i++) p->out[6 + i] = signal[1 + i / 4][i % 4];
}

/* ---- controller, the paper's law ---- */

enum { NODES = 5, ROW = 7 };

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
    double xi, k, slope, c, width, inertia, bound;
    struct law weights, bounds, inertias;
};

/* Height of the Gaussians, reach, 1/b^2 and spacing/b^2. */
struct axis { double height[NODES], reach, sharpness, step; };

struct hub {
    struct loop loop;
    double scale[3];
    four w[NODES][ROW], inner[ROW];
    double outer[NODES], s, tanh, regressor, e, output;
};

struct object {
    struct loop loop;
    double scale[7], compliance[2];
    four w[9], y[2][9], still;
    double s, tanh;
};

struct paper {
    double in[12], out[3];
    struct axis grid, star;
    struct hub hub[2];
    struct object object;
    double target[3], lambda, sat, filter[2], follow[3], bandwidth;
};

static struct axis axis(double width) {
    struct axis a = {{0}, 1 + 1.01 * width * sqrt(-log(1e-30)), 1 / (width * width), 0.5 / (width * width)};
    for (int i = 0; i < NODES; i++) a.height[i] = exp(-pow((i - 2) * 0.5, 2) * a.sharpness);
    return a;
}

static struct loop loop(const double **g, double h) {
    const double *v = *g;
    struct loop l = {v[0], v[1], v[2] + v[3], v[3], v[4], v[11], 0, law(v[5], v[6], h), law(v[7], v[8], h), law(v[9], v[10], h)};
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
    p->grid = axis(*g++);
    p->star = axis(*g++);
    const int which[7] = {0, 1, 2, 3, 3, 4, 4};
    for (int i = 0; i < 7; i++) p->object.scale[i] = 1 / g[which[i]];
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++) p->hub[i].scale[k] = 1 / g[5 + k];
    g += 8;
    double ei1 = g[0], ei2 = g[1], l = g[2], width = g[3], theta = g[5];
    p->lambda = g[4];
    p->object.compliance[0] = 1 / ei1, p->object.compliance[1] = 1 / ei2;
    p->target[0] = theta;
    p->target[1] = theta + l * l / 3 * (ei1 + ei2) / (ei1 * ei2) * p->lambda;
    p->target[2] = l * theta + l * l * l / (3 * ei1) * p->lambda + 0.5 * width;
    for (int i = 0; i < 3; i++) p->follow[i] = -expm1(-p->bandwidth * h * (i < 2 ? node[i] : 1));
    return p;
}

/* exp(-(x - c)^2/b^2)/exp(-x^2/b^2) of the nodes, from exp(x step/b^2). */
ALWAYS void ratios(const struct axis *a, four half, four ratio[NODES]) {
    four up = half * half, down = 1.0 / up;
    ratio[0] = down * down * a->height[0], ratio[1] = down * a->height[1], ratio[2] = all(1);
    ratio[3] = up * a->height[3], ratio[4] = up * up * a->height[4];
}

ALWAYS void fill_grid(struct hub *hub, const struct axis *a, four scale, four half) {
    four ratio[NODES];
    double first[NODES], second[NODES], *inner = (double *)hub->inner;
    ratios(a, half, ratio);
    for (int i = 0; i < NODES; i++) {
        four value = above(scale * ratio[i], 1e-30);
        hub->outer[i] = value[0], first[i] = value[1], second[i] = value[2];
    }
    for (int i = 0; i < NODES; i++)
        for (int j = 0; j < NODES; j++) inner[NODES * i + j] = first[i] * second[j];
}

ALWAYS void fill_star(four y[9], const struct axis *a, four still, four moving) {
    double common = moving[3] > 1e-200 ? moving[3] : 0;
    four ratio[NODES], scale[2] = {all(common), {common, common, common, 0}}, half[2] = {still, moving};
    y[0] = (four){common > 1e-30 ? common : 0, 0, 0, 0};
    for (int group = 0; group < 2; group++) {
        ratios(a, half[group], ratio);
        for (int i = 0; i < NODES; i++)
            if (i != 2) y[1 + 2 * (i > 2 ? i - 1 : i) + group] = above(scale[group] * ratio[i], 1e-30);
    }
}

/* s Y of the object: the axes that the shear rates move are in the second four. */
ALWAYS four moving_exponents(const struct object *o, const struct axis *a, four still, double z_dot, const double rate[2], double *regressor) {
    double w1 = rate[0] * o->compliance[0], w2 = rate[1] * o->compliance[1];
    *regressor = o->loop.slope * z_dot + (w1 + w2);
    four x = {(-o->loop.c * z_dot - (w1 + w2)) * o->scale[2], w1 * o->scale[5], w2 * o->scale[6], 0};
    x = within(x, a->reach);
    four exponent = x * a->step;
    exponent[3] = -sum(still * still + x * x) * a->sharpness;
    return exponent;
}

void paper_step(struct paper *p, double h) {
    const double *in = p->in;
    struct object *o = &p->object;
    double rate[3][2], regressor[3], z = in[4] - p->target[2], z_dot = in[5];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++) rate[i][k] = p->filter[k] + (in[10 + k] - p->filter[k]) * p->follow[i];
    double w1 = in[8] * o->compliance[0], w2 = in[9] * o->compliance[1];
    o->s = o->loop.slope * z + z_dot + (in[8] - p->lambda) * o->compliance[0] + (in[9] + p->lambda) * o->compliance[1];
    for (int i = 0; i < 2; i++) {
        struct hub *hub = &p->hub[i];
        hub->e = in[i] - p->target[i];
        hub->s = hub->loop.slope * hub->e + in[2 + i];
        hub->regressor = in[2 + i] * hub->loop.slope;
    }
    four t = tanh4((four){o->s / o->loop.width, p->hub[0].s / p->hub[0].loop.width, p->hub[1].s / p->hub[1].loop.width, 0});
    o->tanh = t[0], p->hub[0].tanh = t[1], p->hub[1].tanh = t[2];
    four still = within((four){z * o->scale[0], o->s * o->scale[1], w1 * o->scale[3], w2 * o->scale[4]}, p->star.reach);
    four moving[3];
    for (int i = 0; i < 3; i++) moving[i] = exp4(moving_exponents(o, &p->star, still, z_dot, rate[i], &regressor[i]));
    four still_e = exp4(still * p->star.step);
    for (int i = 0; i < 2; i++) {
        struct hub *hub = &p->hub[i];
        four x = within((four){hub->e * hub->scale[0], hub->s * hub->scale[1], -hub->loop.c * in[2 + i] * hub->scale[2], 0}, p->grid.reach);
        fill_grid(hub, &p->grid, exp4(x * x * -p->grid.sharpness), exp4(x * p->grid.step));
    }
    fill_star(o->y[0], &p->star, still_e, moving[0]);
    fill_star(o->y[1], &p->star, still_e, moving[1]);
    for (int i = 0; i < 2; i++) {
        struct hub *hub = &p->hub[i];
        struct loop *l = &hub->loop;
        four decay = all(l->weights.decay), sums = all(0);
        for (int row = 0; row < NODES; row++) {
            four by = all(l->weights.held * hub->s * hub->outer[row]), of_row = all(0);
            for (int j = 0; j < ROW; j++) {
                hub->w[row][j] = decay * hub->w[row][j] + by * hub->inner[j];
                of_row += hub->w[row][j] * hub->inner[j];
            }
            sums += hub->outer[row] * of_row;
        }
        hub->output = sum(sums);
        l->bound = l->bounds.decay * l->bound + l->bounds.held * (hub->s * hub->tanh);
        l->inertia = l->inertias.decay * l->inertia + l->inertias.held * (hub->s * hub->regressor);
        p->out[i] = -l->xi * clamp(hub->s, p->sat) - l->k * hub->s - hub->e - l->inertia * hub->regressor + in[6 + i] - hub->output -
                    l->bound * hub->tanh;
    }
    struct loop *l = &o->loop;
    four first = all(l->weights.sampled[0] * o->s), second = all(l->weights.sampled[1] * o->s), sums = all(0);
    for (int j = 0; j < 9; j++) o->w[j] = l->weights.decay * o->w[j] + first * o->y[0][j] + second * o->y[1][j];
    l->bound = l->bounds.decay * l->bound + (l->bounds.sampled[0] + l->bounds.sampled[1]) * (o->s * o->tanh);
    l->inertia = l->inertias.decay * l->inertia + l->inertias.sampled[0] * (o->s * regressor[0]) + l->inertias.sampled[1] * (o->s * regressor[1]);
    p->filter[0] = rate[2][0], p->filter[1] = rate[2][1];
    fill_star(o->y[0], &p->star, still_e, moving[2]);
    for (int j = 0; j < 9; j++) sums += o->w[j] * o->y[0][j];
    p->out[2] = -l->xi * clamp(o->s, p->sat) - l->k * o->s - z + in[8] + in[9] - sum(sums) - l->bound * o->tanh - l->inertia * regressor[2];
}

/* ---- access by value reference, as an importer asks for it ---- */

void plant_set(struct plant *p, const unsigned *vr, size_t n, const double *x) { for (size_t i = 0; i < n; i++) p->in[vr[i]] = x[i]; }
void plant_get(struct plant *p, const unsigned *vr, size_t n, double *x) { for (size_t i = 0; i < n; i++) x[i] = p->out[vr[i]]; }
void paper_set(struct paper *p, const unsigned *vr, size_t n, const double *x) { for (size_t i = 0; i < n; i++) p->in[vr[i]] = x[i]; }
void paper_get(struct paper *p, const unsigned *vr, size_t n, double *x) { for (size_t i = 0; i < n; i++) x[i] = p->out[vr[i]]; }
size_t plant_size(void) { return sizeof(struct plant); }
size_t paper_size(void) { return sizeof(struct paper); }
