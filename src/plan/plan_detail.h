/* SPDX-License-Identifier: Apache-2.0 */
/* Detail of clouds and mountains that a picture can show: `render.detail` pixels wide at least. */
#ifndef NP_PLAN_PLAN_DETAIL_H
#define NP_PLAN_PLAN_DETAIL_H

#include "cloud/lod.h"
#include "plan/request.h"

#define NP_DETAIL_PIXELS 1.5

enum { NP_COPY_LEVELS_MAX = 4 }; /* halvings for which the voxels of a tile are rounded (cloud/repeat.h) */

/* A cloud to bake, in the request's frame. Voxels are enlarged by powers of √2, so that a moving camera seldom changes
 * them. */
neph_cloud_desc np_plan_get_bake(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud);

/* Description of its bake in the scene's precision, without its limit of memory and its progress. Levels of detail go
 * by all places where the camera ever is, so that they stay from frame to frame. */
neph_bake_desc np_plan_get_bake_desc(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud);

/* Levels of detail that the copies of a field that repeats have, of which each has one; of other clouds 1. */
unsigned np_plan_count_copy_levels(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud);

/* Viewers of a cloud's levels: all places where the camera ever is. */
np_lod_viewers np_plan_get_viewers(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud);

/* The planet and the levels of detail of a bake to a file. Levels depend on the scene's own resolution, so that no
 * picture of another size rebakes it. */
void np_plan_describe_file_bake(const neph_scene *scene, const np_scene_cloud *cloud, neph_bake_desc *desc);

/* Number of voxels in the box of a bake, and that number times the voxels' length in billows, at most 1; 0 for kinds
 * without billows. */
typedef struct np_bake_voxels {
  double box, along_billows;
} np_bake_voxels;

np_bake_voxels np_plan_count_bake_voxels(const np_request *request, const neph_scene *scene,
                                         const np_scene_cloud *cloud);

/* Refuses bakes of more voxels than a box may have: NEPH_ERROR_LIMIT. */
neph_result np_plan_check_boxes(const np_request *request, const neph_scene *scene);

/* Whether a cloud's voxels are coarser than the scene's: it is then baked to memory, and its file stays as it is. */
bool np_plan_is_coarsened(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud);

/* Detail finer than a cloud's voxels: as the scene describes it, or, if it is automatic, in pictures of final quality
 * where a voxel of `voxel_m` at the nearest point of the world box covers more pixels than NP_DETAIL_PIXELS. Its
 * strength then grows with those pixels without a step. A strength of 0: none. */
np_scene_detail np_plan_get_fine_detail(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud,
                                        double voxel_m, np_dvec3 low, np_dvec3 high);

/* Whether a cloud is predicted to have subvoxel detail. For files, whose voxels are unknown, this depends on the
 * scene's keys. */
bool np_plan_has_fine_detail(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud);

/* Generated mountains, with half, a quarter and so on of the scene's heights along a side. */
neph_ridges_desc np_plan_get_ridges(const np_request *request, const neph_scene *scene);

/* Least width of the cells of multiple scattering by `render.light_detail`; 0: none. */
double np_plan_get_light_edge(const np_request *request, const neph_scene *scene, np_dvec3 low, np_dvec3 high);

/* Number of the picture's rays that meet a world box, visible or hidden. */
double np_plan_count_rays_to(const np_request *request, const neph_scene *scene, np_dvec3 low, np_dvec3 high);

/* Pixels that a cell of light covers at least: one where clouds stand in many places, since their number would go with
 * that of the copies, however small those are in the picture. 0: as many cells as there are. */
double np_plan_get_light_detail(const neph_scene *scene);

#endif
