/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras of glTF files, frame by frame. */
#ifndef NP_MESH_CAMERA_FILE_H
#define NP_MESH_CAMERA_FILE_H

#include "core/context_private.h"
#include "core/math.h"

/* Pose in the axes of the file: x to the right, y up, and −z ahead. */
typedef struct np_camera_pose {
  double frame;
  np_dvec3 at, forward, up; /* `forward` and `up` are unit vectors, orthogonal but for rounding */
} np_camera_pose;

typedef struct np_camera_file {
  neph_context *context;   /* borrowed */
  double vertical_fov_rad; /* 0: not given */
  size_t count;            /* number of poses; 1: it stands still */
  np_camera_pose *poses;
} np_camera_file;

/* Loads one camera. `name` NULL: the only one in the file. Poses are for whole frames, from the one before its first
 * key to the one after its last; frame 0 is at 0 seconds. A frame_rate of 0 is unknown. */
neph_result np_camera_file_load(neph_context *context, const char *path, const char *name, double frame_rate,
                                np_camera_file *out_file);
void np_camera_file_clear(np_camera_file *file);

#endif
