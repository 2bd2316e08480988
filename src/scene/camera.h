/* SPDX-License-Identifier: Apache-2.0 */
/* The camera of one picture: maps film positions and lens samples to world rays. */
#ifndef NP_SCENE_CAMERA_H
#define NP_SCENE_CAMERA_H

#include "scene/camera_kinds.h"
#include "scene/scene_private.h"

/* A camera ray after the lens. */
typedef struct np_film_ray {
  np_dvec3 origin;
  np_vec3 direction;    /* unit */
  double near_m, far_m; /* clipping distances along the ray */
} np_film_ray;

/* Initialises the camera of a scene for a picture size and one eye. */
neph_result np_camera_init(const neph_scene *scene, unsigned width, unsigned height, neph_eye eye,
                           np_camera *out_camera);

/* Initialises a camera from a description, which need not be the scene's. */
neph_result np_camera_make(neph_context *context, const np_scene_camera *camera, unsigned width, unsigned height,
                           neph_eye eye, np_camera *out_camera);

/* Ray through a film position and a lens sample, `u` and `v` uniform in [0, 1). False: no light reaches that film
 * position. */
bool np_camera_start_ray(const np_camera *camera, float x, float y, float u, float v, np_film_ray *out_ray);

/* Point on the aperture, right and up in units of its circumscribed radius, uniform for `u` and `v` uniform in [0, 1).
 */
void np_camera_sample_aperture(const np_camera *camera, float u, float v, float out[2]);

/* Depth of a point at a distance along a ray: along the view axis for planar projections, else the distance from the
 * eye. */
double np_camera_get_depth(const np_camera *camera, np_vec3 direction, double distance_m);

/* Diameter in pixels of the circle of confusion of a point at a depth, for a thin lens. Infinity is allowed. */
double np_camera_get_confusion(const np_camera *camera, double depth_m);

#endif
