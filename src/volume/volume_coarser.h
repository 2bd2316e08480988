/* SPDX-License-Identifier: Apache-2.0 */
/* A whole cloud in larger voxels, for copies of it that stand far away. */
#ifndef NP_VOLUME_VOLUME_COARSER_H
#define NP_VOLUME_VOLUME_COARSER_H

#include "volume/volume_private.h"

/* Gives a volume of one part the levels 1 to count − 1: each with voxels twice as long as those of the one before, the
 * mean of eight, so that optical depth is kept. Volumes of which 2^(count − 1) voxels go into an edge do not reach
 * farther than before. */
neph_result np_volume_add_coarser(neph_volume *volume, unsigned count, neph_precision precision, np_monitor *monitor);

#endif
