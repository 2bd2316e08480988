/* SPDX-License-Identifier: Apache-2.0 */
/* A bake: evaluation of a description on a grid. Offsets are metres from the field's centre along x and y, and from the
 * base altitude along z. */
#ifndef NP_CLOUD_BAKE_H
#define NP_CLOUD_BAKE_H

#include <math.h>

#include "cloud/cloud_model.h"
#include "cloud/lod.h"
#include "core/math.h"

/* Purpose of the grid, which determines the memory needed besides it. */
typedef enum np_bake_use {
  NP_BAKE_FOR_GRID, /* measured and discarded */
  NP_BAKE_FOR_BRICKS,
  NP_BAKE_FOR_SKETCH, /* bricks for a first picture, which another bake replaces */
  NP_BAKE_FOR_FILE
} np_bake_use;

/* Levels of detail: cells as large as a leaf of the coarsest level, each baked at one voxel size. */
typedef struct np_bake_lod {
  unsigned count, level;      /* number of levels, and the level of this bake, from 0, the finest */
  np_lod_viewers viewers;     /* positions relative to the bake's centre */
  double cell_m, origin_m[3]; /* edge of a cell, and origin of cell (0, 0, 0) */
} np_bake_lod;

typedef struct np_bake_meter np_bake_meter;

typedef struct np_bake {
  neph_context *context; /* context and monitor are borrowed */
  np_monitor *monitor;
  neph_bake_desc desc;
  np_bake_use use;
  np_cloud_model model;
  np_bake_lod lod;
  np_bake_meter *meter;                 /* borrowed; NULL: the error is not measured */
  double voxel_m;                       /* voxel size of the grid; the model may be finer */
  double shift[3];                      /* offset of index 0 from the field's centre and base, in voxels */
  int32_t leaf_begin[3], leaf_count[3]; /* box to bake, in leaves */
  int32_t region_min[3], region_max[3]; /* voxels to bake, both ends inclusive */
} np_bake;

/* Offset of a voxel index along an axis; the index may be fractional. */
static inline double np_bake_compute_offset_m(const np_bake *bake, int axis, double index) {
  return (index + bake->shift[axis]) * bake->voxel_m;
}

/* Height of an offset above the base, along the curved surface of the planet. */
static inline double np_bake_compute_height_m(const np_bake *bake, const double offset_m[3]) {
  const neph_cloud_desc *cloud = &bake->model.desc;
  const np_dvec3 p = {cloud->center_m[0] + offset_m[0], cloud->center_m[1] + offset_m[1],
                      cloud->base_altitude_m + offset_m[2]};
  return np_altitude(p, bake->desc.planet_radius_m) - cloud->base_altitude_m;
}

/* Voxel size of the finest level of a bake. */
static inline double np_bake_get_finest_m(const np_bake *bake) { return ldexp(bake->voxel_m, -(int)bake->lod.level); }

#endif
