/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/stage_rules.h"

#define BIT(stage) (1u << NP_STAGE_##stage)
#define PER(kind) (1u << NP_PER_##kind)

/* All stages that a world consists of, but for its lights. */
#define MATTER                                                                                                         \
  (BIT(TERRAIN) | BIT(VOLUMES) | BIT(EMISSION) | BIT(ATMOSPHERE) | BIT(CAMERA_SKY) | BIT(CLOUD_SKY) | BIT(WATER_SKY))

/* Functions by the names of the stages that they decide, describe, and whose work they count. */
#define DECIDE(what) .decide = np_stage_decide_##what
#define DESCRIBE(what) .describe = np_stage_describe_##what
#define COUNT(kind, what) .work = NEPH_WORK_##kind, .count = np_stage_count_##what
#define PART(kind, unit) .work = NEPH_WORK_##kind, .part_cost = NP_UNIT_##unit
#define EXPECT(what) .expect = np_stage_expect_##what

/* clang-format off */
static const np_stage_rule rules[NP_STAGE_COUNT] = {
  [NP_STAGE_COLOR] = {"colour", 0, .is_of_sky = true, DECIDE(color), .parts = PER(PICTURE)},
  [NP_STAGE_TERRAIN] = {"terrain", 0, DECIDE(terrain), DESCRIBE(terrain), COUNT(TERRAIN, terrain),
    .parts = PER(PICTURE), .reused_while = "its file or its parameters stay"},
  [NP_STAGE_MOON] = {"moon", 0, .is_of_sky = true, DECIDE(moon)},
  [NP_STAGE_LIGHTS] = {"lights", BIT(COLOR) | BIT(TERRAIN) | BIT(MOON), .is_of_sky = true, .is_of_probes = true,
    DECIDE(lights), .parts = PER(PICTURE) | PER(PACKET)},
  [NP_STAGE_VOLUMES] = {"volumes", BIT(COLOR) | BIT(TERRAIN), DECIDE(volumes), DESCRIBE(volumes),
    COUNT(BAKE, volumes), EXPECT(volumes), .parts = PER(CLOUD),
    .reused_while = "their files or their parameters stay"},
  [NP_STAGE_MOTION] = {"motion", BIT(VOLUMES), DECIDE(motion), .parts = PER(PICTURE)},
  [NP_STAGE_ATMOSPHERE] = {"atmosphere", BIT(COLOR) | BIT(TERRAIN) | BIT(LIGHTS), .is_of_sky = true,
    .is_of_probes = true, DECIDE(atmosphere), PART(SKY, AIR), EXPECT(atmosphere),
    .parts = PER(PACKET), .reused_while = "the air stays, within a tenth of atmosphere.tolerance"},
  [NP_STAGE_CAMERA_SKY] = {"camera sky", BIT(COLOR) | BIT(LIGHTS) | BIT(ATMOSPHERE), .is_of_sky = true,
    .is_of_probes = true, DECIDE(camera_sky), PART(SKY, CAMERA_SKY), .parts = PER(PACKET_LIGHT),
    .reused_while = "air, light and camera stay, within atmosphere.tolerance"},
  [NP_STAGE_COLOR_FIT] = {"colour matrix", BIT(COLOR) | BIT(LIGHTS) | BIT(ATMOSPHERE) | BIT(CAMERA_SKY),
    .is_of_sky = true, DECIDE(color_fit), .parts = PER(PICTURE)},
  [NP_STAGE_EMISSION] = {"emission", BIT(COLOR) | BIT(VOLUMES) | BIT(COLOR_FIT), DECIDE(emission), PART(BAKE, EMITTER),
    EXPECT(emission), .parts = PER(PACKET)},
  [NP_STAGE_CLOUD_SKY] = {"cloud sky", BIT(COLOR) | BIT(LIGHTS) | BIT(VOLUMES) | BIT(ATMOSPHERE), .is_of_sky = true,
    DECIDE(cloud_sky), PART(SKY, SKY), .parts = PER(PACKET_LIGHT),
    .reused_while = "air, light and the middle of the clouds stay, within atmosphere.tolerance"},
  [NP_STAGE_WATER_SKY] = {"water sky", BIT(COLOR) | BIT(LIGHTS) | BIT(ATMOSPHERE), .is_of_sky = true, DECIDE(water_sky),
    PART(SKY, SKY), .parts = PER(PACKET_LIGHT),
    .reused_while = "air, light and camera stay, within atmosphere.tolerance"},
  [NP_STAGE_AIRGLOW] = {"airglow", BIT(COLOR) | BIT(LIGHTS) | BIT(ATMOSPHERE), .is_of_sky = true, DECIDE(airglow),
    .parts = PER(PICTURE) | PER(PACKET)},
  [NP_STAGE_SUN_LIGHT] = {"sun light", 0, DECIDE(sun_light)},
  [NP_STAGE_SKY_LIGHT] = {"sky light", 0, DECIDE(sky_light)},
  [NP_STAGE_GROUND_LIGHT] = {"ground light", 0, DECIDE(ground_light)},
  [NP_STAGE_WORLD] = {"world", MATTER | BIT(COLOR) | BIT(LIGHTS) | BIT(COLOR_FIT) | BIT(AIRGLOW), .is_of_sky = true,
    DECIDE(world), .parts = PER(PACKET) | PER(PACKET_LIGHT)},
  [NP_STAGE_SKY_GUIDE] = {"sky guide", BIT(VOLUMES) | BIT(CLOUD_SKY) | BIT(WORLD), DECIDE(sky_guide),
    .parts = PER(PACKET_LIGHT)},
  [NP_STAGE_SUN_OPTICAL_DEPTH] = {"sun optical depth", BIT(WORLD), DECIDE(sun_optical_depth),
    COUNT(MARCH, sun_optical_depth), EXPECT(sun_optical_depth), .parts = PER(LIGHT),
    .reused_while = "the clouds' extinction and the direction of the light stay, to the bit"},
  [NP_STAGE_ORDINATES] = {"multiple scattering", BIT(VOLUMES) | BIT(WORLD) | BIT(SUN_OPTICAL_DEPTH), DECIDE(ordinates),
    COUNT(SOLVE, ordinates), EXPECT(ordinates), .parts = PER(PACKET_LIGHT),
    .reused_while = "the clouds stay, to the bit, and the light on them, within a thousandth"},
  [NP_STAGE_VIEWER_LIGHT] = {"light to camera", BIT(ORDINATES), DECIDE(viewer_light), COUNT(SOLVE, viewer_light),
    .parts = PER(PACKET_LIGHT), .reused_while = "it is a part of the same picture"},
  [NP_STAGE_GROUND_CLOUDS] = {"clouds on ground", BIT(VOLUMES) | BIT(WORLD) | BIT(SUN_OPTICAL_DEPTH) | BIT(ORDINATES),
    DECIDE(ground_clouds), COUNT(SOLVE, ground_clouds), .parts = PER(PACKET_LIGHT),
    .reused_while = "the solution, the clouds and the scene's keys but those of camera and output are the same"},
  [NP_STAGE_RELIEF_LIGHT] = {"relief light",
    BIT(TERRAIN) | BIT(CAMERA_SKY) | BIT(CLOUD_SKY) | BIT(WORLD) | BIT(SUN_OPTICAL_DEPTH) | BIT(GROUND_CLOUDS),
    DECIDE(relief_light), COUNT(MARCH, relief_light), .parts = PER(PACKET_LIGHT)},
  [NP_STAGE_AIR_SHADOWS] = {"air shadows",
    BIT(TERRAIN) | BIT(VOLUMES) | BIT(CAMERA_SKY) | BIT(WORLD) | BIT(SUN_OPTICAL_DEPTH) | BIT(GROUND_CLOUDS),
    DECIDE(air_shadows), COUNT(MARCH, air_shadows), .parts = PER(LIGHT) | PER(PACKET_LIGHT)},
  [NP_STAGE_APPROXIMATION] = {"approximation", BIT(COLOR) | BIT(VOLUMES), DECIDE(approximation), .parts = PER(PACKET)},
  [NP_STAGE_STARS] = {"stars", BIT(COLOR) | BIT(WORLD), .is_of_sky = true, DECIDE(stars),
    .parts = PER(PICTURE) | PER(PACKET)},
  [NP_STAGE_LIGHTING] = {"lighting",
    BIT(WATER_SKY) | BIT(WORLD) | BIT(SKY_GUIDE) | BIT(SUN_OPTICAL_DEPTH) | BIT(ORDINATES) | BIT(VIEWER_LIGHT) |
    BIT(GROUND_CLOUDS) | BIT(RELIEF_LIGHT) | BIT(AIR_SHADOWS) | BIT(APPROXIMATION),
    DECIDE(lighting), .parts = PER(PACKET_LIGHT)},
  [NP_STAGE_HISTORY] = {"history", 0, DECIDE(history), COUNT(MARCH, history)},
  [NP_STAGE_INTEGRATOR] = {"integrator",
    BIT(COLOR) | BIT(LIGHTS) | BIT(COLOR_FIT) | BIT(SUN_LIGHT) | BIT(SKY_LIGHT) | BIT(MOON) | BIT(WORLD) |
    BIT(APPROXIMATION) | BIT(STARS) | BIT(LIGHTING) | BIT(MOTION) | BIT(HISTORY),
    DECIDE(integrator), COUNT(MARCH, integrator), EXPECT(integrator)},
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
