/* SPDX-License-Identifier: Apache-2.0 */
/* Description of a height-field file, in words or in JSON. */
#include <string.h>

#include "core/alloc.h"
#include "core/json.h"
#include "core/units.h"
#include "terrain/heightfield.h"

/* Pictures say neither where they lie nor how wide they are: PNG is shown in shares of its full scale. */
static const char *get_unit(const np_heightfield *field, const char *path) {
  const char *ending = strrchr(path, '.');
  return !field->has_place && ending && (ending[1] == 'p' || ending[1] == 'P') ? "full scale" : "m";
}

static double get_middle_latitude_deg(const np_heightfield *field) {
  return (field->south_rad + 0.5 * field->step_north_rad * (field->height - 1)) / NP_DEGREE;
}

static double get_middle_longitude_deg(const np_heightfield *field) {
  return (field->west_rad + 0.5 * field->step_east_rad * (field->width - 1)) / NP_DEGREE;
}

static neph_result describe_plain(neph_context *context, const np_heightfield *field, const char *path,
                                  char **out_text) {
  char *place =
      field->has_place
          ? np_alloc_printf(context, "center      %.6g, %.6g deg (latitude, longitude)\nspacing     %.6g arc seconds\n",
                            get_middle_latitude_deg(field), get_middle_longitude_deg(field),
                            field->step_north_rad / NP_DEGREE * 3600.0)
          : np_alloc_text(context, "");
  if (!place) return NEPH_ERROR_OUT_OF_MEMORY;
  *out_text = np_alloc_printf(context, "samples     %u x %u\nelevation   %.6g to %.6g %s\nvoids       %zu\n%s",
                              field->width, field->height, (double)field->elevation_min_m,
                              (double)field->elevation_max_m, get_unit(field, path), field->void_count, place);
  np_alloc_free(context, place);
  return *out_text ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result describe_json(neph_context *context, const np_heightfield *field, const char *path,
                                 char **out_text) {
  np_json *json = np_json_create(context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_json_put_integer(json, "width", field->width);
  np_json_put_integer(json, "height", field->height);
  np_json_put_real(json, "elevation_min", (double)field->elevation_min_m);
  np_json_put_real(json, "elevation_max", (double)field->elevation_max_m);
  np_json_put_text(json, "elevation_unit", get_unit(field, path));
  np_json_put_integer(json, "void_count", (int64_t)field->void_count);
  if (field->has_place) {
    np_json_put_real(json, "center_latitude_deg", get_middle_latitude_deg(field));
    np_json_put_real(json, "center_longitude_deg", get_middle_longitude_deg(field));
    np_json_put_real(json, "spacing_arcsec", field->step_north_rad / NP_DEGREE * 3600.0);
  }
  return np_json_finish(json, out_text);
}

neph_result neph_terrain_describe_file(neph_context *context, const char *path, neph_text_format format,
                                       char **out_text) {
  *out_text = NULL;
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.height_max_m = 1.0; /* PNG values as they are */
  np_heightfield field;
  neph_result result = np_heightfield_load(context, NULL, path, &desc, &field);
  if (result) return result;
  result = format == NEPH_TEXT_JSON ? describe_json(context, &field, path, out_text)
                                    : describe_plain(context, &field, path, out_text);
  np_heightfield_destroy(context, &field);
  return result;
}
