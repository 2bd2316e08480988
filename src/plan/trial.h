/* SPDX-License-Identifier: Apache-2.0 */
/* A coarse map of a scene's clouds in the world, before any of them is built. Clouds that are to be baked are baked
 * with few voxels, files of few voxels are read, and others fill the middle of the boxes in their headers. */
#ifndef NP_PLAN_TRIAL_H
#define NP_PLAN_TRIAL_H

#include "plan/inputs.h"

/* Number of voxel sizes for which a trial counts bricks: one, two and four times the bake's. */
enum { NP_TRIAL_SHARES = 3 };

/* One cloud of a trial. */
typedef struct np_trial_cloud {
  double brick_share[NP_TRIAL_SHARES]; /* share of the bricks in the box of a bake that hold cloud */
  double brick_voxels;                 /* voxels in the bricks of a file that was read; 0: it was not */
  double densest_per_m;                /* extinction at its densest point */
  double voxel_m;                      /* shortest edge of the voxels of a file; 0: of a bake, whose own are finer */
} np_trial_cloud;

/* Share of the bricks of a bake with voxels `factor` times as long as its own. */
double np_trial_cloud_get_share(const np_trial_cloud *cloud, double factor);

typedef struct np_trial {
  neph_context *context; /* borrowed */
  unsigned references;
  np_dvec3 low, high; /* world box of all clouds, of those that repeat without end once */
  bool is_endless;    /* rays meet the map again and again: it has a cloud that repeats along x and y */
  bool is_mixed;      /* and others beside it */
  int32_t size[3];    /* cells of the map, x fastest */
  float *ground_m;    /* height of the ground under fog in each column; negative infinite: none */
  float *extinction;  /* extinction at the middle of each cell, 1/m */
  uint32_t *sums;     /* cells with cloud below each corner of the map, [size + 1] */
  double thickness_m; /* typical thickness of the clouds; infinite: there are none */
  np_trial_cloud clouds[NP_INSTANCES_MAX];
} np_trial;

/* Makes the map. `inputs` has the headers of files. `*out_trial` is NULL where no cloud has a known place. The trial is
 * released once for each reference. */
neph_result np_trial_make(const neph_scene *scene, const np_request *request, const np_inputs *inputs,
                          np_trial **out_trial);

static inline np_trial *np_trial_retain(np_trial *trial) {
  if (trial) trial->references++;
  return trial;
}

void np_trial_release(np_trial *trial);

/* Whether a world box holds cloud, and its middle is not below the ground. */
bool np_trial_has_cloud(const np_trial *trial, np_dvec3 low, np_dvec3 high);

/* Traces a lattice of camera rays through the map of clouds; terrain is ignored. */
np_view_counts np_trial_see(const np_trial *trial, const np_request *request, const neph_scene *scene);

/* Follows paths of the path tracer through the map. */
np_path_counts np_trial_trace(const np_trial *trial, const np_request *request, const neph_scene *scene);

/* Follows rays from points on the ground, at sea level, through the map. */
np_ground_counts np_trial_see_from_ground(const np_trial *trial);

#endif
