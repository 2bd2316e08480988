/* SPDX-License-Identifier: Apache-2.0 */
/* The stages between a scene and a picture, and a plan: which of them are needed, and why. */
#ifndef NP_PLAN_PLAN_STAGES_H
#define NP_PLAN_PLAN_STAGES_H

#include "core/parallel.h"
#include "scene/scene_lights.h"
#include "scene/scene_private.h"
#include "volume/instance.h"

/* In the order in which they are built; stages.c has a row for each. */
typedef enum np_stage {
  NP_STAGE_COLOR,             /* packets of three bands, added up as the eye does */
  NP_STAGE_TERRAIN,           /* height field and its ray-tracing structure */
  NP_STAGE_MOON,              /* its skies, and its light on clouds and ground */
  NP_STAGE_LIGHTS,            /* sun, moon and stars in their places */
  NP_STAGE_VOLUMES,           /* files read and clouds baked, made into bricks */
  NP_STAGE_MOTION,            /* of camera and clouds about the frame */
  NP_STAGE_ATMOSPHERE,        /* optical depths and moments of the air */
  NP_STAGE_CAMERA_SKY,        /* the sky and the air seen from the camera */
  NP_STAGE_COLOR_FIT,         /* from three bands to colours, by the scene's own light */
  NP_STAGE_EMISSION,          /* of clouds: grids of emitters, and their cells by power */
  NP_STAGE_CLOUD_SKY,         /* the sky seen from the clouds */
  NP_STAGE_WATER_SKY,         /* the sky that water reflects */
  NP_STAGE_AIRGLOW,           /* and the map of the stars */
  NP_STAGE_SUN_LIGHT,         /* on clouds and ground */
  NP_STAGE_SKY_LIGHT,         /* on clouds and ground, the environment's included */
  NP_STAGE_GROUND_LIGHT,      /* reflected to the clouds */
  NP_STAGE_WORLD,             /* geometry, media, lights and night, for each light */
  NP_STAGE_SKY_GUIDE,         /* where sky and ground are bright, for paths to aim at */
  NP_STAGE_SUN_OPTICAL_DEPTH, /* of the clouds, filled in once, for march and shadows */
  NP_STAGE_ORDINATES,         /* multiple scattering solved for on coarse cells */
  NP_STAGE_VIEWER_LIGHT,      /* of that solution, towards the camera */
  NP_STAGE_GROUND_CLOUDS,     /* light from the clouds on the ground */
  NP_STAGE_AIR_SHADOWS,       /* of clouds and hills, in the air before the camera */
  NP_STAGE_APPROXIMATION,     /* multiple scattering approximated from single scattering */
  NP_STAGE_STARS,             /* of the catalogue, in the picture */
  NP_STAGE_LIGHTING,          /* the caches that answer the integrator */
  NP_STAGE_HISTORY,           /* the frame before, from which pixels are taken */
  NP_STAGE_INTEGRATOR,
  NP_STAGE_COUNT
} np_stage;

/* Predicted cost of a stage: seconds of one core, and bytes that stay while the picture is rendered. 0: next to
 * nothing, or not known. */
typedef struct np_stage_cost {
  double seconds, bytes;
} np_stage_cost;

typedef struct np_plan_stage {
  bool is_needed;
  char reason[240]; /* why, or why not; empty: not decided yet */
  np_stage_cost cost;
  double
      error; /* predicted share of a pixel's luminance that it is wrong by: a bias, of the integrator with its noise */
} np_plan_stage;

/* The file by which those of a sequence are placed and scaled. */
typedef struct np_plan_reference {
  const char *cloud; /* borrowed from the scene */
  bool is_known;     /* else none that holds anything was asked for yet */
  double number;     /* infinite: all files of the sequence */
} np_plan_reference;

/* States of light that is being solved for, kept with the picture's checkpoint. */
typedef struct np_light_checkpoints {
  const char *path; /* of the checkpoint; NULL: none are kept */
  double interval_s;
  bool is_resumed;
  unsigned block_end; /* 0: light of the frame itself; 1, 2: of the first and the last of the block that it is in */
} np_light_checkpoints;

/* Frames between which the light in clouds is interpolated (light_span.h). */
typedef struct np_light_span {
  int frames[2]; /* equal: none, the light is that of the frame itself */
  double share;  /* of the second, by the way of the light from one to the other */
} np_light_span;

/* A cloud's file by its header. */
typedef struct np_plan_file {
  bool is_known;
  np_affine index_to_world;    /* as placed */
  int32_t size[3];             /* of the box of active voxels */
  np_dvec3 low, high;          /* of that box in the world */
  double voxel_count;          /* active ones */
  double extinction_per_value; /* 1/m, as the file states it; 0: it does not */
  unsigned level_count;        /* files of levels of detail; 0: it is in none */
  bool has_colors;             /* voxel by voxel, which are shown */
} np_plan_file;

