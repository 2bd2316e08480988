/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_choice.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/frame_name.h"

/* ---- Roles ---- */

static bool begins_with(const char *text, const char *beginning) {
  return !strncasecmp(text, beginning, strlen(beginning));
}

static bool is_one_of(const char *text, const char *const *words, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (!strcasecmp(text, words[i])) return true;
  return false;
}

/* Whether a name is a base and an axis: "vel.x", "velocity_y", "v.z". */
static bool is_velocity(const char *name) {
  static const char *const bases[] = {"velocity", "vel", "v"};
  for (size_t i = 0; i < sizeof bases / sizeof *bases; i++) {
    const char *rest = name + strlen(bases[i]);
    if (begins_with(name, bases[i]) && (!*rest || ((*rest == '.' || *rest == '_' || *rest == '[') && rest[1])))
      return true;
  }
  return false;
}

static bool is_field(const char *name) {
  static const char *const names[] = {
      "temperature", "temp",       "heat",      "flame",    "flames", "fuel",     "fire",   "burn",
      "pressure",    "divergence", "speed",     "age",      "react",  "reaction", "oxygen", "humidity",
      "viscosity",   "vorticity",  "collision", "obstacle", "source", "sink",     "noise",  "effective_radius"};
  return is_one_of(name, names, sizeof names / sizeof *names) || begins_with(name, "color") ||
         begins_with(name, "Cd") || begins_with(name, "Ce_") || begins_with(name, "Ce.") ||
         begins_with(name, "albedo") || begins_with(name, "rest") || begins_with(name, "emi");
}

np_grid_role np_volume_get_role(const np_volume_file *file, const np_vdb_grid_info *info) {
  if (info->is_vector) return NP_GRID_VECTOR;
  if ((!info->is_scalar && !info->is_count) || info->is_level_set) return NP_GRID_OTHER;
  if (!strcasecmp(info->name, "density")) return NP_GRID_DENSITY;
  if (is_velocity(info->name)) return NP_GRID_VECTOR;
  if (is_field(info->name)) return NP_GRID_FIELD;
  if (!np_volume_has_grid(file, "density")) return NP_GRID_DENSITY;
  return info->is_scalar ? NP_GRID_FIELD : NP_GRID_OTHER;
}

/* ---- Refusals ---- */

/* List of the grids, such as "'density' (float), 'v' (vec3s)", to be freed; NULL if out of memory. */
static char *list_grids(const np_volume_file *file) {
  const size_t count = np_volume_file_count(file);
  char *list = np_alloc_text(file->context, count ? "" : "nothing");
  for (size_t i = 0; i < count && list; i++) {
    const np_vdb_grid_info info = np_volume_file_describe(file, i);
    char *longer = np_alloc_printf(file->context, "%s%s'%s' (%s%s)", list, i ? ", " : "", info.name, info.value_type,
                                   info.is_level_set ? ", a level set" : "");
    np_alloc_free(file->context, list);
    list = longer;
  }
  return list;
}

