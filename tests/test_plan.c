/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "plan/plan.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "plan/stage_rules.h"
#include "scene/scene_eval.h"
#include "transport/scattering_field.h"

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

static neph_scene *load(test_fixture *f, const char *text) {
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, text, "scene.yaml", &scene), NEPH_OK);
  return scene;
}

/* `needed` has a letter for each stage in the order of np_stage: 'x' needed, '-' not. */
static void assert_plan(test_fixture *f, const char *text, const char *needed) {
  neph_scene *scene = load(f, text);
  np_plan plan;
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_int_equal(strlen(needed), NP_STAGE_COUNT);
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    const np_stage_decision *stage = &plan.decisions.stages[i];
    if (stage->is_needed != (needed[i] == 'x')) {
      fail_msg("%s: %s is %sneeded: %s", text, np_stage_get_rule((np_stage)i)->name, stage->is_needed ? "" : "not ",
               stage->reason);
    }
    assert_true(strlen(stage->reason) > 0);
  }
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

#define CLOUD "clouds: [{vdb: a.vdb, optical_depth: 40}]\n"

/* colour terrain moon lights volumes motion atmosphere camera-sky colour-matrix emission cloud-sky water-sky airglow
 * sun sky ground world sky-guide sun-depth multiple viewer clouds-on-ground relief-light air-shadows approximation
 * stars lighting history integrator */
static void test_only_what_is_needed_runs(void **state) {
  assert_plan(*state, "version: 1", "x--x--xxx----xx-x---------x-x");
  assert_plan(*state, "water: {}", "x--x--xxx--x-xx-x---------x-x");
  assert_plan(*state, CLOUD, "x--xx-xxx-x--xxxx--xxx-x--x-x");
  assert_plan(*state, CLOUD "terrain: {ridges: {}}", "xx-xx-xxx-x--xxxx--xxxxx--x-x");
  assert_plan(*state, "terrain: {ridges: {}}", "xx-x--xxx----xx-x-----xx--x-x");
  assert_plan(*state, CLOUD "atmosphere: none", "x--xx---x----x-xx--xxx----x-x");
  assert_plan(*state, CLOUD "environment: {planet: none}", "x--xx---x----x--x--xx-----x-x");
  assert_plan(*state, CLOUD "environment: {planet: none, radiance: 1}\nsun: {irradiance: 0}",
              "x--xx---x-----x-x--xx-----x-x");
  assert_plan(*state, CLOUD "sun: {irradiance: 0}\nenvironment: {radiance: 1}", "x--xx-x-x-----xxx--xxx----x-x");
  assert_plan(*state, CLOUD "render: {integrator: path}", "x--xx-x-x----xxxx---------x-x");
  assert_plan(*state, CLOUD "sun: {elevation: -4 deg}\nrender: {integrator: path}", "x--xx-x-x-x--xxxxx--------x-x");
  assert_plan(*state, CLOUD "render: {integrator: path, atmosphere: tables}", "x--xx-xxx-x--xxxxx-----x--x-x");
  assert_plan(*state, CLOUD "render: {integrator: path, path_guiding: adjoint}", "x--xx-x-x-x--xxxxx-x------x-x");
  assert_plan(*state, CLOUD "render: {multiple_scattering: none}", "x--xx-xxx-x--xxxx------x--x-x");
  assert_plan(*state, CLOUD "render: {multiple_scattering: octaves}", "x--xx-xxx-x--xxxx------xx-x-x");
  assert_plan(*state, CLOUD "render: {multiple_scattering: powder}", "x--xx-xxx-x--xxxx------xx-x-x");
  assert_plan(*state, CLOUD "render: {max_scatterings: 1}", "x--xx-xxx-x--xxxx------x--x-x");
}

#define MOVE "animate: {camera.position.0: [[1, 0 m], [9, 1 km]]}\n"
#define REPROJECT "render: {history: reproject, history_frames: 8}\n"

