/* SPDX-License-Identifier: Apache-2.0 */
/* The plan of a render: which stages the scene and the wanted outputs need, and why, decided before anything is built.
 */
#ifndef NP_SCENE_PLAN_H
#define NP_SCENE_PLAN_H

#include "scene/reference_store.h"
#include "scene/scene_lights.h"

typedef enum np_stage {
  NP_STAGE_VOLUMES,      /* files read and clouds baked, made into bricks */
  NP_STAGE_TERRAIN,      /* height field and its ray-tracing structure */
  NP_STAGE_ATMOSPHERE,   /* optical depths and moments of the air */
  NP_STAGE_CAMERA_SKY,   /* the sky and the air seen from the camera */
  NP_STAGE_CLOUD_SKY,    /* the sky seen from the clouds */
  NP_STAGE_SUN_LIGHT,    /* on clouds and ground */
  NP_STAGE_SKY_LIGHT,    /* on clouds and ground, the environment's included */
  NP_STAGE_GROUND_LIGHT, /* thrown back at the clouds */
  NP_STAGE_SUN_DEPTH,    /* of the clouds, filled in once, for march and shadows */
  NP_STAGE_ORDINATES,    /* multiple scattering solved for on coarse cells */
  NP_STAGE_GROUND_CLOUDS, /* light from the clouds on the ground */
  NP_STAGE_AIR_SHADOWS,   /* of clouds and hills, in the air before the camera */
  NP_STAGE_LOOK,      /* multiple scattering guessed from single scattering */
  NP_STAGE_INTEGRATOR,
  NP_STAGE_COLOR, /* packets of three bands, added up as the eye does */
  NP_STAGE_MOON,    /* its skies, and its light on clouds and ground */
  NP_STAGE_STARS,   /* of the catalogue, in the picture */
  NP_STAGE_AIRGLOW, /* and the map of the stars */
  NP_STAGE_EMISSION, /* of clouds: grids of what glows, and a list of the lights they are */
  NP_STAGE_COUNT
} np_stage;

typedef struct np_plan_stage {
  bool is_needed;
  char reason[240]; /* why, or why not */
} np_plan_stage;

/* The frame by which a sequence's frames are placed and scaled. */
typedef struct np_plan_reference {
  const char *cloud; /* borrowed from the scene */
  bool is_known;     /* else none that holds anything was asked for yet */
  int frame;
} np_plan_reference;

typedef struct np_plan {
  neph_context *context; /* borrowed */
  neph_render_desc desc; /* the caller's over the scene's, checked */
  unsigned sphere_size[2]; /* of a latitude-longitude picture, set by who paints one; 0: the camera's */
  bool has_beauty;
  unsigned aovs; /* of np_aov */
  np_color_space color_space;
  unsigned wavelength_count, packet_count; /* packets of three bands each */
  bool are_lights_known; /* not where only the height field tells the place, and with it where the sun stands */
  np_scene_lights lights;
  bool has_sun; /* its light matters; the moon's is a stage */
  np_plan_stage stages[NP_STAGE_COUNT];
  unsigned reference_count; /* noted where the inputs are opened */
  np_plan_reference references[NP_INSTANCES_MAX];
  uint64_t ray_count;      /* of the camera: pixels of the crop times samples */
  uint64_t film_bytes;     /* of the film's channels in float */
  unsigned air_ray_spacing; /* pixels between rays along which shadows in the air are looked for; 0: none */
  double bake_voxel_count; /* in the boxes of the clouds to bake: an upper bound of what is kept */
  double cloud_voxel_count; /* that hold cloud: a guess, by which work is judged */
} np_plan;

/* Where a cloud comes from. */
typedef enum np_cloud_source {
  NP_CLOUD_SOURCE_FILE,  /* read */
  NP_CLOUD_SOURCE_BAKE,  /* baked; to its file where it has one, which is not there yet */
  NP_CLOUD_SOURCE_REBAKE /* its file holds another cloud, and is baked anew */
} np_cloud_source;

/* Decides for a cloud of a scene; `file` is that of the frame, NULL where the cloud has none. */
neph_result np_plan_find_source(const neph_scene *scene, const np_scene_cloud *cloud, const char *file, int frame,
                                np_cloud_source *out_source);

/* Checks scene and description, and decides. `desc` NULL: the scene's own. */
neph_result np_plan_make(const neph_scene *scene, const neph_render_desc *desc, np_plan *out_plan);

/* Decides anew for a frame in which no cloud holds anything: what only clouds need is left out. */
neph_result np_plan_leave_out_clouds(const neph_scene *scene, np_plan *plan);

/* Decides between filling a volume of depths towards the sun and marching for each, for a plan whose rays and voxels
 * are counted; says why. */
bool np_plan_choose_sun_volume(const np_plan *plan, const neph_scene *scene, char *out_reason, size_t reason_size);

/* Decides whether clouds and hills cast shadows into the air, for a plan that has a sky for the camera; says why. */
bool np_plan_choose_air_shadows(const np_plan *plan, const neph_scene *scene, char *out_reason, size_t reason_size);

/* Pixels between the rays along which they are looked for: a quarter of a degree, half the sun's disk, or two where
 * that is less. */
unsigned np_plan_choose_air_spacing(const np_plan *plan, const neph_scene *scene);

/* The same for a picture of the sky alone: no clouds, no terrain. */
neph_result np_plan_make_sky(const neph_scene *scene, np_plan *out_plan);

/* Whether paths go on through the air and from the ground. */
bool np_plan_traces_air(const np_plan *plan);

/* Whether light that air scatters is looked up in tables: by all but paths that trace it, and by what those are guided
 * by. */
bool np_plan_has_air_light(const np_plan *plan);

/* The plan as text, to be freed with neph_text_destroy. */
neph_result np_plan_describe(const np_plan *plan, neph_text_format format, char **out_text);

/* "volumes", "camera sky". */
const char *np_stage_get_name(np_stage stage);

#endif
