/* SPDX-License-Identifier: Apache-2.0 */
/* Descriptions of bakes. */
#ifndef NP_CLOUD_BAKE_DESC_H
#define NP_CLOUD_BAKE_DESC_H

#include <nephos/cloud.h>

/* Copies a caller's description (NULL: the defaults) and checks it. */
neph_result np_cloud_bake_desc_read(neph_context *context, const neph_bake_desc *desc, neph_bake_desc *out_desc);

neph_result np_bake_check_radius(neph_context *context, double planet_radius_m);

/* Number of levels of detail: the requested ones, as long as the cloud has enough voxels in its thickness. */
unsigned np_bake_count_levels(const neph_cloud_desc *desc, const neph_bake_desc *bake);

#endif
