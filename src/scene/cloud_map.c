/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/cloud_map.h"

#include <math.h>
#include <string.h>

#include "cloud/cloud_name.h"
#include "core/alloc.h"
#include "core/frame_name.h"
#include "core/hash.h"
#include "core/text.h"

enum { KEY_SIZE = 80 };

/* Pixel size in voxels below which pixels are averaged: each pixel needs several columns. */
static const double pixel_voxels_min = 1.5;

/* Source of a description, on the heap: descriptions point to it. */
typedef struct map_source {
  neph_cloud_measurement_source source;
  char id[33], key[64];
  char *path, *top_path; /* files in the frame */
  np_scene_map map;      /* borrows its patterns */
  np_phase_source phase_source;
  const char *phase_table; /* borrowed; NULL: none */
  double albedo, ground_albedo, planet_radius_m, voxel_m, thickness_m;
  bool has_place, has_ground_map, has_size;
  np_geographic place;
  double center_m[2], extent_m[2], reach_m[2], size_m[2];
} map_source;

/* Rasters that a measurement borrows values from. */
typedef struct loaded_map {
  np_map_raster depth, top;
  double displacement_m[2]; /* displacement of the picture */
} loaded_map;

/* ---- Loading ---- */

static np_map_raster_request make_request(const map_source *s, const char *path, const char *key, unsigned band) {
  np_map_raster_request request = {.path = path,
                                   .key = key,
                                   .band = band,
                                   .has_place = s->has_place,
                                   .place = s->place,
                                   .planet_radius_m = s->planet_radius_m,
                                   .has_size = s->has_size};
  for (int a = 0; a < 2; a++) {
    request.min_m[a] = s->center_m[a] - 0.5 * s->extent_m[a] - s->reach_m[a];
    request.max_m[a] = s->center_m[a] + 0.5 * s->extent_m[a] + s->reach_m[a];
    request.size_m[a] = s->size_m[a];
  }
  return request;
}

/* Averages depths in squares of `factor` pixels; pixels without data do not count. */
static void average(np_map_raster *raster, unsigned factor) {
  const unsigned width = (raster->width + factor - 1) / factor, height = (raster->height + factor - 1) / factor;
  for (unsigned row = 0; row < height; row++)
    for (unsigned column = 0; column < width; column++) {
      double sum = 0, count = 0;
      for (unsigned n = 0; n < factor * factor; n++) {
        const unsigned i = column * factor + n % factor, j = row * factor + n / factor;
        const float value =
            i < raster->width && j < raster->height ? raster->values[(size_t)j * raster->width + i] : NAN;
        sum += isnan(value) ? 0 : (double)value;
        count += !isnan(value);
      }
      /* The place is at or before the first of its square's samples, which have been read. */
      raster->values[(size_t)row * width + column] = count > 0 ? (float)(sum / count) : NAN;
    }
  raster->width = width;
  raster->height = height;
  for (size_t n = 0; n < 2 * (size_t)raster->node_count * raster->node_count; n++)
    raster->node_pixels[n] = (raster->node_pixels[n] + 0.5) / factor - 0.5;
}

static void average_fine_pixels(const map_source *s, neph_context *context, np_map_raster *raster) {
  const unsigned factor = (unsigned)fmax(1.0, ceil(pixel_voxels_min * s->voxel_m / raster->pixel_m - 1e-6));
  if (factor == 1) return;
  np_log(context, NEPH_LOG_WARNING,
         "%s: its pixels are %.3g m, finer than %g voxels of %g m: their optical depths are averaged in squares of %u",
         s->path, raster->pixel_m, pixel_voxels_min, s->voxel_m, factor);
  average(raster, factor);
}

static neph_cloud_raster describe_raster(const map_source *s, const np_map_raster *raster) {
  const np_map_raster_request box = make_request(s, s->path, s->key, 0);
  neph_cloud_raster out = {.width = raster->width,
                           .height = raster->height,
                           .values = raster->values,
                           .node_count = {raster->node_count, raster->node_count},
                           .node_pixels = raster->node_pixels};
  memcpy(out.min_m, box.min_m, sizeof out.min_m);
  memcpy(out.max_m, box.max_m, sizeof out.max_m);
  return out;
}

