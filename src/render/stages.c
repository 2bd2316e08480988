/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stages.h"

#include <stdio.h>

#define BIT(stage) (1u << NP_STAGE_##stage)

/* All that a world is made of, but for its lights. */
#define MATTER (BIT(TERRAIN) | BIT(VOLUMES) | BIT(EMISSION) | BIT(ATMOSPHERE) | BIT(CAMERA_SKY) | BIT(CLOUD_SKY))

/* Functions by the names of what they decide, predict, build and clear. */
#define DECIDE(what) .decide = np_stage_decide_##what
#define PREDICT(what) .predict = np_stage_predict_##what
#define ONCE(what) .build_once = np_stage_build_##what, .clear_once = np_stage_clear_##what
#define LIGHT(what) .build_light = np_stage_build_##what, .clear_light = np_stage_clear_##what
#define PACKET(what) .build_packet = np_stage_build_##what, .clear_packet = np_stage_clear_##what
#define PACKET_LIGHT(what) .build_packet_light = np_stage_build_##what, .clear_packet_light = np_stage_clear_##what

/* clang-format off */
static const np_stage_row rows[NP_STAGE_COUNT] = {
  [NP_STAGE_COLOR] = {"colour", 0, .is_of_sky = true, DECIDE(color), ONCE(packets)},
  [NP_STAGE_TERRAIN] = {"terrain", 0, DECIDE(terrain), .part_seconds = 0.8, ONCE(terrain),
    .reused_while = "its file or its parameters stay"},
  [NP_STAGE_MOON] = {"moon", 0, .is_of_sky = true, DECIDE(moon)},
  [NP_STAGE_LIGHTS] = {"lights", BIT(COLOR) | BIT(TERRAIN) | BIT(MOON), .is_of_sky = true, DECIDE(lights),
    ONCE(lights), PACKET(packet_lights)},
  [NP_STAGE_VOLUMES] = {"volumes", BIT(COLOR), DECIDE(volumes), PREDICT(volumes), ONCE(volumes),
    .reused_while = "their files or their parameters stay", .revise = np_stage_revise_volumes},
  [NP_STAGE_EMISSION] = {"emission", BIT(COLOR) | BIT(VOLUMES), DECIDE(emission), .part_seconds = 0.2,
    PACKET(emission)},
  [NP_STAGE_ATMOSPHERE] = {"atmosphere", BIT(COLOR), .is_of_sky = true, DECIDE(atmosphere), .part_seconds = 0.1,
    PACKET(atmosphere), .reused_while = "the air stays, within a tenth of atmosphere.tolerance"},
  [NP_STAGE_CAMERA_SKY] = {"camera sky", BIT(COLOR) | BIT(LIGHTS) | BIT(ATMOSPHERE), .is_of_sky = true,
    DECIDE(camera_sky), .part_seconds = 0.05, PACKET_LIGHT(camera_sky),
    .reused_while = "air, light and camera stay, within atmosphere.tolerance"},
  [NP_STAGE_CLOUD_SKY] = {"cloud sky", BIT(COLOR) | BIT(LIGHTS) | BIT(VOLUMES) | BIT(ATMOSPHERE), .is_of_sky = true,
    DECIDE(cloud_sky), .part_seconds = 0.05, PACKET_LIGHT(cloud_sky),
    .reused_while = "air, light and the middle of the clouds stay, within atmosphere.tolerance"},
  [NP_STAGE_AIRGLOW] = {"airglow", BIT(COLOR) | BIT(LIGHTS) | BIT(ATMOSPHERE), .is_of_sky = true, DECIDE(airglow),
    ONCE(star_map), PACKET(airglow)},
  [NP_STAGE_SUN_LIGHT] = {"sun light", 0, DECIDE(sun_light)},
  [NP_STAGE_SKY_LIGHT] = {"sky light", 0, DECIDE(sky_light)},
  [NP_STAGE_GROUND_LIGHT] = {"ground light", 0, DECIDE(ground_light)},
  [NP_STAGE_WORLD] = {"world", MATTER | BIT(COLOR) | BIT(LIGHTS) | BIT(AIRGLOW), .is_of_sky = true, DECIDE(world),
    PACKET_LIGHT(world)},
  [NP_STAGE_SKY_GUIDE] = {"sky guide", BIT(VOLUMES) | BIT(CLOUD_SKY) | BIT(WORLD), DECIDE(sky_guide),
    PACKET_LIGHT(sky_guide)},
  [NP_STAGE_SUN_OPTICAL_DEPTH] = {"sun optical depth", BIT(WORLD), DECIDE(sun_optical_depth),
    PREDICT(sun_optical_depth), LIGHT(sun_optical_depth),
    .reused_while = "the clouds' extinction and the direction of the light stay, to the bit"},
  [NP_STAGE_ORDINATES] = {"multiple scattering", BIT(VOLUMES) | BIT(WORLD) | BIT(SUN_OPTICAL_DEPTH), DECIDE(ordinates),
    PREDICT(ordinates), PACKET_LIGHT(ordinates),
    .reused_while = "the clouds stay, to the bit, and the light on them, within a thousandth"},
  [NP_STAGE_VIEWER_LIGHT] = {"light to camera", BIT(ORDINATES), DECIDE(viewer_light), PACKET_LIGHT(viewer_light)},
  [NP_STAGE_GROUND_CLOUDS] = {"clouds on ground", BIT(VOLUMES) | BIT(WORLD) | BIT(SUN_OPTICAL_DEPTH) | BIT(ORDINATES),
    DECIDE(ground_clouds), .part_seconds = 0.2, PACKET_LIGHT(ground_clouds)},
  [NP_STAGE_AIR_SHADOWS] = {"air shadows",
    BIT(TERRAIN) | BIT(VOLUMES) | BIT(CAMERA_SKY) | BIT(WORLD) | BIT(SUN_OPTICAL_DEPTH) | BIT(GROUND_CLOUDS),
    DECIDE(air_shadows), PREDICT(air_shadows), LIGHT(visibility), PACKET_LIGHT(air_shadow)},
  [NP_STAGE_APPROXIMATION] = {"approximation", 0, DECIDE(approximation)},
  [NP_STAGE_STARS] = {"stars", BIT(COLOR) | BIT(WORLD), .is_of_sky = true, DECIDE(stars), ONCE(catalogue),
    PACKET(stars)},
  [NP_STAGE_LIGHTING] = {"lighting",
    BIT(WORLD) | BIT(SKY_GUIDE) | BIT(SUN_OPTICAL_DEPTH) | BIT(ORDINATES) | BIT(VIEWER_LIGHT) | BIT(GROUND_CLOUDS) |
    BIT(AIR_SHADOWS), DECIDE(lighting), PACKET_LIGHT(lighting)},
  [NP_STAGE_INTEGRATOR] = {"integrator",
    BIT(COLOR) | BIT(LIGHTS) | BIT(SUN_LIGHT) | BIT(SKY_LIGHT) | BIT(MOON) | BIT(WORLD) | BIT(APPROXIMATION) |
    BIT(STARS) | BIT(LIGHTING), DECIDE(integrator), PREDICT(integrator)},
};
/* clang-format on */

