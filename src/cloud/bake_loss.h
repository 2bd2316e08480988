/* SPDX-License-Identifier: Apache-2.0 */
/* Losses of a cloud through coarse voxels. */
#ifndef NP_CLOUD_BAKE_LOSS_H
#define NP_CLOUD_BAKE_LOSS_H

#include "cloud/cloud_model.h"

/* Relative losses, 0 if they may be chance, and the means that they refer to. */
typedef struct np_bake_losses {
  double of_depth, of_coverage, of_map; /* coverage in painted places; the census handles the coverage of a key */
  double depth, finer_depth;            /* mean optical depths, in voxels and of the model at half its grain */
  double covered, wanted;               /* covered share of the sky: actual and requested */
} np_bake_losses;

neph_result np_bake_measure_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor,
                                   np_bake_losses *out_losses);
bool np_bake_loses(const np_bake_losses *losses); /* above the tolerance */

/* Warns of losses and recommends a voxel size without them, for which it builds models of finer voxels. */
neph_result np_bake_warn_of_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor);

/* Warns of the losses of a bake with the description's voxel size. */
neph_result np_cloud_check_voxel(neph_context *context, const neph_cloud_desc *cloud, double planet_radius_m);

#endif
