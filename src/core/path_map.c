/* SPDX-License-Identifier: Apache-2.0 */
#include "core/path_map.h"

#include <ctype.h>
#include <nephos/names.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/json.h"
#include "core/path_variables.h"

/* One rule; its texts belong to `rules`. */
typedef struct path_rule {
  const char *source, *destination;
  size_t length;   /* length of the source, without slashes at its end */
  bool is_windows; /* the source is a Windows path: letters of either case, and backslashes */
} path_rule;

struct np_path_map {
  np_json_value *rules; /* NULL: none */
  path_rule *items;
  size_t count;
  np_path_variables *variables; /* NULL: no variables */
  char *time_zone_dir;          /* NULL: NP_TIME_ZONE_DIR */
};

/* ---- Rules ---- */

static bool is_slash(char c, bool is_windows) { return c == '/' || (is_windows && c == '\\'); }

static bool read_rule(const np_json_value *value, path_rule *out) {
  const char *format = np_json_get_text(value, "source_path_format");
  out->source = np_json_get_text(value, "source_path");
  out->destination = np_json_get_text(value, "destination_path");
  if (!format || !out->source || !out->destination) return false;
  out->is_windows = !strcmp(format, "WINDOWS");
  out->length = strlen(out->source);
  while (out->length > 0 && is_slash(out->source[out->length - 1], out->is_windows)) out->length--;
  return out->is_windows || !strcmp(format, "POSIX");
}

static neph_result read_rules(neph_context *context, const char *path, np_path_map *map) {
  static const char key[] = "path_mapping_rules";
  while (np_json_get_element(map->rules, key, map->count)) map->count++;
  map->items = np_alloc(context, map->count + 1, sizeof *map->items);
  if (!map->items) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < map->count; i++)
    if (!read_rule(np_json_get_element(map->rules, key, i), &map->items[i]))
      return np_fail(context, NEPH_ERROR_BAD_FILE,
                     "%s: rule %zu of path_mapping_rules must have source_path_format, POSIX or WINDOWS, source_path "
                     "and destination_path",
                     path, i + 1);
  return NEPH_OK;
}

/* Parses rules. The empty object has no version. */
static neph_result parse(neph_context *context, const char *path, const char *text, np_path_map *map) {
  map->rules = np_json_read(text);
  const char *version = map->rules ? np_json_get_text(map->rules, "version") : NULL;
  if (!map->rules || (version && strcmp(version, "pathmapping-1.0")))
    return np_fail(
        context, NEPH_ERROR_BAD_FILE,
        "%s: has no path mapping rules: must be a JSON object of version pathmapping-1.0, with path_mapping_rules",
        path);
  return read_rules(context, path, map);
}

neph_result np_path_map_load(neph_context *context, const char *path, np_path_map **out_map) {
  void *bytes;
  size_t size;
  *out_map = NULL;
  neph_result result = np_file_read_text(context, path, &bytes, &size);
  if (result) return result;
  np_path_map *map = np_alloc(context, 1, sizeof *map);
  result = map ? parse(context, path, bytes, map) : NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(context, bytes);
  if (!result)
    *out_map = map;
  else
    np_path_map_destroy(context, map);
  return result;
}

static void clear_names(neph_context *context, np_path_map *map) {
  np_path_variables_destroy(context, map->variables);
  np_alloc_free(context, map->time_zone_dir);
  map->variables = NULL;
  map->time_zone_dir = NULL;
}

void np_path_map_destroy(neph_context *context, np_path_map *map) {
  if (!map) return;
  clear_names(context, map);
  np_json_value_destroy(map->rules);
  np_alloc_free(context, map->items);
  np_alloc_free(context, map);
}

/* ---- Names ---- */

static bool is_same(char a, char b, bool is_windows) {
  if (is_slash(a, is_windows) && is_slash(b, is_windows)) return true;
  return is_windows ? tolower((unsigned char)a) == tolower((unsigned char)b) : a == b;
}

static bool applies(const path_rule *rule, const char *name) {
  for (size_t i = 0; i < rule->length; i++)
    if (!name[i] || !is_same(name[i], rule->source[i], rule->is_windows)) return false;
  return !name[rule->length] || is_slash(name[rule->length], rule->is_windows);
}

static char *map_name(neph_context *context, const char *base_file, const char *name) {
  const np_path_map *map = context->path_map;
  const path_rule *best = NULL;
  for (size_t i = 0; map && i < map->count; i++)
    if ((!best || map->items[i].length > best->length) && applies(&map->items[i], name)) best = &map->items[i];
  if (!best) return np_file_resolve(context, base_file, name);
  char *mapped = np_alloc_printf(context, "%s%s", best->destination, name + best->length);
  for (char *c = mapped ? mapped + strlen(best->destination) : NULL; c && best->is_windows && *c; c++)
    if (*c == '\\') *c = '/';
  return mapped;
}

neph_result np_path_map_resolve(neph_context *context, const char *base_file, const char *name, char **out_path,
                                char **out_problem) {
  char *expanded;
  *out_path = NULL;
  neph_result result = np_path_variables_expand(context, context->path_map ? context->path_map->variables : NULL, name,
                                                &expanded, out_problem);
  if (result) return result;
  *out_path = map_name(context, base_file, expanded);
  np_alloc_free(context, expanded);
  return *out_path ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

char *np_path_map_resolve_again(neph_context *context, const char *base_file, const char *name) {
  char *path, *problem;
  (void)np_path_map_resolve(context, base_file, name, &path, &problem);
  np_alloc_free(context, problem);
  return path;
}

/* ---- Names that are set ---- */

const char *np_path_map_get_time_zone_dir(const neph_context *context) {
  return context->path_map ? context->path_map->time_zone_dir : NULL;
}

neph_result neph_context_set_names(neph_context *context, const neph_names_desc *desc) {
  const neph_names_desc defaults = NEPH_NAMES_DESC_DEFAULT;
  neph_names_desc wanted;
  if (!context) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = np_desc_read(context, "neph_names_desc", &defaults, sizeof defaults, desc, &wanted);
  if (result) return result;
  if (!context->path_map) context->path_map = np_alloc(context, 1, sizeof *context->path_map);
  np_path_map *map = context->path_map;
  if (!map) return NEPH_ERROR_OUT_OF_MEMORY;
  clear_names(context, map);
  if (wanted.variables) result = np_path_variables_create(context, wanted.variables, &map->variables);
  if (result || !wanted.time_zone_dir) return result;
  map->time_zone_dir = np_alloc_text(context, wanted.time_zone_dir);
  return map->time_zone_dir ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}
