/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/terrain_source.h"

#include <math.h>

#include "core/given.h"
#include "core/units.h"
#include "terrain/mesh_ground.h"
#include "terrain/terrain_private.h"

/* ---- Rows ---- */

static neph_result check_file(neph_context *context, const np_terrain_source *source, const neph_terrain_desc *desc,
                              unsigned out_size[2]) {
  return np_heightfield_check(context, source->file, desc, out_size);
}

static neph_result load_field(neph_context *context, np_monitor *monitor, const np_terrain_source *source,
                              const neph_terrain_desc *desc, np_heightfield *out_field) {
  np_monitor_set_part(monitor, np_monitor_whole, 0.0, 0.6);
  np_monitor_set_stage(monitor, "reading heights");
  return np_heightfield_load(context, monitor, source->file, desc, out_field);
}

static neph_result make_ridges(neph_context *context, np_monitor *monitor, const np_terrain_source *source,
                               const neph_terrain_desc *desc, np_heightfield *out_field) {
  np_monitor_set_part(monitor, np_monitor_whole, 0.0, 0.6);
  return np_heightfield_make_ridges(context, monitor, source->ridges, desc, out_field);
}

static neph_result make_nothing(neph_context *context, np_monitor *monitor, const np_terrain_source *source,
                                const neph_terrain_desc *desc, np_heightfield *out_field) {
  (void)context, (void)monitor, (void)source, (void)desc;
  *out_field = (np_heightfield){0};
  return NEPH_OK;
}

const np_terrain_row np_terrain_rows[NP_TERRAIN_KIND_COUNT] = {
    [NP_TERRAIN_NONE] = {"the scene has no terrain", NULL, NULL},
    [NP_TERRAIN_HEIGHTFIELD] = {"height field ", check_file, load_field},
    [NP_TERRAIN_RIDGES] = {"ridges from noise", NULL, make_ridges},
    [NP_TERRAIN_MESH] = {"", NULL, make_nothing},
    [NP_TERRAIN_GIVEN] = {"a terrain that a call has set", NULL, NULL},
};

/* ---- All kinds ---- */

static neph_result check_albedo(neph_context *context, const char *name, const double albedo[3]) {
  for (int band = 0; band < 3; band++)
    if (!(albedo[band] >= 0 && albedo[band] <= 1))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain %s[%d] is %g, must be in [0, 1]", name, band,
                     albedo[band]);
  return NEPH_OK;
}

static neph_result check_slope(neph_context *context, const char *name, double slope_rad) {
  if (slope_rad >= 0 && slope_rad <= 0.5 * NP_PI) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain %s is %g, must be in [0, pi/2]", name, slope_rad);
}

static neph_result check_choices(neph_context *context, const neph_terrain_desc *desc) {
  const struct {
    const char *name;
    unsigned value, last;
  } choices[] = {{"edge", desc->edge, NEPH_TERRAIN_EDGE_WALL},
                 {"unit", desc->unit, NEPH_HEIGHT_UNIT_US_SURVEY_FOOT},
                 {"encoding", desc->encoding, NEPH_HEIGHT_ENCODING_TERRARIUM},
                 {"raw_type", desc->raw_type, NEPH_RAW_TYPE_FLOAT32},
                 {"ground_cover", desc->ground_cover, NEPH_GROUND_COVER_SAVANNA}};
  for (size_t i = 0; i < sizeof choices / sizeof *choices; i++)
    if (choices[i].value > choices[i].last)
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain %s is %u, must be in [0, %u]", choices[i].name,
                     choices[i].value, choices[i].last);
  return NEPH_OK;
}

