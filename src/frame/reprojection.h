/* SPDX-License-Identifier: Apache-2.0 */
/* Places of a picture's pixels in the picture before, by a pixel's depth and both cameras.
 *
 * A pixel moves as what is seen of it most: as its clouds, at their mean distance weighted by what they hide, or as the
 * ground or the sky behind. Values are taken there by a cubic of four by four pixels (Catmull and Rom 1974, "A Class of
 * Local Interpolating Splines"), which blurs little however often it is repeated; where some of them show something
 * else, nearer or farther, by those of the nearest four that do not, and where none is left there is no history. */
#ifndef NP_FRAME_REPROJECTION_H
#define NP_FRAME_REPROJECTION_H

#include "frame/history.h"

/* A pixel's place in the picture before. */
typedef struct np_reprojected {
  bool is_seen;                /* the previous picture shows this place; else the pixel has no history */
  bool is_cloud;               /* moves as its clouds do */
  float at[2];                 /* in pixels from the window's corner */
  float distance_m;            /* distance from the eye of then */
  const np_pixel_guide *guide; /* the guide of the pixel now */
  float slope;                 /* slope of the inverse distance, 1/m a pixel */
} np_reprojected;

_Static_assert(sizeof(np_reprojected) == NP_HISTORY_PLACE_BYTES, "plans predict the memory of places by it");

typedef struct np_reprojection {
  const np_history_frame *before;
  const np_camera *camera;      /* the camera now */
  const np_pixel_guide *guides; /* the guides now of all pixels of the window */
  int min[2];                   /* corner of the window; both pictures have the same window */
  unsigned width, height;
  bool is_still; /* the camera did not move */
} np_reprojection;

/* Whether a pixel moves as its clouds do. */
bool np_pixel_guide_is_cloud(const np_pixel_guide *guide);

/* Difference of two distances over the larger inverse: 0 to 1. */
float np_pixel_guide_compare(float a_m, float b_m);

/* Fills `is_edge`, `near_m` and `far_m` of a pixel's guide from its neighbours' guides. */
void np_pixel_guide_fill_around(np_pixel_guide *guides, unsigned width, unsigned height, unsigned x, unsigned y);

/* Whether two pixels may contain light from neighbours at the same distances. */
bool np_pixel_guide_has_same_around(const np_pixel_guide *from, const np_pixel_guide *to);

np_reprojection np_reprojection_make(const np_history_frame *before, const np_camera *camera,
                                     const np_pixel_guide *guides, const int min[2], unsigned width, unsigned height);

/* The place of a pixel of the window. */
np_reprojected np_reprojection_project(const np_reprojection *r, unsigned x, unsigned y);

/* Interpolated values of all channels of the previous picture at a reprojected place, and the number of rendered values
 * that are averaged in them. */
void np_reprojection_sample(const np_reprojection *r, const np_reprojected *place, float *out_values, float *out_count);

#endif
