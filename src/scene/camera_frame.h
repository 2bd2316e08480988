/* SPDX-License-Identifier: Apache-2.0 */
/* The camera of one picture: where it stands, and what its film and lens are. */
#ifndef NP_SCENE_CAMERA_FRAME_H
#define NP_SCENE_CAMERA_FRAME_H

#include <nephos/scene_build.h>

#include "core/math.h"

typedef struct np_camera {
  const struct np_camera_row *row;
  neph_camera_kind kind;
  np_dvec3 origin;
  np_vec3 right, up, back;               /* unit; the view is along −back; of an equirectangular picture, level */
  float tan_half_width, tan_half_height; /* of a perspective */
  float half_width_m, half_height_m;     /* of an orthographic picture */
  float half_angle, radius;              /* of a fisheye: at the rim of its circle, which is so many pixels away */
  float shift[2];                        /* of the picture's middle: tangents, or metres of an orthographic one */
  float lens_radius_m, focus_m;          /* of a perspective; 0: a pinhole; distance along the view */
  unsigned blade_count;
  double near_m, far_m;
  unsigned width, height;
} np_camera;

/* Whether all rays have one origin, but for the lens. */
static inline bool np_camera_has_centre(const np_camera *camera) { return camera->kind != NEPH_CAMERA_ORTHOGRAPHIC; }

#endif
