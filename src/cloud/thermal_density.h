/* SPDX-License-Identifier: Apache-2.0 */
/* Density of thermals. */
#ifndef NP_CLOUD_THERMAL_DENSITY_H
#define NP_CLOUD_THERMAL_DENSITY_H

#include "cloud/cloud_model.h"

/* Octaves of a frequency of 1 and more: its logarithm to base 2, straight between the powers. */
float np_thermals_count_octaves(double frequency);

/* Amplitudes of the noises and how far they reach, from the description. */
void np_thermals_prepare(np_cloud_model *model);

/* Evaluates those of the points that are numbered, which are between base and top, and near each other. */
void np_thermals_eval_run(const np_cloud_model *model, const np_cloud_points *points, const uint16_t *numbers,
                          size_t count, float *out_extinction_per_m);

/* True only if there is no cloud anywhere in the box, rain aside. */
bool np_thermals_is_empty(const np_cloud_model *model, const np_cloud_box *box);

#endif
