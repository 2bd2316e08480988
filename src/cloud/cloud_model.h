/* SPDX-License-Identifier: Apache-2.0 */
/* A density model: a description prepared for evaluation. Lengths are metres; x and y are relative to the field's
 * centre, heights to the cloud base. */
#ifndef NP_CLOUD_CLOUD_MODEL_H
#define NP_CLOUD_CLOUD_MODEL_H

#include <nephos/cloud.h>

#include "cloud/balls.h"
#include "cloud/cloud_kinds.h"
#include "cloud/cloud_wind.h"
#include "cloud/measured_columns.h"
#include "cloud/weather_map.h"
#include "core/parallel.h"
#include "noise/noise.h"
#include "volume/sparse_grid.h"

enum { NP_CLOUD_OCTAVES_MAX = 6, NP_CLOUD_BLOCK = NP_LEAF_SIZE };

typedef struct np_cloud_octave {
  np_noise_lattice lattice;
  float frequency_per_m;
  float amplitude;          /* in units of depth, see cells.c */
  float mean;               /* mean of the noise */
  float gain_max, loss_max; /* largest increase and decrease of depth by this octave and all finer ones */
} np_cloud_octave;

enum { NP_THERMAL_WARPS = 3 };

/* Noises on thermals, in metres. */
typedef struct np_thermal_noises {
  float billow_m; /* size of the largest billows: the description's, or less in a small field */
  np_noise_lattice warp[NP_THERMAL_WARPS], floor, wisps;
  float warp_size_m[NP_THERMAL_WARPS], warp_m[NP_THERMAL_WARPS]; /* rms of each component */
  float warp_max_m;                                              /* largest length of the sum */
  unsigned wisp_octaves;
  float wisp_size_m, fray_m;
  float wisp_m[NEPH_CLOUD_PARTS], wisp_max_m; /* depth of wisps at tops, flanks and base */
  float wisp_fineness[NEPH_CLOUD_PARTS];      /* number of octaves by which wisps of this part are finer */
  float floor_m, floor_size_m;            /* mean height of the base above its lowest point, and size of its noise */
  float crisp_m, soft_m;                  /* widths of young and old edges */
  float gain_max_m, loss_max_m;           /* largest displacement of the surface by noise, outwards and inwards */
  float fray_gain_max_m, fray_loss_max_m; /* part of these by fraying */
  float reach_max_m;                      /* largest outward reach of gain and wisps */
} np_thermal_noises;

/* Noises of sheets, rolls, streaks and lines. */
typedef struct np_kind_noises {
  np_noise_lattice coarse, medium, fine, eddies;
  float fine_m, edge_m; /* size of the fine noise; softness of the surface */
  float shear;          /* largest horizontal displacement over a metre of height; fall streaks alone */
  unsigned fine_octaves;
} np_kind_noises;

/* A contrail: its direction, the offset of its line from the field's centre, and its largest age. */
typedef struct np_trail {
  float along[2], offset_m, half_m, age, width_max_m;
  float drop; /* lowering of its level, in thicknesses */
} np_trail;

/* Rain below the base: noise of its streaks, and of the shafts in which it falls. */
typedef struct np_cloud_rain {
  np_noise_lattice streaks, shafts;
  float depth_m; /* below the lowest base; 0: no rain */
} np_cloud_rain;

/* Positions to evaluate, at most NP_CLOUD_BLOCK. */
struct np_cloud_points {
  size_t count;
  const float *x_m, *y_m, *height_m;
};

struct np_cloud_box {
  float min_m[3], max_m[3]; /* x, y, height */
};

struct np_cloud_model {
  const np_cloud_kind *kind;
  neph_context *context; /* borrowed */
  neph_cloud_desc desc;  /* its voxel is the grain: the bake's voxel, or an integer fraction of it */
  double planet_radius_m;
  unsigned sample_count; /* grains over the height of a voxel; a value is their mean */
  np_weather_map map;
  const np_noise_table *noise;
  float waterline; /* threshold of the map */
  double covered;  /* covered share of the field's sky with the best waterline so far */
  float depth_scale,
      depth_offset;  /* linear map from map value to depth: 0 at the outline, 1 in the centre of the largest cell */
  float slope_per_m; /* slope of depth at the outline of the largest cell */
  float edge;        /* depth over which extinction rises from 0 to the core's */
  np_cloud_octave base, detail[NP_CLOUD_OCTAVES_MAX];
  unsigned detail_count, sheet_octave_count;
  float detail_gain_max, base_gain_max; /* largest increase of depth by noise */
  float detail_loss_max;                /* largest decrease of depth by detail */
  float base_ramp_inverse;              /* 1/(share of a column over which its base thickens) */
  np_noise_lattice curl;
  float curl_frequency_per_m, curl_distance_m;
  float drift_m[2], turnover; /* drift of the air since time 0, and turnover of the billows in units of their size */
  float heading[2];
  np_cloud_rain rain;
  double lifetimes_per_s;
  np_ball_heap balls;   /* thermals and their billows; empty in other models */
  np_shape_grid *shape; /* distance grid of a mesh or a height map; NULL: none */
  np_thermal_noises thermals;
  np_cloud_wind wind;
  np_kind_noises noises;
  np_trail trails[NEPH_CLOUD_TRAILS_MAX];
  np_measured_columns columns; /* empty without a measured field */
  bool is_empty;               /* coverage 0 */
  bool is_sketch;              /* grains are twice as long, and the waterline is searched roughly */
};

#endif
