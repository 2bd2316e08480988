/* SPDX-License-Identifier: Apache-2.0 */
/* A scene that needs a stage and one that does not, for each stage, with a word of each reason: a row of the stage
 * table without an example fails. */
#include <nephos/nephos.h>

#include <stdlib.h>

#include "plan/stage_rules.h"
#include "test_box_files.h"

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

#define EMPTY "version: 1\n"
#define CLOUD "clouds: [{bake: {extent: 400 m, thickness: 100 m, voxel: 20 m}}]\n"
#define PATH CLOUD "render: {integrator: path, atmosphere: tables}\n"
#define FIRE "clouds: [{vdb: box.vdb, extinction: 1, emission: {flame: none, temperature: none, offset: 2000 K}}]\n"
#define STARS "place: {latitude: 1, longitude: 2}\nsun: {elevation: -30 deg}\nstars: {sidereal_time: 1}\n"
#define SEQUENCE "animate: {camera.fov: [[1, 40 deg], [9, 50 deg]]}\nrender: {history: reproject}\n"

static const struct {
  np_stage stage;
  const char *with, *reason;        /* a scene that needs it, and a word of the reason */
  const char *without, *reason_not; /* one that does not; NULL: every picture needs it, for this reason */
} examples[] = {
    {NP_STAGE_COLOR, EMPTY, "bands", NULL, "every picture is made of bands"},
    {NP_STAGE_TERRAIN, "terrain: {ridges: {}}", "ridges", EMPTY, "terrain"},
    {NP_STAGE_MOON, "sun: {elevation: -30 deg}\nmoon: {elevation: 30, azimuth: 10}", "moon", EMPTY, "moon"},
    {NP_STAGE_LIGHTS, EMPTY, "elevation", NULL, "a light without power has a place too"},
    {NP_STAGE_VOLUMES, CLOUD, "baked", EMPTY, "no clouds"},
    {NP_STAGE_MOTION, CLOUD "output: {aovs: [motion]}", "motion", CLOUD, "camera.motion_blur"},
    {NP_STAGE_ATMOSPHERE, EMPTY, "air", "atmosphere: none", "atmosphere.preset"},
    {NP_STAGE_CAMERA_SKY, EMPTY, "sky", "atmosphere: none", "atmosphere.preset"},
    {NP_STAGE_COLOR_FIT, EMPTY, "wavelengths", "output: {beauty: false, aovs: [depth]}", "light"},
    {NP_STAGE_EMISSION, FIRE, "black bodies", CLOUD, "emission"},
    {NP_STAGE_CLOUD_SKY, CLOUD, "cloud", EMPTY, "clouds"},
    {NP_STAGE_WATER_SKY, "water: {}", "water", EMPTY, "water"},
    {NP_STAGE_AIRGLOW, "airglow: {}\nsun: {elevation: -30 deg}", "night", EMPTY, "airglow"},
    {NP_STAGE_SUN_LIGHT, EMPTY, "sun", "sun: {irradiance: 0}", "sun"},
    {NP_STAGE_SKY_LIGHT, CLOUD, "sky", CLOUD "atmosphere: none", "environment"},
    {NP_STAGE_GROUND_LIGHT, CLOUD, "ground", EMPTY, "clouds"},
    {NP_STAGE_WORLD, EMPTY, "places", NULL, "every picture is of a world"},
    {NP_STAGE_SKY_GUIDE, PATH, "path", CLOUD, "only paths"},
    {NP_STAGE_SUN_OPTICAL_DEPTH, CLOUD "render: {sun_optical_depth: volume}", "render.sun_optical_depth",
     CLOUD "render: {sun_optical_depth: march}", "render.sun_optical_depth"},
    {NP_STAGE_ORDINATES, CLOUD, "solved", CLOUD "render: {multiple_scattering: none}", "render.multiple_scattering"},
    {NP_STAGE_VIEWER_LIGHT, CLOUD, "camera", CLOUD "render: {multiple_scattering: none}", "multiple"},
    {NP_STAGE_GROUND_CLOUDS, CLOUD, "ground", CLOUD "environment: {planet: none}", "ground"},
    {NP_STAGE_RELIEF_LIGHT, "terrain: {ridges: {samples: 65}}", "hills", EMPTY, "hills"},
    {NP_STAGE_AIR_SHADOWS, CLOUD "render: {air_shadows: true}", "render.air_shadows",
     CLOUD "render: {air_shadows: false}", "render.air_shadows"},
    {NP_STAGE_APPROXIMATION, CLOUD "render: {multiple_scattering: octaves}", "octaves", CLOUD,
     "render.multiple_scattering"},
    {NP_STAGE_STARS, STARS, "light", EMPTY, "stars"},
    {NP_STAGE_LIGHTING, EMPTY, "caches", NULL, "an integrator takes all light from it"},
    {NP_STAGE_HISTORY, SEQUENCE, "frame", EMPTY, "render.history"},
    {NP_STAGE_INTEGRATOR, EMPTY, "march", NULL, "every picture has samples"},
};

