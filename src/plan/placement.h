/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in their places: from a grid's own transform and unit to world and 1/m. */
#ifndef NP_PLAN_PLACEMENT_H
#define NP_PLAN_PLACEMENT_H

#include "core/parallel.h"
#include "scene/camera.h"
#include "scene/scene_private.h"
#include "terrain/terrain_private.h"
#include "volume/instance.h"

/* Placement of a cloud's files in the world, and the meaning of their values. */
typedef struct np_anchor {
  np_affine file_to_world;
  float extinction_per_value; /* 1/m, by key optical_depth; 0 without that key: the scale then depends on no frame */
} np_anchor;

typedef struct np_placement {
  np_instance world;
  np_affine index_to_world;
  np_dvec3 bounds_min, bounds_max; /* world box of the active samples */
} np_placement;

/* World box of a volume's active samples. */
void np_placement_compute_bounds(const np_affine *index_to_world, const neph_volume *volume, np_dvec3 *out_min,
                                 np_dvec3 *out_max);

/* Largest edge of a voxel, in the unit of the map's range. */
double np_placement_get_voxel_edge(const np_affine *map);

/* Upright, scaled, tilted about x and y, turned about the vertical. */
np_affine np_placement_make_turn(const np_scene_cloud *cloud, double scale);

/* Moves a cloud's pivot to its position, if it has one. `low` and `high`: box of the file's voxels. */
void np_placement_move_box(const np_scene_cloud *cloud, np_dvec3 low, np_dvec3 high, np_affine *file_to_world);

/* Extinction, 1/m, of a value of 1; or the optical depth, by which it is scaled. `of_file` is the extinction that its
 * file states, which counts where no key does. */
double np_placement_get_extinction(const np_scene_cloud *cloud, double of_file);

/* Whether a cloud's voxel, position or optical_depth depend on the contents of a volume. */
bool np_placement_needs_reference(const np_scene_cloud *cloud);

/* Placement of a cloud's files by its keys: up axis, voxel edge, scale, rotation, position; and the extinction that
 * optical_depth requires. `reference` is the volume that they depend on; NULL where they need none. */
neph_result np_placement_anchor(const np_scene_cloud *cloud, const neph_volume *reference, np_monitor *monitor,
                                np_anchor *out_anchor);

/* Places a volume of a cloud's file. */
neph_result np_placement_make(const np_scene_cloud *cloud, const np_anchor *anchor, const neph_volume *volume,
                              np_monitor *monitor, np_placement *out_placement);

/* Surroundings by which a cloud's place is judged. */
typedef struct np_placement_view {
  const np_camera *camera;
  double planet_radius_m;      /* 0: no planet, and no ground */
  const neph_terrain *terrain; /* NULL: the sphere alone */
} np_placement_view;

/* A place or a size that cannot be meant. */
typedef struct np_placement_fault {
  const char *rule; /* "cloud.out_of_view" */
  char cause[200];  /* behind the cloud's name: "is 3 m across, less than 10 m" */
  const char *keys; /* placement by the file */
} np_placement_fault;

enum { NP_PLACEMENT_FAULTS_MAX = 8 };

/* Lists what is wrong with a cloud whose world box is wholly outside the camera's view, before its near plane, beyond
 * its far plane, smaller than a pixel, below the ground or far from the terrain, under 10 m or over 1000 km across.
 * What stands before it does not count. Returns their number. */
unsigned np_placement_list_faults(const np_scene_cloud *cloud, const np_placement_view *view, np_dvec3 low,
                                  np_dvec3 high, np_placement_fault out_faults[NP_PLACEMENT_FAULTS_MAX]);

/* Warns of an implausible placement. */
void np_placement_check(neph_context *context, const np_scene_cloud *cloud, const np_placement_view *view, np_dvec3 low,
                        np_dvec3 high);

#endif
