/* SPDX-License-Identifier: Apache-2.0 */
/* Kinds of camera, one row of functions each: film position to direction, and direction to film position. */
#ifndef NP_SCENE_CAMERA_KINDS_H
#define NP_SCENE_CAMERA_KINDS_H

#include "scene/camera_frame.h"

typedef struct np_camera_row {
  bool is_flat; /* planar projection: depths are along the view axis */
  /* Ray through a film position. `origin` holds the eye and receives the ray's origin. False: there is no ray. */
  bool (*start)(const np_camera *camera, float x, float y, np_dvec3 *origin, np_vec3 *out_direction);
  /* Film position of an offset from the eye, in right, up and view coordinates; `is_infinite`: the offset is a
   * direction. False: outside. */
  bool (*project)(const np_camera *camera, np_dvec3 offset, bool is_infinite, double out_film[2]);
  double (*get_pixel_sr)(const np_camera *camera, int x, int y);
  bool (*sees_box)(const np_camera *camera, np_dvec3 low, np_dvec3 high);
  /* Fills one row of worldToNDC (columns x, y, z, w) from the camera-space vector `p` of a world axis; NULL: not
   * defined. */
  void (*fill_ndc)(const np_camera *camera, const double p[4], float out[4]);
} np_camera_row;

const np_camera_row *np_camera_get_row(neph_camera_kind kind);

/* Direction through a film position, in pixels from the top left, through the lens centre. False outside of a fisheye's
 * image circle, where the direction is extrapolated. */
bool np_camera_get_direction(const np_camera *camera, float x, float y, np_vec3 *out_direction);

/* Film position of a point at infinity. False: outside of the picture, or not a single position. */
bool np_camera_project_direction(const np_camera *camera, np_dvec3 direction, double out_film[2]);

/* Film position of a world point, through the lens centre, and its depth. False: behind the camera or outside of the
 * picture. */
bool np_camera_project(const np_camera *camera, np_dvec3 point, double out_film[2], double *out_depth_m);

/* Solid angle of a pixel; 0 for parallel rays, and outside of a fisheye's image circle. */
double np_camera_get_pixel_sr(const np_camera *camera, int x, int y);

/* Whether a world box may overlap the picture, ignoring occlusion. */
bool np_camera_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);

/* OpenEXR's worldToCamera and worldToNDC, for row vectors; false if worldToNDC is not defined. */
bool np_camera_get_matrices(const np_camera *camera, float out_world_to_camera[16], float out_world_to_ndc[16]);

#endif