enum { EXAMPLES = sizeof examples / sizeof *examples };

static void every_stage_has_an_example(void **state) {
  (void)state;
  for (int stage = 0; stage < NP_STAGE_COUNT; stage++) {
    int i = 0;
    while (i < EXAMPLES && (int)examples[i].stage != stage) i++;
    if (i == EXAMPLES)
      fail_msg("the stage %s has no example: add a scene that needs it and one that does not to `examples` in "
               "tests/test_stage_rows.c",
               np_stage_get_rule((np_stage)stage)->name);
  }
}

/* The line of a stage in --explain: "name   yes  reason". */
static void assert_line(test_fixture *f, const char *scene_text, np_stage stage, bool is_needed, const char *word) {
  char line[4096] = "\n", *text = NULL, *path = test_path(f->folder, "scene.yaml");
  const char *name = np_stage_get_rule(stage)->name, *at;
  neph_scene *scene = NULL;
  if (neph_scene_load_text(f->context, scene_text, path, &scene)) fail_msg("%s: %s", scene_text, f->log.text);
  if (neph_render_explain(scene, NULL, NEPH_TEXT_PLAIN, &text)) fail_msg("%s: %s", scene_text, f->log.text);
  strcat(strcat(line, name), "  ");
  if (!(at = strstr(text, line))) fail_msg("no stage %s in\n%s", name, text);
  snprintf(line, sizeof line, "%.*s", (int)strcspn(at + 1, "\n"), at + 1);
  at = line + strlen(name) + strspn(line + strlen(name), " ");
  if (strncmp(at, is_needed ? "yes " : "no ", is_needed ? 4 : 3) != 0 || !strstr(at, word))
    fail_msg("%s\nmust be %s, with a reason that holds \"%s\": %s", scene_text, is_needed ? "yes" : "no", word, line);
  neph_text_destroy(f->context, text);
  neph_scene_destroy(scene);
  free(path);
}

static void every_stage_is_needed_where_it_must_be(void **state) {
  test_fixture *f = *state;
  static const test_box box = {{0, 0, 0}, {8, 8, 8}, 1.0f};
  char *path = test_path(f->folder, "box.vdb");
  test_boxes_write(f->context, path, "density", &box, 1);
  for (int i = 0; i < EXAMPLES; i++) {
    assert_line(f, examples[i].with, examples[i].stage, true, examples[i].reason);
    if (examples[i].without)
      assert_line(f, examples[i].without, examples[i].stage, false, examples[i].reason_not);
    else
      assert_true(strlen(examples[i].reason_not) > 0);
  }
  free(path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_stage_has_an_example),
      cmocka_unit_test_setup_teardown(every_stage_is_needed_where_it_must_be, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
