/* SPDX-License-Identifier: Apache-2.0 */
/* The second part of a plan: facts about the files and bakes of the clouds of a request; inputs.c writes it. Sizes of
 * files are known at once, headers and the filling of bakes once they are measured. */
#ifndef NP_PLAN_INPUTS_H
#define NP_PLAN_INPUTS_H

#include "plan/input_store.h"
#include "plan/request.h"
#include "volume/instance.h"

/* The header of a cloud's file. */
typedef struct np_input_file {
  bool is_known;
  np_affine index_to_world;    /* its placement */
  int32_t size[3];             /* voxels along the box of active voxels */
  np_dvec3 low, high;          /* that box in the world */
  double voxel_count;          /* active voxels */
  double extinction_per_value; /* 1/m, as the file states it; 0: it does not */
  unsigned level_count;        /* files of levels of detail; 0: it is in none */
  bool has_colors;             /* it has shown colours, voxel by voxel */
} np_input_file;

/* Voxels of all clouds. A guess by sizes of files and of bakes, by which work is judged. */
typedef struct np_voxel_counts {
  double baked_box;     /* voxels in the boxes of the clouds to bake: an upper bound of stored voxels */
  double along_billows; /* baked voxels along billows (plan_detail.h) */
  double cloud[2];      /* voxels that hold cloud; second: with coarse voxels of files */
  double detailed[2];   /* the share of clouds with detail finer than voxels */
} np_voxel_counts;

typedef struct np_inputs {
  np_voxel_counts voxels;
  double filled_share; /* share of their boxes that baked clouds fill: two fifths, or as measured */

  /* The rest is 0 until it is measured. */
  bool is_measured;
  np_input_file *files; /* the header of each cloud's file; owned */
  unsigned file_count;
  double file_voxel_count; /* active voxels of all files */
  double file_cell_count;  /* cells of light in the boxes of files, as far as pixels limit them */
  double file_cover;       /* share of the picture's rays that meet files; 0 where there are other clouds */
} np_inputs;

/* Counts the voxels of a request's clouds; nothing of a picture of the sky. */
neph_result np_inputs_make(const neph_scene *scene, const np_request *request, np_inputs *out_inputs);

/* Reads headers, and measures by trial bakes of few voxels, a tenth of a second each, how much of their boxes clouds
 * fill. `*out_is_changed`: predictions change with it. */
neph_result np_inputs_measure(const neph_scene *scene, const np_request *request, np_input_store *store,
                              np_inputs *inputs, bool *out_is_changed);

void np_inputs_clear(neph_context *context, np_inputs *inputs);

/* The header of a cloud's file; an unknown one before it is measured. */
const np_input_file *np_inputs_get_file(const np_inputs *inputs, unsigned cloud);

/* Files of levels of detail that a cloud has: 0 before the header of a file from elsewhere is read. */
unsigned np_inputs_count_levels(const np_inputs *inputs, const neph_scene *scene, const np_scene_cloud *cloud);

#endif
