/* SPDX-License-Identifier: Apache-2.0 */
/* Constants of the model of cost. `sh tests/bench/costs.sh NEPHOS ... --fit src/plan/cost_table.h` writes this file. */
#ifndef NP_PLAN_COST_TABLE_H
#define NP_PLAN_COST_TABLE_H

/* clang-format off */

/* Rows of the cost table: unit, name, seconds of one core and bytes for one unit. */
#define NP_COST_ROWS(X) \
  X(PROGRAM, "program", 0, 1.4e+07) \
  X(VDB_LIBRARY, "OpenVDB", 0, 3.1e+07) \
  X(BYTE, "bytes", 0, 1) \
  X(TERRAIN, "terrains", 0.0285, 0) \
  X(MADE_HEIGHT, "heights made", 5.97e-07, 27.9) \
  X(READ_HEIGHT, "heights read", 1.5e-07, 32.4) \
  X(MESH_BYTE, "bytes of meshes", 5e-08, 6) \
  X(BAKE, "bakes", 0.0973, 5.32e+06) \
  X(BOX_VOXEL, "voxels in boxes of bakes", 1.28e-08, 0) \
  X(BAKED_VOXEL, "baked voxels in bricks", 1.61e-07, 0) \
  X(BILLOW_VOXEL, "baked voxels along billows", 3.32e-05, 0) \
  X(READ_FILE, "files read", 0.0459, 7.38e+06) \
  X(READ_VOXEL, "read voxels in bricks", 2.47e-08, 0) \
  X(SAMPLE_BYTE, "bytes of samples", 0, 1) \
  X(DETAIL, "noises of detail", 0.03, 7.5e+05) \
  X(DETAIL_VOXEL, "voxels with detail", 0, 0.344) \
  X(AIR, "tables of air", 0.0316, 5.96e+06) \
  X(CAMERA_SKY, "skies of the camera", 0.043, 3.17e+06) \
  X(SKY, "skies of clouds and water", 0.0689, 0) \
  X(EMITTER, "grids of emission", 0.2, 0) \
  X(SUN_VOXEL, "thin voxels of sun optical depth", 5e-08, 25) \
  X(STEEP_SUN_VOXEL, "steep voxels of sun optical depth", 1.87e-07, 25) \
  X(CELL, "cells of multiple scattering", 2.37e-06, 0) \
  X(CELL_SWEEP, "directions times moments times cells of sweeps", 3.25e-10, 0) \
  X(LAST_SWEEP, "directions times moments times cells of sweeps that resolve", 2.8e-10, 0) \
  X(CELL_BYTE, "bytes of cells", 0, 0.56) \
  X(CELL_PLACE, "places for cells, empty ones included", 0, 42) \
  X(VIEWED_CELL, "cells in the light to the camera", 4.07e-07, 0) \
  X(GROUND, "maps of light on the ground", 0.0296, 0) \
  X(GROUND_STEP, "steps from the ground to clouds", 2.33e-08, 0) \
  X(GROUND_CLOUD_STEP, "steps in cloud from the ground", 1.74e-06, 0) \
  X(RELIEF_POINT, "points of light on slopes", 0.00012, 0) \
  X(HILL_RAY, "rays for shadows of hills", 1.65e-05, 0) \
  X(CLOUD_RAY, "rays for shadows of clouds", 7.37e-05, 0) \
  X(CLEAR_SAMPLE, "samples", 7.62e-07, 0) \
  X(LOOKED_UP_SAMPLE, "samples of cloud with a volume of sun optical depth", 6e-06, 0) \
  X(LOOKED_UP_STEP, "voxels along samples with such a volume", 3e-08, 0) \
  X(MARCHED_SAMPLE, "samples of cloud marched to the sun", 1.91e-05, 0) \
  X(MARCHED_STEP, "voxels along samples that are marched", 4.68e-08, 0) \
  X(CLEAR_PATH, "paths", 1e-05, 0) \
  X(CLOUD_PATH, "paths that meet cloud", 5.5e-06, 0) \
  X(COLLISION, "collisions of paths with cloud", 2e-06, 0) \
  X(FLIGHT_STEP, "voxels along paths in cloud", 1e-07, 0) \
  X(LIGHT_STEP, "voxels from paths to the sun", 6.1e-07, 0)

/* Number of a scene of report/calibrate.c, stage, kind of work, and its seconds of one core with these constants. */
#define NP_CALIBRATION_ROWS(X) \
  X(1, TERRAIN, TERRAIN, 0.322) \
  X(0, VOLUMES, BAKE, 0.682) \
  X(1, ATMOSPHERE, SKY, 0.111) \
  X(1, CAMERA_SKY, SKY, 0.0475) \
  X(3, ORDINATES, SOLVE, 0.979) \
  X(0, SUN_OPTICAL_DEPTH, MARCH, 0.0982) \
  X(0, INTEGRATOR, MARCH, 0.344) \
  X(2, INTEGRATOR, PATH, 0.43)

/* clang-format on */

#endif
