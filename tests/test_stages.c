/* SPDX-License-Identifier: Apache-2.0 */
/* The stages: the form of their tables, that what a plan needs is built and nothing else, and that a stage reads no
 * other result than those which its row names. */
#include <string.h>

#include "core/hash.h"
#include "plan/plan.h"
#include "stages/assembly.h"
#include "stages/motion.h"
#include "stages/stage_makers.h"
#include "test_scenes.h"

/* ---- The table ---- */

static bool is_bit(uint32_t bits, int stage) { return bits >> stage & 1u; }

static void names_and_decisions_are_there_once(void **state) {
  (void)state;
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    const np_stage_rule *row = np_stage_get_rule((np_stage)i);
    assert_non_null(row->name);
    assert_non_null(row->decide);
    for (int k = 0; k < i; k++) {
      const np_stage_rule *other = np_stage_get_rule((np_stage)k);
      assert_string_not_equal(row->name, other->name);
      assert_ptr_not_equal(row->decide, other->decide);
    }
  }
}

/* So that the order of the rows is one of building. */
static void stages_need_earlier_ones(void **state) {
  (void)state;
  for (int i = 0; i < NP_STAGE_COUNT; i++) assert_int_equal(np_stage_get_rule((np_stage)i)->needs >> i, 0);
}

static bool has_parts(const np_stage_rule *rule) {
  const np_part_counts one = np_part_counts_make(1, 1, 1);
  return np_stage_count_parts(rule, &one) > 0;
}

static void assert_reuse_is_whole(const np_stage_reuse *reuse) {
  assert_true(reuse->get_key && reuse->adapt && reuse->exchange);
  assert_true(reuse->make && reuse->destroy);
}

/* Each part that a rule names has a maker, and no other has. */
static void makers_are_those_of_the_rules(void **state) {
  (void)state;
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    const np_stage_rule *rule = np_stage_get_rule((np_stage)i);
    const np_stage_maker *maker = np_stage_get_maker((np_stage)i);
    uint32_t made = maker->reuse ? 1u << maker->reuse->kind : 0;
    for (int kind = 0; kind < NP_PART_KINDS; kind++) {
      if (maker->build[kind]) made |= 1u << kind;
      assert_true(maker->build[kind] || !maker->clear[kind]);
    }
    assert_int_equal(made, rule->parts);
    assert_true(made || !maker->finish);
    assert_int_equal(maker->reuse != NULL, rule->reused_while != NULL);
    if (maker->reuse) assert_reuse_is_whole(maker->reuse);
  }
}

/* A sky alone is built without what is not of it. */
static void the_rows_of_a_sky_are_enough(void **state) {
  (void)state;
  const uint32_t matter = 1u << NP_STAGE_TERRAIN | 1u << NP_STAGE_VOLUMES | 1u << NP_STAGE_EMISSION;
  uint32_t of_sky = matter; /* none of which is no fault */
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (np_stage_get_rule((np_stage)i)->is_of_sky) of_sky |= 1u << i;
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (is_bit(of_sky, i)) assert_int_equal(np_stage_get_rule((np_stage)i)->needs & ~of_sky, 0);
}

/* ---- Building ---- */

#define CLOUD                                                                                                          \
  "clouds: [{name: a, extinction: 1 1/m, bake: {preset: cumulus_mediocris, model: hero, seed: 3,"                      \
  " extent: [600 m, 600 m], voxel: 60 m}}],"
#define CAMERA "camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 900 m], fov: 40 deg, resolution: [16, 8]},"
#define AIR "atmosphere: {preset: earth, tolerance: 0.1},"
#define NIGHT                                                                                                          \
  "place: {latitude: 45 deg, longitude: 0 deg}, sun: {elevation: -30 deg, azimuth: 100 deg},"                          \
  " moon: {elevation: 40 deg, azimuth: 100 deg}, stars: {sidereal_time: 30 deg}, airglow: {},"

static const char nothing[] = "{version: 1, atmosphere: none, environment: {planet: none}, sun: {irradiance: 0}}";
static const char day[] = "{" CAMERA AIR CLOUD "sun: {elevation: 30 deg, azimuth: 140 deg},"
                          " terrain: {ridges: {samples: 33, relief: 200 m}, width: 10 km}, water: {level: 50 m},"
                          " render: {samples: 1, sun_optical_depth: volume, air_shadows: true},"
                          " output: {aovs: [motion]}}";
