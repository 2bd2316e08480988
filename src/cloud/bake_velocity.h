/* SPDX-License-Identifier: Apache-2.0 */
/* Velocities of a bake. */
#ifndef NP_CLOUD_BAKE_VELOCITY_H
#define NP_CLOUD_BAKE_VELOCITY_H

#include "cloud/bake.h"

/* The velocity "vel" in m/s at the active voxels of a grid: x, y and z, each a grid of its leaves. On failure all three
 * are left cleared. */
neph_result np_bake_make_velocity(const np_bake *bake, const np_sparse_grid *density, np_sparse_grid out_velocity[3]);

#endif
