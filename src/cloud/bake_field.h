/* SPDX-License-Identifier: Apache-2.0 */
/* The field of a bake: its model, and the positions of its voxels. */
#ifndef NP_CLOUD_BAKE_FIELD_H
#define NP_CLOUD_BAKE_FIELD_H

#include "cloud/bake.h"

/* Computes the box and builds the model, from descriptions that are already checked. On failure nothing needs to be
 * freed. */
neph_result np_bake_start(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                          np_bake_use use, np_monitor *monitor, np_bake *out_bake);

/* Checks both descriptions, and starts the monitor with their callback, then the bake. */
neph_result np_bake_start_checked(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                  np_bake_use use, np_monitor *monitor, np_bake *out_bake);

/* Computes the box alone, from checked descriptions: NEPH_ERROR_LIMIT for one of more leaves than a bake can have. */
neph_result np_bake_check_box(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc);

void np_bake_end(np_bake *bake);

size_t np_bake_count_box(const np_bake *bake); /* number of leaves */

/* Range of offsets of the cloud, including rain and the curvature of the planet, for any voxel size and region. */
void np_bake_compute_field(const np_bake *bake, double out_low_m[3], double out_high_m[3]);

np_affine np_bake_compute_transform(const np_bake *bake);

/* Up to NP_CLOUD_BLOCK positions in model coordinates. */
typedef struct np_bake_points {
  size_t count;
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK];
} np_bake_points;

void np_bake_add_point(const np_bake *bake, const double offset_m[3], np_bake_points *points);
void np_bake_eval(const np_cloud_model *model, const np_bake_points *points, float *out_extinction_per_m);

/* Bake of one level of detail; it borrows the model of the whole bake. */
neph_result np_bake_get_level(const np_bake *bake, unsigned level, np_bake *out_level);

#endif
