/* SPDX-License-Identifier: Apache-2.0 */
/* Searches and loads modules on first need: a program linked with OpenVDB or GDAL pays 22 ms and 31 MB before main.
 * Programs that the library starts are in the same folders.
 *
 * The dynamic linker keeps a module and counts its users, so that nothing is remembered here; it is never unloaded, for
 * registries and threads of the libraries behind it do not survive that.
 */
#include "core/module.h"

#include <dlfcn.h>
#include <execinfo.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/file.h"
#include "core/parallel.h"
#include "core/text.h"

typedef struct search {
  const np_module_kind *kind;
  const void *table;      /* table of the module; NULL until found */
  char program[PATH_MAX]; /* path of the program; empty until found */
  bool has_no_room;       /* address space is too small for the module, which was found */
  bool is_over;
  np_text *tried; /* paths tried and their errors, for the message; NULL: no message follows */
} search;

static void note_failure(search *s, const char *path, const char *reason) {
  if (s->tried) np_text_add(s->tried, "%s%s: %s", s->tried->length ? "; " : "", path, reason);
}

static neph_result fail(neph_context *context, const search *s) {
  if (s->tried->has_failed) return NEPH_ERROR_OUT_OF_MEMORY;
  return np_fail(context, NEPH_ERROR_UNSUPPORTED, "cannot load %s, which %s: %s", s->kind->file, s->kind->purpose,
                 np_text_get(s->tried));
}

static uint64_t compute_need_bytes(const np_module_kind *kind) {
  return kind->library_bytes + kind->library_threads * np_thread_stack_bytes();
}

/* Makes the C library load its unwinder while there is memory: it would load it at the first exception through one of
 * its functions, and end the process on failure. */
static void load_unwinder(void) {
  void *frame;
  (void)backtrace(&frame, 1);
}

/* Opens a module. NULL, with the reason noted, when it cannot be loaded. */
static void *open_module(search *s, const char *path) {
  enum { MODE = RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE };
  void *handle = dlopen(path, MODE | RTLD_NOLOAD);
  if (handle) return handle;
  s->has_no_room = !np_memory_has_room(compute_need_bytes(s->kind));
  if (!s->has_no_room) handle = dlopen(path, MODE);
  if (handle)
    load_unwinder();
  else
    note_failure(s, path, s->has_no_room ? "no room" : dlerror());
  return handle;
}

static bool try_module(search *s, const char *path) {
  void *handle = open_module(s, path);
  if (!handle) return s->has_no_room;
  const uint32_t *(*get_table)(void) = NULL;
  void *symbol = dlsym(handle, s->kind->function);
  memcpy(&get_table, &symbol, sizeof get_table); /* ISO C has no cast from object to function pointers */
  const uint32_t *table = get_table ? get_table() : NULL;
  if (table && *table == s->kind->version)
    s->table = table;
  else
    note_failure(s, path, "of another version of nephos");
  dlclose(handle);
  return s->table;
}

static bool try_program(search *s, const char *path) {
  if (access(path, X_OK)) return note_failure(s, path, "cannot be run"), false;
  memcpy(s->program, path, strlen(path) + 1);
  return true;
}

static void try_folder(search *s, const char *folder, const char *below) {
  char path[PATH_MAX];
  const int length = snprintf(path, sizeof path, "%s%s/%s", folder, below, s->kind->file);
  if (s->is_over) return;
  if (length <= 0 || (size_t)length >= sizeof path) {
    note_failure(s, folder, "its name is too long");
    return;
  }
  if (np_file_exists(path))
    s->is_over = s->kind->function ? try_module(s, path) : try_program(s, path);
  else
    note_failure(s, path, "not there");
}

/* Folder of the library or program that contains this function. False when it is unknown. */
static bool get_own_folder(char out_folder[PATH_MAX]) {
  Dl_info info;
  static const char anchor;
  if (!dladdr(&anchor, &info) || !info.dli_fname) return false;
  const char *file = strchr(info.dli_fname, '/') ? info.dli_fname : "/proc/self/exe"; /* a program found by PATH */
  if (!realpath(file, out_folder)) return false;
  char *slash = strrchr(out_folder, '/');
  if (slash) *slash = 0;
  return slash != NULL;
}

static search search_folders(const neph_context *context, const np_module_kind *kind, np_text *tried) {
  search s = {.kind = kind, .tried = tried};
  char folder[PATH_MAX];
  if (get_own_folder(folder)) {
    try_folder(&s, folder, "/nephos");
    try_folder(&s, folder, "/../lib/nephos");
  }
  try_folder(&s, NEPHOS_MODULE_INSTALL_DIR, "");
  if (context->module_dir) try_folder(&s, context->module_dir, "");
  return s;
}

bool np_module_is_present(neph_context *context, const np_module_kind *kind) {
  return search_folders(context, kind, NULL).table != NULL;
}

neph_result np_module_get(neph_context *context, const np_module_kind *kind, const void **out_table) {
  np_text tried = {.context = context};
  const search s = search_folders(context, kind, &tried);
  *out_table = s.table;
  if (!s.has_no_room) return np_text_end(&tried, s.table ? NEPH_OK : fail(context, &s));
  (void)np_text_end(&tried, NEPH_OK);
  return np_fail(context, NEPH_ERROR_OUT_OF_MEMORY,
                 "out of memory: %s, which %s, needs %llu MB of address space, more than the process has left: raise "
                 "its limit (ulimit -v)",
                 kind->file, kind->purpose, (unsigned long long)(compute_need_bytes(kind) / 1000000));
}

bool np_module_has_program(neph_context *context, const np_module_kind *kind) {
  return search_folders(context, kind, NULL).program[0];
}

neph_result np_module_get_program(neph_context *context, const np_module_kind *kind, char out_path[PATH_MAX]) {
  np_text tried = {.context = context};
  const search s = search_folders(context, kind, &tried);
  memcpy(out_path, s.program, sizeof s.program);
  return np_text_end(&tried, s.program[0] ? NEPH_OK : fail(context, &s));
}
