/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail by the distance to their viewers. */
#ifndef NP_CLOUD_LOD_H
#define NP_CLOUD_LOD_H

/* Viewers of levels of detail: their bounding box, and the largest angle that a voxel may span. */
typedef struct np_lod_viewers {
  double min_m[3], max_m[3], angle_rad;
} np_lod_viewers;

/* Coarsest of `count` levels, from voxel_m on, whose voxels span at most the angle, seen from the nearest viewer at the
 * nearest point of a box. Sums and roots have a fixed order, for equal bits everywhere. */
unsigned np_lod_choose(const np_lod_viewers *viewers, unsigned count, double voxel_m, const double low_m[3],
                       const double high_m[3]);

#endif
