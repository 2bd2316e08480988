/* SPDX-License-Identifier: Apache-2.0 */
/* The camera of one picture: its position, orientation, film and lens. */
#ifndef NP_SCENE_CAMERA_FRAME_H
#define NP_SCENE_CAMERA_FRAME_H

#include <nephos/scene_build.h>

#include "core/math.h"

typedef struct np_camera {
  const struct np_camera_row *row;
  neph_camera_kind kind;
  np_dvec3 origin;
  np_vec3 right, up, back; /* unit vectors; the view is along −back; horizontal for an equirectangular picture */
  float tan_half_width, tan_half_height; /* perspective camera */
  float half_width_m, half_height_m;     /* orthographic camera */
  float half_angle, radius;     /* fisheye: angle at the rim of the image circle, and radius of the circle in pixels */
  float shift[2];               /* lens shift of the picture's centre: tangents, or metres for an orthographic camera */
  float lens_radius_m, focus_m; /* perspective: lens radius (0: a pinhole), and focus distance along the view axis */
  unsigned blade_count;
  double near_m, far_m;
  unsigned width, height;
} np_camera;

/* Whether all rays have one origin, apart from the lens. */
static inline bool np_camera_has_centre(const np_camera *camera) { return camera->kind != NEPH_CAMERA_ORTHOGRAPHIC; }

#endif
