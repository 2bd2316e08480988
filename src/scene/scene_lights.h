/* SPDX-License-Identifier: Apache-2.0 */
/* Directions of a scene's sun, moon and stars, and which of them a picture needs. */
#ifndef NP_SCENE_SCENE_LIGHTS_H
#define NP_SCENE_SCENE_LIGHTS_H

#include "atmosphere/celestial.h"
#include "scene/scene_private.h"

typedef struct np_scene_lights {
  np_dvec3 to_sun;
  double sun_factor; /* what is left of the sun's light: 1, and from 18° to 19° below the horizon down to 0 */
  np_moon_place moon;
  double moon_ratio;      /* of its irradiance above the air to the sun's, at 550 nm; 0: there is no moon */
  np_celestial_turn turn; /* of the stars */
} np_scene_lights;

/* Computes them from angles, or from time and place. */
np_scene_lights np_scene_lights_compute(const neph_scene *scene, double latitude_rad, double longitude_rad);

/* Order of the lights by brightness; every bound is a thousandth. */
typedef struct np_scene_light_levels {
  double sun_height_deg;  /* above the horizon that the camera sees */
  double moon_height_deg; /* above the same horizon */
  double sun_lux;         /* on the ground, of sun and clear sky */
  double moon_lux;        /* of the moon, at the zenith */
  bool is_sun_dark;       /* its sky and its light need not be built */
  bool is_moon_outshone;  /* or below its own twilight: only its disk is to be seen */
  bool is_airglow_outshone;
  bool are_stars_outshone; /* for pixels of this solid angle */
} np_scene_light_levels;

np_scene_light_levels np_scene_light_levels_compute(const neph_scene *scene, const np_scene_lights *lights,
                                                    double pixel_sr);

#endif
