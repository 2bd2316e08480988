/* SPDX-License-Identifier: Apache-2.0 */
/* Coarser versions of a whole cloud, for distant copies. */
#ifndef NP_VOLUME_VOLUME_COARSER_H
#define NP_VOLUME_VOLUME_COARSER_H

#include "volume/volume_private.h"

/* Adds the levels 1 to count − 1 to a volume of one part. Each voxel is the mean of eight voxels of the level before,
 * which preserves optical depth. Volumes whose edges are multiples of 2^(count − 1) voxels keep their bounds. */
neph_result np_volume_add_coarser(neph_volume *volume, unsigned count, neph_precision precision, np_monitor *monitor);

#endif
