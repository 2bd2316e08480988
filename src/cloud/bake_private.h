/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of a bake: from a description and what is asked of it to grids, their memory, and what they lost. Inside
 * the cloud module only. Offsets are metres from the field's centre along x and y, from the base altitude along z. */
#ifndef NP_CLOUD_BAKE_PRIVATE_H
#define NP_CLOUD_BAKE_PRIVATE_H

#include "cloud/cloud_private.h"

/* Use of the grid, which decides how much memory is needed besides it. */
typedef enum np_bake_use {
  NP_BAKE_FOR_GRID, /* it is looked at and thrown away */
  NP_BAKE_FOR_BRICKS,
  NP_BAKE_FOR_FILE
} np_bake_use;

/* Levels of detail: cells as large as a leaf of the coarsest are held at one size of voxels each (bake_lod.c). */
typedef struct np_bake_lod {
  unsigned count, level;      /* sizes; that of this bake, from 0, the finest */
  np_lod_viewers viewers;     /* by offsets */
  double cell_m, origin_m[3]; /* edge; of cell (0, 0, 0) */
} np_bake_lod;

typedef struct np_bake_meter np_bake_meter;

typedef struct np_bake {
  neph_context *context; /* borrowed, as is the monitor */
  np_monitor *monitor;
  neph_bake_desc desc;
  np_bake_use use;
  np_cloud_model model;
  np_bake_lod lod;
  np_bake_meter *meter;                 /* borrowed; NULL: the error is not asked for */
  double voxel_m;                       /* of the grid; the model may be of a finer one */
  double shift[3];                      /* of the sample at index 0 from the field's centre and base, in voxels */
  int32_t leaf_begin[3], leaf_count[3]; /* the box to bake, in leaves */
  int32_t region_min[3], region_max[3]; /* voxels to bake, both ends inside */
} np_bake;

/* ---- bake_field.c ---- */

/* Finds the box and builds the model, from descriptions that have been checked. Nothing is to be ended on failure. */
neph_result np_bake_start(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                          np_bake_use use, np_monitor *monitor, np_bake *out_bake);

/* Checks both descriptions, starts the monitor with the callback in them, and the bake. */
neph_result np_bake_start_checked(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                  np_bake_use use, np_monitor *monitor, np_bake *out_bake);
void np_bake_end(np_bake *bake);

size_t np_bake_count_box(const np_bake *bake); /* leaves */

/* Offsets between which the cloud lies, rain and the curve of the planet included, whatever its voxels and region. */
void np_bake_compute_field(const np_bake *bake, double out_low_m[3], double out_high_m[3]);

/* World position of a voxel index, or of a place between two. */
static inline double np_bake_compute_offset_m(const np_bake *bake, int axis, double index) {
  return (index + bake->shift[axis]) * bake->voxel_m;
}

np_affine np_bake_compute_transform(const np_bake *bake);

/* Up to NP_CLOUD_BLOCK positions in the coordinates of the model. */
typedef struct np_bake_points {
  size_t count;
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK];
} np_bake_points;

/* Above the base, on the planet's sphere. */
static inline double np_bake_compute_height_m(const np_bake *bake, const double offset_m[3]) {
  const neph_cloud_desc *cloud = &bake->model.desc;
  const np_dvec3 p = {cloud->center_m[0] + offset_m[0], cloud->center_m[1] + offset_m[1],
                      cloud->base_altitude_m + offset_m[2]};
  return np_altitude(p, bake->desc.planet_radius_m) - cloud->base_altitude_m;
}

void np_bake_add_point(const np_bake *bake, const double offset_m[3], np_bake_points *points);
void np_bake_eval(const np_cloud_model *model, const np_bake_points *points, float *out_extinction_per_m);

/* A level of detail of a bake that was started, which lends it the model. */
neph_result np_bake_get_level(const np_bake *bake, unsigned level, np_bake *out_level);

/* ---- bake_lod.c ---- */

/* Edge of the voxels of a bake's finest level. */
static inline double np_bake_get_finest_m(const np_bake *bake) { return ldexp(bake->voxel_m, -(int)bake->lod.level); }

