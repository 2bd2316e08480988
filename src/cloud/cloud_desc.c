/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/cloud_desc.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "cloud/cloud_kinds.h"
#include "cloud/cloud_name.h"
#include "cloud/ground_map.h"
#include "cloud/repeat_check.h"
#include "cloud/shape_desc.h"
#include "cloud/weather_picture.h"
#include "core/alloc.h"
#include "core/json.h"
#include "core/text.h"

typedef enum range_kind { INCLUSIVE, ABOVE_LOW } range_kind;

typedef struct real_field {
  const char *name;
  const char *key, *unit; /* names of a scene, used in messages */
  size_t offset;
  int count;
  double low, high;
  range_kind kind;
} real_field;

#define FIELD(name, key, unit, count, low, high, kind)                                                                 \
  { #name, key, unit, offsetof(neph_cloud_desc, name), count, low, high, kind }

/* Limits are far beyond real clouds, and keep lengths in float exact to a few centimetres. */
static const real_field fields[] = {
    FIELD(extent_m, "extent", " m", 2, 0, 1e6, ABOVE_LOW),
    FIELD(center_m, "center", " m", 2, -1e6, 1e6, INCLUSIVE),
    FIELD(base_altitude_m, "base", " m", 1, -1000, 1e5, INCLUSIVE),
    FIELD(thickness_m, "thickness", " m", 1, 0, 1e5, ABOVE_LOW),
    FIELD(voxel_m, "voxel", " m", 1, 0, 1e5, ABOVE_LOW),
    FIELD(coverage, "coverage", "", 1, 0, 1, INCLUSIVE),
    FIELD(cell_m, "cell", " m", 1, 0, 1e6, ABOVE_LOW),
    FIELD(type, "type", "", 1, 0, 1, INCLUSIVE),
    FIELD(billow_m, "billow", " m", 1, 0, 1e5, ABOVE_LOW),
    FIELD(billowiness, "billowiness", "", 1, 0, 1, INCLUSIVE),
    FIELD(erosion, "erosion", "", 1, 0, 1, INCLUSIVE),
    FIELD(wispiness, "wispiness", "", 1, 0, 1, INCLUSIVE),
    FIELD(turbulence, "turbulence", "", 1, 0, 1, INCLUSIVE),
    FIELD(skew_m, "skew", " m", 2, -1e5, 1e5, INCLUSIVE),
    FIELD(extinction_per_m, "extinction", " 1/m", 1, 0, 100, ABOVE_LOW),
    FIELD(softness, "softness", "", 1, 0, 1, INCLUSIVE),
    FIELD(stretch, "stretch", "", 1, 1, 100, INCLUSIVE),
    FIELD(anvil, "anvil", "", 1, 0, 1, INCLUSIVE),
    FIELD(precipitation, "precipitation", "", 1, 0, 1, INCLUSIVE),
    FIELD(profile, "profile", "", NEPH_CLOUD_PROFILE_POINTS, 0, 1, INCLUSIVE),
    FIELD(wind_m_s, "wind", " m/s", 2, -200, 200, INCLUSIVE),
    FIELD(time_s, "time", " s", 1, -1e6, 1e6, INCLUSIVE),
    FIELD(lifetime_s, "lifetime", " s", 1, 0, 1e9, ABOVE_LOW),
    FIELD(map_size_m, "map.size", " m", 2, 0, 1e7, ABOVE_LOW),
    FIELD(age, "age", "", 1, 0, 1, INCLUSIVE),
    FIELD(wind_speed_m_s, "wind_speed", " m/s", NEPH_CLOUD_PROFILE_POINTS, 0, 200, INCLUSIVE),
    FIELD(wind_direction_rad, "wind_direction", " rad", NEPH_CLOUD_PROFILE_POINTS, -7, 7, INCLUSIVE),
    FIELD(ground_lift, "ground_lift", "", 1, 0, 1, INCLUSIVE),
    FIELD(ground_cover, "ground_cover", "", 1, -1, 1, INCLUSIVE),
    FIELD(trail_direction_rad, "trail_direction", " rad", 1, -7, 7, INCLUSIVE),
    FIELD(billow_amounts, "billow_amounts", "", NEPH_CLOUD_PARTS, 0, 2, INCLUSIVE),
    FIELD(billow_frequencies, "billow_frequencies", "", NEPH_CLOUD_PARTS, 1, 8, INCLUSIVE),
    FIELD(wisp_amounts, "wisp_amounts", "", NEPH_CLOUD_PARTS, 0, 2, INCLUSIVE),
    FIELD(repeat_m, "repeat", " m", 1, 0, 1e6, INCLUSIVE),
    FIELD(streets, "streets", "", 1, 0, 1, INCLUSIVE),
    FIELD(cells_size_m, "cells.size", " m", 1, 0, 1e6, ABOVE_LOW),
    FIELD(wisp_frequencies, "wisp_frequencies", "", NEPH_CLOUD_PARTS, 1, 8, INCLUSIVE),
};

/* Older files lack the fields from `age` on, which then have their defaults. */
enum { FIELD_COUNT = sizeof fields / sizeof *fields, FIELD_AGE = FIELD_COUNT - 13 };

static const double *get_values(const neph_cloud_desc *desc, const real_field *field) {
  return (const double *)(const void *)((const char *)desc + field->offset);
}

static bool is_inside(const real_field *field, double value) {
  return (field->kind == ABOVE_LOW ? value > field->low : value >= field->low) && value <= field->high;
}

static neph_result check_field(neph_context *context, const neph_cloud_desc *desc, const real_field *field) {
  const double *values = get_values(desc, field);
  for (int i = 0; i < field->count; i++) {
    if (is_inside(field, values[i])) continue;
    char index[16] = "";
    if (field->count > 1) np_print(index, sizeof index, "[%d]", i);
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.%s%s is %g%s, must be in %c%g, %g]%s",
                   np_cloud_desc_name(desc), field->key, index, values[i], field->unit,
                   field->kind == ABOVE_LOW ? '(' : '[', field->low, field->high, field->unit);
  }
  return NEPH_OK;
}

