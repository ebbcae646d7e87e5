/* Loading and unloading of shared libraries, and files whose names are in UTF-8, on every system alike. */
#ifndef LOADER_H
#define LOADER_H

#include <stdio.h>

#ifdef _WIN32
#include <windows.h>

/* Names are UTF-8 here and UTF-16 there. */
static const wchar_t *wide(const char *text, wchar_t *buffer, int size) {
    return MultiByteToWideChar(CP_UTF8, 0, text, -1, buffer, size) > 0 ? buffer : L"";
}

static void *load(const char *path) {
    wchar_t buffer[4096];
    return (void *)LoadLibraryExW(wide(path, buffer, 4096), NULL, LOAD_WITH_ALTERED_SEARCH_PATH);
}

static void *find(void *library, const char *name) {
    return (void *)GetProcAddress((HMODULE)library, name);
}

/* Whether the library is gone from the process then. */
static int unload(void *library) {
    wchar_t path[4096];
    return GetModuleFileNameW((HMODULE)library, path, 4096) > 0 && FreeLibrary((HMODULE)library)
        && GetModuleHandleW(path) == NULL;
}

static const char *problem(void) {
    static char text[32];
    snprintf(text, sizeof text, "error %lu", (unsigned long)GetLastError());
    return text;
}

static FILE *open_file(const char *path, const char *mode) {
    wchar_t buffer[4096], how[8];
    wide(path, buffer, 4096);
    return _wfopen(buffer, wide(mode, how, 8));
}

#else
#include <dlfcn.h>

static char loaded[4096];

static void *load(const char *path) {
    snprintf(loaded, sizeof loaded, "%s", path);
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}

static void *find(void *library, const char *name) {
    return dlsym(library, name);
}

/* Whether the library that was loaded last is gone from the process then. */
static int unload(void *library) {
    return dlclose(library) == 0 && dlopen(loaded, RTLD_NOW | RTLD_NOLOAD) == NULL;
}

static const char *problem(void) {
    return dlerror();
}

static FILE *open_file(const char *path, const char *mode) {
    return fopen(path, mode);
}

#endif
#endif
