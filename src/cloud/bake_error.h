/* SPDX-License-Identifier: Apache-2.0 */
/* Measurement of the error of a bake. */
#ifndef NP_CLOUD_BAKE_ERROR_H
#define NP_CLOUD_BAKE_ERROR_H

#include "cloud/bake.h"

/* Measurement of a bake's error, level by level. */
struct np_bake_meter {
  const np_bake *bake;           /* borrowed */
  np_cloud_model detailed;       /* the model without detail limits */
  double low_m[3], high_m[3];    /* box of the rays */
  struct np_bake_ray_sums *rays; /* sums over all levels so far */
  size_t lod_count;              /* 0: without levels */
  neph_bake_lod_error lods[NEPH_BAKE_LODS_MAX];
};

/* Starts the measurement of a bake. On failure nothing needs to be freed. */
neph_result np_bake_meter_start(const np_bake *bake, np_bake_meter *out_meter);

/* Adds the error of a level, or of a bake without levels, before and after pruning; its grid must not be pruned yet. */
neph_result np_bake_meter_add(np_bake_meter *meter, const np_bake *level, const np_sparse_grid *grid);
double np_bake_meter_count_bytes(void); /* memory of the sums, without the model */
neph_result np_bake_meter_get(const np_bake_meter *meter, neph_bake_error *out_error);
void np_bake_meter_end(np_bake_meter *meter);

/* Measures the error of a bake without levels. */
neph_result np_bake_measure_error(const np_bake *bake, const np_sparse_grid *grid, neph_bake_error *out_error);

#endif