static np_map_conversion make_conversion(const map_source *s, neph_context *context, const char *path) {
  return (np_map_conversion){.context = context,
                             .map = &s->map,
                             .path = path,
                             .key = s->key,
                             .phase_source = s->phase_source,
                             .phase_table = s->phase_table,
                             .albedo = s->albedo,
                             .ground_albedo = s->ground_albedo};
}

static np_map_raster_request request_depths(const map_source *s, char key[KEY_SIZE]) {
  np_print(key, KEY_SIZE, "%s.file", s->key);
  return make_request(s, s->path, key, s->map.band);
}

static np_map_raster_request request_tops(const map_source *s, char key[KEY_SIZE]) {
  np_print(key, KEY_SIZE, "%s.top.file", s->key);
  return make_request(s, s->top_path, key, s->map.top_band);
}

static neph_result load_depths(const map_source *s, neph_context *context, loaded_map *loaded) {
  np_map_raster *out = &loaded->depth;
  char key[KEY_SIZE];
  const np_map_raster_request request = request_depths(s, key);
  const np_map_conversion conversion = make_conversion(s, context, s->path);
  neph_result result = np_map_raster_load(context, &request, out);
  if (!result) result = np_map_convert_depths(&conversion, out);
  if (!result) np_map_compute_displacement(&conversion, out, s->thickness_m, loaded->displacement_m);
  if (!result) average_fine_pixels(s, context, out);
  return result;
}

static neph_result load_tops(const map_source *s, neph_context *context, np_map_raster *out) {
  char key[KEY_SIZE];
  if (!s->top_path) return NEPH_OK;
  const np_map_raster_request request = request_tops(s, key);
  const np_map_conversion conversion = make_conversion(s, context, s->top_path);
  const neph_result result = np_map_raster_load(context, &request, out);
  return result ? result : np_map_convert_tops(&conversion, out);
}

static void unload(void *user, neph_context *context, neph_cloud_measurement *measurement) {
  loaded_map *loaded = measurement->owner;
  (void)user;
  if (!loaded) return;
  np_map_raster_clear(&loaded->depth);
  np_map_raster_clear(&loaded->top);
  np_alloc_free(context, loaded);
  *measurement = (neph_cloud_measurement){.owner = NULL};
}

static neph_result check_place(const map_source *s, neph_context *context) {
  if (s->has_place || s->has_size || !s->has_ground_map) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_SCENE,
                 "place is missing: a measured map and a height field in one scene stand by their coordinates, and "
                 "place.latitude and place.longitude say where the origin is");
}

static neph_result load(void *user, neph_context *context, neph_cloud_measurement *out) {
  const map_source *s = user;
  *out = (neph_cloud_measurement){.threshold = s->map.threshold};
  neph_result result = check_place(s, context);
  loaded_map *loaded = result ? NULL : np_alloc(context, 1, sizeof *loaded);
  if (!loaded) return result ? result : NEPH_ERROR_OUT_OF_MEMORY;
  out->owner = loaded;
  loaded->depth.context = loaded->top.context = context;
  result = load_depths(s, context, loaded);
  if (!result) result = load_tops(s, context, &loaded->top);
  if (result) {
    unload(user, context, out);
    return result;
  }
  out->optical_depth = describe_raster(s, &loaded->depth);
  for (int a = 0; a < 2; a++) {
    out->optical_depth.min_m[a] -= loaded->displacement_m[a];
    out->optical_depth.max_m[a] -= loaded->displacement_m[a];
  }
  if (s->top_path) out->top_m = describe_raster(s, &loaded->top);
  return NEPH_OK;
}

/* ---- Source ---- */

static neph_result compute_id(neph_context *context, map_source *s) {
  np_hash *hash = np_hash_create(context);
  np_hash_add_file(hash, s->path);
  np_hash_add_file(hash, s->top_path);
  np_hash_add_file(hash, s->phase_table);
  NP_HASH_ADD(hash, s->map.quantity);
  NP_HASH_ADD(hash, s->map.band);
  NP_HASH_ADD(hash, s->map.has_elevation);
  NP_HASH_ADD(hash, s->map.has_azimuth);
  NP_HASH_ADD(hash, s->map.sun_rad);
  NP_HASH_ADD(hash, s->map.view_rad);
  NP_HASH_ADD(hash, s->map.threshold);
  NP_HASH_ADD(hash, s->map.depth_max);
  NP_HASH_ADD(hash, s->map.top_quantity);
  NP_HASH_ADD(hash, s->map.top_band);
  NP_HASH_ADD(hash, s->map.ground_temperature_k);
  np_hash_add(hash, &s->phase_source, sizeof s->phase_source);
  NP_HASH_ADD(hash, s->albedo);
  NP_HASH_ADD(hash, s->ground_albedo);
  NP_HASH_ADD(hash, s->planet_radius_m);
  NP_HASH_ADD(hash, s->thickness_m);
  NP_HASH_ADD(hash, s->has_place);
  NP_HASH_ADD(hash, s->place.latitude_rad);
  NP_HASH_ADD(hash, s->place.longitude_rad);
  NP_HASH_ADD(hash, s->has_size);
  NP_HASH_ADD(hash, s->size_m);
  return np_hash_finish(hash, s->id);
}