static const char night[] = "{" CAMERA AIR CLOUD NIGHT " render: {integrator: path, samples: 1, splitting: adjoint}}";
static const char colours[] = "{" CAMERA AIR CLOUD "sun: {elevation: 30 deg, azimuth: 140 deg},"
                              " render: {samples: 1, wavelengths: 6, multiple_scattering: octaves, air_shadows: true,"
                              " sun_optical_depth: march}}";

/* A plan, and the stages of it that were built, from stores that hold nothing. */
typedef struct building {
  neph_scene *scene;
  np_plan plan;
  np_stores stores;
  np_assembly assembly;
} building;

static void build_planned(building *b, uint32_t stages) {
  np_monitor monitor;
  const np_build_job job = np_build_job_make(&b->stores);
  np_monitor_start(&monitor, b->scene->context, NULL, NULL);
  assert_int_equal(np_assembly_build_some(b->scene, &b->plan, stages, &job, &monitor, &b->assembly), NEPH_OK);
}

static void build(neph_context *context, const char *text, uint32_t stages, building *out) {
  *out = (building){.scene = NULL};
  assert_int_equal(neph_scene_load_text(context, text, "scene.yaml", &out->scene), NEPH_OK);
  assert_int_equal(np_plan_make(out->scene, NULL, &out->plan), NEPH_OK);
  build_planned(out, stages);
}

static void clear(building *b) {
  np_plan_clear(&b->plan);
  np_assembly_clear(&b->assembly);
  np_stores_clear(b->scene->context, &b->stores);
  neph_scene_destroy(b->scene);
}

static void assert_built(neph_context *context, const char *text, unsigned expected_count) {
  building b;
  build(context, text, UINT32_MAX, &b);
  unsigned count = 0;
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    const bool is_expected = np_plan_needs(&b.plan, (np_stage)i) && has_parts(np_stage_get_rule((np_stage)i));
    assert_int_equal(is_bit(b.assembly.built, i), is_expected);
    count += is_expected ? 1 : 0;
  }
  assert_int_equal(count, expected_count);
  const np_packet *packet = &b.assembly.packets[0];
  const np_packet_light *light = &packet->lights[0];
  assert_int_equal(!b.assembly.terrain, !np_plan_needs(&b.plan, NP_STAGE_TERRAIN));
  assert_int_equal(!b.assembly.clouds.volume_count, !np_plan_needs(&b.plan, NP_STAGE_VOLUMES));
  assert_int_equal(!packet->atmosphere, !np_plan_needs(&b.plan, NP_STAGE_ATMOSPHERE));
  assert_int_equal(!light->camera_sky, !np_plan_needs(&b.plan, NP_STAGE_CAMERA_SKY));
  assert_int_equal(!light->cloud_sky, !np_plan_needs(&b.plan, NP_STAGE_CLOUD_SKY));
  assert_int_equal(!b.assembly.caches[0].sun_optical_depth, !np_plan_needs(&b.plan, NP_STAGE_SUN_OPTICAL_DEPTH));
  assert_int_equal(!light->scattering, !np_plan_needs(&b.plan, NP_STAGE_ORDINATES));
  assert_int_equal(!light->viewer_light, !np_plan_needs(&b.plan, NP_STAGE_VIEWER_LIGHT));
  assert_int_equal(!light->cloud_light, !np_plan_needs(&b.plan, NP_STAGE_GROUND_CLOUDS));
  assert_int_equal(!light->relief_light, !np_plan_needs(&b.plan, NP_STAGE_RELIEF_LIGHT));
  assert_int_equal(!light->air_shadow.visible_fraction, !np_plan_needs(&b.plan, NP_STAGE_AIR_SHADOWS));
  assert_int_equal(!packet->gains, !np_plan_needs(&b.plan, NP_STAGE_APPROXIMATION));
  assert_int_equal(!packet->stars.count, !np_plan_needs(&b.plan, NP_STAGE_STARS));
  clear(&b);
}

/* Bands, places of lights, world and lighting are in every picture. */
static void what_is_needed_is_built_and_nothing_else(void **state) {
  fixture *f = *state;
  assert_built(f->context, nothing, 4);
  assert_built(f->context, "{version: 1}", 7);
  assert_built(f->context, day, 18);
  assert_built(f->context, night, 13);
  assert_built(f->context, colours, 10);
}

/* ---- Reading ---- */

static void add_spectrum(np_hash *hash, np_spectrum s) { np_hash_add(hash, &s, sizeof s); }

