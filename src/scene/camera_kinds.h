/* SPDX-License-Identifier: Apache-2.0 */
/* Kinds of camera, one row of functions each, and what is asked of them: film positions to directions, and back. */
#ifndef NP_SCENE_CAMERA_KINDS_H
#define NP_SCENE_CAMERA_KINDS_H

#include "scene/camera_frame.h"

typedef struct np_camera_row {
  bool is_flat; /* depths are along the view: pictures in a plane */
  /* Origin, which is given as the eye, and direction of the ray through a film position. False: there is none. */
  bool (*start)(const np_camera *camera, float x, float y, np_dvec3 *origin, np_vec3 *out_direction);
  /* Film position of an offset from the eye, right, up and along the view; infinitely far: a direction. False: none. */
  bool (*project)(const np_camera *camera, np_dvec3 offset, bool is_infinite, double out_film[2]);
  double (*get_pixel_sr)(const np_camera *camera, int x, int y);
  bool (*sees_box)(const np_camera *camera, np_dvec3 low, np_dvec3 high);
  /* Columns of worldToNDC, x, y, z, w, in a row of the world's, whose camera space is `p`; NULL: there is none. */
  void (*fill_ndc)(const np_camera *camera, const double p[4], float out[4]);
} np_camera_row;

const np_camera_row *np_camera_get_row(neph_camera_kind kind);

/* Direction through a film position, in pixels from the top left, from the middle of the lens. False where no light
 * falls on the film, outside a fisheye's circle: there it goes on as within. */
bool np_camera_get_direction(const np_camera *camera, float x, float y, np_vec3 *out_direction);

/* Film position of what is infinitely far away. False: not in the picture, or not at one place of it. */
bool np_camera_project_direction(const np_camera *camera, np_dvec3 direction, double out_film[2]);

/* Film position of a world point, seen from the middle of the lens, and its depth. False: behind, or outside. */
bool np_camera_project(const np_camera *camera, np_dvec3 point, double out_film[2], double *out_depth_m);

/* Solid angle of a pixel; 0 where it has none: of parallel rays, or outside a fisheye's circle. */
double np_camera_get_pixel_sr(const np_camera *camera, int x, int y);

/* Whether any of a world box may be in the picture, whatever stands before it. */
bool np_camera_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);

/* Row-vector matrices of OpenEXR's worldToCamera and worldToNDC; false where there is no worldToNDC. */
bool np_camera_get_matrices(const np_camera *camera, float out_world_to_camera[16], float out_world_to_ndc[16]);

#endif
