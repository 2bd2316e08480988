/* SPDX-License-Identifier: Apache-2.0 */
/* Samples of a bake lie on level planes, while heights of a model follow the curved planet. */
#ifndef NP_CLOUD_LEVEL_SAMPLES_H
#define NP_CLOUD_LEVEL_SAMPLES_H

#include "cloud/cloud_model.h"

/* Height of the lowest sample above the base at a position of the field, in grains: in [0, 1). */
double np_level_samples_compute_lowest(const np_cloud_model *model, double x_m, double y_m);

#endif