/* Parts of the first packet's first light; those that it lacks are left out. */
static void add_sky_result(np_hash *hash, const np_packet *p, const np_packet_light *l, np_stage stage) {
  const np_vec3 up = np_vec3_make(0.0f, 0.6f, 0.8f);
  const np_dvec3 origin = np_dvec3_make(0.0, -3000.0, 900.0);
  if (stage == NP_STAGE_ATMOSPHERE) add_spectrum(hash, np_atmosphere_transmittance_to_space(p->atmosphere, origin, up));
  if (stage == NP_STAGE_CAMERA_SKY) add_spectrum(hash, np_sky_radiance(l->camera_sky, up));
  if (stage == NP_STAGE_COLOR_FIT) np_hash_add(hash, p->color_weight, sizeof p->color_weight);
  if (stage == NP_STAGE_CLOUD_SKY) add_spectrum(hash, np_sky_radiance(l->cloud_sky, up));
  if (stage == NP_STAGE_AIRGLOW) add_spectrum(hash, p->night.ground_irradiance);
  if (stage == NP_STAGE_STARS) np_hash_add(hash, p->stars.pixels, p->stars.count * sizeof *p->stars.pixels);
  if (stage != NP_STAGE_WORLD) return;
  add_spectrum(hash, np_world_sunlight(&l->world, origin, l->world.to_sun));
  add_spectrum(hash, np_world_sky_radiance(&l->world, l->world.cloud_sky, origin, up));
  add_spectrum(hash, np_world_disk_radiance(&l->world, l->world.to_sun));
}

static void add_light_result(np_hash *hash, const np_packet_light *l, np_stage stage) {
  const np_ground_light *ground = np_cloud_light_get_ground(l->cloud_light);
  const np_lit_air *air = np_cloud_light_get_air(l->cloud_light);
  const np_vec3 ahead = np_vec3_make(0.0f, 1.0f, 0.0f);
  if (stage == NP_STAGE_SKY_GUIDE) np_hash_add(hash, &l->sky_guide, sizeof l->sky_guide);
  if (stage == NP_STAGE_ORDINATES) {
    const double residual = np_scattering_field_get_quality(l->scattering).residual;
    np_hash_add(hash, &residual, sizeof residual);
  }
  if (stage == NP_STAGE_VIEWER_LIGHT) np_hash_add(hash, l->viewer_light->outgoing, 8 * sizeof(float));
  if (stage == NP_STAGE_GROUND_CLOUDS)
    np_hash_add(hash, ground->points, (size_t)ground->size[0] * (size_t)ground->size[1] * sizeof *ground->points);
  if (stage == NP_STAGE_GROUND_CLOUDS && air)
    np_hash_add(hash, air->points, (size_t)air->size[0] * (size_t)air->size[1] * sizeof *air->points);
  if (stage == NP_STAGE_AIR_SHADOWS)
    add_spectrum(
        hash,
        np_air_shadow_get(&l->air_shadow, &(np_view_ray){.direction = ahead}, INFINITY, NP_RAY_END_NONE).lost_share);
  if (stage != NP_STAGE_LIGHTING) return;
  const bool answers[] = {l->lighting.scattering, l->lighting.viewer_light, l->lighting.ground_light,
                          l->lighting.air_shadow, l->lighting.sky_guide,    l->lighting.sun_optical_depths.cache};
  np_hash_add(hash, answers, sizeof answers);
}

static void fingerprint(const building *b, np_stage stage, char out_hex[33]) {
  const np_assembly *a = &b->assembly;
  const np_packet *packet = a->packets; /* NULL before they are built */
  np_hash *hash = np_hash_create(a->context);
  assert_non_null(hash);
  if (stage == NP_STAGE_LIGHTS) np_hash_add(hash, &a->lights.places, sizeof a->lights.places);
  if (stage == NP_STAGE_LIGHTS) add_spectrum(hash, packet->lights[0].beam.irradiance);
  if (stage == NP_STAGE_VOLUMES) np_hash_add(hash, &a->clouds.high, sizeof a->clouds.high);
  if (stage == NP_STAGE_MOTION) {
    np_hash_add(hash, &a->motion->next.origin, sizeof a->motion->next.origin);
    np_hash_add(hash, &a->motion->clouds->frame_to_part[0], sizeof *a->motion->clouds->frame_to_part);
  }
  if (stage == NP_STAGE_SUN_OPTICAL_DEPTH)
    np_hash_add(hash, a->caches[0].sun_optical_depth->level_cells, sizeof(uint64_t));
  if (packet) add_sky_result(hash, packet, &packet->lights[0], stage);
  if (packet) add_light_result(hash, &packet->lights[0], stage);
  assert_int_equal(np_hash_finish(hash, out_hex), NEPH_OK);
}

