/* SPDX-License-Identifier: Apache-2.0 */
/* The frame before, from which a frame of a sequence takes pixels.
 *
 * Frames are divided into blocks of render.history_frames, counted from frame 1. The first of a block is rendered by
 * itself, each further one takes pixels from the one before. So a frame follows from its scene and its number alone,
 * whatever a process rendered before it: a process without the frame before renders the block up to it. */
#ifndef NP_FRAME_HISTORY_H
#define NP_FRAME_HISTORY_H

#include "plan/plan_history.h"
#include "plan/plan_parts.h"
#include "scene/camera.h"
#include "stages/stores.h"

/* Distances from the eye along the ray through a pixel's centre, in metres; infinite: the ray meets nothing. */
typedef struct np_pixel_guide {
  float cloud_m;       /* mean distance of clouds, weighted by their opacity as seen from the eye */
  float behind_m;      /* distance of the ground */
  float half_m;        /* distance at which the transmittance falls below one half */
  float opacity;       /* opacity of the clouds */
  bool is_edge;        /* next to pixels at other distances, whose light the pixel filter may mix in, … */
  float near_m, far_m; /* … and the nearest and farthest of those distances */
} np_pixel_guide;

_Static_assert(sizeof(np_pixel_guide) == NP_HISTORY_GUIDE_BYTES, "plans predict the memory of guides by it");

/* A frame as it was rendered. */
typedef struct np_history_frame {
  char hash[33]; /* name of the picture; empty: unknown */
  int frame;
  np_camera camera;
  unsigned channel_count;
  float *values;          /* [channel][pixel]; NULL: there is no frame */
  float *counts;          /* rendered values that are averaged in each pixel; 0: it is interpolated */
  np_pixel_guide *guides; /* one for each pixel */
} np_history_frame;

neph_result np_history_frame_create(neph_context *context, size_t pixel_count, unsigned channel_count,
                                    np_history_frame *out);

/* Frees a frame's arrays; does nothing for a zeroed frame. */
void np_history_frame_clear(neph_context *context, np_history_frame *frame);

/* The frame with which rendering must begin for a plan's: the one behind that in the stores, if that is of the same
 * block and pictures, else the block's first. Without history the plan's own. */
neph_result np_history_choose_begin(const neph_scene *scene, const np_plan *plan, const np_stores *stores,
                                    int *out_frame);

/* The frame before a plan's in the stores; NULL: the plan uses no history. */
const np_history_frame *np_history_get(const neph_scene *scene, const np_plan *plan, const np_stores *stores);

/* Moves a plan's frame into the stores, for the next frame. */
neph_result np_history_put(const np_plan *plan, np_stores *stores, np_history_frame *frame);

#endif
