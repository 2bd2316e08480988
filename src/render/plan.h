/* SPDX-License-Identifier: Apache-2.0 */
/* The plan of a render: which stages the scene and the wanted outputs need, and why, decided before anything is built.
 */
#ifndef NP_RENDER_PLAN_H
#define NP_RENDER_PLAN_H

#include "render/plan_stages.h"

/* Where a cloud comes from. */
typedef enum np_cloud_source {
  NP_CLOUD_SOURCE_FILE,  /* read */
  NP_CLOUD_SOURCE_BAKE,  /* baked; to its file where it has one, which is not there yet */
  NP_CLOUD_SOURCE_REBAKE, /* its file holds another cloud, and is baked anew */
  NP_CLOUD_SOURCE_GIVEN /* a volume that a call has added */
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
