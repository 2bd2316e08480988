/* SPDX-License-Identifier: Apache-2.0 */
/* Light at a point of a world, as an integrator asks for it: whichever caches were built answer.
 *
 * Filled by render. A cache that a scene does not need is NULL, and costs nothing.
 */
#ifndef NP_CACHES_LIGHTING_H
#define NP_CACHES_LIGHTING_H

#include "caches/air_shadow.h"
#include "caches/ground_light.h"
#include "caches/sky_guide.h"
#include "caches/sun_optical_depth.h"
#include "caches/viewer_light.h"
#include "optics/multiple_scattering.h"
#include "volume/tracking.h"

typedef struct np_lighting {
  np_sun_optical_depths sun_optical_depths;
  const np_scattering_field *scattering;  /* NULL: not solved for */
  const np_viewer_light *viewer_light;    /* of that solution, for rays from its viewer; NULL: not prepared */
  const np_ground_light *ground_light;    /* NULL: the sky over the ground is taken as clear */
  const np_air_shadow *air_shadow;        /* of the camera's sky; NULL: clear */
  const np_sky_guide *sky_guide;          /* NULL: sky and ground are met by chance alone */
  const np_cloud_gain *gains;             /* of an approximation in each cloud; NULL: the settings' for all */
  const struct np_reflection *reflection; /* for rays that water reflects; NULL: there is none */
} np_lighting;

/* The world and its light as a ray sees it that water reflects: under the sky over the water. */
typedef struct np_reflection {
  np_world world;
  np_lighting lighting;
} np_reflection;

/* Radiance of sky, night and environment along a camera's ray that meets no ground, in the clouds' and hills' shadow.
 */
np_spectrum np_lighting_camera_sky(const np_lighting *lighting, const np_world *world, const np_view_ray *view);

/* The same with the disks of sun and moon, through the air. */
np_spectrum np_lighting_background(const np_lighting *lighting, const np_world *world, const np_view_ray *view);

/* The air between the eye and a point along its ray, in the same shadow. */
np_aerial_perspective np_lighting_camera_air(const np_lighting *lighting, const np_world *world,
                                             const np_view_ray *view, double distance_m);

/* Irradiance of sky and clouds on the ground, free of hills. */
np_spectrum np_lighting_ground_irradiance(const np_lighting *lighting, const np_world *world, const np_ground_hit *hit);

/* The clouds towards the sun. */
static inline void np_lighting_start_depths(const np_lighting *lighting, np_dvec3 position, np_vec3 to_sun,
                                            np_place_walk *out) {
  np_place_walk_start(out, lighting->sun_optical_depths.clouds, position, to_sun, INFINITY);
}

/* Optical depth of one of them: looked up where a cache knows it, else integrated for the query. */
static inline float np_lighting_get_cloud_depth(const np_lighting *lighting, const np_instance *volume,
                                                np_dvec3 position, np_vec3 to_sun, const np_depth_query *query,
                                                float faded) {
  const float known = np_sun_optical_depths_get_known(&lighting->sun_optical_depths, volume, position, to_sun);
  if (known != NP_SUN_OPTICAL_DEPTH_UNKNOWN)
    return volume->bricks->detail ? np_maxf(known + np_track_near_detail(volume, position, to_sun), 0.0f) : known;
  return np_track_volume_depth(volume, position, to_sun, INFINITY, query, faded);
}

#endif