static void assert_history(test_fixture *f, const char *text, int frame, bool is_needed, const char *reason) {
  neph_scene *scene = load(f, text);
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  np_plan plan;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.frame = frame;
  neph_scene at;
  assert_int_equal(np_plan_make_frame(scene, &desc, &at, &plan), NEPH_OK);
  const np_stage_decision *stage = &plan.decisions.stages[NP_STAGE_HISTORY];
  if (stage->is_needed != is_needed || !strstr(stage->reason, reason))
    fail_msg("%s: %s: %s", text, stage->is_needed ? "yes" : "no", stage->reason);
  assert_int_equal(plan.forecast.stages[NP_STAGE_HISTORY].cost.bytes > 0.0, is_needed);
  np_plan_clear(&plan);
  np_scene_eval_clear(&at);
  neph_scene_destroy(scene);
}

/* One frame has no history; of a sequence every one has, and those of a block lead up to it. */
static void test_history_is_that_of_a_sequence(void **state) {
  assert_history(*state, CLOUD REPROJECT, 1, false, "one frame");
  assert_history(*state, CLOUD MOVE, 1, false, "render.history is none");
  assert_history(*state, CLOUD MOVE REPROJECT, 1, true, "frame 1 begins a block of 8");
  assert_history(*state, CLOUD MOVE REPROJECT, 9, true, "frame 9 begins a block of 8");
  assert_history(*state, CLOUD MOVE REPROJECT, 0, true,
                 "those of frame -1; a process without it renders from frame -7");
  assert_history(*state, CLOUD MOVE REPROJECT, 5, true, "1 pixel in 16 is rendered, the others are those of frame 4");
}

/* Rays of a block's frames in the mean, and memory for the picture and the one before it. */
static void test_fewer_pixels_are_predicted_to_cost_less(void **state) {
  static const struct {
    const char *scene;
    double rays, bytes; /* counts for a picture of 120 x 68 pixels and 4 samples */
  } rows[] = {
      {CLOUD MOVE, 32640.0, 163200.0},
      {CLOUD "render: {upsample: 2}\n", 8160.0, 163200.0},
      {CLOUD "render: {upsample: 4}\n", 2040.0, 163200.0},
      {CLOUD MOVE REPROJECT, 32640.0 * (1.0 + 7.0 / 16.0) / 8.0, 163200.0},
      {CLOUD MOVE "render: {history: reproject, history_frames: 8, upsample: 2}\n", 8160.0 * (1.0 + 7.0 / 16.0) / 8.0,
       163200.0},
  };
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    char text[512];
    snprintf(text, sizeof text, "camera: {resolution: [120, 68]}\n%s", rows[i].scene);
    neph_scene *scene = load(*state, text);
    np_plan plan;
    assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
    assert_float_equal((double)plan.request.ray_count, rows[i].rays, 1.0); /* a whole number of them */
    assert_float_equal((double)plan.request.film_bytes, rows[i].bytes, 0.0);
    assert_int_equal(plan.forecast.stages[NP_STAGE_INTEGRATOR].cost.bytes > rows[i].bytes, i > 0);
    np_plan_clear(&plan);
    neph_scene_destroy(scene);
  }
}

/* Nothing of it where nothing may move; for vectors in any case. */
static void test_motion_where_something_moves(void **state) {
  static const char still[] = "clouds: [{bake: {}}]\n", blur[] = "camera: {motion_blur: {shutter: 0.5}}\n";
  const struct {
    const char *cloud, *keys, *more;
    bool is_needed;
  } rows[] = {{CLOUD, "", "", false},
              {CLOUD, blur, "", true},
              {"clouds: [{vdb: a.vdb, extinction: 1, velocity: none}]\n", blur, "", false},
              {still, blur, "", false},
              {still, "", "output: {aovs: [motion]}\n", true},
              {"clouds: [{bake: {wind: [5, 0], frame_time: 1 s}}]\n", blur, "", true},
              {still, blur, "animate: {camera.fov: [[1, 40 deg], [2, 50 deg]]}\n", true},
              {still, blur, "animate:\n  clouds[0].rotation: [[1, 40 deg], [2, 50 deg]]\n", true},
              {still, blur, "animate: {sun.elevation: [[1, 40 deg], [2, 50 deg]]}\n", false}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    char text[512];
    np_plan plan;
    (void)snprintf(text, sizeof text, "%s%s%s", rows[i].cloud, rows[i].keys, rows[i].more);
    neph_scene *scene = load(*state, text);
    assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
    assert_int_equal(np_plan_needs(&plan, NP_STAGE_MOTION), rows[i].is_needed);
    np_plan_clear(&plan);
    neph_scene_destroy(scene);
  }
}

