/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/heightfield_files.h"

#include <glob.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/text.h"

/* The list in the first braces of a name; `begin` NULL: there is none. */
typedef struct brace_list {
  const char *begin, *end; /* position of the braces */
} brace_list;

static brace_list get_braces(const char *path) {
  const char *begin = strchr(path, '{'), *end = begin ? strchr(begin, '}') : NULL;
  return end ? (brace_list){begin, end} : (brace_list){NULL, NULL};
}

bool np_height_files_is_pattern(const char *path) {
  return (strpbrk(path, "*?") || get_braces(path).begin) && !np_file_exists(path);
}

const char *np_height_files_get_ending(const char *path) {
  const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
  return dot ? dot : "";
}

/* Escapes brackets, which are characters of a name here, and no pattern. */
static char *escape_brackets(neph_context *context, const char *path) {
  char *pattern = np_alloc(context, 2 * strlen(path) + 1, 1), *out = pattern;
  for (; pattern && *path; path++) {
    if (strchr("[]\\", *path)) *out++ = '\\';
    *out++ = *path;
  }
  return pattern;
}

static neph_result add_paths(neph_context *context, char *const *paths, size_t count, np_height_files *out) {
  char **grown = np_alloc(context, out->count + count, sizeof *grown);
  if (!grown) return NEPH_ERROR_OUT_OF_MEMORY;
  if (out->count) memcpy(grown, out->paths, out->count * sizeof *grown);
  np_alloc_free(context, out->paths);
  out->paths = grown;
  for (size_t i = 0; i < count; i++) {
    if (!(out->paths[out->count] = np_alloc_text(context, paths[i]))) return NEPH_ERROR_OUT_OF_MEMORY;
    out->count++;
  }
  return NEPH_OK;
}

static neph_result add_pattern(neph_context *context, const char *path, np_height_files *out) {
  char *pattern = escape_brackets(context, path);
  if (!pattern) return NEPH_ERROR_OUT_OF_MEMORY;
  glob_t found = {0};
  const int failure = glob(pattern, 0, NULL, &found);
  neph_result result = failure == 0 ? add_paths(context, found.gl_pathv, found.gl_pathc, out)
                                    : np_fail(context, NEPH_ERROR_NOT_FOUND, "%s: no file matches this name", path);
  globfree(&found);
  np_alloc_free(context, pattern);
  return result;
}

/* Adds a file, or all that match a pattern. */
static neph_result add_name(neph_context *context, const char *path, np_height_files *out) {
  if (strpbrk(path, "*?") && !np_file_exists(path)) return add_pattern(context, path, out);
  if (!np_file_exists(path)) return np_fail(context, NEPH_ERROR_NOT_FOUND, "%s: no such file", path);
  char *const paths[] = {(char *)(uintptr_t)path};
  return add_paths(context, paths, 1, out);
}

/* Adds each name of a list, all of which must exist. */
static neph_result add_list(neph_context *context, const char *path, brace_list braces, np_height_files *out) {
  const size_t size = strlen(path) + 1;
  char *name = np_alloc(context, size, 1);
  neph_result result = name ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (const char *item = braces.begin + 1; !result && item <= braces.end;) {
    const size_t length = strcspn(item, ",}");
    np_print(name, size, "%.*s%.*s%s", (int)(braces.begin - path), path, (int)length, item, braces.end + 1);
    result = add_name(context, name, out);
    item += length + 1;
  }
  np_alloc_free(context, name);
  return result;
}

neph_result np_height_files_list(neph_context *context, const char *path, np_height_files *out_files) {
  *out_files = (np_height_files){.count = 0};
  const brace_list braces = get_braces(path);
  neph_result result = braces.begin && !np_file_exists(path) ? add_list(context, path, braces, out_files)
                                                             : add_name(context, path, out_files);
  if (result) np_height_files_clear(context, out_files);
  return result;
}

void np_height_files_clear(neph_context *context, np_height_files *files) {
  for (size_t i = 0; i < files->count; i++) np_alloc_free(context, files->paths[i]);
  np_alloc_free(context, files->paths);
  *files = (np_height_files){.count = 0};
}

void np_height_files_describe(const np_height_files *files, const char *path, char *out, size_t size) {
  char count[32] = "";
  if (files->count > 1) np_print(count, sizeof count, " (%zu files)", files->count);
  const size_t length = np_print_short(out, size - strlen(count), path);
  np_print(out + length, size - length, "%s", count);
}
