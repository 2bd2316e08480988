/* SPDX-License-Identifier: Apache-2.0 */
/* Files by their identity: device and inode of existing files, otherwise the real path of the folder and the name. Rows
 * are sorted by identity, so that a sequence of thousands takes no longer than looking its files up. */
#include <nephos/files.h>

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/file_target.h"
#include "core/given.h"

typedef struct file_row {
  char *role, *path, *identity;
  neph_file_use use;
  size_t index; /* position in the order of addition */
} file_row;

struct neph_files {
  neph_context *context;
  file_row *rows;
  size_t count, capacity;
};

neph_result neph_files_create(neph_context *context, neph_files **out_files) {
  if (NP_LACKS_OUT(context, out_files)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_files *files = *out_files = np_alloc(context, 1, sizeof *files);
  if (!files) return NEPH_ERROR_OUT_OF_MEMORY;
  files->context = context;
  return NEPH_OK;
}

static void clear_row(neph_context *context, file_row *row) {
  np_alloc_free(context, row->role);
  np_alloc_free(context, row->path);
  np_alloc_free(context, row->identity);
}

void neph_files_destroy(neph_files *files) {
  if (!files) return;
  for (size_t i = 0; i < files->count; i++) clear_row(files->context, &files->rows[i]);
  np_alloc_free(files->context, files->rows);
  np_alloc_free(files->context, files);
}

/* ---- Identity ---- */

/* Path with links resolved, or `path` itself where links form a ring. NULL: no memory. */
static char *follow_links(neph_context *context, const char *path) {
  int error;
  char *target = np_file_target_follow(context, path, &error);
  return target || !error ? target : np_alloc_text(context, path);
}

/* Name of a missing file in the real path of its folder, where the folder exists. NULL: no memory. */
static char *resolve_name(neph_context *context, const char *path) {
  char folder[PATH_MAX], *resolved = NULL;
  char *name = follow_links(context, path), *beside = name ? np_file_resolve(context, name, ".") : NULL;
  const char *slash = name ? strrchr(name, '/') : NULL;
  if (beside && realpath(beside, folder))
    resolved = np_alloc_printf(context, "%s/%s", folder, slash ? slash + 1 : name);
  else if (beside)
    resolved = np_alloc_text(context, name);
  np_alloc_free(context, name);
  np_alloc_free(context, beside);
  return resolved;
}

/* Identity of a regular file; NULL, with NEPH_OK: the path is not a regular file. */
static neph_result identify(neph_context *context, const char *path, char **out_identity) {
  struct stat status;
  *out_identity = NULL;
  if (stat(path, &status))
    *out_identity = resolve_name(context, path);
  else if (S_ISREG(status.st_mode))
    *out_identity =
        np_alloc_printf(context, "%llu:%llu", (unsigned long long)status.st_dev, (unsigned long long)status.st_ino);
  else
    return NEPH_OK;
  return *out_identity ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Rows ---- */

static bool grow(neph_files *files) {
  if (files->count < files->capacity) return true;
  const size_t capacity = files->capacity ? 2 * files->capacity : 16;
  file_row *rows = np_alloc_resize(files->context, files->rows, capacity, sizeof *rows);
  if (!rows) return false;
  files->rows = rows;
  files->capacity = capacity;
  return true;
}

/* Fails, with a message, where no file can be written. */
static neph_result check_place(neph_context *context, const char *path) {
  char *target = follow_links(context, path);
  const neph_result result = target ? np_file_target_check_place(context, path, target) : NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(context, target);
  return result;
}

neph_result neph_files_add(neph_files *files, neph_file_use use, const char *role, const char *path) {
  if (!files) return NEPH_ERROR_INVALID_ARGUMENT;
  file_row row = {.use = use, .index = files->count};
  if (!path) return NEPH_OK;
  neph_result result = identify(files->context, path, &row.identity);
  if (result || !row.identity) return result;
  if (use == NEPH_FILE_WRITTEN) result = check_place(files->context, path);
  if (result) {
    clear_row(files->context, &row);
    return result;
  }
  row.role = np_alloc_text(files->context, role);
  row.path = np_alloc_text(files->context, path);
  if (!row.role || !row.path || !grow(files)) {
    clear_row(files->context, &row);
    return NEPH_ERROR_OUT_OF_MEMORY;
  }
  files->rows[files->count++] = row;
  return NEPH_OK;
}

/* ---- The check ---- */

static int compare_rows(const void *a, const void *b) {
  const file_row *left = *(file_row *const *)a, *right = *(file_row *const *)b;
  const int order = strcmp(left->identity, right->identity);
  return order ? order : (left->index > right->index) - (left->index < right->index);
}

static neph_result fail_same(const neph_files *files, const file_row *written, const file_row *other) {
  const bool is_one_name = !strcmp(written->path, other->path);
  const bool is_read = other->use == NEPH_FILE_READ;
  return np_fail(files->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s is the same file as %s%s: %s%s%s; give %s a name of its own", written->role, other->role,
                 is_read ? ", which is read" : "", written->path, is_one_name ? "" : " and ",
                 is_one_name ? "" : other->path, is_read ? "the output" : "each");
}

/* The written row among rows of one file, and in `out_other` another use of the same file; NULL: no conflict. */
static const file_row *search_fault(file_row *const *run, size_t count, const file_row **out_other) {
  for (size_t i = count; count > 1 && i-- > 0;) {
    if (run[i]->use != NEPH_FILE_WRITTEN) continue;
    *out_other = run[i ? 0 : 1];
    return run[i];
  }
  return NULL;
}

/* Reports the first file added, where several conflict. */
neph_result neph_files_check(const neph_files *files) {
  if (!files) return NEPH_ERROR_INVALID_ARGUMENT;
  const file_row *written = NULL, *other = NULL;
  file_row **sorted = np_alloc(files->context, files->count, sizeof *sorted);
  if (!sorted) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < files->count; i++) sorted[i] = &files->rows[i];
  qsort(sorted, files->count, sizeof *sorted, compare_rows);
  for (size_t begin = 0, end; begin < files->count; begin = end) {
    for (end = begin + 1; end < files->count && !strcmp(sorted[begin]->identity, sorted[end]->identity);) end++;
    const file_row *beside, *found = search_fault(sorted + begin, end - begin, &beside);
    if (found && (!written || found->index < written->index)) written = found, other = beside;
  }
  np_alloc_free(files->context, sorted);
  return written ? fail_same(files, written, other) : NEPH_OK;
}
