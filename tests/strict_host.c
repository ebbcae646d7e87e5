/* A host that takes the standard at its word: any status but fmi2OK ends it (FMI 2.0.4, section 4.2.2).
 *
 *   strict_host < plan
 *
 * The plan is read line by line; slaves are numbered from 0 in the order in which they are given.
 *
 *   slave GUID LIBRARY          an instance; the library is the rest of the line
 *   real S VR VALUE             a start value; also integer
 *   wire FROM VR TO VR          a real output and the real input that follows it
 *   drive STEP S VR VALUE       a real input from this step on; in order of the steps
 *   read S VR                   a real output to print at the end
 *   trace EVERY                 also prints their bits after every so many steps, in hexadecimal
 *   save FILE                   writes the state of slave S to FILE.S in the end
 *   load DONE FILE              goes on from such states, which stand after so many steps
 *   run STEPS SIZE              initialises and runs; the last line
 *
 * Model exchange: what comes after
 *
 *   exchange                    makes the following slaves for it
 *   size S STATES INDICATORS    how many continuous states and event indicators slave S has
 *   integrate STEPS SIZE        initialises and integrates all as one system; the last line instead of `run`
 *
 * Prints the values asked for, one a line, and then the number of warnings the loggers were told. Two other last lines:
 *
 *   panic VR VALUE              slave 0 panics in a step when this integer is set; the host must live on, and the slave
 *                               after a reset
 *   cycles COUNT GUID LIBRARY   loads, runs a step and unloads so many times
 */
#define __USE_MINGW_ANSI_STDIO 1 /* numbers are read and printed exactly on Windows, too */
#include <inttypes.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "loader.h"

typedef void *Component;
typedef unsigned int Reference;
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*free)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct { int again, terminate, nominals, states, has_next_time; double next_time; } EventInfo;

typedef struct {
    Component c;
    void *library;
    /* Of model exchange: where its states are among those of all. */
    size_t states, first, indicators, first_indicator;
    int (*enter_event_mode)(Component);
    int (*new_discrete_states)(Component, EventInfo *);
    int (*enter_continuous_time_mode)(Component);
    int (*completed)(Component, int, int *, int *);
    int (*set_time)(Component, double);
    int (*set_states)(Component, const double *, size_t);
    int (*get_states)(Component, double *, size_t);
    int (*get_derivatives)(Component, double *, size_t);
    int (*get_indicators)(Component, double *, size_t);
    int (*setup)(Component, int, double, double, int, double);
    int (*enter)(Component);
    int (*leave)(Component);
    int (*terminate)(Component);
    int (*get_real)(Component, const Reference *, size_t, double *);
    int (*set_real)(Component, const Reference *, size_t, const double *);
    int (*set_integer)(Component, const Reference *, size_t, const int *);
    int (*step)(Component, double, double, int);
    int (*reset)(Component);
    int (*get_state)(Component, void **);
    int (*set_state)(Component, void *);
    int (*free_state)(Component, void **);
    int (*state_size)(Component, void *, size_t *);
    int (*serialize)(Component, void *, char *, size_t);
    int (*deserialize)(Component, const char *, size_t, void **);
    void (*free)(Component);
} Slave;

typedef struct { int from, to; Reference output, input; } Wire;
typedef struct { long step; int slave; Reference input; double value; } Drive;
typedef struct { int slave; Reference output; } Read;

enum { STATES = 1000, SLAVES = 8, WIRES = 64, DRIVES = 200000, READS = 64 };
static Slave slaves[SLAVES];
static Wire wires[WIRES];
static Drive drives[DRIVES];
static Read reads[READS];
static int slave_count, wire_count, drive_count, read_count, warnings, errors;
static long trace_every, steps_done;
static int exchange;
static size_t state_count, indicator_count;
static char save_to[4096], load_from[4096];

static void fail(const char *what, double time, int status) {
    fprintf(stderr, "%s at t = %g s: status %d\n", what, time, status);
    exit(1);
}

static void ok(int status, const char *what, double time) {
    if (status != 0) fail(what, time, status);
}