typedef struct np_plan {
  neph_context *context;            /* borrowed */
  neph_render_desc desc;            /* the caller's over the scene's, checked */
  int view_min[2], view_max[2];     /* pixels of the picture and its overscan; view_max is one past the last */
  int window_min[2], window_max[2]; /* those of them that are rendered: the data window */
  int whole_min[2], whole_max[2];   /* the window that this is a tile of */
  char hash[33];                    /* of the picture, once its files may be read; empty: none */
  unsigned sphere_size[2];          /* of a latitude-longitude picture, set by who paints one; 0: the camera's */
  double sphere_center_rad;         /* azimuth of its middle */
  bool is_sky_alone;                /* without clouds and terrain */
  bool is_of_bands;                 /* at 680, 550 and 440 nm, whatever the scene's pictures are */
  bool has_beauty;
  unsigned aovs; /* of np_aov */
  np_color_space color_space;
  unsigned wavelength_count, packet_count; /* packets of three bands each */
  bool are_lights_known; /* not where only the height field tells the place, and with it where the sun stands */
  np_scene_lights lights;
  bool has_light_groups;   /* each light has a world of its own, and is summed apart */
  unsigned emission_count; /* clouds with emission */
  bool has_sun;            /* its light matters; the moon's is a stage */
  np_plan_stage stages[NP_STAGE_COUNT];
  unsigned reference_count; /* noted where the inputs are opened */
  np_plan_reference references[NP_INSTANCES_MAX];
  uint64_t ray_count;        /* of the camera: pixels of the crop times samples */
  uint64_t film_bytes;       /* of the film's channels in float */
  unsigned air_ray_spacing;  /* pixels between rays along which shadows in the air are looked for; 0: none */
  double bake_voxel_count;   /* in the boxes of the clouds to bake: an upper bound of what is kept */
  double cloud_voxel_count;  /* that hold cloud: a guess, by which work is judged */
  double billow_voxel_count; /* of those baked, along billows (plan_detail.h) */
  double detail_voxel_count; /* of those of clouds with detail finer than voxels */
  double filled_share;       /* of the boxes of clouds that are baked: two fifths, or as measured */
  double file_cell_count;    /* of light, in the boxes of files, as far as pixels limit them; 0: not measured */
  double file_cover; /* share of the picture's rays that meet files, where there are no other clouds; 0: not known */
  double file_voxel_count;              /* active ones of all files, by their headers; 0: not measured */
  np_plan_file files[NP_INSTANCES_MAX]; /* of each cloud that has one, once it is measured */
  bool is_fill_measured;
  double light_bytes_max;              /* of multiple scattering while it is solved for */
  double light_bytes_wanted;           /* the same without memory_max_bytes */
  bool are_halves;                     /* volumes in memory, whatever their clouds' precision */
  bool are_coarse;                     /* volumes of files: voxels twice as long */
  char savings[240];                   /* what was given up to stay within the limit on memory; empty: nothing */
  double bias, noise;                  /* predicted of the picture: docs/error.md */
  double sample_mean;                  /* predicted samples a pixel; with a target error it is what that takes */
  double work_factor[NEPH_WORK_COUNT]; /* time of each kind of work, over that of the machine of the constants */
  double constant_s;                   /* predicted for all stages without those factors: the same on every machine */
  double constant_common_s;            /* of that, what parts of a picture have in common: all but its samples */
  np_light_span light_span;
  np_light_checkpoints light_checkpoints;
  double light_error;      /* expected of the largest cells of multiple scattering; 0: it is not solved */
  double light_cell_count; /* in the box of clouds of which one is known, where multiple scattering is solved for; else
                              0 */
  double light_share;      /* of them, those with cloud */
} np_plan;

static inline uint64_t np_plan_count_pixels(const np_plan *plan) {
  return (uint64_t)(plan->window_max[0] - plan->window_min[0]) * (uint64_t)(plan->window_max[1] - plan->window_min[1]);
}

static inline bool np_plan_needs(const np_plan *plan, np_stage stage) { return plan->stages[stage].is_needed; }

/* Seconds that its threads take for what one core takes a second for. */
static inline double np_plan_get_core_s(const np_plan *plan) {
  return 1.0 / neph_context_get_thread_count(plan->context);
}

/* Whether paths go on through the air and from the ground. */
static inline bool np_plan_traces_air(const np_plan *plan) {
  return plan->desc.integrator == NEPH_INTEGRATOR_PATH && plan->desc.atmosphere == NEPH_RENDER_ATMOSPHERE_TRACED;
}

/* Whether light that air scatters is looked up in tables: by all but paths that trace it, and by what those are guided
 * by. */
static inline bool np_plan_has_air_light(const np_plan *plan) {
  return !np_plan_traces_air(plan) || np_plan_needs(plan, NP_STAGE_CLOUD_SKY) ||
         np_plan_needs(plan, NP_STAGE_ORDINATES);
}

/* Precision of a cloud's values in memory. */
static inline neph_precision np_plan_get_precision(const np_plan *plan, const np_scene_cloud *cloud) {
  return plan->are_halves ? NEPH_PRECISION_HALF : cloud->precision;
}

/* Lights with a world of their own: sun, moon or both; the sun, without light, where neither shines. */
static inline bool np_plan_has_sun_world(const np_plan *plan) {
  return plan->has_sun || !np_plan_needs(plan, NP_STAGE_MOON);
}

static inline unsigned np_plan_count_lights(const np_plan *plan) {
  if (plan->has_light_groups)
    return (plan->has_sun ? 2u : 1u) + (np_plan_needs(plan, NP_STAGE_MOON) ? 1u : 0u) + plan->emission_count;
  return (np_plan_has_sun_world(plan) ? 1u : 0u) + (np_plan_needs(plan, NP_STAGE_MOON) ? 1u : 0u);
}

#endif
