/* SPDX-License-Identifier: Apache-2.0 */
/* Exported clouds as a USD layer (UsdVol): a Volume with one OpenVDBAsset for each of its grids, Z up, in metres.
 * Several frames are time samples; a frame without a file is blocked by None. Asset paths below the layer's folder
 * begin with "./", which anchors them to the layer; others are absolute. */
#include <ctype.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include <nephos/render.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/text.h"
#include "scene/scene_private.h"

enum { NAME_BYTES = 64 };

typedef struct volume_list {
  const neph_scene *scene;
  const neph_exported_cloud *clouds;
  size_t count;
  const char *path; /* the layer's file */
} volume_list;

/* ---- Names ---- */

/* An identifier of USD: letters, digits and _, no digit first. */
static void make_identifier(const char *name, char out[NAME_BYTES]) {
  size_t used = 0;
  if (isdigit((unsigned char)*name)) out[used++] = '_';
  for (; *name && used + 1 < NAME_BYTES; name++) out[used++] = isalnum((unsigned char)*name) ? *name : '_';
  if (used == 0) out[used++] = '_';
  out[used] = '\0';
}

/* Whether it is the first of its name. */
static bool is_first(const volume_list *list, size_t index) {
  for (size_t i = 0; i < index; i++)
    if (!strcmp(list->clouds[i].name, list->clouds[index].name)) return false;
  return true;
}

/* Names that become one identifier differ by the number of the entry. */
static void make_prim_name(const volume_list *list, size_t index, char out[NAME_BYTES + 24]) {
  char own[NAME_BYTES], other[NAME_BYTES];
  make_identifier(list->clouds[index].name, own);
  np_print(out, NAME_BYTES + 24, "%s", own);
  for (size_t i = 0; i < index; i++) {
    make_identifier(list->clouds[i].name, other);
    if (!strcmp(own, other) && strcmp(list->clouds[i].name, list->clouds[index].name) != 0)
      np_print(out, NAME_BYTES + 24, "%s_%zu", own, index);
  }
}

/* Length of the folder of a path, its slash included. */
static size_t get_folder_length(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? (size_t)(slash - path) + 1 : 0;
}

static void add_asset(np_text *out, const volume_list *list, const neph_exported_cloud *cloud) {
  const size_t folder = get_folder_length(list->path);
  char absolute[PATH_MAX];
  if (cloud->is_empty)
    np_text_add(out, "None");
  else if (!strncmp(cloud->path, list->path, folder) && cloud->path[folder] != '/')
    np_text_add(out, "@./%s@", cloud->path + folder);
  else
    np_text_add(out, "@%s@", realpath(cloud->path, absolute) ? absolute : cloud->path);
}

/* ---- Prims ---- */

static const neph_exported_cloud *get_first_filled(const volume_list *list, const char *name) {
  for (size_t i = 0; i < list->count; i++)
    if (!strcmp(list->clouds[i].name, name) && !list->clouds[i].is_empty) return &list->clouds[i];
  return NULL;
}

static bool is_sequence(const volume_list *list) {
  for (size_t i = 1; i < list->count; i++)
    if (list->clouds[i].frame != list->clouds[0].frame) return true;
  return false;
}

static void add_box(np_text *out, const neph_exported_cloud *cloud) {
  const double *a = cloud->bounds_min_m, *b = cloud->bounds_max_m;
  np_text_add(out, "[(%.9g, %.9g, %.9g), (%.9g, %.9g, %.9g)]", a[0], a[1], a[2], b[0], b[1], b[2]);
}

static void add_extents(np_text *out, const volume_list *list, const neph_exported_cloud *first) {
  np_text_add(out, "    float3[] extent = ");
  add_box(out, first);
  np_text_add(out, "\n");
  if (!is_sequence(list)) return;
  np_text_add(out, "    float3[] extent.timeSamples = {\n");
  for (size_t i = 0; i < list->count; i++) {
    if (strcmp(list->clouds[i].name, first->name) != 0 || list->clouds[i].is_empty) continue;
    np_text_add(out, "      %d: ", list->clouds[i].frame);
    add_box(out, &list->clouds[i]);
    np_text_add(out, ",\n");
  }
  np_text_add(out, "    }\n");
}

static void add_files(np_text *out, const volume_list *list, const neph_exported_cloud *first) {
  np_text_add(out, "      asset filePath = ");
  add_asset(out, list, first);
  np_text_add(out, "\n");
  if (!is_sequence(list)) return;
  np_text_add(out, "      asset filePath.timeSamples = {\n");
  for (size_t i = 0; i < list->count; i++) {
    if (strcmp(list->clouds[i].name, first->name) != 0) continue;
    np_text_add(out, "        %d: ", list->clouds[i].frame);
    add_asset(out, list, &list->clouds[i]);
    np_text_add(out, ",\n");
  }
  np_text_add(out, "      }\n");
}