/* Name of a file in the scene's frame; NULL without a file. */
static neph_result name_file(const neph_scene *scene, const np_scene_cloud *cloud, const char *pattern, char **out) {
  *out = NULL;
  if (!pattern) return NEPH_OK;
  *out = np_frame_name_make(scene->context, pattern, np_scene_cloud_get_number(cloud, scene->frame));
  return *out ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void fill_source(const neph_scene *scene, const np_scene_cloud *cloud, map_source *s) {
  const neph_cloud_desc *bake = &cloud->bake;
  s->map = cloud->map;
  s->phase_source = cloud->phase_source;
  s->phase_table = cloud->phase_source.kind == NEPH_PHASE_TABLE ? cloud->phase_table : NULL;
  s->albedo = cloud->albedo[1];
  s->ground_albedo = cloud->map.has_ground_albedo ? cloud->map.ground_albedo : np_scene_get_ground_albedo(scene)[1];
  s->planet_radius_m = scene->atmosphere.planet_radius_m;
  s->voxel_m = bake->voxel_m;
  s->thickness_m = bake->thickness_m;
  s->has_place = scene->has_place;
  s->place = (np_geographic){scene->latitude_rad, scene->longitude_rad};
  s->has_ground_map = scene->terrain.heightfield != NULL;
  s->has_size = bake->has_map_size;
  np_print(s->key, sizeof s->key, "%s.map", np_cloud_desc_name(bake));
  for (int a = 0; a < 2; a++) {
    const double time_s = bake->time_s + cloud->frame_time_s * (scene->frame - 1.0);
    s->center_m[a] = bake->center_m[a];
    s->extent_m[a] = bake->extent_m[a];
    s->size_m[a] = bake->map_size_m[a];
    s->reach_m[a] = fabs(bake->wind_m_s[a] * time_s);
    if (np_map_is_displaced(&s->map)) s->reach_m[a] += NP_MAP_DISPLACEMENT_MAX * bake->thickness_m;
  }
  s->source = (neph_cloud_measurement_source){.name = s->path, .id = s->id, .load = load, .unload = unload, .user = s};
}

neph_result np_cloud_map_source_make(const neph_scene *scene, np_scene_cloud *cloud) {
  neph_context *context = scene->context;
  if (!cloud->map.file || !cloud->is_baked) return NEPH_OK;
  map_source *s = np_alloc(context, 1, sizeof *s);
  if (!s) return NEPH_ERROR_OUT_OF_MEMORY;
  cloud->bake.measurement = &s->source;
  s->source.user = s;
  neph_result result = name_file(scene, cloud, cloud->map.file, &s->path);
  if (!result) result = name_file(scene, cloud, cloud->map.top_file, &s->top_path);
  if (result) return result;
  fill_source(scene, cloud, s);
  return compute_id(context, s);
}

neph_result np_cloud_map_check(neph_context *context, const np_scene_cloud *cloud) {
  char key[KEY_SIZE];
  if (!cloud->bake.measurement) return NEPH_OK;
  const map_source *s = cloud->bake.measurement->user;
  neph_result result = check_place(s, context);
  np_map_raster_request request = request_depths(s, key);
  if (!result) result = np_map_raster_check(context, &request);
  if (result || !s->top_path) return result;
  request = request_tops(s, key);
  return np_map_raster_check(context, &request);
}

void np_cloud_map_source_clear(neph_context *context, np_scene_cloud *cloud) {
  if (!cloud->bake.measurement) return;
  map_source *s = cloud->bake.measurement->user;
  cloud->bake.measurement = NULL;
  np_alloc_free(context, s->path);
  np_alloc_free(context, s->top_path);
  np_alloc_free(context, s);
}
