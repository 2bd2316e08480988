/* SPDX-License-Identifier: Apache-2.0 */
/* The camera of one picture: film positions and places of the lens to world rays. */
#ifndef NP_SCENE_CAMERA_H
#define NP_SCENE_CAMERA_H

#include "scene/camera_kinds.h"
#include "scene/scene_private.h"

/* A ray from the eye, as the lens makes it. */
typedef struct np_film_ray {
  np_dvec3 origin;
  np_vec3 direction;    /* unit */
  double near_m, far_m; /* along it */
} np_film_ray;

/* For a picture of this size, seen by one eye. */
neph_result np_camera_init(const neph_scene *scene, unsigned width, unsigned height, neph_eye eye,
                           np_camera *out_camera);

/* The same of a camera that is not, or not now, the scene's. */
neph_result np_camera_make(neph_context *context, const np_scene_camera *camera, unsigned width, unsigned height,
                           neph_eye eye, np_camera *out_camera);

/* Ray through a film position and a place of the lens, `u` and `v` even in [0, 1). False: no light falls there. */
bool np_camera_start_ray(const np_camera *camera, float x, float y, float u, float v, np_film_ray *out_ray);

/* A place of the aperture, right and up in radii of its corners, even over it for `u` and `v` even in [0, 1). */
void np_camera_sample_aperture(const np_camera *camera, float u, float v, float out[2]);

/* Depth of a place so far along a ray: along the view where the picture is flat, else from the eye. */
double np_camera_get_depth(const np_camera *camera, np_vec3 direction, double distance_m);

/* Diameter of the circle of confusion on the film, in pixels, of a point so deep: the thin lens. Infinity is allowed.
 */
double np_camera_get_confusion(const np_camera *camera, double depth_m);

#endif
