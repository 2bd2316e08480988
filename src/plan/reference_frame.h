/* SPDX-License-Identifier: Apache-2.0 */
/* The frame by which all frames of an imported sequence are placed and scaled.
 *
 * A cloud's `position` is that of a box, its `voxel` that of the largest edge, its `optical_depth` that of the densest
 * column; taken from each frame anew they would move what stands still, and change what stays as dense. One frame gives
 * them to all: the scene's reference_frame, else the first rendered one that is not empty. A cloud that is no
 * sequence depends on its own volume.
 */
#ifndef NP_PLAN_REFERENCE_FRAME_H
#define NP_PLAN_REFERENCE_FRAME_H

#include "plan/input_store.h"

typedef struct np_frame_cloud {
  np_reference **references; /* references in the store of inputs */
  const neph_scene *scene;
  unsigned index;                    /* number of the cloud */
  double number;                     /* number of its file in this frame */
  neph_volume *volume;               /* volume of that file; NULL: it is empty */
  const neph_volume_load_desc *load; /* how the cloud's files are read */
  np_monitor *monitor;
} np_frame_cloud;

/* Finds where a cloud's files stand, reading its reference frame where that is another and not known yet.
 * `*out_is_known` is false where no frame that is not empty was met yet by which to place them. */
neph_result np_reference_frame_get_anchor(const np_frame_cloud *of, np_anchor *out_anchor, bool *out_is_known);

/* Fails with a message that a reference frame is empty. */
neph_result np_reference_frame_fail_empty(const neph_scene *scene, unsigned index, double number);

#endif