static void assert_air_light(test_fixture *f, const char *text, bool has_light) {
  neph_scene *scene = load(f, text);
  np_plan plan;
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_true(plan.decisions.stages[NP_STAGE_ATMOSPHERE].is_needed);
  assert_int_equal(np_plan_has_air_light(&plan), has_light);
  assert_int_equal(strstr(plan.decisions.stages[NP_STAGE_ATMOSPHERE].reason, "left out") == NULL, has_light);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

/* A traced atmosphere needs no tables, except for path guiding under any light, and for the brightest direction at
 * dusk. */
static void test_light_in_the_air_is_known_to_who_asks(void **state) {
  assert_air_light(*state, CLOUD, true);
  assert_air_light(*state, CLOUD "render: {integrator: path}", false);
  assert_air_light(*state, CLOUD "render: {integrator: path, atmosphere: tables}", true);
  assert_air_light(*state, CLOUD "render: {integrator: path, path_guiding: adjoint}", true);
  assert_air_light(*state, CLOUD "sun: {irradiance: 0}\nairglow: {}\nrender: {integrator: path, path_guiding: adjoint}",
                   true);
  assert_air_light(*state, "render: {integrator: path, path_guiding: adjoint}", false);
  assert_air_light(*state, CLOUD "sun: {elevation: -4 deg}\nrender: {integrator: path}", true);
}

static void test_no_light_where_none_is_wanted(void **state) {
  assert_plan(*state, CLOUD "terrain: {ridges: {}}\noutput: {beauty: false, aovs: [depth, transmittance, distance]}",
              "xx-xx-----------x---------x-x");
  assert_plan(*state, CLOUD "output: {beauty: false, aovs: [depth, sun]}", "x--xx-xxx-x--xxxx--xxx-x--x-x");
}

static void test_no_light_where_nothing_shines(void **state) {
  assert_plan(*state, CLOUD "sun: {irradiance: 0}", "x--xx-----------x---------x-x");
}

static void assert_sky_alone(test_fixture *f, const char *text) {
  neph_scene *scene = load(f, text);
  np_plan plan;
  assert_int_equal(np_plan_make_sky(scene, &(np_sky_request){.is_of_bands = false}, &plan), NEPH_OK);
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    assert_int_equal(plan.decisions.stages[i].is_needed, i == NP_STAGE_COLOR || i == NP_STAGE_LIGHTS ||
                                                             i == NP_STAGE_ATMOSPHERE || i == NP_STAGE_CAMERA_SKY ||
                                                             i == NP_STAGE_COLOR_FIT || i == NP_STAGE_WORLD);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

/* Whatever the scene's pictures are of. */
static void test_sky_alone(void **state) {
  assert_sky_alone(*state, CLOUD "terrain: {ridges: {}}\noutput: {beauty: false}");
  assert_sky_alone(*state, CLOUD "render: {integrator: path}");
}

#define BAKE "clouds: [{bake: {extent: 4 km, thickness: 1 km, voxel: 20 m}}]\n"
#define MOVING "clouds: [{bake: {frame_time: 1 s, extent: 4 km, thickness: 1 km, voxel: 20 m}}]\n"
#define SMALL "camera: {resolution: [120, 68]}\n"

static void assert_sun_volume(test_fixture *f, const char *text, bool is_needed, const char *reason) {
  neph_scene *scene = load(f, text);
  np_plan plan;
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_int_equal(plan.decisions.stages[NP_STAGE_SUN_OPTICAL_DEPTH].is_needed, is_needed);
  assert_non_null(strstr(plan.decisions.stages[NP_STAGE_SUN_OPTICAL_DEPTH].reason, reason));
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

/* Two million voxels in the box: too many for a thumbnail, few for a picture, or for a sequence of small ones. */
static void test_sun_volume_is_filled_where_it_pays(void **state) {
  assert_sun_volume(*state, BAKE "camera: {resolution: [960, 540]}", true, "filling it takes");
  assert_sun_volume(*state, BAKE "camera: {resolution: [20, 10]}\nrender: {samples: 1}", false, "filling it takes");
  assert_sun_volume(*state, BAKE SMALL, false, "filling it takes");
  assert_sun_volume(*state, BAKE SMALL "output: {image: a.##.exr}", true, "once for a sequence of frames");
  assert_sun_volume(*state, MOVING SMALL "output: {image: a.##.exr}", false, "s of one core and spares");
  assert_sun_volume(*state, BAKE "render: {sun_optical_depth: march}", false, "render.sun_optical_depth is march");
  assert_sun_volume(*state, BAKE "camera: {resolution: [20, 10]}\nrender: {samples: 1, sun_optical_depth: volume}",
                    true, "render.sun_optical_depth is volume");
  assert_sun_volume(*state, BAKE "sun: {angular_radius: 2 deg}", false, "its disk is marched for");
  assert_sun_volume(*state, BAKE "camera: {resolution: [960, 540]}\nrender: {integrator: path}", true,
                    "filling it takes");
  assert_sun_volume(*state, BAKE "camera: {resolution: [4, 4]}\nrender: {integrator: path}", false, "filling it takes");
  assert_sun_volume(*state, "version: 1", false, "no clouds");
}

static void assert_air_shadows(test_fixture *f, const char *text, bool are_needed, const char *reason) {
  neph_scene *scene = load(f, text);
  np_plan plan;
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  const np_stage_decision *stage = &plan.decisions.stages[NP_STAGE_AIR_SHADOWS];
  if (stage->is_needed != are_needed || !strstr(stage->reason, reason))
    fail_msg("%s: %s: %s", text, stage->is_needed ? "yes" : "no", stage->reason);
  assert_int_equal(plan.decisions.air_ray_spacing > 0.0, are_needed);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

/* A field of kilometres yes, a puff of 80 m no; hills while the sun throws their shadows far enough. */
static void test_shadows_in_the_air_are_cast_where_they_may_be_seen(void **state) {
  static const char puff[] = "clouds: [{bake: {extent: 80 m, thickness: 40 m, voxel: 5 m}}]";
  assert_air_shadows(*state, BAKE, true, "clouds may shade air that scatters up to");
  assert_air_shadows(*state, puff, false, "clouds may shade air that scatters up to");
  assert_air_shadows(*state, CLOUD, true, "clouds may shade air");
  assert_air_shadows(*state, "terrain: {ridges: {relief: 800 m}}\nsun: {elevation: 5 deg}", true,
                     "hills may shade air");
  assert_air_shadows(*state, "terrain: {ridges: {relief: 200 m}}\nsun: {elevation: 60 deg}", false, "hills may shade");
  assert_air_shadows(*state, BAKE "sun: {elevation: -5 deg}", false, "5.0 deg below the horizon the sun shines over");
  assert_air_shadows(*state, "version: 1", false, "there are neither clouds nor hills");
  assert_air_shadows(*state, BAKE "atmosphere: none", false, "atmosphere.preset is none");
  assert_air_shadows(*state, BAKE "render: {integrator: path}", false, "render.atmosphere is traced");
  assert_air_shadows(*state, BAKE "render: {air_shadows: false}", false, "render.air_shadows is false");
  assert_air_shadows(*state, BAKE "sun: {elevation: -5 deg}\nrender: {air_shadows: true}", true,
                     "render.air_shadows is true");
}

static void assert_air_spacing(test_fixture *f, const char *text, double pixels) {
  neph_scene *scene = load(f, text);
  np_plan plan;
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_true(plan.decisions.air_ray_spacing == pixels);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

/* A quarter of a degree of the default 50 deg in 960 pixels; two pixels of a small picture, of hills a 64th of it. */
static void test_rays_for_shadows_are_a_quarter_of_a_degree_apart(void **state) {
  static const char hills[] = BAKE "terrain: {ridges: {samples: 129}}\ncamera: {resolution: [16, 9]}\n";
  assert_air_spacing(*state, BAKE, 4.0);
  assert_air_spacing(*state, BAKE "camera: {resolution: [96, 54]}\n", 2.0);
  assert_air_spacing(*state, hills, 0.25);
}

static void assert_light_errors(test_fixture *f, const char *text, const char *reason) {
  neph_scene *scene = load(f, text);
  np_plan plan;
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  const char *found = plan.decisions.stages[NP_STAGE_ORDINATES].reason;
  if (!strstr(found, reason)) fail_msg("%s: %s", text, found);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

/* All cells are alike with memory enough; of 2 GB most go to what is near, and the far ones grow. */
static void test_errors_of_light_are_foretold_near_and_far(void **state) {
#define FIELD "clouds: [{bake: {extent: 16 km, thickness: 2 km, voxel: 15 m}}]\n"
  assert_light_errors(*state, FIELD "render: {light_memory: 100 GB}",
                      "expected error 2 % near the camera, 2 % in the largest cells");
  assert_light_errors(*state, FIELD "render: {light_memory: 2 GB}", "expected error 2 % near the camera, 9 % in");
  assert_light_errors(*state, CLOUD, "expected error 2 to 4 %, more where that is little");
}

/* Cells are the whole picture's, so that its crops match; the tracer, which needs less of them, has no fine ones. */
static void test_crops_have_the_cells_of_the_whole(void **state) {
  neph_scene *scene = load(*state, CLOUD "camera: {resolution: [1000, 500]}\nrender: {samples: 2}\n");
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  np_plan plan;
  np_scattering_desc cells;
  desc.crop_max[0] = 10;
  assert_int_equal(np_plan_make(scene, &desc, &plan), NEPH_OK);
  const np_dvec3 around_low = {-1e6, -1e6, -1e6}, around_high = {1e6, 1e6, 1e6};
  np_plan_choose_cells(&plan, scene, around_low, around_high, &cells);
  assert_int_equal(cells.cells.cell_count_fine, 1500000);
  desc.integrator = NEPH_INTEGRATOR_PATH;
  np_plan_clear(&plan);
  assert_int_equal(np_plan_make(scene, &desc, &plan), NEPH_OK);
  np_plan_choose_cells(&plan, scene, around_low, around_high, &cells);
  assert_int_equal(cells.cells.cell_count_fine, 0);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

/* A cube a tenth of the distance wide, straight ahead in a picture of 90°, has its near face in 0.0526² of it; of all
 * kinds of camera one that looks away sees none, and one inside sees it everywhere. The lattice adds a square at most.
 */
static void test_rays_to_a_box_are_counted(void **state) {
  static const char *const kinds[] = {"fov: 90 deg", "kind: orthographic, orthographic_width: 1000 m", "kind: fisheye",
                                      "kind: equirectangular"};
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
    char text[200];
    snprintf(text, sizeof text, "camera: {position: [0, -1 km, 0], look_at: [0, 0, 0], resolution: [400, 400], %s}",
             kinds[i]);
    neph_scene *scene = load(*state, text);
    np_request request = {.context = scene->context, .desc = NEPH_RENDER_DESC_DEFAULT};
    request.desc.width = request.desc.height = 400;
    const double all = 160000.0 * request.desc.sample_count, square = all / 4096.0;
    const np_dvec3 low = {-50, -50, -50}, high = {50, 50, 50}, behind = {-50, -1900, -50}, near = {50, -1800, 50};
    const double seen = np_plan_count_rays_to(&request, scene, low, high);
    assert_true(seen > 0.0 && seen < 0.1 * all);
    if (i == 0) assert_near(sqrt(seen / all), 100.0 / 1900.0, 2.0 / 64.0);
    if (i < 3) assert_near(np_plan_count_rays_to(&request, scene, behind, near), square, 1e-6 * all);
    const np_dvec3 around_low = {-1e4, -1e4, -1e4}, around_high = {1e4, 1e4, 1e4};
    if (i != 2) assert_near(np_plan_count_rays_to(&request, scene, around_low, around_high), all, 1e-6 * all);
    neph_scene_destroy(scene);
  }
}

/* Light scattered more than once is solved for, but only to split paths: the ground takes no light from it. */
static void test_paths_are_split_by_the_solution(void **state) {
  neph_scene *scene = load(*state, BAKE "render: {integrator: path, path_guiding: adjoint}");
  np_plan plan;
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_true(plan.decisions.stages[NP_STAGE_ORDINATES].is_needed);
  assert_non_null(strstr(plan.decisions.stages[NP_STAGE_ORDINATES].reason, "paths are guided by it; solved for once"));
  assert_false(plan.decisions.stages[NP_STAGE_GROUND_CLOUDS].is_needed);
  assert_int_equal(neph_scene_set(scene, "render.path_guiding", "none"), NEPH_OK);
  np_plan_clear(&plan);
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_false(plan.decisions.stages[NP_STAGE_ORDINATES].is_needed);
  assert_string_equal(plan.decisions.stages[NP_STAGE_ORDINATES].reason, "paths scatter as often as it takes");
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

static void test_work_is_counted(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, "camera: {resolution: [100, 50]}\noutput: {aovs: [sun, distance]}\n"
                              "clouds: [{bake: {extent: 1 km, thickness: 100 m, voxel: 10 m}}]");
  np_plan plan;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.crop_min[0] = 90;
  desc.sample_count = 3;
  assert_int_equal(np_plan_make(scene, &desc, &plan), NEPH_OK);
  assert_int_equal(plan.request.ray_count, 10 * 50 * 3);
  assert_int_equal(plan.request.film_bytes, 10 * 50 * 4 * (5 + 3 + 1)); /* R G B A Z, sun, distance */
  assert_near(plan.inputs.voxels.baked_box, 100 * 100 * 10, 1e-6);      /* a quotient of doubles */
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

static void assert_refused(test_fixture *f, const neph_scene *scene, const neph_render_desc *desc, const char *word) {
  np_plan plan;
  assert_int_equal(np_plan_make(scene, desc, &plan), NEPH_ERROR_INVALID_ARGUMENT);
  np_plan_clear(&plan);
  assert_one_error(&f->log, word);
}

static void test_bad_descriptions_are_refused(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, "version: 1");
  neph_render_desc good = NEPH_RENDER_DESC_DEFAULT, desc;
  assert_int_equal(neph_scene_get_render_desc(scene, &good), NEPH_OK);
  desc = good, desc.width = 0, assert_refused(f, scene, &desc, "0 x 540 pixels");
  desc = good, desc.height = 65537, assert_refused(f, scene, &desc, "960 x 65537");
  desc = good, desc.crop_min[0] = 960, assert_refused(f, scene, &desc, "crop is 960,0 to 960,540");
  desc = good, desc.crop_max[1] = 541, assert_refused(f, scene, &desc, "within 960 x 540");
  desc = good, desc.sample_count = 0, assert_refused(f, scene, &desc, "samples is 0");
  desc = good, desc.integrator = (neph_integrator)7, assert_refused(f, scene, &desc, "integrator is 7");
  desc = good, desc.atmosphere = (neph_render_atmosphere)2, assert_refused(f, scene, &desc, "atmosphere is 2, must be");
  desc = good, desc.path_guiding = (neph_path_guiding)2;
  assert_refused(f, scene, &desc, "path_guiding is 2, must be none");
  desc = good, desc.struct_size = 4, assert_refused(f, scene, &desc, "struct_size is 4");
  neph_scene_destroy(scene);
}

static void test_incomplete_scenes_are_refused(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  np_plan plan;
  assert_int_equal(neph_scene_create(f->context, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "clouds[0].name", "a"), NEPH_OK);
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "clouds[0] has no source", "must have vdb");
  assert_int_equal(neph_scene_set(scene, "clouds[0].vdb", "a.vdb"), NEPH_OK);
  np_plan_clear(&plan);
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

static void test_plan_is_described(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, "clouds: [{name: hero, vdb: \"a.####.vdb\", optical_depth: 4}, {name: low, bake: {}}]");
  np_plan plan;
  char *plain, *json;
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_int_equal(np_plan_describe(scene, &plan, NULL, NEPH_TEXT_PLAIN, &plain), NEPH_OK);
  assert_int_equal(np_plan_describe(scene, &plan, NULL, NEPH_TEXT_JSON, &json), NEPH_OK);
  assert_non_null(strstr(plain, "hero is read from a.0001.vdb; low is baked"));
  assert_non_null(strstr(plain, "terrain              no   the scene has no terrain"));
  assert_non_null(strstr(json, "\"stage\": \"terrain\""));
  neph_text_destroy(f->context, plain);
  neph_text_destroy(f->context, json);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

static neph_result plan_and_describe(neph_context *context, void *user) {
  neph_scene *scene;
  np_plan plan = {.hash = ""};
  char *text = NULL;
  neph_result result = neph_scene_load_text(context, CLOUD, "scene.yaml", &scene);
  if (!result) result = np_plan_make(scene, NULL, &plan);
  if (!result) result = np_plan_describe(scene, &plan, NULL, *(neph_text_format *)user, &text);
  neph_text_destroy(context, text);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
  return result;
}

/* The frames of a job are weighed by it: those after the first take over its volumes and light, unless clouds move. */
static void test_next_frames_take_over_the_light(void **state) {
  const struct {
    const char *text;
    bool takes_over;
  } cases[] = {{BAKE, true}, {MOVING, false}, {"clouds: [{vdb: a.####.vdb, extinction: 1}]\n", false}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    neph_scene *scene = load(*state, cases[i].text);
    double first_s = 0.0, next_s = 0.0;
    assert_int_equal(neph_render_estimate_time(scene, NULL, &first_s, &next_s), NEPH_OK);
    assert_true(next_s > 0.0);
    if (cases[i].takes_over)
      assert_true(next_s < 0.9 * first_s);
    else
      assert_true(next_s == first_s);
    assert_int_equal(neph_render_estimate_time(scene, NULL, &next_s, NULL), NEPH_OK);
    assert_true(next_s == first_s);
    neph_scene_destroy(scene);
  }
}

static void test_failed_allocations(void **state) {
  (void)state;
  neph_text_format format = NEPH_TEXT_PLAIN;
  assert_survives_failed_allocations(plan_and_describe, &format);
  format = NEPH_TEXT_JSON;
  assert_survives_failed_allocations(plan_and_describe, &format);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_only_what_is_needed_runs, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_history_is_that_of_a_sequence, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_fewer_pixels_are_predicted_to_cost_less, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_motion_where_something_moves, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_light_in_the_air_is_known_to_who_asks, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_no_light_where_none_is_wanted, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_no_light_where_nothing_shines, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_sky_alone, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_sun_volume_is_filled_where_it_pays, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_shadows_in_the_air_are_cast_where_they_may_be_seen, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_rays_for_shadows_are_a_quarter_of_a_degree_apart, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_errors_of_light_are_foretold_near_and_far, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_crops_have_the_cells_of_the_whole, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_rays_to_a_box_are_counted, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_paths_are_split_by_the_solution, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_work_is_counted, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_bad_descriptions_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_incomplete_scenes_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_plan_is_described, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_next_frames_take_over_the_light, set_up, test_tear_down),
      cmocka_unit_test(test_failed_allocations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
