/* A host that takes the standard at its word: any status but fmi2OK ends it (FMI 2.0.4, section 4.2.2).
 *
 *   strict_host < plan
 *
 * The plan is read line by line; slaves are numbered from 0 in the order in which they are given.
 *
 *   slave LIBRARY GUID          an instance
 *   real S VR VALUE             a start value; also integer
 *   wire FROM VR TO VR          a real output and the real input that follows it
 *   drive STEP S VR VALUE       a real input from this step on; in order of the steps
 *   read S VR                   a real output to print at the end
 *   run STEPS SIZE              initialises and runs; the last line
 *
 * Prints the values asked for, one a line, and then the number of warnings the loggers were told.
 */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

typedef struct {
    Component c;
    int (*setup)(Component, int, double, double, int, double);
    int (*enter)(Component);
    int (*leave)(Component);
    int (*terminate)(Component);
    int (*get_real)(Component, const Reference *, size_t, double *);
    int (*set_real)(Component, const Reference *, size_t, const double *);
    int (*set_integer)(Component, const Reference *, size_t, const int *);
    int (*step)(Component, double, double, int);
    void (*free)(Component);
} Slave;

typedef struct { int from, to; Reference output, input; } Wire;
typedef struct { long step; int slave; Reference input; double value; } Drive;
typedef struct { int slave; Reference output; } Read;

enum { SLAVES = 8, WIRES = 64, DRIVES = 200000, READS = 64 };
static Slave slaves[SLAVES];
static Wire wires[WIRES];
static Drive drives[DRIVES];
static Read reads[READS];
static int slave_count, wire_count, drive_count, read_count, warnings;

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
    void *found = dlsym(library, name);
    if (!found) fail(name, 0, -1);
    return found;
}

static void open_slave(const char *path, const char *guid) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    Slave *s = &slaves[slave_count];
    char name[16];
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
    if (!library) fail(dlerror(), 0, -1);
    snprintf(name, sizeof name, "slave %d", slave_count++);
    *(void **)&instantiate = symbol(library, "fmi2Instantiate");
    *(void **)&s->setup = symbol(library, "fmi2SetupExperiment");
    *(void **)&s->enter = symbol(library, "fmi2EnterInitializationMode");
    *(void **)&s->leave = symbol(library, "fmi2ExitInitializationMode");
    *(void **)&s->terminate = symbol(library, "fmi2Terminate");
    *(void **)&s->get_real = symbol(library, "fmi2GetReal");
    *(void **)&s->set_real = symbol(library, "fmi2SetReal");
    *(void **)&s->set_integer = symbol(library, "fmi2SetInteger");
    *(void **)&s->step = symbol(library, "fmi2DoStep");
    *(void **)&s->free = symbol(library, "fmi2FreeInstance");
    s->c = instantiate(name, 1, guid, "", &callbacks, 0, 1);
    if (!s->c) fail("fmi2Instantiate", 0, -1);
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

static void run(long steps, double size) {
    int next = 0;
    for (int s = 0; s < slave_count; s++) {
        ok(slaves[s].setup(slaves[s].c, 0, 0.0, 0.0, 1, steps * size), "fmi2SetupExperiment", 0);
        ok(slaves[s].enter(slaves[s].c), "fmi2EnterInitializationMode", 0);
    }
    for (int sweep = 0; sweep < slave_count; sweep++)
        for (int s = 0; s < slave_count; s++) hand_on(s, 0);
    for (int s = 0; s < slave_count; s++) ok(slaves[s].leave(slaves[s].c), "fmi2ExitInitializationMode", 0);
    for (long i = 0; i < steps; i++) {
        double time = i * size;
        for (; next < drive_count && drives[next].step <= i; next++) {
            Drive *d = &drives[next];
            ok(slaves[d->slave].set_real(slaves[d->slave].c, &d->input, 1, &d->value), "fmi2SetReal", time);
        }
        for (int s = 0; s < slave_count; s++) hand_on(s, time);
        for (int s = 0; s < slave_count; s++) ok(slaves[s].step(slaves[s].c, time, size, 1), "fmi2DoStep", time);
    }
    for (int i = 0; i < read_count; i++) {
        Slave *s = &slaves[reads[i].slave];
        double value;
        ok(s->get_real(s->c, &reads[i].output, 1, &value), "fmi2GetReal", steps * size);
        printf("%.17g\n", value);
    }
    for (int s = 0; s < slave_count; s++) {
        ok(slaves[s].terminate(slaves[s].c), "fmi2Terminate", steps * size);
        slaves[s].free(slaves[s].c);
    }
    printf("%d\n", warnings);
}

int main(void) {
    static char line[4096], path[4096], guid[64];
    int slave, integer;
    long count;
    double value;
    while (fgets(line, sizeof line, stdin)) {
        Wire *w = &wires[wire_count];
        Drive *d = &drives[drive_count];
        Read *r = &reads[read_count];
        Reference reference;
        if (sscanf(line, "slave %4095s %63s", path, guid) == 2 && slave_count < SLAVES) {
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