/* Refuses a choice with a list of the grids. Takes ownership of `reason`, a string from np_alloc_printf. */
static neph_result refuse(const np_volume_file *file, const np_grid_query *query, char *reason, char **out_refusal) {
  const char *key = query->is_field ? query->key : "clouds[].grid";
  char *list = list_grids(file);
  if (list && reason)
    *out_refusal = np_alloc_printf(file->context, "%s: found %s%s%s%s", reason, list, key ? "; " : "", key ? key : "",
                                   !key              ? ""
                                   : query->is_field ? " names one"
                                                     : " names one, or \"a + b\" a sum");
  np_alloc_free(file->context, list);
  np_alloc_free(file->context, reason);
  return *out_refusal ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Refuses a choice without a list of the grids. */
static neph_result refuse_plainly(char *reason, char **out_refusal) {
  *out_refusal = reason;
  return reason ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Choice by name ---- */

/* Grids that match a name, by number among all. */
typedef struct matches {
  size_t count, index; /* number of matches, and index of the selected one among all grids */
} matches;

static matches search_exact(const np_volume_file *file, const char *name, size_t length, size_t wanted, bool is_exact) {
  matches found = {0, SIZE_MAX};
  const size_t count = np_volume_file_count(file);
  for (size_t i = 0; i < count; i++) {
    const char *other = np_volume_file_describe(file, i).name;
    const bool is_alike =
        strlen(other) == length && (is_exact ? !memcmp(other, name, length) : !strncasecmp(other, name, length));
    if (is_alike && found.count++ == wanted) found.index = i;
  }
  return found;
}

/* Searches grids by exact name, or ignoring case if there is none; `index` is the match with the number `wanted`. */
static matches search_name(const np_volume_file *file, const char *name, size_t length, size_t wanted) {
  const matches found = search_exact(file, name, length, wanted, true);
  return found.count ? found : search_exact(file, name, length, wanted, false);
}

bool np_volume_has_grid(const np_volume_file *file, const char *name) {
  return search_name(file, name, strlen(name), 0).count > 0;
}

/* Splits "name[2]" into the length of its name and 2. False if the text does not have that form. */
static bool split_number(const char *text, size_t length, size_t *out_length, size_t *out_number) {
  const char *end = text + length, *bracket = end;
  if (length < sizeof "a[0]" - 1 || end[-1] != ']') return false;
  while (bracket > text && *bracket != '[') bracket--;
  char *digits_end;
  *out_number = strtoul(bracket + 1, &digits_end, 10);
  *out_length = (size_t)(bracket - text);
  return bracket[1] >= '0' && bracket[1] <= '9' && digits_end == end - 1;
}

static neph_result choose_by_name(const np_volume_file *file, const np_grid_query *query, const char *name,
                                  size_t length, size_t *out_index, char **out_refusal) {
  size_t bare, number;
  matches found = search_name(file, name, length, 0);
  if (!found.count && split_number(name, length, &bare, &number)) {
    found = search_name(file, name, bare, number);
    found.count = found.index != SIZE_MAX;
  }
  *out_index = found.index;
  const int width = (int)length;
  if (found.count > 1)
    return refuse(file, query,
                  np_alloc_printf(file->context, "%zu grids are named '%.*s': ask for '%.*s[0]' to '%.*s[%zu]'",
                                  found.count, width, name, width, name, width, name, found.count - 1),
                  out_refusal);
  if (found.index == SIZE_MAX && !query->sequence)
    return refuse(file, query, np_alloc_printf(file->context, "no grid '%.*s'", width, name), out_refusal);
  return NEPH_OK;
}

/* ---- Default choice ---- */

static const char usual[] = "density";

/* Kinds of grids that may be a density without the name, the likeliest first. */
typedef enum likeness { FOG, NUMBERS, COUNTS, LEVEL_SETS } likeness;

static bool is_like(const np_vdb_grid_info *info, likeness like) {
  const bool is_other = is_velocity(info->name) || is_field(info->name),
             is_fog = info->is_scalar && !info->is_level_set;
  switch (like) {
  case FOG:
    return is_fog && !is_other && !strcmp(info->grid_class, "fog volume");
  case NUMBERS:
    return is_fog && !is_other;
  case COUNTS:
    return info->is_count && !is_other;
  case LEVEL_SETS:
    return info->is_scalar && !is_other;
  }
  return false;
}

static matches search_like(const np_volume_file *file, likeness like) {
  matches found = {0, SIZE_MAX};
  const size_t count = np_volume_file_count(file);
  for (size_t i = 0; i < count; i++) {
    const np_vdb_grid_info info = np_volume_file_describe(file, i);
    if (is_like(&info, like) && !found.count++) found.index = i;
  }
  return found;
}

/* Reason why a file has no default density. */
static const char *explain_none(const np_volume_file *file) {
  const size_t count = np_volume_file_count(file);
  bool are_vectors = count > 0, has_level_set = false, has_field = false;
  for (size_t i = 0; i < count; i++) {
    const np_vdb_grid_info info = np_volume_file_describe(file, i);
    are_vectors = are_vectors && info.is_vector;
    has_level_set = has_level_set || info.is_level_set;
    has_field = has_field || (info.is_scalar && (is_velocity(info.name) || is_field(info.name)));
  }
  if (are_vectors) return "no density, only colours or velocities, which belong to a density of the same file";
  if (has_level_set) return "no fog volume, and a level set is one by clouds[].level_set alone";
  return has_field ? "no density, and a temperature, a velocity or the like is one by clouds[].grid alone"
                   : "no fog volume";
}

static neph_result choose_usual(const np_volume_file *file, const np_grid_query *query, size_t *out_index,
                                char **out_refusal) {
  if (np_volume_has_grid(file, usual)) return choose_by_name(file, query, usual, strlen(usual), out_index, out_refusal);
  matches found = {0, SIZE_MAX};
  const likeness last = query->level_set_voxels > 0.0 ? LEVEL_SETS : COUNTS;
  for (likeness like = FOG; like <= last && !found.count; like++) found = search_like(file, like);
  *out_index = found.index;
  if (found.count == 1) return NEPH_OK;
  return refuse(
      file, query,
      np_alloc_text(file->context, found.count ? "no grid 'density', and several others" : explain_none(file)),
      out_refusal);
}

/* ---- Default choice of a sequence ---- */

/* Files that are opened to determine the name of a density other than "density". */
enum { FILES_LOOKED_AT_MAX = 16 };

/* Name of the density of a single file, to be freed, replaces `*name`; unchanged if the file has none. */
static neph_result name_density(const np_volume_file *file, const np_grid_query *query, char **name) {
  const np_grid_query alone = {.level_set_voxels = query->level_set_voxels};
  size_t index;
  char *refusal = NULL;
  neph_result result = choose_usual(file, &alone, &index, &refusal);
  if (!result && !refusal && (!*name || np_volume_has_grid(file, usual))) {
    np_alloc_free(file->context, *name);
    *name = np_alloc_text(file->context, np_volume_file_describe(file, index).name);
    result = *name ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_alloc_free(file->context, refusal);
  return result;
}

static neph_result name_density_at(neph_context *context, const np_grid_query *query, double number, char **name) {
  np_volume_file file;
  char *path = np_frame_name_make(context, query->sequence, number);
  neph_result result = path ? np_volume_file_open(context, path, NULL, NULL, &file) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) {
    result = name_density(&file, query, name);
    np_volume_file_close(&file);
  }
  np_alloc_free(context, path);
  return result;
}

/* One name for all files: "density" if one of the first has it, else the default choice of the first file with a
 * density. A frame without the density never falls back to another grid. */
static neph_result name_density_of_all(neph_context *context, const np_grid_query *query, char **out_name) {
  np_frame_numbers there;
  *out_name = NULL;
  neph_result result = np_frame_name_list(context, query->sequence, &there);
  for (size_t i = 0; !result && i < there.count && i < FILES_LOOKED_AT_MAX; i++) {
    if (*out_name && !strcasecmp(*out_name, usual)) break;
    result = name_density_at(context, query, there.numbers[i], out_name);
  }
  np_alloc_free(context, there.numbers);
  return result;
}

static neph_result choose_of_sequence(const np_volume_file *file, const np_grid_query *query, size_t *out_index,
                                      char **out_refusal) {
  char *name = NULL;
  if (np_volume_has_grid(file, usual)) return choose_by_name(file, query, usual, strlen(usual), out_index, out_refusal);
  neph_result result = name_density_of_all(file->context, query, &name);
  if (!result && name)
    result = choose_by_name(file, query, name, strlen(name), out_index, out_refusal);
  else if (!result)
    result = choose_usual(file, query, out_index, out_refusal);
  np_alloc_free(file->context, name);
  return result;
}

/* ---- Sums ---- */

/* Length of a name without surrounding spaces; advances its beginning. */
static size_t trim(const char **name, size_t length) {
  while (length > 0 && **name == ' ') (*name)++, length--;
  while (length > 0 && (*name)[length - 1] == ' ') length--;
  return length;
}

/* Chooses each grid of a sum such as "density + fuel". */
static neph_result choose_sum(const np_volume_file *file, const np_grid_query *query, np_volume_choice *out_choice,
                              char **out_refusal) {
  neph_result result = NEPH_OK;
  for (const char *name = query->grid; name && !result && !*out_refusal;) {
    const char *end = strchr(name, '+');
    if (out_choice->count == NP_VOLUME_GRIDS_MAX)
      return refuse_plainly(np_alloc_printf(file->context, "'%s' are too many grids, must be at most %d", query->grid,
                                            NP_VOLUME_GRIDS_MAX),
                            out_refusal);
    const size_t length = trim(&name, end ? (size_t)(end - name) : strlen(name));
    size_t *index = &out_choice->indices[out_choice->count];
    result = choose_by_name(file, query, name, length, index, out_refusal);
    out_choice->count += !result && *index != SIZE_MAX;
    name = end ? end + 1 : NULL;
  }
  return result;
}

/* ---- Kinds ---- */

/* Checks the kind of a grid. A level set is a density only with a depth at which it is solid. */
static neph_result check_kind(const np_volume_file *file, const np_grid_query *query, const np_vdb_grid_info *info,
                              char **out_refusal) {
  if (!info->is_scalar && !info->is_count)
    return refuse_plainly(
        np_alloc_printf(file->context, "grid '%s' holds %s, must hold numbers or marks", info->name, info->value_type),
        out_refusal);
  if (info->is_level_set && !(query->level_set_voxels > 0.0))
    return refuse_plainly(np_alloc_printf(file->context,
                                          "grid '%s' is a level set, which holds distances, not a density: "
                                          "clouds[].level_set says how many voxels below its surface it is 1",
                                          info->name),
                          out_refusal);
  return NEPH_OK;
}

neph_result np_volume_choose(const np_volume_file *file, const np_grid_query *query, np_volume_choice *out_choice,
                             char **out_refusal) {
  const char *name = query->grid;
  neph_result result;
  *out_choice = (np_volume_choice){.level_set_voxels = query->level_set_voxels};
  *out_refusal = NULL;
  if (name && strchr(name, '+') && !np_volume_has_grid(file, name)) {
    result = choose_sum(file, query, out_choice, out_refusal);
  } else {
    size_t *index = out_choice->indices;
    *index = SIZE_MAX;
    result = name              ? choose_by_name(file, query, name, strlen(name), index, out_refusal)
             : query->sequence ? choose_of_sequence(file, query, index, out_refusal)
                               : choose_usual(file, query, index, out_refusal);
    out_choice->count = *index != SIZE_MAX;
  }
  for (size_t i = 0; i < out_choice->count && !result && !*out_refusal; i++) {
    const np_vdb_grid_info info = np_volume_file_describe(file, out_choice->indices[i]);
    result = check_kind(file, query, &info, out_refusal);
  }
  return result;
}

char *np_volume_describe_absence(const np_volume_file *file, const np_grid_query *query) {
  char *list = list_grids(file);
  char *text = list ? np_alloc_printf(file->context, "it has no grid '%s', found %s: the cloud is empty in this frame",
                                      query->grid ? query->grid : usual, list)
                    : NULL;
  np_alloc_free(file->context, list);
  return text;
}
