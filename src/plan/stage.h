/* SPDX-License-Identifier: Apache-2.0 */
/* The stages between a scene and a picture; stage_rules.c has a row for each. */
#ifndef NP_PLAN_STAGE_H
#define NP_PLAN_STAGE_H

/* The stages in the order in which they are built. */
typedef enum np_stage {
  NP_STAGE_COLOR,             /* packets of three bands, summed to colours */
  NP_STAGE_TERRAIN,           /* height field and its ray-tracing structure */
  NP_STAGE_MOON,              /* the moon's skies, and its light on clouds and ground */
  NP_STAGE_LIGHTS,            /* sun, moon and stars in their places */
  NP_STAGE_VOLUMES,           /* bricks of files that are read, and of clouds that are baked */
  NP_STAGE_MOTION,            /* motion of camera and clouds about the frame */
  NP_STAGE_ATMOSPHERE,        /* optical depths and moments of the air */
  NP_STAGE_CAMERA_SKY,        /* the sky and the air seen from the camera */
  NP_STAGE_COLOR_FIT,         /* matrix of three bands to colours, by the scene's own light */
  NP_STAGE_EMISSION,          /* grids of emitters in clouds, and their cells by power */
  NP_STAGE_CLOUD_SKY,         /* the sky seen from the clouds */
  NP_STAGE_WATER_SKY,         /* the sky that water reflects */
  NP_STAGE_AIRGLOW,           /* airglow and the map of the stars */
  NP_STAGE_SUN_LIGHT,         /* sunlight on clouds and ground */
  NP_STAGE_SKY_LIGHT,         /* skylight on clouds and ground, the environment's included */
  NP_STAGE_GROUND_LIGHT,      /* light that the ground reflects to the clouds */
  NP_STAGE_WORLD,             /* geometry, media, lights and night, for each light */
  NP_STAGE_SKY_GUIDE,         /* bright directions of sky and ground, sampled by paths */
  NP_STAGE_SUN_OPTICAL_DEPTH, /* optical depths of the clouds towards the sun, filled once for march and shadows */
  NP_STAGE_ORDINATES,         /* multiple scattering solved for on coarse cells */
  NP_STAGE_VIEWER_LIGHT,      /* light of that solution towards the camera */
  NP_STAGE_GROUND_CLOUDS,     /* light from the clouds on the ground */
  NP_STAGE_RELIEF_LIGHT,      /* light of hills and of the sky between hills, on slopes */
  NP_STAGE_AIR_SHADOWS,       /* shadows of clouds and hills in the air before the camera */
  NP_STAGE_APPROXIMATION,     /* multiple scattering approximated from single scattering */
  NP_STAGE_STARS,             /* stars of the catalogue in the picture */
  NP_STAGE_LIGHTING,          /* the caches that integrators look up light in */
  NP_STAGE_HISTORY,           /* the frame before, which supplies pixels */
  NP_STAGE_INTEGRATOR,
  NP_STAGE_COUNT
} np_stage;

#endif