static void hear(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    va_list arguments;
    (void)environment;
    if (status == 1) warnings++;
    if (status <= 1) return;
    errors++;
    fprintf(stderr, "%s: %s: ", instance, category);
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void finished(void *environment, int status) {
    (void)environment;
    fail("stepFinished was called", 0, status);
}

static const Callbacks callbacks = {hear, calloc, free, finished, NULL};

static void *symbol(void *library, const char *name) {
    void *found = find(library, name);
    if (!found) fail(name, 0, -1);
    return found;
}

static void open_slave(const char *path, const char *guid) {
    void *library = load(path);
    Slave *s = &slaves[slave_count];
    char name[16];
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
    if (!library) fail(problem(), 0, -1);
    snprintf(name, sizeof name, "slave %d", slave_count++);
    s->library = library;
    *(void **)&instantiate = symbol(library, "fmi2Instantiate");
    *(void **)&s->setup = symbol(library, "fmi2SetupExperiment");
    *(void **)&s->enter = symbol(library, "fmi2EnterInitializationMode");
    *(void **)&s->leave = symbol(library, "fmi2ExitInitializationMode");
    *(void **)&s->terminate = symbol(library, "fmi2Terminate");
    *(void **)&s->get_real = symbol(library, "fmi2GetReal");
    *(void **)&s->set_real = symbol(library, "fmi2SetReal");
    *(void **)&s->set_integer = symbol(library, "fmi2SetInteger");
    *(void **)&s->step = symbol(library, "fmi2DoStep");
    *(void **)&s->reset = symbol(library, "fmi2Reset");
    *(void **)&s->get_state = symbol(library, "fmi2GetFMUstate");
    *(void **)&s->set_state = symbol(library, "fmi2SetFMUstate");
    *(void **)&s->free_state = symbol(library, "fmi2FreeFMUstate");
    *(void **)&s->state_size = symbol(library, "fmi2SerializedFMUstateSize");
    *(void **)&s->serialize = symbol(library, "fmi2SerializeFMUstate");
    *(void **)&s->deserialize = symbol(library, "fmi2DeSerializeFMUstate");
    *(void **)&s->free = symbol(library, "fmi2FreeInstance");
    if (exchange) {
        *(void **)&s->enter_event_mode = symbol(library, "fmi2EnterEventMode");
        *(void **)&s->new_discrete_states = symbol(library, "fmi2NewDiscreteStates");
        *(void **)&s->enter_continuous_time_mode = symbol(library, "fmi2EnterContinuousTimeMode");
        *(void **)&s->completed = symbol(library, "fmi2CompletedIntegratorStep");
        *(void **)&s->set_time = symbol(library, "fmi2SetTime");
        *(void **)&s->set_states = symbol(library, "fmi2SetContinuousStates");
        *(void **)&s->get_states = symbol(library, "fmi2GetContinuousStates");
        *(void **)&s->get_derivatives = symbol(library, "fmi2GetDerivatives");
        *(void **)&s->get_indicators = symbol(library, "fmi2GetEventIndicators");
    }
    s->c = instantiate(name, exchange ? 0 : 1, guid, "", &callbacks, 0, 1);
    if (!s->c) fail("fmi2Instantiate", 0, -1);
}

/* The file of a slave's state. */
static FILE *state_file(const char *name, int slave, const char *mode) {
    char path[4200];
    FILE *file;
    snprintf(path, sizeof path, "%s.%d", name, slave);
    file = open_file(path, mode);
    if (!file) fail(path, 0, -1);
    return file;
}

static void save(Slave *s, FILE *file) {
    void *state = NULL;
    size_t size;
    char *bytes;
    ok(s->get_state(s->c, &state), "fmi2GetFMUstate", 0);
    ok(s->state_size(s->c, state, &size), "fmi2SerializedFMUstateSize", 0);
    bytes = malloc(size);
    ok(s->serialize(s->c, state, bytes, size), "fmi2SerializeFMUstate", 0);
    if (fwrite(bytes, 1, size, file) != size || fclose(file) != 0) fail("cannot write a state", 0, -1);
    free(bytes);
    ok(s->free_state(s->c, &state), "fmi2FreeFMUstate", 0);
}

static void restore(Slave *s, FILE *file) {
    static char bytes[1 << 20];
    size_t size = fread(bytes, 1, sizeof bytes, file);
    void *state = NULL;
    fclose(file);
    ok(s->deserialize(s->c, bytes, size, &state), "fmi2DeSerializeFMUstate", 0);
    ok(s->set_state(s->c, state), "fmi2SetFMUstate", 0);
    ok(s->free_state(s->c, &state), "fmi2FreeFMUstate", 0);
}

static void start(Slave *s, int has_stop, double stop) {
    ok(s->setup(s->c, 0, 0.0, 0.0, has_stop, stop), "fmi2SetupExperiment", 0);
    ok(s->enter(s->c), "fmi2EnterInitializationMode", 0);
}

/* A step panics, which the slave must catch and say; after a reset it can be used again. */
static void panic(Reference reference, int value) {
    Slave *s = &slaves[0];
    int status, before = errors;
    start(s, 0, 0.0);
    ok(s->leave(s->c), "fmi2ExitInitializationMode", 0);
    ok(s->set_integer(s->c, &reference, 1, &value), "fmi2SetInteger", 0);
    status = s->step(s->c, 0.0, 1e-3, 1);
    if (status != 3 || errors == before) fail("the panic was not reported as fmi2Error", 0, status);
    ok(s->reset(s->c), "fmi2Reset", 0);
    start(s, 0, 0.0);
    ok(s->leave(s->c), "fmi2ExitInitializationMode", 0);
    ok(s->step(s->c, 0.0, 1e-3, 1), "fmi2DoStep", 0);
    s->free(s->c);
    puts("caught");
}

static void cycle(const char *path, const char *guid) {
    Slave *s = &slaves[0];
    slave_count = 0;
    open_slave(path, guid);
    start(s, 0, 0.0);
    ok(s->leave(s->c), "fmi2ExitInitializationMode", 0);
    ok(s->step(s->c, 0.0, 1e-3, 1), "fmi2DoStep", 0);
    s->free(s->c);
    if (!unload(s->library)) fail("the library is not unloaded", 0, -1);
}

/* Hands on what slave `from` puts out. */
static void hand_on(int from, double time) {
    for (int i = 0; i < wire_count; i++) {
        double value;
        if (wires[i].from != from) continue;
        ok(slaves[from].get_real(slaves[from].c, &wires[i].output, 1, &value), "fmi2GetReal", time);
        ok(slaves[wires[i].to].set_real(slaves[wires[i].to].c, &wires[i].input, 1, &value), "fmi2SetReal", time);
    }
}

static double read_value(const Read *read, double time) {
    Slave *s = &slaves[read->slave];
    double value;
    ok(s->get_real(s->c, &read->output, 1, &value), "fmi2GetReal", time);
    return value;
}

/* The bits of all values asked for, in one line. */
static void trace(double time) {
    for (int i = 0; i < read_count; i++) {
        double value = read_value(&reads[i], time);
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        printf("%s%016" PRIx64, i ? " " : "", bits);
    }
    putchar('\n');
}

static void run(long steps, double size) {
    int next = 0;
    /* A saved state remembers the stop time, and is to go on beyond it. */
    int has_stop = !*save_to && !*load_from;
    for (int s = 0; s < slave_count; s++) start(&slaves[s], has_stop, steps * size);
    for (int sweep = 0; sweep < slave_count; sweep++)
        for (int s = 0; s < slave_count; s++) hand_on(s, 0);
    for (int s = 0; s < slave_count; s++) ok(slaves[s].leave(slaves[s].c), "fmi2ExitInitializationMode", 0);
    if (*load_from)
        for (int s = 0; s < slave_count; s++) restore(&slaves[s], state_file(load_from, s, "rb"));
    for (long i = steps_done; i < steps; i++) {
        double time = i * size;
        for (; next < drive_count && drives[next].step <= i; next++) {
            Drive *d = &drives[next];
            ok(slaves[d->slave].set_real(slaves[d->slave].c, &d->input, 1, &d->value), "fmi2SetReal", time);
        }
        for (int s = 0; s < slave_count; s++) hand_on(s, time);
        for (int s = 0; s < slave_count; s++) ok(slaves[s].step(slaves[s].c, time, size, 1), "fmi2DoStep", time);
        if (trace_every && (i + 1) % trace_every == 0) trace(time);
    }
    for (int i = 0; i < read_count; i++) printf("%.17g\n", read_value(&reads[i], steps * size));
    if (*save_to)
        for (int s = 0; s < slave_count; s++) save(&slaves[s], state_file(save_to, s, "wb"));
    for (int s = 0; s < slave_count; s++) {
        ok(slaves[s].terminate(slaves[s].c), "fmi2Terminate", steps * size);
        slaves[s].free(slaves[s].c);
    }
    printf("%d\n", warnings);
}

/* Sets time and states of all, and what they tell each other then. */
static void put(double time, const double *z) {
    for (int i = 0; i < slave_count; i++) {
        Slave *s = &slaves[i];
        ok(s->set_time(s->c, time), "fmi2SetTime", time);
        ok(s->set_states(s->c, z + s->first, s->states), "fmi2SetContinuousStates", time);
    }
    for (int i = 0; i < slave_count; i++) hand_on(i, time);
}

static void rates(double time, const double *z, double *dz) {
    put(time, z);
    for (int i = 0; i < slave_count; i++) {
        Slave *s = &slaves[i];
        ok(s->get_derivatives(s->c, dz + s->first, s->states), "fmi2GetDerivatives", time);
    }
}

/* On which side of zero the event indicators are; whether that is elsewhere than before. */
static int look(int *sides, double time) {
    static double values[STATES];
    int moved = 0;
    for (int i = 0; i < slave_count; i++) {
        Slave *s = &slaves[i];
        ok(s->get_indicators(s->c, values + s->first_indicator, s->indicators), "fmi2GetEventIndicators", time);
    }
    for (size_t i = 0; i < indicator_count; i++) {
        moved |= sides[i] != (values[i] > 0);
        sides[i] = values[i] > 0;
    }
    return moved;
}

/* Brings all discrete states up to date; the slaves are in event mode. */
static void update(double *z, double time) {
    for (int i = 0; i < slave_count; i++) {
        Slave *s = &slaves[i];
        EventInfo info = {1, 0, 0, 0, 0, 0.0};
        while (info.again) {
            ok(s->new_discrete_states(s->c, &info), "fmi2NewDiscreteStates", time);
            if (info.terminate) fail("a slave wants to end", time, 0);
        }
        ok(s->enter_continuous_time_mode(s->c), "fmi2EnterContinuousTimeMode", time);
    }
    for (int i = 0; i < slave_count; i++) hand_on(i, time);
    for (int i = 0; i < slave_count; i++) {
        Slave *s = &slaves[i];
        ok(s->get_states(s->c, z + s->first, s->states), "fmi2GetContinuousStates", time);
    }
}

/* All slaves as one system, by the classical Runge-Kutta method; events at the ends of steps, as the Reference FMUs' fmusim. */
static void integrate(long steps, double h) {
    static double z[STATES], x[STATES], k[4][STATES];
    static int sides[STATES];
    size_t n = state_count;
    int events = 0;
    for (int i = 0; i < slave_count; i++) start(&slaves[i], 1, steps * h);
    for (int i = 0; i < slave_count; i++) hand_on(i, 0);
    for (int i = 0; i < slave_count; i++) ok(slaves[i].leave(slaves[i].c), "fmi2ExitInitializationMode", 0);
    update(z, 0);
    look(sides, 0);
    for (long step = 0; step < steps; step++) {
        double time = step * h;
        int event;
        rates(time, z, k[0]);
        for (size_t i = 0; i < n; i++) x[i] = z[i] + h / 2 * k[0][i];
        rates(time + h / 2, x, k[1]);
        for (size_t i = 0; i < n; i++) x[i] = z[i] + h / 2 * k[1][i];
        rates(time + h / 2, x, k[2]);
        for (size_t i = 0; i < n; i++) x[i] = z[i] + h * k[2][i];
        rates(time + h, x, k[3]);
        for (size_t i = 0; i < n; i++) z[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
        put(time + h, z);
        event = look(sides, time + h);
        for (int i = 0; i < slave_count; i++) {
            int wants_event = 0, wants_end = 0;
            ok(slaves[i].completed(slaves[i].c, 1, &wants_event, &wants_end), "fmi2CompletedIntegratorStep", time + h);
            if (wants_end) fail("a slave wants to end", time + h, 0);
            event |= wants_event;
        }
        if (event) {
            for (int i = 0; i < slave_count; i++)
                ok(slaves[i].enter_event_mode(slaves[i].c), "fmi2EnterEventMode", time + h);
            update(z, time + h);
            look(sides, time + h);
            events++;
        }
        if (trace_every && (step + 1) % trace_every == 0) trace(time + h);
    }
    for (int i = 0; i < slave_count; i++) {
        ok(slaves[i].terminate(slaves[i].c), "fmi2Terminate", steps * h);
        slaves[i].free(slaves[i].c);
    }
    printf("%d\n", events);
}

/* How many states and event indicators a slave has. */
static void set_size(int slave, unsigned states, unsigned indicators) {
    Slave *s = &slaves[slave];
    s->states = states, s->first = state_count, state_count += states;
    s->indicators = indicators, s->first_indicator = indicator_count, indicator_count += indicators;
    if (state_count > STATES || indicator_count > STATES) fail("too many states", 0, -1);
}

int main(void) {
    static char line[4096], path[4096], guid[64];
    int slave, integer;
    unsigned states, indicators;
    long count;
    double value;
    while (fgets(line, sizeof line, stdin)) {
        Wire *w = &wires[wire_count];
        Drive *d = &drives[drive_count];
        Read *r = &reads[read_count];
        Reference reference;
        if (sscanf(line, "slave %63s %4095[^\r\n]", guid, path) == 2 && slave_count < SLAVES) {
            open_slave(path, guid);
        } else if (sscanf(line, "real %d %u %lf", &slave, &reference, &value) == 3) {
            ok(slaves[slave].set_real(slaves[slave].c, &reference, 1, &value), "fmi2SetReal", 0);
        } else if (sscanf(line, "integer %d %u %d", &slave, &reference, &integer) == 3) {
            ok(slaves[slave].set_integer(slaves[slave].c, &reference, 1, &integer), "fmi2SetInteger", 0);
        } else if (sscanf(line, "wire %d %u %d %u", &w->from, &w->output, &w->to, &w->input) == 4
                   && wire_count < WIRES - 1) {
            wire_count++;
        } else if (sscanf(line, "drive %ld %d %u %lf", &d->step, &d->slave, &d->input, &d->value) == 4
                   && drive_count < DRIVES - 1) {
            drive_count++;
        } else if (sscanf(line, "read %d %u", &r->slave, &r->output) == 2 && read_count < READS - 1) {
            read_count++;
        } else if (sscanf(line, "trace %ld", &trace_every) == 1
                   || sscanf(line, "save %4095[^\r\n]", save_to) == 1
                   || sscanf(line, "load %ld %4095[^\r\n]", &steps_done, load_from) == 2) {
            continue;
        } else if (sscanf(line, "panic %u %d", &reference, &integer) == 2 && slave_count == 1) {
            panic(reference, integer);
            return 0;
        } else if (sscanf(line, "cycles %ld %63s %4095[^\r\n]", &count, guid, path) == 3) {
            for (long i = 0; i < count; i++) cycle(path, guid);
            printf("%ld\n", count);
            return 0;
        } else if (strncmp(line, "exchange", 8) == 0) {
            exchange = 1;
        } else if (sscanf(line, "size %d %u %u", &slave, &states, &indicators) == 3) {
            set_size(slave, states, indicators);
        } else if (sscanf(line, "integrate %ld %lf", &count, &value) == 2) {
            integrate(count, value);
            return 0;
        } else if (sscanf(line, "run %ld %lf", &count, &value) == 2) {
            run(count, value);
            return 0;
        } else {
            fprintf(stderr, "not understood, or too many of them: %s", line);
            return 2;
        }
    }
    return 2;
}