/* A stage and all that it needs, and what that needs. */
static uint32_t close_needs(np_stage stage) {
  uint32_t closed = 1u << stage;
  for (int i = (int)stage; i >= 0; i--)
    if (is_bit(closed, i)) closed |= np_stage_get_rule((np_stage)i)->needs;
  return closed;
}

static void assert_reads_what_it_names(neph_context *context, const char *text) {
  building whole, part;
  build(context, text, UINT32_MAX, &whole);
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    if (!is_bit(whole.assembly.built, i)) continue;
    char of_whole[33], of_part[33];
    build(context, text, close_needs((np_stage)i), &part);
    fingerprint(&whole, (np_stage)i, of_whole);
    fingerprint(&part, (np_stage)i, of_part);
    if (strcmp(of_whole, of_part) != 0) fail_msg("%s reads more than it names", np_stage_get_rule((np_stage)i)->name);
    clear(&part);
  }
  clear(&whole);
}

/* Without what it does not name, a stage makes the same. */
static void a_stage_reads_what_it_names(void **state) {
  fixture *f = *state;
  assert_reads_what_it_names(f->context, day);
  assert_reads_what_it_names(f->context, night);
}

/* ---- Reuse ---- */

/* Light towards the camera is kept for parts of one picture alone. */
static bool is_of_parts(int stage) { return stage == NP_STAGE_VIEWER_LIGHT; }

/* Each of those stages says once that it was kept, and once more in the bands that colours are fitted by; no other
 * does. */
static void what_rows_say_is_kept_is(void **state) {
  fixture *f = *state;
  building b;
  build(f->context, day, UINT32_MAX, &b);
  np_assembly_clear(&b.assembly);
  test_log_clear(&f->log);
  build_planned(&b, UINT32_MAX);
  unsigned kept = 0, expected = 0;
  for (const char *at = f->log.text; (at = strstr(at, ": reused")); at++) kept++;
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (np_plan_needs(&b.plan, (np_stage)i) && np_stage_get_rule((np_stage)i)->reused_while && !is_of_parts(i))
      expected += np_stage_get_rule((np_stage)i)->is_of_probes ? 2 : 1;
  assert_int_equal(expected, 12); /* terrain, volumes, airs, four skies, sun optical depth, multiple scattering, ground,
                                     hills */
  assert_int_equal(kept, expected);
  clear(&b);
}

/* ---- Costs ---- */

/* Nothing is predicted of what is not needed, and of the day's picture what takes longest: air, clouds and light. */
static void costs_are_those_of_what_is_needed(void **state) {
  fixture *f = *state;
  neph_scene *scene;
  np_plan plan;
  assert_int_equal(neph_scene_load_text(f->context, day, "scene.yaml", &scene), NEPH_OK);
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    const np_stage_cost *cost = &plan.forecast.stages[i].cost;
    assert_true(plan.decisions.stages[i].is_needed || (cost->seconds == 0.0 && cost->bytes == 0.0));
  }
  assert_true(plan.forecast.stages[NP_STAGE_VOLUMES].cost.seconds > 0.0 &&
              plan.forecast.stages[NP_STAGE_VOLUMES].cost.bytes > 0.0);
  assert_true(plan.forecast.stages[NP_STAGE_ORDINATES].cost.seconds > 0.0 &&
              plan.forecast.stages[NP_STAGE_ORDINATES].cost.bytes > 0.0);
  assert_true(plan.forecast.stages[NP_STAGE_INTEGRATOR].cost.bytes == (double)plan.request.film_bytes);
  const np_stage_cost all = np_forecast_sum(&plan.forecast);
  assert_true(all.bytes > plan.forecast.stages[NP_STAGE_ORDINATES].cost.bytes);
  np_schedule schedule;
  np_schedule_make(&plan, np_monitor_whole, &schedule);
  np_plan_clear(&plan);
  assert_near(schedule.all_s, 0.5 * all.seconds, 1e-9); /* sums of the same doubles, on two threads */
  neph_scene_destroy(scene);
}

static int set_up(void **state) { return set_up_scene_verbose(state, 2, nothing); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(names_and_decisions_are_there_once),
      cmocka_unit_test(stages_need_earlier_ones),
      cmocka_unit_test(makers_are_those_of_the_rules),
      cmocka_unit_test(the_rows_of_a_sky_are_enough),
      cmocka_unit_test_setup_teardown(what_is_needed_is_built_and_nothing_else, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_stage_reads_what_it_names, set_up, tear_down),
      cmocka_unit_test_setup_teardown(what_rows_say_is_kept_is, set_up, tear_down),
      cmocka_unit_test_setup_teardown(costs_are_those_of_what_is_needed, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
