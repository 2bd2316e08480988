/* SPDX-License-Identifier: Apache-2.0 */
/* Warnings about the sun's place, once for each scene: a time without a zone, and a night that nothing lights. */
#ifndef NP_STAGES_LIGHT_WARNINGS_H
#define NP_STAGES_LIGHT_WARNINGS_H

#include "stages/assembly.h"

/* Logs the warnings of a picture that its scene has not logged yet. `lights` NULL: unknown, no warnings. */
neph_result np_light_warnings_log(const neph_scene *scene, const np_plan *plan, np_stores *stores,
                                  const np_scene_lights *lights, double longitude_rad);

/* Directions of the lights: the plan's, or, if the position comes from the terrain, those computed with it. NULL: the
 * picture has no lights. */
static inline const np_scene_lights *np_assembly_get_lights(const np_assembly *assembly, const np_plan *plan) {
  if (plan->decisions.are_lights_known) return &plan->decisions.lights;
  return np_plan_needs(plan, NP_STAGE_LIGHTS) ? &assembly->lights.places : NULL;
}

#endif
