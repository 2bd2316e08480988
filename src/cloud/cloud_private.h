/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of the cloud module: a description becomes a weather map, both become a density model, and a bake samples
 * it. Lengths are metres; x and y count from the field's centre, heights from the cloud base. */
#ifndef NP_CLOUD_CLOUD_PRIVATE_H
#define NP_CLOUD_CLOUD_PRIVATE_H

#include <nephos/cloud.h>

#include "core/parallel.h"
#include "noise/noise.h"
#include "volume/sparse_grid.h"

/* Streams of random numbers that share a description's seed; their order is part of what a seed means. */
typedef enum np_cloud_stream {
  NP_CLOUD_STREAM_CELLS,
  NP_CLOUD_STREAM_SMALL_CELLS,
  NP_CLOUD_STREAM_WARP_X,
  NP_CLOUD_STREAM_WARP_Y,
  NP_CLOUD_STREAM_GROUPS,
  NP_CLOUD_STREAM_BASE,
  NP_CLOUD_STREAM_CURL,
  NP_CLOUD_STREAM_DETAIL, /* one more for each octave */
  NP_CLOUD_STREAM_SHEET = 32,
  NP_CLOUD_STREAM_RAIN
} np_cloud_stream;

/* ---- Descriptions: cloud_desc.c ---- */

/* Copies a caller's description (NULL: the defaults) and checks every field. */
neph_result np_cloud_desc_read(neph_context *context, const neph_cloud_desc *desc, neph_cloud_desc *out_desc);

/* The description, and what of the bake decides values, as JSON, to be freed with np_alloc_free. */
neph_result np_cloud_desc_to_json(neph_context *context, const neph_cloud_desc *desc, const neph_bake_desc *bake,
                                  char **out_text);

/* Reads such JSON; `file` is where it was found, for messages. The descriptions are still to be checked. */
neph_result np_cloud_desc_from_json(neph_context *context, const char *file, const char *text,
                                    neph_cloud_desc *out_desc, neph_bake_desc *bake);

/* ---- Presets: presets.c ---- */

bool np_cloud_has_preset(const char *name);

/* Their names, parted by ", ". */
void np_cloud_list_presets(char *out, size_t size);

/* ---- Weather map: weather_map.c ---- */

/* Height of a landscape: of rounded cells, or, for a slab, of noise. A waterline through it, chosen by the coverage,
 * parts cloud from sky. A second landscape, of the largest cells alone and wider, holds the anvils. */
typedef struct np_weather_map {
  neph_context *context; /* borrowed */
  int32_t size[2];       /* texels along x, y */
  float origin_m[2];     /* of the first texel */
  float step_m;
  float radius_m; /* a lone cell is a − r²/radius²: its outline at waterline t is a circle of radius·√(a − t) */
  float lowest, highest; /* over all texels */
  float *values;         /* x fastest */
  float *anvils;         /* NULL: none */
} np_weather_map;

/* The map at the description's time. */
neph_result np_weather_map_build(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                 np_weather_map *out_map);
void np_weather_map_clear(np_weather_map *map); /* a zeroed map is allowed */

/* Of `values` or `anvils`, bilinear; the border's value beyond it. */
float np_weather_map_sample(const np_weather_map *map, const float *values, float x_m, float y_m);

/* No sample in the rectangle is larger. */
float np_weather_map_get_max(const np_weather_map *map, const float *values, const float min_m[2],
                             const float max_m[2]);

/* Along the wind, or along x in a calm. */
void np_cloud_desc_find_heading(const neph_cloud_desc *desc, float out_heading[2]);

/* ---- Density: cloud_density.c ---- */

enum { NP_CLOUD_OCTAVES_MAX = 6, NP_CLOUD_BLOCK = NP_LEAF_SIZE };

typedef struct np_cloud_octave {
  np_noise_lattice lattice;
  float frequency_per_m;
  float amplitude; /* in units of depth, see cloud_density.c */
  float mean;      /* of the noise */
} np_cloud_octave;

typedef struct np_cloud_model {
  neph_cloud_desc desc;
  np_weather_map map;
  const np_noise_table *noise;
  float depth_scale, depth_offset; /* map value to depth: 0 at the outline, 1 in the heart of the largest cell */
  float slope_per_m;               /* of depth, at the outline of the largest cell */
  float edge;                      /* depth over which extinction rises from nothing to the core's */
  np_cloud_octave base, detail[NP_CLOUD_OCTAVES_MAX];
  unsigned detail_count, sheet_octave_count;
  float detail_gain_max, base_gain_max; /* largest that noise adds to depth */
  np_noise_lattice curl, rain;
  float curl_frequency_per_m, curl_distance_m;
  float drift_m[2], turnover; /* of the air since time 0, and of the billows, in their own size */
  float heading[2];
  float rain_depth_m; /* below the base */
  bool is_empty;      /* coverage 0 */
} np_cloud_model;

/* Builds the map, and sets its waterline so that the covered fraction of the sky is what was asked for: cloud_model.c.
 */
neph_result np_cloud_model_build(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                 np_cloud_model *out_model);
void np_cloud_model_clear(np_cloud_model *model); /* a zeroed model is allowed */

/* Positions to evaluate, at most NP_CLOUD_BLOCK of them. */
typedef struct np_cloud_points {
  size_t count;
  const float *x_m, *y_m, *height_m;
} np_cloud_points;

/* Extinction in 1/m. What it gives for a position depends on nothing else: not on neighbours, threads or kernels. */
void np_cloud_model_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

typedef struct np_cloud_box {
  float min_m[3], max_m[3]; /* x, y, height */
} np_cloud_box;

/* True only if there is no cloud anywhere in the box; costs no noise. */
bool np_cloud_model_is_empty(const np_cloud_model *model, const np_cloud_box *box);

/* ---- Bake: bake.c ---- */

/* Evaluates the model on a grid named `name`. On failure the grid is left cleared. */
neph_result np_cloud_bake_grid(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                               const char *name, np_monitor *monitor, np_sparse_grid *out_grid);

/* Copies a caller's description (NULL: the defaults) and checks it. */
neph_result np_cloud_bake_desc_read(neph_context *context, const neph_bake_desc *desc, neph_bake_desc *out_desc);

/* Whether a file was baked from this cloud for this planet, as its nephos:params say. Files without them, not ours, are
 * taken to be. */
neph_result np_cloud_file_is_current(neph_context *context, const char *path, const neph_cloud_desc *cloud,
                                     double planet_radius_m, bool *out_is_current);

/* ---- Levels of detail: bake_levels.c ---- */

/* A grid named `name`_`factor` of half the resolution; its transform is a bake's, without shear. On failure it is to be
 * cleared all the same. */
neph_result np_cloud_halve_grid(neph_context *context, const np_sparse_grid *fine, const char *name, unsigned factor,
                                np_sparse_grid *out_coarse);

#endif
