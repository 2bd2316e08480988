/* SPDX-License-Identifier: Apache-2.0 */
/* The second part of a plan: facts about the files and bakes of the clouds of a request; inputs.c writes it. Sizes of
 * files are known at once, headers and the filling of bakes once they are measured. */
#ifndef NP_PLAN_INPUTS_H
#define NP_PLAN_INPUTS_H

#include "plan/input_store.h"
#include "plan/request.h"
#include "volume/instance.h"

/* Share of its bricks that a bake is taken to fill until it is measured. */
#define NP_FILLED_SHARE 0.4

/* Share of the cells and bricks with cloud, where a share of the voxels has it: one voxel with cloud is enough for a
 * cell. The exponent fits a hero, a deck, and three fields whose voxels fill 0.1 to 0.16, to a quarter. */
static inline double np_plan_get_cell_share(double voxel_share) { return pow(voxel_share, 0.6); }

/* The header of a cloud's file. */
typedef struct np_input_file {
  bool is_known;
  np_affine index_to_world;    /* its placement */
  int32_t size[3];             /* voxels along the box of active voxels */
  np_dvec3 low, high;          /* world bounds of that box */
  double voxel_count;          /* active voxels */
  double extinction_per_value; /* 1/m, as the file states it; 0: it does not */
  unsigned level_count;        /* files of levels of detail; 0: it is in none */
  bool has_colors;             /* it has shown colours, voxel by voxel */
} np_input_file;

/* Voxels of all clouds. A guess by sizes of files and of bakes, by which work is judged. */
typedef struct np_voxel_counts {
  double baked_box;     /* voxels in the boxes of the clouds to bake: an upper bound of stored voxels */
  double baked;         /* baked voxels in bricks */
  double along_billows; /* baked voxels along billows (plan_detail.h) */
  double cloud[2];      /* voxels that hold cloud, baked or read; second: with coarse voxels of files */
  double detailed[2];   /* the share of clouds with detail finer than voxels */
  double split[2];      /* the share of clouds that are split into droplets and crystals */
  double parts[2];      /* voxels in bricks that this adds (volume/volume_ice.h) */
} np_voxel_counts;

/* The terrain's source. */
typedef struct np_terrain_counts {
  double made, read; /* generated heights, and heights from files with their margin */
  double mesh_bytes; /* bytes of a file of a mesh */
  double texels;     /* texels of a picture of its albedo */
} np_terrain_counts;

/* Means over the rays of a picture. */
typedef struct np_view_counts {
  double cover;    /* share of rays that meet cloud */
  double length_m; /* path length in cloud until the ray is opaque */
} np_view_counts;

/* Means over the paths of a picture. */
typedef struct np_path_counts {
  double cover;             /* share of paths that collide with cloud */
  double collisions;        /* collisions with cloud */
  double flight_m, light_m; /* path length in cloud, of the path and of its rays to the sun or moon */
} np_path_counts;

/* Rays from points on the ground to the clouds, by which light from the clouds on the ground is gathered. */
typedef struct np_ground_counts {
  double points;   /* points on the ground */
  double way_m;    /* mean path length of a ray through the clouds' box */
  double length_m; /* path length in cloud until the ray is opaque */
} np_ground_counts;

typedef struct np_inputs {
  np_voxel_counts voxels;
  np_terrain_counts terrain;

  /* The rest is 0 until it is measured. */
  bool is_measured;
  np_input_file *files; /* the header of each cloud's file; owned */
  unsigned file_count;
  double file_voxel_count; /* active voxels of all files */
  double file_cell_count;  /* number of light cells in the boxes of files, as limited by the pixels' size */
  struct np_trial *trial;  /* retained map of the clouds; NULL: none */
  np_view_counts view;     /* rays of the picture through the trial */
  np_path_counts paths;    /* paths of the picture through it; 0 for the march */
  np_ground_counts ground; /* rays from the ground through it */
} np_inputs;

/* Counts the voxels of a request's clouds; 0 for a picture of the sky alone. */
neph_result np_inputs_make(const neph_scene *scene, const np_request *request, np_inputs *out_inputs);

/* Reads headers, and builds a trial (trial.h) in a few tenths of a second, or takes the store's; then counts again.
 * `*out_is_changed`: predictions have changed. */
neph_result np_inputs_measure(const neph_scene *scene, const np_request *request, np_input_store *store,
                              np_inputs *inputs, bool *out_is_changed);

/* Frees the trial here and in the store after the last decision that depends on it: it takes some megabytes. */
void np_inputs_drop_trial(np_inputs *inputs, np_input_store *store);

void np_inputs_clear(neph_context *context, np_inputs *inputs);

/* The header of a cloud's file; `is_known` is false before it is measured. */
const np_input_file *np_inputs_get_file(const np_inputs *inputs, unsigned cloud);

/* Share of a file's box that is cloud. */
double np_input_file_get_share(const np_input_file *file);

/* Length after which a cloud from a file repeats along x or y; 0: it does not. */
double np_input_file_get_period_m(const np_scene_cloud *cloud, const np_input_file *file, int axis);

/* Extinction at the densest point of a file, 1/m, by its header. */
double np_input_file_guess_extinction(const np_scene_cloud *cloud, const np_input_file *file);

/* Files of levels of detail that a cloud has: 0 before the header of a file from elsewhere is read. */
unsigned np_inputs_count_levels(const np_inputs *inputs, const neph_scene *scene, const np_scene_cloud *cloud);

#endif
