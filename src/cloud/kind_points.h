/* SPDX-License-Identifier: Apache-2.0 */
/* Points and boxes for kinds of clouds whose columns have a strength, with the ground below them, and noises at the
 * points. */
#ifndef NP_CLOUD_KIND_POINTS_H
#define NP_CLOUD_KIND_POINTS_H

#include "cloud/cloud_model.h"
#include "cloud/cloud_streams.h"

/* A box with ranges of the weather map, for bounds. */
typedef struct np_kind_box {
  np_cloud_box box;
  np_interval strength, ground_m;       /* ground above the lowest base; −INFINITY without ground */
  np_interval base_m;                   /* range of column bases */
  float field_min_m[2], field_max_m[2]; /* range of columns, without skew */
} np_kind_box;

/* Points that may be in cloud, with their columns; positions are in the frame of the air. */
typedef struct np_kind_points {
  size_t count;
  uint16_t index[NP_CLOUD_BLOCK];
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK]; /* heights above the column's base */
  float field_x_m[NP_CLOUD_BLOCK], field_y_m[NP_CLOUD_BLOCK];               /* positions without skew */
  float strength[NP_CLOUD_BLOCK], ground_m[NP_CLOUD_BLOCK];                 /* like np_kind_box */
  float sx[NP_CLOUD_BLOCK], sy[NP_CLOUD_BLOCK], sz[NP_CLOUD_BLOCK], noise[NP_CLOUD_BLOCK]; /* scratch */
} np_kind_points;

/* Selects the points between base and top whose columns have a positive strength. False: there are none. */
bool np_kind_points_collect(const np_cloud_model *model, const np_cloud_points *points, np_kind_points *out_points);

/* False: border, strength or heights exclude cloud. */
bool np_kind_box_make(const np_cloud_model *model, const np_cloud_box *box, np_kind_box *out_box);

/* Positions in units of a noise's size, rotated so that x is along the heading and `stretch` times as long. */
np_noise_points np_kind_scale(const np_cloud_model *model, np_kind_points *points, float size_m, float stretch);

/* A lattice for such positions that repeats with the tile; unchanged for fields that do not repeat. */
np_noise_lattice np_kind_wrap(const np_cloud_model *model, const np_noise_lattice *lattice, float size_m,
                              float stretch);

/* Number of octaves from a size down to two voxels. */
unsigned np_kind_count_octaves(const neph_cloud_desc *desc, float size_m);

#endif
