/* SPDX-License-Identifier: Apache-2.0 */
/* Description of a height-field file, in words or in JSON. */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/json.h"
#include "core/text.h"
#include "core/units.h"
#include "image/preview.h"
#include "terrain/heightfield.h"

/* Unit of heights. Pictures state neither position nor width: PNG is shown as shares of its full scale. */
static const char *get_unit(const np_heightfield *field, const char *path) {
  const char *ending = strrchr(path, '.');
  return !field->has_place && ending && (ending[1] == 'p' || ending[1] == 'P') ? "full scale" : "m";
}

/* Spacing of samples: an angle on a graticule of the planet, else a length. */
static double get_spacing(const np_heightfield *field, double step_rad) {
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  return field->has_chart ? step_rad * desc.planet_radius_m : step_rad / NP_DEGREE * 3600.0;
}

/* Prints the spacing: "30", or "30 x 20", from west to east and south to north, where those differ. */
static void print_spacing(const np_heightfield *field, char *out, size_t size) {
  const double east = get_spacing(field, field->step_east_rad), north = get_spacing(field, field->step_north_rad);
  if (fabs(east - north) > 1e-3 * north)
    np_print(out, size, "%.6g x %.6g", east, north);
  else
    np_print(out, size, "%.6g", north);
}

static neph_result describe_place(neph_context *context, const np_heightfield *field, char **out_text) {
  const np_geographic middle = np_heightfield_get_middle(field);
  char spacing[64];
  print_spacing(field, spacing, sizeof spacing);
  *out_text = field->has_place
                  ? np_alloc_printf(context, "center      %.6g, %.6g deg (latitude, longitude)\nspacing     %s %s\n",
                                    middle.latitude_rad / NP_DEGREE, middle.longitude_rad / NP_DEGREE, spacing,
                                    field->has_chart ? "m" : "arc seconds")
                  : np_alloc_text(context, "");
  return *out_text ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result describe_summary(neph_context *context, const np_raster_summary *raster, char **out_text) {
  *out_text = raster->format[0]
                  ? np_alloc_printf(context, "format      %s, %s\nsystem      %s\nunit        %s\n", raster->format,
                                    raster->sample_type,
                                    raster->crs[0] ? raster->crs : "none stated: terrain.crs or terrain.width place it",
                                    raster->unit[0] ? raster->unit : "none stated, taken for metres")
                  : np_alloc_text(context, "");
  return *out_text ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result describe_plain(neph_context *context, const np_heightfield *field, const np_raster_summary *raster,
                                  const char *path, char **out_text) {
  char *place = NULL, *summary = NULL;
  neph_result result = describe_place(context, field, &place);
  if (!result) result = describe_summary(context, raster, &summary);
  if (!result)
    *out_text =
        np_alloc_printf(context, "samples     %u x %u\nelevation   %.6g to %.6g %s\nvoids       %zu\n%s%s",
                        field->width, field->height, (double)field->elevation_min_m, (double)field->elevation_max_m,
                        get_unit(field, path), field->void_count, place, summary);
  np_alloc_free(context, place);
  np_alloc_free(context, summary);
  return *out_text ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result describe_json(neph_context *context, const np_heightfield *field, const np_raster_summary *raster,
                                 const char *path, char **out_text) {
  np_json *json = np_json_create(context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_json_put_integer(json, "width", field->width);
  np_json_put_integer(json, "height", field->height);
  np_json_put_real(json, "elevation_min", (double)field->elevation_min_m);
  np_json_put_real(json, "elevation_max", (double)field->elevation_max_m);
  np_json_put_text(json, "elevation_unit", get_unit(field, path));
  np_json_put_integer(json, "void_count", (int64_t)field->void_count);
  if (field->has_place) {
    const np_geographic middle = np_heightfield_get_middle(field);
    np_json_put_real(json, "center_latitude_deg", middle.latitude_rad / NP_DEGREE);
    np_json_put_real(json, "center_longitude_deg", middle.longitude_rad / NP_DEGREE);
    np_json_put_real(json, field->has_chart ? "spacing_m" : "spacing_arcsec",
                     get_spacing(field, field->step_north_rad));
    np_json_put_real(json, field->has_chart ? "spacing_east_m" : "spacing_east_arcsec",
                     get_spacing(field, field->step_east_rad));
  }
  if (raster->format[0]) {
    np_json_put_text(json, "format", raster->format);
    np_json_put_text(json, "sample_type", raster->sample_type);
    np_json_put_text(json, "coordinate_system", raster->crs);
    np_json_put_text(json, "file_unit", raster->unit);
  }
  return np_json_finish(json, out_text);
}

neph_result neph_terrain_describe_file(neph_context *context, const char *path, neph_text_format format,
                                       char **out_text) {
  if (NP_LACKS_OUT(context, out_text, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = np_preview_describe_file(context, path, format, out_text);
  if (result || *out_text) return result; /* a rendered picture is no height field */
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.height_max_m = 1.0; /* PNG values unscaled */
  np_heightfield field;
  np_raster_summary raster = {.file_count = 0};
  if (np_heightfield_is_raster(path)) result = np_heightfield_describe_raster(context, path, &desc, &raster);
  desc.has_width = !raster.has_place;
  if (!result) result = np_heightfield_load(context, NULL, path, &desc, &field);
  if (result) return result;
  result = format == NEPH_TEXT_JSON ? describe_json(context, &field, &raster, path, out_text)
                                    : describe_plain(context, &field, &raster, path, out_text);
  np_heightfield_destroy(context, &field);
  return result;
}