static neph_result check_profile(neph_context *context, const neph_cloud_desc *desc) {
  const double *profile = desc->profile;
  for (int i = 1; i < NEPH_CLOUD_PROFILE_POINTS; i++)
    if (profile[i] < profile[i - 1])
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "%s.profile[%d] is %g, must not be below profile[%d], which is %g: a profile never falls",
                     np_cloud_desc_name(desc), i, profile[i], i - 1, profile[i - 1]);
  if (profile[NEPH_CLOUD_PROFILE_POINTS - 1] > 0) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.profile is 0 at the top, must be above it",
                 np_cloud_desc_name(desc));
}

static const char *const cells_kinds[] = {
    [NEPH_CLOUD_CELLS_NONE] = "none", [NEPH_CLOUD_CELLS_OPEN] = "open", [NEPH_CLOUD_CELLS_CLOSED] = "closed"};

enum { CELLS_KIND_COUNT = sizeof cells_kinds / sizeof *cells_kinds };

static neph_result refuse_model(neph_context *context, const neph_cloud_desc *desc) {
  np_text list = {.context = context};
  const np_cloud_kind *kind;
  for (int i = 0; (kind = np_cloud_kind_get((neph_cloud_model)i)); i++)
    np_text_add(&list, "%s%s (%d)",
                !i                                             ? ""
                : np_cloud_kind_get((neph_cloud_model)(i + 1)) ? ", "
                                                               : " or ",
                kind->name, i);
  if (list.has_failed) return np_text_end(&list, NEPH_OK);
  return np_text_end(&list, np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.model is %d, must be %s",
                                    np_cloud_desc_name(desc), (int)desc->model, np_text_get(&list)));
}

static neph_result check_model(neph_context *context, const neph_cloud_desc *desc) {
  if (!np_cloud_kind_get(desc->model)) return refuse_model(context, desc);
  if ((unsigned)desc->cells_kind >= CELLS_KIND_COUNT)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s.cells.kind is %d, must be none (0), open (1) or closed (2)", np_cloud_desc_name(desc),
                   (int)desc->cells_kind);
  if (desc->trails < 1 || desc->trails > NEPH_CLOUD_TRAILS_MAX)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.trails is %u, must be in [1, %d]",
                   np_cloud_desc_name(desc), desc->trails, (int)NEPH_CLOUD_TRAILS_MAX);
  if (desc->sublayers >= 1 && desc->sublayers <= 16) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.sublayers is %u, must be in [1, 16]",
                 np_cloud_desc_name(desc), desc->sublayers);
}

/* Checks the channels of a picture. */
static neph_result check_map(neph_context *context, const neph_cloud_desc *desc) {
  int q = 0;
  while (q < NEPH_CLOUD_MAP_QUANTITY_COUNT && !desc->map_channels[q]) q++;
  if (!desc->map_file && q < NEPH_CLOUD_MAP_QUANTITY_COUNT)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s.map.%s is channel %s of no picture, must come with an EXR or PNG", np_cloud_desc_name(desc),
                   np_cloud_map_quantity_get_name((neph_cloud_map_quantity)q), desc->map_channels[q]);
  return NEPH_OK;
}

