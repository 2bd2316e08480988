/* SPDX-License-Identifier: Apache-2.0 */
/* Density of thermals. */
#ifndef NP_CLOUD_THERMAL_DENSITY_H
#define NP_CLOUD_THERMAL_DENSITY_H

#include "cloud/cloud_model.h"

/* Number of octaves of a frequency of 1 or more: its binary logarithm, linear between powers of two. */
float np_thermals_count_octaves(double frequency);

/* Sets up amplitudes and reaches of the noises from the description. */
void np_thermals_prepare(np_cloud_model *model);

/* Evaluates the listed points, which are between base and top and close to each other. */
void np_thermals_eval_run(const np_cloud_model *model, const np_cloud_points *points, const uint16_t *numbers,
                          size_t count, float *out_extinction_per_m);

/* True only if the box is free of cloud, apart from rain. */
bool np_thermals_is_empty(const np_cloud_model *model, const np_cloud_box *box);

#endif
