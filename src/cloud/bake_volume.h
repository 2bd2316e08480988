/* SPDX-License-Identifier: Apache-2.0 */
/* Baked volumes. */
#ifndef NP_CLOUD_BAKE_VOLUME_H
#define NP_CLOUD_BAKE_VOLUME_H

#include "cloud/bake.h"

/* Builds a volume in memory, with all levels if there are several, from a bake started for bricks. */
neph_result np_bake_make_volume(np_bake *bake, neph_volume **out_volume);

/* neph_cloud_bake for a first picture, by a model that is a sketch (np_cloud_model_sketch). */
neph_result np_cloud_bake_sketch(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                 neph_volume **out_volume);

#endif
