/* SPDX-License-Identifier: Apache-2.0 */
/* Names of time zones, and their files. */
#include <ctype.h>
#include <dirent.h>
#include <string.h>
#include <sys/stat.h>

#include "core/alloc.h"
#include "core/edit_distance.h"
#include "core/file.h"
#include "core/path_map.h"
#include "core/text.h"
#include "core/time_zone.h"

enum { NAME_SIZE = 64, SHOWN = 60, DEPTH_MAX = 3 };
static const uint64_t file_bytes_max = 1 << 20; /* the largest file of the tz database has 4 kB */

/* ---- Names ---- */

/* Whether a name has valid form: letters, digits and signs between slashes, no part "..", no slash at its start. */
static bool is_name(const char *name) {
  static const char signs[] = "_+-/";
  if (!isalpha((unsigned char)*name) || strlen(name) >= NAME_SIZE || strstr(name, "//")) return false;
  for (const char *c = name; *c; c++)
    if ((unsigned char)*c >= 128 || (!isalnum((unsigned char)*c) && !strchr(signs, *c))) return false;
  return name[strlen(name) - 1] != '/';
}

static const char *get_last_part(const char *name) {
  const char *slash = strrchr(name, '/');
  return slash ? slash + 1 : name;
}

/* Copies a name in small letters, for comparison. */
static void fold(const char *name, char out[NAME_SIZE]) {
  size_t i = 0;
  for (; name[i] && i + 1 < NAME_SIZE; i++) out[i] = name[i] == ' ' ? '_' : (char)tolower((unsigned char)name[i]);
  out[i] = '\0';
}

/* ---- Guesses ---- */

typedef struct zone_guess {
  char wanted[NAME_SIZE]; /* name to guess, in small letters */
  size_t limit;           /* greatest edit distance */
  size_t best_distance;
  char best[NAME_SIZE]; /* best zone so far; empty: none */
} zone_guess;

/* Compares a zone with the name, also without its region: "New_York". */
static void weigh(zone_guess *g, const char *name) {
  char folded[NAME_SIZE];
  fold(name, folded);
  const size_t whole = np_edit_distance(g->wanted, folded);
  const size_t part = np_edit_distance(get_last_part(g->wanted), get_last_part(folded));
  const size_t distance = whole < part ? whole : part;
  if (distance > g->limit || distance >= g->best_distance) return;
  g->best_distance = distance;
  memcpy(g->best, name, strlen(name) + 1);
}

static void weigh_folder(zone_guess *g, neph_context *context, const char *folder, const char *prefix, int depth);

static void weigh_entry(zone_guess *g, neph_context *context, const char *folder, const char *name, int depth) {
  struct stat status;
  char *path = is_name(name) ? np_alloc_printf(context, "%s/%s", folder, name) : NULL;
  const bool is_present = path && !stat(path, &status);
  if (is_present && S_ISREG(status.st_mode)) weigh(g, name);
  if (is_present && S_ISDIR(status.st_mode) && depth < DEPTH_MAX) weigh_folder(g, context, folder, name, depth + 1);
  np_alloc_free(context, path);
}

/* Compares all zones of a folder; `prefix` is its path below `folder`; "posix" and "right" repeat all zones. */
static void weigh_folder(zone_guess *g, neph_context *context, const char *folder, const char *prefix, int depth) {
  if (!strcmp(prefix, "posix") || !strcmp(prefix, "right")) return;
  char *path = np_alloc_printf(context, "%s/%s", folder, prefix);
  DIR *list = path ? opendir(path) : NULL;
  for (struct dirent *entry; list && (entry = readdir(list));) {
    char name[2 * sizeof entry->d_name];
    np_print(name, sizeof name, "%s%s%s", prefix, *prefix ? "/" : "", entry->d_name);
    weigh_entry(g, context, folder, name, depth);
  }
  if (list) closedir(list);
  np_alloc_free(context, path);
}

/* Guesses a zone, but not for abbreviations, which are near to too many names: EDT is not EST. */
char *np_time_zone_guess(neph_context *context, const char *folder, const char *name) {
  zone_guess g = {.best_distance = SIZE_MAX};
  const size_t length = strlen(get_last_part(name));
  if (strlen(name) >= NAME_SIZE) return NULL;
  fold(name, g.wanted);
  g.limit = length < 4 ? 0 : length < 8 ? 1 : length / 4;
  weigh_folder(&g, context, folder, "", 0);
  return *g.best ? np_alloc_text(context, g.best) : NULL;
}

/* ---- Files ---- */

/* Request for a zone, and destination of problems. */
typedef struct zone_request {
  neph_context *context;
  const char *folder, *name;
  char **out_problem;
} zone_request;

static neph_result refuse(const zone_request *q, const char *format, ...) __attribute__((format(printf, 2, 3)));

static neph_result refuse(const zone_request *q, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  *q->out_problem = np_alloc_printf_list(q->context, format, arguments);
  va_end(arguments);
  return *q->out_problem ? NEPH_ERROR_BAD_FILE : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result refuse_missing(const zone_request *q) {
  struct stat status;
  if (stat(q->folder, &status) || !S_ISDIR(status.st_mode))
    return refuse(q,
                  "the time zone %s cannot be looked up, since there is no folder %s: install the package tzdata, or "
                  "write an offset such as +02:00",
                  q->name, q->folder);
  char *guess = np_time_zone_guess(q->context, q->folder, q->name);
  const neph_result result =
      refuse(q,
             "%s is no time zone in %s%s%s%s must be Z, an offset such as +02:00, the name of a zone such as "
             "America/New_York, or nothing, which is UTC",
             q->name, q->folder, guess ? ", did you mean " : "", guess ? guess : "", guess ? "?" : ",");
  np_alloc_free(q->context, guess);
  return result;
}

static neph_result refuse_name(const zone_request *q) {
  char shown[SHOWN + 1];
  np_print_short(shown, sizeof shown, q->name);
  return refuse(q,
                "\"%s\" at its end is no zone, must be Z, an offset such as +02:00, or the name of a time zone such as "
                "America/New_York: letters, digits, _, + and - between slashes; nothing is UTC",
                shown);
}

static neph_result read_file(const zone_request *q, const char *path, np_time_zone **out_zone) {
  void *bytes;
  size_t size;
  if (np_file_get_size(path) > file_bytes_max)
    return refuse(q, "the file of the time zone %s, %s, is larger than 1 MB: install the package tzdata anew", q->name,
                  path);
  neph_result result = np_file_read(q->context, path, &bytes, &size);
  if (result) return result;
  result = np_time_zone_parse(q->context, q->name, bytes, size, out_zone, q->out_problem);
  np_alloc_free(q->context, bytes);
  return result;
}

neph_result np_time_zone_load(neph_context *context, const char *name, np_time_zone **out_zone, char **out_problem) {
  const char *folder = np_path_map_get_time_zone_dir(context);
  const zone_request q = {context, folder ? folder : NP_TIME_ZONE_DIR, name,
                          out_problem};
  const char *reason;
  *out_zone = NULL;
  *out_problem = NULL;
  if (!is_name(name)) return refuse_name(&q);
  char *path = np_alloc_printf(context, "%s/%s", q.folder, name);
  if (!path) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_file_probe(path, &reason) ? refuse_missing(&q) : read_file(&q, path, out_zone);
  np_alloc_free(context, path);
  return result;
}
