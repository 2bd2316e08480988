/* SPDX-License-Identifier: Apache-2.0 */
/* Velocities of a bake. */
#ifndef NP_CLOUD_BAKE_VELOCITY_H
#define NP_CLOUD_BAKE_VELOCITY_H

#include "cloud/bake.h"

/* The velocity "vel" in m/s at the active voxels of a grid: one grid each for x, y and z, with the same leaves. On
 * failure all three are cleared. */
neph_result np_bake_make_velocity(const np_bake *bake, const np_sparse_grid *density, np_sparse_grid out_velocity[3]);

#endif
