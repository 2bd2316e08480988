/* SPDX-License-Identifier: Apache-2.0 */
/* Light at a point of a world: holds the light caches for the integrator. Render fills it. A cache that a scene does
 * not need is NULL, and costs nothing.
 */
#ifndef NP_CACHES_LIGHTING_H
#define NP_CACHES_LIGHTING_H

#include "caches/air_shadow.h"
#include "caches/ground_light.h"
#include "caches/relief_light.h"
#include "caches/sky_guide.h"
#include "caches/sun_optical_depth.h"
#include "caches/viewer_light.h"
#include "optics/multiple_scattering.h"
#include "volume/tracking.h"

typedef struct np_lighting {
  np_sun_optical_depths sun_optical_depths;
  const np_scattering_field *scattering;  /* NULL: no solution */
  const np_viewer_light *viewer_light;    /* outgoing light of `scattering` towards one viewer, for rays from it; NULL:
                                             not computed */
  const np_ground_light *ground_light;    /* NULL: the sky over the ground counts as clear */
  const np_relief_light *relief_light;    /* NULL: hills neither hide nor light slopes */
  const np_air_shadow *air_shadow;        /* shadows in the camera's sky; NULL: none */
  bool has_shade_by_places;               /* the sun is looked for along each ray instead, up to whatever it meets */
  const np_sky_guide *sky_guide;          /* NULL: sky and ground are sampled by scattering alone */
  const np_cloud_gain *gains;             /* gains of an approximation for each cloud; NULL: the settings' gain for
                                             all */
  const struct np_reflection *reflection; /* lighting of rays that water reflects; NULL: none */
} np_lighting;

/* World and lighting for a ray that water reflects: under the sky over the water. */
typedef struct np_reflection {
  np_world world;
  np_lighting lighting;
} np_reflection;

/* Radiance of sky, night and environment along a camera ray that does not meet the ground, with the shadows of clouds
 * and hills.
 */
np_spectrum np_lighting_camera_sky(const np_lighting *lighting, const np_world *world, const np_view_ray *view);

/* Background radiance: np_lighting_camera_sky plus the disks of sun and moon, through the air. */
np_spectrum np_lighting_background(const np_lighting *lighting, const np_world *world, const np_view_ray *view);

/* In-scatter and transmittance between the eye and a point along its ray, with the shadows of clouds and hills. Beside
 * these the light of what ends the ray there that haze scatters straight on counts as transmitted. */
np_aerial_perspective np_lighting_camera_air(const np_lighting *lighting, const np_world *world,
                                             const np_view_ray *view, double distance_m, np_ray_end end);

/* Irradiance of sky, clouds and ground around on the ground. */
np_spectrum np_lighting_ground_irradiance(const np_lighting *lighting, const np_world *world, const np_ground_hit *hit);

/* Starts a query of optical depths of all clouds towards the sun. */
static inline void np_lighting_start_depths(const np_lighting *lighting, np_dvec3 position, np_vec3 to_sun,
                                            np_place_walk *out) {
  np_place_walk_start(out, lighting->sun_optical_depths.clouds, position, to_sun, INFINITY);
}

/* Optical depth of one cloud in a query: looked up where a cache has it, otherwise integrated. */
static inline float np_lighting_get_cloud_depth(const np_lighting *lighting, const np_instance *volume,
                                                np_dvec3 position, np_vec3 to_sun, const np_depth_query *query,
                                                float faded) {
  const float known = np_sun_optical_depths_get_known(&lighting->sun_optical_depths, volume, position, to_sun);
  if (known != NP_SUN_OPTICAL_DEPTH_UNKNOWN)
    return volume->bricks->detail ? np_maxf(known + np_track_near_detail(volume, position, to_sun), 0.0f) : known;
  return np_track_volume_depth(volume, position, to_sun, INFINITY, query, faded);
}

#endif