/* Distance from the viewers within which all of a level is; infinite of the coarsest. */
double np_bake_get_reach_m(const np_bake *bake);

/* Whether a leaf of the bake's grid is in the part of the field that its size of voxels holds. Levels share the samples
 * of the finest lattice, so that cells of all of them end on the same planes. */
bool np_bake_owns_leaf(const np_bake *bake, const int32_t origin[3]);

/* The same of a place, by its offset. */
bool np_bake_owns_point(const np_bake *bake, const double offset_m[3]);

/* Whether the samples of a leaf are needed: it is the bake's own, or, for bricks and an error, beyond a face of one
 * that is. Who reads a file takes those from the level there (volume/volume_levels.h). */
bool np_bake_needs_leaf(const np_bake *bake, const int32_t origin[3]);

/* A volume in memory, of all levels where there are several, from a bake that was started for bricks. */
neph_result np_bake_make_volume(np_bake *bake, neph_volume **out_volume);

/* ---- bake.c ---- */

/* The grid, pruned as asked for unless its error is wanted too. On failure the grid is left cleared. */
neph_result np_bake_make_grid(np_bake *bake, const char *name, np_sparse_grid *out_grid);

/* Takes out what is at most the bake's prune_per_m, and what is not active. */
void np_bake_prune(const np_bake *bake, np_sparse_grid *grid);

/* ---- bake_memory.c ---- */

/* Which leaves of the bake's box may hold cloud: a byte each, z fastest. */
typedef struct np_bake_marks {
  uint8_t *is_cloudy;
  size_t cloudy_count;
  double share; /* of the marked leaves that do hold cloud, by a sample */
} np_bake_marks;

/* Says what the bake and what is done with its grid may need at most, and fails when that is not to be had. */
neph_result np_bake_check_memory(const np_bake *bake, const np_bake_marks *marks);

/* ---- bake_error.c ---- */

/* A measurement of a bake's error, level by level. */
struct np_bake_meter {
  const np_bake *bake;           /* borrowed */
  np_cloud_model detailed;       /* with all its detail */
  double low_m[3], high_m[3];    /* the box of its rays */
  struct np_bake_ray_sums *rays; /* over the levels so far */
  size_t lod_count;              /* 0: without levels */
  neph_bake_lod_error lods[NEPH_BAKE_LODS_MAX];
};

/* From a bake that was started. Nothing is to be ended on failure. */
neph_result np_bake_meter_start(const np_bake *bake, np_bake_meter *out_meter);

/* Adds the error of a level, or of a bake without levels, whose grid is not pruned yet, before and after pruning. */
neph_result np_bake_meter_add(np_bake_meter *meter, const np_bake *level, const np_sparse_grid *grid);
double np_bake_meter_count_bytes(void); /* of sums, besides the model */
neph_result np_bake_meter_get(const np_bake_meter *meter, neph_bake_error *out_error);
void np_bake_meter_end(np_bake_meter *meter);

/* The error of a bake without levels. */
neph_result np_bake_measure_error(const np_bake *bake, const np_sparse_grid *grid, neph_bake_error *out_error);

/* ---- bake_loss.c ---- */

/* Shares that are lost to the size of voxels, 0 where it may be chance, and the means that they are of. */
typedef struct np_bake_losses {
  double of_depth, of_coverage, of_map; /* coverage if painted: a key's is in the census */
  double depth, finer_depth;            /* mean optical depths, in voxels and of the model at half its grain */
  double covered, wanted;               /* shares of the sky */
} np_bake_losses;

neph_result np_bake_measure_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor,
                                   np_bake_losses *out_losses);
bool np_bake_loses(const np_bake_losses *losses); /* more than is tolerated */

/* Warns of what is lost, with the voxel that keeps it, for which models of finer voxels are built. */
neph_result np_bake_warn_of_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor);

/* ---- bake_velocity.c ---- */

/* The velocity "vel" in m/s at the active voxels of a grid: x, y and z, each a grid of its leaves. On failure all three
 * are left cleared. */
neph_result np_bake_make_velocity(const np_bake *bake, const np_sparse_grid *density, np_sparse_grid out_velocity[3]);

#endif
