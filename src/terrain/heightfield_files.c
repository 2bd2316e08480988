/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/heightfield_files.h"

#include <glob.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"

bool np_height_files_is_pattern(const char *path) { return strpbrk(path, "*?") && !np_file_exists(path); }

const char *np_height_files_get_ending(const char *path) {
  const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
  return dot ? dot : "";
}

/* Brackets are characters of a name, and no pattern. */
static char *escape_brackets(neph_context *context, const char *path) {
  char *pattern = np_alloc(context, 2 * strlen(path) + 1, 1), *out = pattern;
  for (; pattern && *path; path++) {
    if (strchr("[]\\", *path)) *out++ = '\\';
    *out++ = *path;
  }
  return pattern;
}

static neph_result copy_paths(neph_context *context, char *const *paths, size_t count, np_height_files *out) {
  out->paths = np_alloc(context, count, sizeof *out->paths);
  for (size_t i = 0; out->paths && i < count; i++) {
    if (!(out->paths[i] = np_alloc_text(context, paths[i]))) break;
    out->count = i + 1;
  }
  if (out->count == count) return NEPH_OK;
  np_height_files_clear(context, out);
  return NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result list_pattern(neph_context *context, const char *path, np_height_files *out) {
  char *pattern = escape_brackets(context, path);
  if (!pattern) return NEPH_ERROR_OUT_OF_MEMORY;
  glob_t found = {0};
  const int failure = glob(pattern, 0, NULL, &found);
  neph_result result = failure == 0 ? copy_paths(context, found.gl_pathv, found.gl_pathc, out)
                                    : np_fail(context, NEPH_ERROR_NOT_FOUND, "%s: no file fits this name", path);
  globfree(&found);
  np_alloc_free(context, pattern);
  return result;
}

neph_result np_height_files_list(neph_context *context, const char *path, np_height_files *out_files) {
  *out_files = (np_height_files){.count = 0};
  if (np_height_files_is_pattern(path)) return list_pattern(context, path, out_files);
  if (!np_file_exists(path)) return np_fail(context, NEPH_ERROR_NOT_FOUND, "%s: no such file", path);
  char *const paths[] = {(char *)(uintptr_t)path};
  return copy_paths(context, paths, 1, out_files);
}

void np_height_files_clear(neph_context *context, np_height_files *files) {
  for (size_t i = 0; i < files->count; i++) np_alloc_free(context, files->paths[i]);
  np_alloc_free(context, files->paths);
  *files = (np_height_files){.count = 0};
}

void np_height_files_describe(const np_height_files *files, const char *path, char *out, size_t size) {
  if (files->count > 1)
    snprintf(out, size, "%s (%zu files)", path, files->count);
  else
    snprintf(out, size, "%s", path);
}