const np_stage_row *np_stage_get_row(np_stage stage) { return &rows[stage]; }

static const np_plan_stage *get(np_decision *d, np_stage stage) {
  np_plan_stage *out = &d->plan->stages[stage];
  if (out->reason[0] || d->result) return out;
  if (!d->plan->is_sky_alone || rows[stage].is_of_sky)
    rows[stage].decide(d, out);
  else
    snprintf(out->reason, sizeof out->reason, "only the sky is wanted");
  return out;
}

neph_result np_stages_decide(np_plan *plan, const neph_scene *scene, const np_scene_facts *facts) {
  np_decision d = {.plan = plan, .scene = scene, .facts = facts, .get = get};
  for (int i = 0; i < NP_STAGE_COUNT && !d.result; i++) (void)get(&d, (np_stage)i);
  return d.result;
}

unsigned np_stage_count_parts(const np_stage_row *row, unsigned packets, unsigned lights) {
  return (row->build_once ? 1u : 0u) + (row->build_light ? lights : 0u) + (row->build_packet ? packets : 0u) +
         (row->build_packet_light ? packets * lights : 0u);
}

void np_stages_predict(np_plan *plan, const neph_scene *scene) {
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    if (!plan->stages[i].is_needed) continue;
    const unsigned parts = np_stage_count_parts(&rows[i], plan->packet_count, np_plan_count_lights(plan));
    plan->stages[i].cost = rows[i].predict ? rows[i].predict(plan, scene)
                                           : (np_stage_cost){.seconds = rows[i].part_seconds * parts};
  }
}

np_stage_cost np_stages_count_cost(const np_plan *plan) {
  np_stage_cost all = {.seconds = 0.0};
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    all.seconds += plan->stages[i].cost.seconds;
    all.bytes += plan->stages[i].cost.bytes;
  }
  return all;
}
