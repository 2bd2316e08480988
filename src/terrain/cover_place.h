/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NP_TERRAIN_COVER_PLACE_H
#define NP_TERRAIN_COVER_PLACE_H

/* A place on the ground. */
typedef struct np_cover_place {
  float east, north;      /* share of the field's extent, 0 to 1 from its south-western corner */
  double east_m, north_m; /* distance from the south-western corner */
  float elevation_m, slope_rad;
  float north_face;  /* northward component of the normal: 0 on level ground */
  float footprint_m; /* width over which land cover is averaged; 0: none, infinite: all of its noise */
} np_cover_place;

#endif