neph_result np_cloud_desc_read(neph_context *context, const neph_cloud_desc *desc, neph_cloud_desc *out_desc) {
  static const neph_cloud_desc defaults = NEPH_CLOUD_DESC_DEFAULT;
  neph_result result = np_desc_read(context, "neph_cloud_desc", &defaults, sizeof defaults, desc, out_desc);
  for (int i = 0; i < FIELD_COUNT && !result; i++) result = check_field(context, out_desc, &fields[i]);
  if (!result) result = check_model(context, out_desc);
  if (!result && out_desc->has_profile) result = check_profile(context, out_desc);
  if (!result) result = check_map(context, out_desc);
  if (!result) result = np_shape_check(context, out_desc);
  if (!result) result = np_repeat_check(context, out_desc);
  return result;
}

static void name_channel(neph_cloud_map_quantity quantity, char *out, size_t size) {
  np_print(out, size, "map_channel_%s", np_cloud_map_quantity_get_name(quantity));
}

/* Writes the picture's hash, which identifies it, and its file name. */
static neph_result put_map(neph_context *context, np_json *json, const neph_cloud_desc *desc) {
  if (!desc->map_file) return NEPH_OK;
  char hash[33];
  neph_result result = np_cloud_map_hash(context, desc->map_file, hash);
  if (result) return result;
  np_json_put_text(json, "map_file", desc->map_file);
  np_json_put_text(json, "map_hash", hash);
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT; q++) {
    char key[32];
    name_channel((neph_cloud_map_quantity)q, key, sizeof key);
    if (desc->map_channels[q]) np_json_put_text(json, key, desc->map_channels[q]);
  }
  return NEPH_OK;
}

static neph_result put_ground(neph_context *context, np_json *json, const neph_cloud_desc *desc) {
  char id[33];
  if (!np_cloud_desc_has_ground(desc)) return NEPH_OK;
  const neph_result result = np_ground_map_identify(context, desc, id);
  if (!result) np_json_put_text(json, "ground", id);
  return result;
}

static void put_levels(np_json *json, const neph_bake_desc *bake) {
  np_json_put_integer(json, "lod_count", bake->lod_count);
  np_json_put_reals(json, "lod_viewer_min_m", bake->lod_viewer_min_m, 3);
  np_json_put_reals(json, "lod_viewer_max_m", bake->lod_viewer_max_m, 3);
  np_json_put_real(json, "lod_angle_rad", bake->lod_angle_rad);
}

