/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/stage_rules.h"

#include "plan/stage_needs.h"

#define BIT_OF(stage) | 1u << NP_STAGE_##stage
#define PER(kind) (1u << NP_PER_##kind)

/* Bits of the stages that a stage names in stage_needs.h. */
#define NEEDS(stage) .needs = 0 NP_NEEDS_##stage(BIT_OF)

/* Functions by the names of the stages that they decide, describe, and whose work they count. */
#define DECIDE(what) .decide = np_stage_decide_##what
#define DESCRIBE(what) .describe = np_stage_describe_##what
#define COUNT(kind, what) .work = NEPH_WORK_##kind, .count = np_stage_count_##what
#define PART(kind, unit) .work = NEPH_WORK_##kind, .part_cost = NP_UNIT_##unit
#define EXPECT(what) .expect = np_stage_expect_##what

/* clang-format off */
static const np_stage_rule rules[NP_STAGE_COUNT] = {
  [NP_STAGE_COLOR] = {"colour", NEEDS(COLOR), .is_of_sky = true, DECIDE(color), .parts = PER(PICTURE)},
  [NP_STAGE_TERRAIN] = {"terrain", NEEDS(TERRAIN), DECIDE(terrain), DESCRIBE(terrain), COUNT(TERRAIN, terrain),
    .parts = PER(PICTURE), .reused_while = "its file or its parameters stay"},
  [NP_STAGE_MOON] = {"moon", NEEDS(MOON), .is_of_sky = true, DECIDE(moon)},
  [NP_STAGE_LIGHTS] = {"lights", NEEDS(LIGHTS), .is_of_sky = true, .is_of_probes = true, DECIDE(lights),
    .parts = PER(PICTURE) | PER(PACKET)},
  [NP_STAGE_VOLUMES] = {"volumes", NEEDS(VOLUMES), DECIDE(volumes), DESCRIBE(volumes), COUNT(BAKE, volumes),
    EXPECT(volumes), .parts = PER(CLOUD), .reused_while = "their files or their parameters stay"},
  [NP_STAGE_MOTION] = {"motion", NEEDS(MOTION), DECIDE(motion), .parts = PER(PICTURE)},
  [NP_STAGE_ATMOSPHERE] = {"atmosphere", NEEDS(ATMOSPHERE), .is_of_sky = true, .is_of_probes = true,
    DECIDE(atmosphere), PART(SKY, AIR), EXPECT(atmosphere), .parts = PER(PACKET),
    .reused_while = "the air stays, within a tenth of atmosphere.tolerance"},
  [NP_STAGE_CAMERA_SKY] = {"camera sky", NEEDS(CAMERA_SKY), .is_of_sky = true, .is_of_probes = true,
    DECIDE(camera_sky), PART(SKY, CAMERA_SKY), .parts = PER(PACKET_LIGHT),
    .reused_while = "air, light and camera stay, within atmosphere.tolerance"},
  [NP_STAGE_COLOR_FIT] = {"colour matrix", NEEDS(COLOR_FIT), .is_of_sky = true, DECIDE(color_fit),
    .parts = PER(PICTURE)},
  [NP_STAGE_EMISSION] = {"emission", NEEDS(EMISSION), DECIDE(emission), PART(BAKE, EMITTER), EXPECT(emission),
    .parts = PER(PACKET)},
  [NP_STAGE_CLOUD_SKY] = {"cloud sky", NEEDS(CLOUD_SKY), .is_of_sky = true, DECIDE(cloud_sky), PART(SKY, SKY),
    .parts = PER(PACKET_LIGHT),
    .reused_while = "air, light and the middle of the clouds stay, within atmosphere.tolerance"},
  [NP_STAGE_WATER_SKY] = {"water sky", NEEDS(WATER_SKY), .is_of_sky = true, DECIDE(water_sky), PART(SKY, SKY),
    .parts = PER(PACKET_LIGHT), .reused_while = "air, light and camera stay, within atmosphere.tolerance"},
  [NP_STAGE_AIRGLOW] = {"airglow", NEEDS(AIRGLOW), .is_of_sky = true, DECIDE(airglow),
    .parts = PER(PICTURE) | PER(PACKET)},
  [NP_STAGE_SUN_LIGHT] = {"sun light", NEEDS(SUN_LIGHT), DECIDE(sun_light)},
  [NP_STAGE_SKY_LIGHT] = {"sky light", NEEDS(SKY_LIGHT), DECIDE(sky_light)},
  [NP_STAGE_GROUND_LIGHT] = {"ground light", NEEDS(GROUND_LIGHT), DECIDE(ground_light)},
  [NP_STAGE_WORLD] = {"world", NEEDS(WORLD), .is_of_sky = true, DECIDE(world),
    .parts = PER(PACKET) | PER(PACKET_LIGHT)},
  [NP_STAGE_SKY_GUIDE] = {"sky guide", NEEDS(SKY_GUIDE), DECIDE(sky_guide), .parts = PER(PACKET_LIGHT)},
  [NP_STAGE_SUN_OPTICAL_DEPTH] = {"sun optical depth", NEEDS(SUN_OPTICAL_DEPTH), DECIDE(sun_optical_depth),
    COUNT(MARCH, sun_optical_depth), EXPECT(sun_optical_depth), .parts = PER(LIGHT),
    .reused_while = "the clouds' extinction and the direction of the light stay, to the bit"},
  [NP_STAGE_ORDINATES] = {"multiple scattering", NEEDS(ORDINATES), DECIDE(ordinates), COUNT(SOLVE, ordinates),
    EXPECT(ordinates), .parts = PER(PACKET_LIGHT),
    .reused_while = "the clouds stay, to the bit, and the light on them, within a thousandth"},
  [NP_STAGE_VIEWER_LIGHT] = {"light to camera", NEEDS(VIEWER_LIGHT), DECIDE(viewer_light), COUNT(SOLVE, viewer_light),
    .parts = PER(PACKET_LIGHT), .reused_while = "it is a part of the same picture"},
  [NP_STAGE_GROUND_CLOUDS] = {"clouds on ground", NEEDS(GROUND_CLOUDS), DECIDE(ground_clouds),
    COUNT(SOLVE, ground_clouds), .parts = PER(PACKET_LIGHT),
    .reused_while = "the solution, the clouds and the scene's keys but those of camera and output are the same"},
  [NP_STAGE_RELIEF_LIGHT] = {"relief light", NEEDS(RELIEF_LIGHT), DECIDE(relief_light), COUNT(MARCH, relief_light),
    .parts = PER(PACKET_LIGHT),
    .reused_while = "the light on the ground and the scene's keys but those of camera and output are the same"},
  [NP_STAGE_AIR_SHADOWS] = {"air shadows", NEEDS(AIR_SHADOWS), DECIDE(air_shadows), COUNT(MARCH, air_shadows),
    .parts = PER(LIGHT) | PER(PACKET_LIGHT)},
  [NP_STAGE_APPROXIMATION] = {"approximation", NEEDS(APPROXIMATION), DECIDE(approximation), .parts = PER(PACKET)},
  [NP_STAGE_STARS] = {"stars", NEEDS(STARS), .is_of_sky = true, DECIDE(stars), .parts = PER(PICTURE) | PER(PACKET)},
  [NP_STAGE_LIGHTING] = {"lighting", NEEDS(LIGHTING), DECIDE(lighting), .parts = PER(PACKET_LIGHT)},
  [NP_STAGE_HISTORY] = {"history", NEEDS(HISTORY), DECIDE(history), COUNT(MARCH, history)},
  [NP_STAGE_INTEGRATOR] = {"integrator", NEEDS(INTEGRATOR), DECIDE(integrator), COUNT(MARCH, integrator),
    EXPECT(integrator)},
};
/* clang-format on */

const np_stage_rule *np_stage_get_rule(np_stage stage) { return &rules[stage]; }

np_part_counts np_part_counts_make(unsigned clouds, unsigned lights, unsigned packets) {
  return (np_part_counts){{1, clouds, lights, packets, packets * lights}};
}

unsigned np_stage_count_parts(const np_stage_rule *rule, const np_part_counts *counts) {
  unsigned count = 0;
  for (int kind = 0; kind < NP_PART_KINDS; kind++)
    if (np_stage_has_kind(rule, (np_part_kind)kind)) count += counts->of[kind];
  return count;
}
