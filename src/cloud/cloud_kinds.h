/* SPDX-License-Identifier: Apache-2.0 */
/* Kinds of cloud with a shape of their own, one row each, and the ground that they may stand on. */
#ifndef NP_CLOUD_CLOUD_KINDS_H
#define NP_CLOUD_CLOUD_KINDS_H

#include "cloud/cloud_private.h"

/* ---- Kinds: cloud_kinds.c ---- */

/* A box as the weather map knows it, for bounds. */
typedef struct np_kind_box {
  np_cloud_box box;
  np_interval strength, ground_m;       /* the latter above the lowest base; −INFINITY without ground */
  np_interval base_m;                   /* of columns */
  float field_min_m[2], field_max_m[2]; /* the columns, freed from the skew */
} np_kind_box;

/* Points that may hold cloud, with their columns; positions are in the air. */
typedef struct np_kind_points {
  size_t count;
  uint16_t index[NP_CLOUD_BLOCK];
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK]; /* heights above the column's base */
  float field_x_m[NP_CLOUD_BLOCK], field_y_m[NP_CLOUD_BLOCK];               /* freed from the skew */
  float strength[NP_CLOUD_BLOCK], ground_m[NP_CLOUD_BLOCK];                 /* as in np_kind_box */
  float sx[NP_CLOUD_BLOCK], sy[NP_CLOUD_BLOCK], sz[NP_CLOUD_BLOCK], noise[NP_CLOUD_BLOCK]; /* scratch */
} np_kind_points;

typedef struct np_cloud_kind {
  void (*set)(np_cloud_model *model); /* noises, from the description */
  /* Extinction at points whose columns have a strength above 0. */
  void (*eval)(const np_cloud_model *model, np_kind_points *points, float *out_extinction_per_m);
  /* True only if there is none in the box; columns may have a strength above 0. */
  bool (*is_empty)(const np_cloud_model *model, const np_kind_box *box);
} np_cloud_kind;

/* NULL: the model is none of these. */
const np_cloud_kind *np_cloud_kind_get(neph_cloud_model model);

extern const np_cloud_kind np_fog_kind, np_lens_kind, np_trail_kind, np_deck_kind, np_streak_kind;

void np_kind_eval(const np_cloud_kind *kind, const np_cloud_model *model, const np_cloud_points *points,
                  float *out_extinction_per_m);
bool np_kind_is_empty(const np_cloud_kind *kind, const np_cloud_model *model, const np_cloud_box *box);

/* A lattice of the description's seed. */
np_noise_lattice np_kind_make_lattice(const neph_cloud_desc *desc, unsigned stream);

/* Positions in a noise's own size, turned so that x is along the heading and `stretch` times as long. */
np_noise_points np_kind_scale(const np_cloud_model *model, np_kind_points *points, float size_m, float stretch);

/* A lattice that repeats with the tile under positions that were scaled so; itself where the field ends. */
np_noise_lattice np_kind_wrap(const np_cloud_model *model, const np_noise_lattice *lattice, float size_m,
                              float stretch);

/* Octaves from a size to two voxels. */
unsigned np_kind_count_octaves(const neph_cloud_desc *desc, float size_m);

/* ---- Anvils on thermals: anvil.c ---- */

/* False only if there is no ice at any of these shares of the thickness, in columns of these strengths at most. */
bool np_anvil_is_possible(float anvil_max, float tower_max, const np_interval *shares);

/* Raises extinction to that of the anvils of the model's map. */
void np_anvil_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

/* ---- Columns: cloud_column.c ---- */

/* False: no cloud is possible for its border or heights. */
bool np_cloud_column_bound(const np_cloud_model *model, const np_cloud_box *box, np_kind_box *out_box);

/* ---- Ground: ground_map.c ---- */

/* Whether the ground has a part in the shape. */
bool np_cloud_desc_has_ground(const neph_cloud_desc *desc);

/* Samples the ground, where it has a part. */
neph_result np_ground_map_fill(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                               np_weather_map *map);

/* The landscape over high or low ground, and bases. */
void np_ground_map_cover(const neph_cloud_desc *desc, np_weather_map *map);
void np_ground_map_lift(const neph_cloud_desc *desc, np_weather_map *map);

/* Text that stands for the ground. */
neph_result np_ground_map_identify(neph_context *context, const neph_cloud_desc *desc, char out_id[33]);

/* ---- Waves: mountain_wave.c ---- */

/* Replaces the landscape by the height to which air rises over ridges, its own where no ground is known. */
neph_result np_mountain_wave_fill(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                  np_weather_map *map);

#endif
