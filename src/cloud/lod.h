/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail by the distance of their viewers. */
#ifndef NP_CLOUD_LOD_H
#define NP_CLOUD_LOD_H

/* Viewers of levels of detail: a box that holds all, and the angle that a voxel may span before a smaller size
 * is taken. */
typedef struct np_lod_viewers {
  double min_m[3], max_m[3], angle_rad;
} np_lod_viewers;

/* The coarsest of so many levels, from voxel_m on, whose voxels span no more than the angle, seen from the nearest of
 * the viewers at the nearest point of a box; a fixed order of sums and roots, the same bits everywhere. */
unsigned np_lod_choose(const np_lod_viewers *viewers, unsigned count, double voxel_m, const double low_m[3],
                       const double high_m[3]);

#endif
