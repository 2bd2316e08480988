/* SPDX-License-Identifier: Apache-2.0 */
/* The camera as its keys leave it, and numbers that follow. */
#ifndef NP_SCENE_SCENE_CAMERA_H
#define NP_SCENE_SCENE_CAMERA_H

#include <nephos/render.h>
#include <nephos/scene_build.h>

typedef struct np_scene_camera {
  neph_camera_kind kind;
  double position_m[3];
  double look_at_m[3];
  double roll_rad;
  double fov_rad;         /* of a perspective */
  double fisheye_fov_rad; /* across the circle */
  bool has_focal_length;
  double focal_length_m, sensor_m; /* of a sensor as wide as the picture */
  double orthographic_width_m;                  /* of an orthographic picture, in the world */
  double shift[2];                 /* of the picture, to the right and up, in its widths */
  double near_m, far_m;            /* clouds and ground outside are not seen */
  bool has_lens;                   /* f_stop was given: else a pinhole */
  double f_stop, focus_distance_m; /* infinite: that of look_at */
  unsigned blade_count;            /* of the aperture; 0: round */
  bool has_iso, has_shutter;
  double iso, shutter_s;
  bool is_stereo;
  neph_eye eye;                       /* that is rendered; centre: both */
  double interaxial_m, convergence_m; /* infinite: the distance of look_at */
  unsigned resolution[2];
  unsigned overscan; /* pixels rendered beyond each edge of the picture */
} np_scene_camera;

/* Angle between neighbouring pixels, in the middle, before there is a picture. Of parallel rays,
 * as if seen from as far away as look_at. */
double np_scene_camera_get_pixel_rad(const np_scene_camera *camera, unsigned width, unsigned height);

/* From position to look_at. */
double np_scene_camera_get_target_m(const np_scene_camera *camera);

/* Horizontal angle of view of a perspective, by fov or focal_length. */
double np_scene_camera_get_fov_rad(const np_scene_camera *camera);

double np_scene_camera_get_focal_length_m(const np_scene_camera *camera);

/* Exposure value at ISO 100, log2(N²/t · 100/S); false where f_stop, shutter and iso were not all given. */
bool np_scene_camera_get_ev100(const np_scene_camera *camera, double *out_ev);

#endif
