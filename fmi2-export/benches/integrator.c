/* The integrator of examples/two_models.rs as it is written in C by hand, after the pattern of Modelica's Reference-FMUs: a mask of
 * states for each function, a switch over the value references, values computed when they are asked for. What the benchmark
 * `call_cost` compares with. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

enum { OK = 0, DISCARD = 2, ERROR = 3 };
enum { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8 };

typedef struct {
    int state;
    int is_dirty;
    int stop_defined;
    double time;
    double stop;
    double u;
    double y;
    double x;
} Instance;

#define BEGIN(mask) \
    Instance *s = c; \
    if (!s || !(s->state & (mask))) return ERROR

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *functions, int visible,
                      int logging) {
    (void)resources; (void)visible; (void)logging;
    if (!name || !*name || type != 1 || !guid || !functions) return NULL;
    Instance *s = calloc(1, sizeof *s);
    if (s) { s->state = INSTANTIATED; s->is_dirty = 1; }
    return s;
}

void fmi2FreeInstance(void *c) { free(c); }

int fmi2SetupExperiment(void *c, int tolerance_defined, double tolerance, double start, int stop_defined, double stop) {
    BEGIN(INSTANTIATED);
    (void)tolerance_defined; (void)tolerance;
    s->time = start;
    s->stop_defined = stop_defined;
    s->stop = stop;
    return OK;
}

int fmi2EnterInitializationMode(void *c) { BEGIN(INSTANTIATED); s->state = INITIALIZATION; return OK; }
int fmi2ExitInitializationMode(void *c) { BEGIN(INITIALIZATION); s->x = 0; s->state = STEPPING; return OK; }

static int set(Instance *s, unsigned reference, double value) {
    switch (reference) {
    case 0:
        if (!isfinite(value)) return ERROR;
        s->u = value;
        return OK;
    default:
        return ERROR;
    }
}

static int get(const Instance *s, unsigned reference, double *value) {
    switch (reference) {
    case 0: *value = s->u; return OK;
    case 1: *value = s->y; return OK;
    default: return ERROR;
    }
}

int fmi2SetReal(void *c, const unsigned vr[], size_t n, const double value[]) {
    BEGIN(INSTANTIATED | INITIALIZATION | STEPPING);
    if (n && (!vr || !value)) return ERROR;
    for (size_t i = 0; i < n; i++) {
        int status = set(s, vr[i], value[i]);
        if (status > DISCARD) return status;
    }
    s->is_dirty = 1;
    return OK;
}

int fmi2GetReal(void *c, const unsigned vr[], size_t n, double value[]) {
    BEGIN(INITIALIZATION | STEPPING | TERMINATED);
    if (n && (!vr || !value)) return ERROR;
    if (s->is_dirty) {
        s->y = s->x;
        s->is_dirty = 0;
    }
    for (size_t i = 0; i < n; i++) {
        int status = get(s, vr[i], &value[i]);
        if (status > DISCARD) return status;
    }
    return OK;
}

int fmi2DoStep(void *c, double time, double size, int no_set_state_before) {
    BEGIN(STEPPING);
    (void)no_set_state_before;
    if (!(size > 0) || fabs(time - s->time) > 1e-9 * (1 + fabs(time))) return ERROR;
    if (s->stop_defined && time + size > s->stop * (1 + 1e-9)) return ERROR;
    s->x += s->u * size;
    s->time = time + size;
    s->is_dirty = 1;
    return OK;
}
