/* SPDX-License-Identifier: Apache-2.0 */
/* Directions of a scene's sun, moon and stars, and selection of the lights that a picture needs. */
#ifndef NP_SCENE_SCENE_LIGHTS_H
#define NP_SCENE_SCENE_LIGHTS_H

#include "atmosphere/celestial.h"
#include "scene/scene_private.h"

typedef struct np_scene_lights {
  np_dvec3 to_sun;
  double sun_factor; /* attenuation of a low sun: 1, falling to 0 from 18° to 19° below the horizon */
  np_moon_place moon;
  double moon_ratio;      /* irradiance relative to the sun's above the atmosphere, at 550 nm; 0: no moon */
  np_celestial_turn turn; /* rotation of the stars */
} np_scene_lights;

/* Computes the directions from angles, or from time and place. */
np_scene_lights np_scene_lights_compute(const neph_scene *scene, double latitude_rad, double longitude_rad);

/* Brightness of the lights relative to each other; every threshold is 1/1000. */
typedef struct np_scene_light_levels {
  double sun_height_deg;  /* elevation above the camera's visible horizon */
  double moon_height_deg; /* elevation above the camera's visible horizon */
  double sun_lux;         /* illuminance of the ground by sun and clear sky */
  double moon_lux;        /* illuminance by the moon at the zenith */
  bool is_sun_dark;       /* sun and its sky need not be built */
  bool is_moon_outshone;  /* the moon is outshone or far below the horizon: only its disk is visible */
  bool is_airglow_outshone;
  bool are_stars_outshone; /* stars are negligible in pixels of the given solid angle */
} np_scene_light_levels;

np_scene_light_levels np_scene_light_levels_compute(const neph_scene *scene, const np_scene_lights *lights,
                                                    double pixel_sr);

#endif
