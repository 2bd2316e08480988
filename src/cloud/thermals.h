/* SPDX-License-Identifier: Apache-2.0 */
/* Cumulus as thermals: stacks of balls that stand on the weather map, with billows on them, level on level. */
#ifndef NP_CLOUD_THERMALS_H
#define NP_CLOUD_THERMALS_H

#include "cloud/cloud_private.h"

static inline bool np_cloud_desc_has_thermals(const neph_cloud_desc *desc) {
  return desc->model == NEPH_CLOUD_MODEL_THERMALS || desc->model == NEPH_CLOUD_MODEL_HERO;
}

static inline bool np_cloud_model_has_thermals(const np_cloud_model *model) {
  return np_cloud_desc_has_thermals(&model->desc);
}

/* Levels of balls, from the thermals to billows of two voxels. */
unsigned np_thermals_count_levels(const np_cloud_model *model);

/* Adds the first level. */
neph_result np_thermals_add_stacks(np_cloud_model *model, np_monitor *monitor, float blend_m, float bin_m);

/* Share of the field that lies below the stacks of thermals, from its waterline; leaves the heap empty. */
neph_result np_thermals_count_shadow(np_cloud_model *model, np_monitor *monitor, double *out_fraction);

/* Makes the first `level_count` levels of the model's heap anew, from its map, waterline and time. */
neph_result np_thermals_build(np_cloud_model *model, np_monitor *monitor, unsigned level_count);

/* ---- Slope: thermal_slope.c ---- */

/* Vertical component of the normal of the stacks near points that are at most 9 voxels or 1.25 billows apart along each
 * axis, whichever is more. What it gives for a position depends on nothing else. */
void np_thermals_eval_slope(const np_cloud_model *model, const np_ball_points *points, float *out_normal_z);

/* ---- Density: thermal_density.c ---- */

/* Octaves of a frequency of 1 and more: its logarithm to base 2, straight between the powers. */
float np_thermals_count_octaves(double frequency);

/* Amplitudes of the noises and how far they reach, from the description. */
void np_thermals_set_noises(np_cloud_model *model);

/* Evaluates those of the points that are numbered, which are between base and top, and near each other. */
void np_thermals_eval_run(const np_cloud_model *model, const np_cloud_points *points, const uint16_t *numbers,
                          size_t count, float *out_extinction_per_m);

/* True only if there is no cloud anywhere in the box, rain aside. */
bool np_thermals_is_empty(const np_cloud_model *model, const np_cloud_box *box);

/* ---- Runs: thermal_runs.c ---- */

void np_thermals_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

#endif
