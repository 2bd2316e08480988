/* SPDX-License-Identifier: Apache-2.0 */
/* Construction of density models. */
#ifndef NP_CLOUD_CLOUD_BUILD_H
#define NP_CLOUD_CLOUD_BUILD_H

#include "cloud/cloud_model.h"

/* Builds the map, and sets its waterline for the requested cloud cover, with flat voxels and heights that follow the
 * planet. */
neph_result np_cloud_model_build(neph_context *context, const neph_cloud_desc *desc, double planet_radius_m,
                                 np_monitor *monitor, np_cloud_model *out_model);

/* A model for a first picture, in about a third of the time: with grains twice as long where a voxel has several, and
 * cloud cover right to a few hundredths. */
neph_result np_cloud_model_sketch(neph_context *context, const neph_cloud_desc *desc, double planet_radius_m,
                                  np_monitor *monitor, np_cloud_model *out_model);

void np_cloud_model_clear(np_cloud_model *model); /* a zeroed model is allowed */

/* The model with detail down to `share` of its grain, as far as that needs no other balls and no other waterline. It
 * borrows everything from the model. */
np_cloud_model np_cloud_model_refine(const np_cloud_model *model, double share);

#endif