static neph_result check_desc(neph_context *context, const neph_terrain_desc *desc) {
  if (!(desc->planet_radius_m >= 1e3 && desc->planet_radius_m <= 1e9))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain planet_radius_m is %g, must be in [1e3, 1e9]",
                   desc->planet_radius_m);
  if (!(desc->width_m > 0 && desc->width_m <= desc->planet_radius_m))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "terrain.width is %g m, must be above 0 and at most the planet's radius", desc->width_m);
  if (!(fabs(desc->latitude_rad) <= 0.5 * NP_PI) || !isfinite(desc->longitude_rad))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "terrain place is at latitude %g, longitude %g rad, must be in [-pi/2, pi/2] and finite",
                   desc->latitude_rad, desc->longitude_rad);
  if (!(fabs(desc->height_min_m) <= 1e5 && fabs(desc->height_max_m) <= 1e5))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain heights are %g to %g m, must be within 100 km of 0",
                   desc->height_min_m, desc->height_max_m);
  neph_result result = check_choices(context, desc);
  if (!result) result = check_albedo(context, "ground_albedo", desc->ground_albedo);
  if (!result) result = check_albedo(context, "rock_albedo", desc->rock_albedo);
  if (!result) result = check_albedo(context, "snow_albedo", desc->snow_albedo);
  if (!result) result = check_slope(context, "rock_slope_rad", desc->rock_slope_rad);
  if (!result) result = check_slope(context, "snow_slope_rad", desc->snow_slope_rad);
  if (result || fabs(desc->snow_level_m) <= 1e5) return result;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain snow_level_m is %g, must be within 100 km of 0",
                 desc->snow_level_m);
}

static neph_result read_desc(neph_context *context, const neph_terrain_desc *desc, neph_terrain_desc *out) {
  const neph_terrain_desc defaults = NEPH_TERRAIN_DESC_DEFAULT;
  neph_result result = np_desc_read(context, "neph_terrain_desc", &defaults, sizeof defaults, desc, out);
  return result ? result : check_desc(context, out);
}

neph_result np_terrain_create(neph_context *context, const np_terrain_source *source, const neph_terrain_desc *desc,
                              neph_terrain **out_terrain) {
  *out_terrain = NULL;
  neph_terrain_desc read;
  neph_result result = read_desc(context, desc, &read);
  if (result) return result;
  const unsigned float_mode = np_float_mode_enter();
  np_monitor monitor;
  np_monitor_start(&monitor, context, read.progress, read.progress_user);
  np_heightfield field;
  if (read.mesh_file) result = np_mesh_ground_check(context, &read);
  if (!result) result = np_terrain_rows[source->kind].make_field(context, &monitor, source, &read, &field);
  if (!result) result = np_terrain_create_from_field(context, &field, &read, false, &monitor, out_terrain);
  np_float_mode_leave(float_mode);
  return result;
}

neph_result np_terrain_check_mesh(neph_context *context, const neph_terrain_desc *desc) {
  return np_mesh_ground_check(context, desc);
}

neph_result np_terrain_load_from_cache(neph_context *context, np_cache_entry *entry, const neph_terrain_desc *desc,
                                       neph_terrain **out_terrain) {
  *out_terrain = NULL;
  neph_terrain_desc read;
  np_heightfield field;
  neph_result result = read_desc(context, desc, &read);
  if (result || !np_heightfield_load_from_cache(entry, &field)) return result;
  const unsigned float_mode = np_float_mode_enter();
  np_monitor monitor;
  np_monitor_start(&monitor, context, read.progress, read.progress_user);
  result = np_terrain_create_from_field(context, &field, &read, true, &monitor, out_terrain);
  np_float_mode_leave(float_mode);
  return result;
}

neph_result neph_terrain_load(neph_context *context, const char *path, const neph_terrain_desc *desc,
                              neph_terrain **out_terrain) {
  if (NP_LACKS_OUT(context, out_terrain, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  const np_terrain_source source = {.kind = NP_TERRAIN_HEIGHTFIELD, .file = path};
  return np_terrain_create(context, &source, desc, out_terrain);
}

neph_result neph_terrain_create_ridges(neph_context *context, const neph_ridges_desc *ridges,
                                       const neph_terrain_desc *desc, neph_terrain **out_terrain) {
  if (NP_LACKS_OUT(context, out_terrain)) return NEPH_ERROR_INVALID_ARGUMENT;
  const np_terrain_source source = {.kind = NP_TERRAIN_RIDGES, .ridges = ridges};
  return np_terrain_create(context, &source, desc, out_terrain);
}

neph_result neph_terrain_load_mesh(neph_context *context, const neph_terrain_desc *desc, neph_terrain **out_terrain) {
  if (NP_LACKS_OUT(context, out_terrain)) return NEPH_ERROR_INVALID_ARGUMENT;
  const np_terrain_source source = {.kind = NP_TERRAIN_MESH};
  if (desc && desc->mesh_file) return np_terrain_create(context, &source, desc, out_terrain);
  *out_terrain = NULL;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain mesh_file is NULL, must name a file");
}
