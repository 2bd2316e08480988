/* SPDX-License-Identifier: Apache-2.0 */
/* One frame: camera rays through an assembled scene to the channels of an image. */
#ifndef NP_RENDER_FRAME_H
#define NP_RENDER_FRAME_H

#include "render/assembly.h"

/* Renders the crop of the plan into a new image with R, G, B, A, Z and the scene's AOVs. The same bits for any number
 * of threads and any division into crops. */
neph_result np_frame_render(const neph_scene *scene, const np_plan *plan, const np_assembly *assembly,
                            np_monitor *monitor, neph_image **out_image);

/* neph_render_image by a plan, under a monitor that was started: the plan's time limit counts from then. */
neph_result np_render_image(const neph_scene *scene, np_plan *plan, np_monitor *monitor, neph_image **out_image);

/* neph_render_explain with the results that earlier pictures and plans left in `stores`. */
neph_result np_render_explain(const neph_scene *scene, const neph_render_desc *desc, np_stores *stores,
                              neph_text_format format, char **out_text);

/* neph_scene_choose_effort, which leaves what it measures in `stores` for the picture. */
neph_result np_effort_choose(neph_scene *scene, const neph_render_desc *desc, np_stores *stores,
                             neph_effort *out_effort);

#endif