neph_result np_cloud_desc_to_json(neph_context *context, const neph_cloud_desc *desc, const neph_bake_desc *bake,
                                  char **out_text) {
  np_json *json = np_json_create(context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  char seed[24];
  np_print(seed, sizeof seed, "%llu", (unsigned long long)desc->seed);
  np_json_put_text(json, "seed", seed); /* text, because JSON numbers lose the last bits of 64 */
  np_json_put_text(json, "model", np_cloud_kind_get(desc->model)->name);
  np_json_put_text(json, "cells_kind", cells_kinds[desc->cells_kind]);
  np_json_put_integer(json, "sublayers", desc->sublayers);
  np_json_put_integer(json, "trails", desc->trails);
  np_json_put_bool(json, "has_profile", desc->has_profile);
  np_json_put_bool(json, "has_map_size", desc->has_map_size);
  np_json_put_bool(json, "has_winds", desc->has_winds);
  np_json_put_bool(json, "is_map_tiling", desc->is_map_tiling);
  neph_result result = put_map(context, json, desc);
  if (!result) result = put_ground(context, json, desc);
  if (desc->measurement) np_json_put_text(json, "measurement", desc->measurement->id);
  if (!result) result = np_shape_put_json(context, json, desc);
  if (result) {
    np_json_destroy(json);
    return result;
  }
  for (int i = 0; i < FIELD_COUNT; i++) {
    const double *values = get_values(desc, &fields[i]);
    if (fields[i].count == 1)
      np_json_put_real(json, fields[i].name, *values);
    else
      np_json_put_reals(json, fields[i].name, values, (size_t)fields[i].count);
  }
  np_json_put_real(json, "planet_radius_m", bake->planet_radius_m);
  np_json_put_real(json, "prune_per_m", bake->prune_per_m);
  np_json_put_bool(json, "has_region", bake->has_region);
  np_json_put_reals(json, "region_min_m", bake->region_min_m, 3);
  np_json_put_reals(json, "region_max_m", bake->region_max_m, 3);
  if (bake->lod_count > 1) put_levels(json, bake);
  return np_json_finish(json, out_text);
}

static bool read_model(const np_json_value *json, neph_cloud_desc *desc) {
  const char *text = np_json_get_text(json, "model");
  const np_cloud_kind *kind;
  int i = 0;
  while ((kind = np_cloud_kind_get((neph_cloud_model)i)) && text && strcmp(text, kind->name)) i++;
  desc->model = (neph_cloud_model)i;
  return text && kind;
}

/* Reads the kind of cells, which older files lack. */
static bool read_cells_kind(const np_json_value *json, neph_cloud_desc *desc) {
  const char *text = np_json_get_text(json, "cells_kind");
  int i = 0;
  while (text && i < CELLS_KIND_COUNT && strcmp(text, cells_kinds[i])) i++;
  desc->cells_kind = (neph_cloud_cells)i;
  return i < CELLS_KIND_COUNT;
}

/* Reads the levels, which a bake of one level lacks. */
static bool read_levels(const np_json_value *json, neph_bake_desc *bake) {
  double count;
  if (!np_json_get_reals(json, "lod_count", &count, 1)) return true;
  bake->lod_count = (unsigned)count;
  return np_json_get_reals(json, "lod_viewer_min_m", bake->lod_viewer_min_m, 3) &&
         np_json_get_reals(json, "lod_viewer_max_m", bake->lod_viewer_max_m, 3) &&
         np_json_get_reals(json, "lod_angle_rad", &bake->lod_angle_rad, 1);
}

static bool read_values(const np_json_value *json, neph_cloud_desc *desc, neph_bake_desc *bake) {
  double number;
  const char *text = np_json_get_text(json, "seed");
  if (!text || sscanf(text, "%" SCNu64, &desc->seed) != 1 || !read_model(json, desc) || !read_cells_kind(json, desc))
    return false;
  if (!np_json_get_reals(json, "sublayers", &number, 1)) return false;
  desc->sublayers = (unsigned)number;
  if (np_json_get_reals(json, "trails", &number, 1)) desc->trails = (unsigned)number;
  for (int i = 0; i < FIELD_COUNT; i++) {
    double *values = (double *)(void *)((char *)desc + fields[i].offset);
    if (!np_json_get_reals(json, fields[i].name, values, (size_t)fields[i].count) && i < FIELD_AGE) return false;
  }
  (void)np_json_get_bool(json, "has_winds", &desc->has_winds);
  return np_json_get_bool(json, "has_profile", &desc->has_profile) &&
         np_json_get_bool(json, "has_map_size", &desc->has_map_size) &&
         np_json_get_bool(json, "is_map_tiling", &desc->is_map_tiling) &&
         np_json_get_reals(json, "planet_radius_m", &bake->planet_radius_m, 1) &&
         np_json_get_reals(json, "prune_per_m", &bake->prune_per_m, 1) &&
         np_json_get_bool(json, "has_region", &bake->has_region) &&
         np_json_get_reals(json, "region_min_m", bake->region_min_m, 3) &&
         np_json_get_reals(json, "region_max_m", bake->region_max_m, 3) && read_levels(json, bake);
}

/* Reads the picture; the description owns the texts. A ground or a measured map is only named. */
static neph_result read_map(neph_context *context, const np_json_value *json, neph_cloud_desc *desc) {
  const char *text = np_json_get_text(json, "ground");
  if (!text) text = np_json_get_text(json, "measurement");
  if (text && !(desc->ground_id = np_alloc_text(context, text))) return NEPH_ERROR_OUT_OF_MEMORY;
  text = np_json_get_text(json, "map_file");
  if (!text) return NEPH_OK;
  if (!(desc->map_file = np_alloc_text(context, text))) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT; q++) {
    char key[32];
    name_channel((neph_cloud_map_quantity)q, key, sizeof key);
    text = np_json_get_text(json, key);
    if (text && !(desc->map_channels[q] = np_alloc_text(context, text))) return NEPH_ERROR_OUT_OF_MEMORY;
  }
  return NEPH_OK;
}

static void free_text(neph_context *context, const char **text) {
  np_alloc_free(context, (void *)(uintptr_t)*text);
  *text = NULL;
}

void np_cloud_desc_clear(neph_context *context, neph_cloud_desc *desc) {
  free_text(context, &desc->ground_id);
  np_shape_clear_desc(context, desc);
  free_text(context, &desc->map_file);
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT; q++) free_text(context, &desc->map_channels[q]);
}

neph_result np_cloud_desc_from_json(neph_context *context, const char *file, const char *text,
                                    neph_cloud_desc *out_desc, neph_bake_desc *bake) {
  *out_desc = (neph_cloud_desc)NEPH_CLOUD_DESC_DEFAULT;
  np_json_value *json = np_json_read(text);
  neph_result result = NEPH_OK;
  if (!json || !read_values(json, out_desc, bake))
    result = np_fail(context, NEPH_ERROR_BAD_FILE, "%s: nephos:params is not what this version of nephos writes", file);
  if (!result) result = read_map(context, json, out_desc);
  if (!result) result = np_shape_read_json(context, json, out_desc);
  np_json_value_destroy(json);
  if (result) np_cloud_desc_clear(context, out_desc);
  return result;
}
