/* SPDX-License-Identifier: Apache-2.0 */
/* The camera's keys, and quantities derived from them. */
#ifndef NP_SCENE_SCENE_CAMERA_H
#define NP_SCENE_SCENE_CAMERA_H

#include <nephos/render.h>
#include <nephos/scene_build.h>

typedef struct np_scene_camera {
  neph_camera_kind kind;
  double position_m[3];
  double look_at_m[3];
  double roll_rad;
  double fov_rad;         /* horizontal angle of view of a perspective camera */
  double fisheye_fov_rad; /* angle across the image circle */
  bool has_focal_length;
  double focal_length_m, sensor_m; /* the sensor is as wide as the picture */
  double orthographic_width_m;     /* width of an orthographic picture in the world */
  double shift[2];                 /* lens shift to the right and up, in widths of the picture */
  double near_m, far_m;            /* clipping range for clouds and ground */
  bool has_lens;                   /* f_stop is set; false: a pinhole camera */
  double f_stop, focus_distance_m; /* focus distance; infinite: the distance of look_at */
  unsigned blade_count;            /* aperture blades; 0: a round aperture */
  bool has_iso, has_shutter;
  double iso, shutter_s;
  bool is_stereo;
  neph_eye eye;                       /* rendered eye; centre: both */
  double interaxial_m, convergence_m; /* infinite convergence: the distance of look_at */
  unsigned resolution[2];
  unsigned overscan; /* extra pixels rendered beyond each edge of the picture */
} np_scene_camera;

/* Angle between adjacent pixels at the picture's centre. For parallel rays it is the angle as seen from the distance of
 * look_at. */
double np_scene_camera_get_pixel_rad(const np_scene_camera *camera, unsigned width, unsigned height);

/* Distance from position to look_at. */
double np_scene_camera_get_target_m(const np_scene_camera *camera);

/* Horizontal angle of view of a perspective camera, from fov or focal_length. */
double np_scene_camera_get_fov_rad(const np_scene_camera *camera);

double np_scene_camera_get_focal_length_m(const np_scene_camera *camera);

/* Exposure value at ISO 100, log2(N²/t · 100/S); false unless f_stop, shutter and iso are all set. */
bool np_scene_camera_get_ev100(const np_scene_camera *camera, double *out_ev);

#endif
