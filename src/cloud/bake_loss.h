/* SPDX-License-Identifier: Apache-2.0 */
/* Losses of a cloud to the size of its voxels. */
#ifndef NP_CLOUD_BAKE_LOSS_H
#define NP_CLOUD_BAKE_LOSS_H

#include "cloud/cloud_model.h"

/* Shares that are lost to the size of voxels, 0 where it may be chance, and the means that they are of. */
typedef struct np_bake_losses {
  double of_depth, of_coverage, of_map; /* coverage if painted: a key's is in the census */
  double depth, finer_depth;            /* mean optical depths, in voxels and of the model at half its grain */
  double covered, wanted;               /* shares of the sky */
} np_bake_losses;

neph_result np_bake_measure_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor,
                                   np_bake_losses *out_losses);
bool np_bake_loses(const np_bake_losses *losses); /* more than is tolerated */

/* Warns of what is lost, with the voxel that keeps it, for which models of finer voxels are built. */
neph_result np_bake_warn_of_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor);

/* Warns of what a bake in the description's voxels would lose. */
neph_result np_cloud_check_voxel(neph_context *context, const neph_cloud_desc *cloud, double planet_radius_m);

#endif
