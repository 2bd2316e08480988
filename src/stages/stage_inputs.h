/* SPDX-License-Identifier: Apache-2.0 */
/* The inputs of each stage's makers: surroundings of the part, and results of other stages.
 *
 * NP_RESULT_STAGE(X) lists what a stage hands over as X(type, name, source), where `at` is the task of the reader: its
 * picture, and the packet, the light and the caches of its part; a part of the picture or of a light reads the first
 * packet's. The inputs of a stage are the results of the stages that stage_needs.h lists for it, and its own earlier
 * parts.
 */
#ifndef NP_STAGES_STAGE_INPUTS_H
#define NP_STAGES_STAGE_INPUTS_H

#include "plan/stage_needs.h"
#include "stages/build_job.h"
#include "stages/packet.h"

#define NP_STAGE_PART_MEMBERS                                                                                          \
  neph_context *context;                                                                                               \
  const neph_scene *scene; /* NULL when parts are cleared, and the five below */                                       \
  const np_plan *plan;                                                                                                 \
  np_monitor *monitor;                                                                                                 \
  const np_build_job *job;                                                                                             \
  np_schedule *schedule; /* shares of a time limit */                                                                  \
  const np_camera *camera;                                                                                             \
  bool has_reused; /* some results of the picture are reused from earlier pictures */                                  \
  unsigned slot;   /* index of the part among the parts that later pictures reuse */                                   \
  unsigned cloud;  /* number of the cloud of a part per cloud */                                                       \
  unsigned group;  /* group of the light of a part per light */                                                        \
  void *key;       /* key by which later pictures may reuse the part; NULL: the part is not reused */                  \
  void *spare;     /* parts of an earlier result for the one that is built; NULL: none */

/* Surroundings of a part that is built, compared or cleared. */
typedef struct np_stage_part {
  NP_STAGE_PART_MEMBERS
} np_stage_part;

/* clang-format off */
#define NP_RESULT_COLOR(X) X(const np_band_set *, bands, &at->packet->bands)
#define NP_RESULT_TERRAIN(X) X(neph_terrain *, terrain, at->picture->terrain)
#define NP_RESULT_MOON(X)
#define NP_RESULT_LIGHTS(X) \
  X(const np_picture_lights *, lights, &at->picture->lights) \
  X(const np_light_beam *, beam, &at->light->beam)
#define NP_RESULT_VOLUMES(X) X(const np_frame_clouds *, clouds, &at->picture->clouds)
#define NP_RESULT_MOTION(X) X(const struct np_motion *, motion, at->picture->motion)
#define NP_RESULT_ATMOSPHERE(X) X(neph_atmosphere *, atmosphere, at->packet->atmosphere)
#define NP_RESULT_CAMERA_SKY(X) X(neph_sky *, camera_sky, at->light->camera_sky)
#define NP_RESULT_COLOR_FIT(X) X(const np_picture_color *, color, &at->picture->color)
#define NP_RESULT_EMISSION(X) X(const np_packet_emission *, emission, &at->packet->emission)
#define NP_RESULT_CLOUD_SKY(X) X(const neph_sky *, cloud_sky, at->light->cloud_sky)
#define NP_RESULT_WATER_SKY(X) X(const neph_sky *, water_sky, at->light->water_sky)
#define NP_RESULT_AIRGLOW(X) \
  X(const np_sphere_map *, star_map, &at->picture->star_map) \
  X(const np_night *, night, &at->packet->night)
#define NP_RESULT_WORLD(X) \
  X(const np_placed_clouds *, placed, &at->packet->placed) \
  X(const np_world *, world, &at->light->world)
#define NP_RESULT_SKY_GUIDE(X) X(const np_sky_guide *, sky_guide, &at->light->sky_guide)
#define NP_RESULT_SUN_OPTICAL_DEPTH(X) X(const np_sun_optical_depth *, depth, at->caches->sun_optical_depth)
#define NP_RESULT_ORDINATES(X) X(const np_scattering_field *, scattering, at->light->scattering)
#define NP_RESULT_VIEWER_LIGHT(X) X(const np_viewer_light *, viewer_light, at->light->viewer_light)
#define NP_RESULT_GROUND_CLOUDS(X) X(const np_cloud_light *, cloud_light, at->light->cloud_light)
#define NP_RESULT_RELIEF_LIGHT(X) X(const np_relief_light *, relief_light, at->light->relief_light)
#define NP_RESULT_AIR_SHADOWS(X) \
  X(const np_air_visibility *, visibility, &at->caches->air_visibility) \
  X(const np_air_shadow *, air_shadow, &at->light->air_shadow)
#define NP_RESULT_APPROXIMATION(X) \
  X(const np_cloud_gain *, gains, at->packet->gains) \
  X(const np_cloud_gain *, first_gains, at->picture->packets->gains)
#define NP_RESULT_STARS(X) X(const np_star_catalogue *, catalogue, &at->picture->catalogue)
#define NP_RESULT_LIGHTING(X) X(const np_lighting *, lighting, &at->light->lighting)

/* The stages whose makers have inputs: X(name, STAGE). The stage of colours has none, and is the first. */
#define NP_INPUTS_OF_STAGES(X) \
  X(terrain, TERRAIN) X(lights, LIGHTS) X(volumes, VOLUMES) X(motion, MOTION) X(atmosphere, ATMOSPHERE) \
  X(camera_sky, CAMERA_SKY) X(color_fit, COLOR_FIT) X(emission, EMISSION) X(cloud_sky, CLOUD_SKY) \
  X(water_sky, WATER_SKY) X(airglow, AIRGLOW) X(world, WORLD) X(sky_guide, SKY_GUIDE) \
  X(sun_optical_depth, SUN_OPTICAL_DEPTH) X(ordinates, ORDINATES) X(viewer_light, VIEWER_LIGHT) \
  X(ground_clouds, GROUND_CLOUDS) X(relief_light, RELIEF_LIGHT) X(air_shadows, AIR_SHADOWS) \
  X(approximation, APPROXIMATION) X(stars, STARS) X(lighting, LIGHTING)
/* clang-format on */

#define NP_INPUTS_MEMBER(type, name, source) type name;
#define NP_INPUTS_MEMBERS(STAGE) NP_RESULT_##STAGE(NP_INPUTS_MEMBER)
#define NP_INPUTS_STRUCT(name, STAGE)                                                                                  \
  typedef struct np_##name##_inputs {                                                                                  \
    union {                                                                                                            \
      np_stage_part part;                                                                                              \
      struct {                                                                                                         \
        NP_STAGE_PART_MEMBERS                                                                                          \
      };                                                                                                               \
    };                                                                                                                 \
    NP_NEEDS_##STAGE(NP_INPUTS_MEMBERS) NP_RESULT_##STAGE(NP_INPUTS_MEMBER)                                            \
  } np_##name##_inputs;

/* Input structs np_NAME_inputs: members of a part, then the results that NP_RESULT_STAGE lists. */
NP_INPUTS_OF_STAGES(NP_INPUTS_STRUCT)

#define NP_INPUTS_OF_STAGE(name, STAGE) np_##name##_inputs name;

/* The inputs of one stage; its part is theirs. */
typedef union np_stage_inputs {
  np_stage_part part;
  NP_INPUTS_OF_STAGES(NP_INPUTS_OF_STAGE)
} np_stage_inputs;

#endif
