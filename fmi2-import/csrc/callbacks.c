/* The C half of the FMI 2.0 callbacks: fmi2CallbackLogger is variadic, which stable Rust can call but not define.
 * The message is formatted here and handed on as plain text. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* Defined in src/instance/log.rs. Must not unwind. */
void fmi2_import_log(void *environment, const char *instance_name, int status, const char *category, const char *message);

enum { SHORT_MESSAGE = 1024 };

void fmi2_import_logger(void *environment, const char *instance_name, int status, const char *category,
                         const char *format, ...) {
    char text[SHORT_MESSAGE];
    char *message = text;
    if (format == NULL) {
        fmi2_import_log(environment, instance_name, status, category, "");
        return;
    }

    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(text, sizeof text, format, arguments);
    if (length >= SHORT_MESSAGE) {
        char *longer = malloc((size_t)length + 1);
        if (longer != NULL) {
            vsnprintf(longer, (size_t)length + 1, format, again);
            message = longer;
        }
    }
    va_end(again);
    va_end(arguments);

    fmi2_import_log(environment, instance_name, status, category, length < 0 ? format : message);
    if (message != text) {
        free(message);
    }
}

void *fmi2_import_allocate(size_t count, size_t size) { return calloc(count, size); }

void fmi2_import_free(void *memory) { free(memory); }
