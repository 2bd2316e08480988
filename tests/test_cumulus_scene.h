/* SPDX-License-Identifier: Apache-2.0 */
/* A small cumulus over ridges, in which every stage of a render runs; what is rendered of it, and how, follows. */
#ifndef NP_TEST_CUMULUS_SCENE_H
#define NP_TEST_CUMULUS_SCENE_H

#define TEST_CUMULUS_SCENE                                                                                             \
  "version: 1\n"                                                                                                       \
  "camera: {position: [0 m, -3 km, 900 m], look_at: [0 m, 0 m, 1500 m], fov: 60 deg, resolution: [24, 16]}\n"          \
  "sun: {elevation: 30 deg, azimuth: 110 deg}\n"                                                                       \
  "clouds:\n"                                                                                                          \
  "  - name: cumulus\n"                                                                                                \
  "    bake: {preset: cumulus_mediocris, seed: 4, extent: [2 km, 2 km], base: 1200 m, voxel: 100 m, coverage: 0.6}\n"  \
  "terrain: {ridges: {samples: 129, relief: 700 m}, width: 20 km}\n"

#endif