/* Grids of a file, the density first, which each has. */
static const struct field {
  unsigned kind;                      /* 0: it is in every file */
  const char *name, *types[2], *role; /* types: single values as floats, as halves */
} fields[] = {
    {0, "density", {"float", "half"}, NULL},
    {NEPH_EXPORT_VELOCITY, "vel", {"float3", "half3"}, "Vector"},
    {NEPH_EXPORT_COLOR, "Cd", {"float3", "half3"}, "Color"},
    {NEPH_EXPORT_LIGHT, "Ce", {"float3", "half3"}, "Color"},
    {NEPH_EXPORT_TEMPERATURE, "temperature", {"float", "half"}, NULL},
    {NEPH_EXPORT_FLAME, "flame", {"float", "half"}, NULL},
    {NEPH_EXPORT_SIZES, "effective_radius", {"float", "half"}, NULL},
};

enum { FIELDS = sizeof fields / sizeof *fields };

static bool has_field(const neph_exported_cloud *cloud, const struct field *field) {
  return !field->kind || cloud->fields & field->kind;
}

static void add_field(np_text *out, const volume_list *list, const neph_exported_cloud *first,
                      const struct field *field) {
  np_text_add(out, "\n    def OpenVDBAsset \"%s\"\n    {\n", field->name);
  add_files(out, list, first);
  np_text_add(out, "      token fieldName = \"%s\"\n", field->name);
  if (!field->role) np_text_add(out, "      token fieldClass = \"fogVolume\"\n");
  np_text_add(out, "      token fieldDataType = \"%s\"\n", field->types[first->is_half]);
  if (field->role) np_text_add(out, "      token vectorDataRoleHint = \"%s\"\n", field->role);
  np_text_add(out, "    }\n");
}

/* Adds a volume. A cloud that is empty in every frame is skipped. */
static void add_volume(np_text *out, const volume_list *list, size_t index) {
  const neph_exported_cloud *first = get_first_filled(list, list->clouds[index].name);
  char name[NAME_BYTES + 24];
  if (!first) return;
  make_prim_name(list, index, name);
  np_text_add(out, "  def Volume \"%s\"\n  {\n", name);
  add_extents(out, list, first);
  np_text_add(out, "    custom float nephos:extinctionPerValue = %.9g\n", first->extinction_per_value);
  for (int i = 0; i < FIELDS; i++)
    if (has_field(first, &fields[i]))
      np_text_add(out, "    rel field:%s = </World/%s/%s>\n", fields[i].name, name, fields[i].name);
  for (int i = 0; i < FIELDS; i++)
    if (has_field(first, &fields[i])) add_field(out, list, first, &fields[i]);
  np_text_add(out, "  }\n");
}

/* ---- Layer ---- */

static void add_times(np_text *out, const volume_list *list) {
  if (!is_sequence(list)) return;
  int first = list->clouds[0].frame, last = first;
  for (size_t i = 1; i < list->count; i++) {
    first = list->clouds[i].frame < first ? list->clouds[i].frame : first;
    last = list->clouds[i].frame > last ? list->clouds[i].frame : last;
  }
  const double rate = list->scene->frame_rate > 0.0 ? list->scene->frame_rate : 24.0;
  np_text_add(out, "  startTimeCode = %d\n  endTimeCode = %d\n  timeCodesPerSecond = %.9g\n", first, last, rate);
}

static neph_result check(const volume_list *list) {
  for (size_t i = 0; i < list->count; i++)
    if (!list->clouds[i].name || (!list->clouds[i].is_empty && !list->clouds[i].path) ||
        (list->clouds[i].path && strpbrk(list->clouds[i].path, "@\n")))
      return np_fail(list->scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                     "cloud %zu of a USD layer has the name %s and the path %s: both must be there, the path "
                     "without @ and line breaks",
                     i, list->clouds[i].name ? list->clouds[i].name : "NULL",
                     list->clouds[i].path ? list->clouds[i].path : "NULL");
  return NEPH_OK;
}

neph_result neph_scene_save_volumes_usd(const neph_scene *scene, const neph_exported_cloud *clouds, size_t count,
                                        const char *path) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), clouds, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  const volume_list list = {scene, clouds, count, path};
  char *text = NULL;
  neph_result result = check(&list);
  if (result) return result;
  np_text out = {.context = scene->context};
  np_text_add(&out, "#usda 1.0\n(\n  defaultPrim = \"World\"\n  metersPerUnit = 1\n  upAxis = \"Z\"\n");
  add_times(&out, &list);
  np_text_add(&out, ")\n\ndef Xform \"World\"\n{\n");
  for (size_t i = 0; i < count; i++)
    if (is_first(&list, i)) add_volume(&out, &list, i);
  np_text_add(&out, "}\n");
  result = np_text_finish(&out, &text);
  if (!result) result = np_file_write_all(scene->context, path, text, strlen(text));
  np_alloc_free(scene->context, text);
  return result;
}
