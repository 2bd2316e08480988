/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in many places: the hierarchy against all of them in turn, and pictures against clouds of their own. */
#include <stdlib.h>

#include "test_scenes.h"
#include "test_volumes.h"

#include "core/alloc.h"
#include "volume/depth_cursor.h"
#include "volume/places.h"
#include "volume/ray_intervals.h"

/* ---- The hierarchy ---- */

enum { PLACES = 200 };

typedef struct crowd {
  neph_context *context;
  neph_volume *volume;
  np_instance row;
  np_places places;
  np_instances all, in_turn; /* under the hierarchy; the same without */
} crowd;

static double random_in(np_random *random, double low, double high) {
  return low + (high - low) * np_random_double(random);
}

/* Balls of 24 voxels, turned, of 5 to 20 m, `width` across. */
static np_instance place_ball(const neph_volume *volume, np_random *random, double width) {
  const double angle = random_in(random, 0.0, 6.0), scale = random_in(random, 0.2, 0.8);
  const double c = scale * cos(angle), s = scale * sin(angle);
  const double x = random_in(random, 0.0, width), y = random_in(random, 0.0, width), z = random_in(random, 0.0, 20.0);
  const np_affine to_world = {{{c, -s, 0, x}, {s, c, 0, y}, {0, 0, scale, z}}};
  const np_affine index_to_world = np_affine_compose(&to_world, &volume->index_to_world);
  np_instance out = {.bricks = &volume->bricks, .extinction_per_value = 0.1f};
  assert_true(np_affine_invert(&index_to_world, &out.world_to_index));
  return out;
}

static void crowd_create(crowd *c, double width) {
  np_random random = np_random_start(7, 0, 0, 0, 0);
  *c = (crowd){.context = test_context_create(1, NULL)};
  const np_dvec3 step = {1.0, 1.0, 1.0}, middle = {0.0, 0.0, 0.0};
  assert_int_equal(test_volume_create(c->context, test_soft_ball, TEST_EDGE, step, middle, &c->volume), NEPH_OK);
  np_instance *at = np_alloc(c->context, PLACES, sizeof *at);
  for (int i = 0; i < PLACES; i++) at[i] = place_ball(c->volume, &random, width);
  c->row = at[0];
  assert_int_equal(np_places_build(c->context, at, PLACES, &c->places), NEPH_OK);
  c->all = (np_instances){.count = 1, .at = &c->row, .places = &c->places};
  c->in_turn = (np_instances){.count = PLACES, .at = c->places.at};
}

static void crowd_destroy(crowd *c) {
  np_places_clear(c->context, &c->places);
  neph_volume_release(c->volume);
  neph_context_destroy(c->context);
}

static np_vec3 random_direction(np_random *random) {
  return np_vec3_make((float)random_in(random, -1, 1), (float)random_in(random, -1, 1),
                      (float)random_in(random, -0.2, 0.2));
}

/* Optical depth of all in turn: exact, but for its sum. */
static double compute_depth(const crowd *c, np_dvec3 origin, np_vec3 direction, double end) {
  np_random random = np_random_start(1, 0, 0, 0, 0);
  const float passed = np_track_transmittance(&c->in_turn, origin, direction, end, INFINITY, &random);
  return -log((double)passed);
}

/* Depth by intervals, midpoint rule of 64 points in each. */
static double sum_intervals(const crowd *c, np_dvec3 origin, np_vec3 direction, double end) {
  static np_ray_intervals all;
  np_ray_interval s;
  double depth = 0.0, last = 0.0;
  np_ray_intervals_start(&all, &c->all, origin, direction, end);
  while (np_ray_intervals_next(&all, &s)) {
    assert_true(s.begin >= last && s.end > s.begin);
    last = s.end;
    for (int k = 0; k < 64; k++) {
      const double t = s.begin + (s.end - s.begin) * (k + 0.5) / 64.0;
      float value;
      for (unsigned i = 0; i < s.count; i++) {
        const np_ray_instance *m = &all.instance[s.active[i]];
        const float at[NP_BRICK_LINE] = {(float)(t - s.begin)};
        float found[NP_BRICK_LINE];
        np_ray_instance_fill_extinction(m, s.begin, 0.0f, at, 1, found);
        value = found[0];
        depth += (double)value * (s.end - s.begin) / 64.0;
      }
    }
  }
  return depth;
}

static double sum_cursors(const crowd *c, np_dvec3 origin, np_vec3 direction, double end) {
  static np_depth_cursors cursors;
  double before = 0.0;
  np_depth_cursors_start(&cursors, &c->all, origin, direction, end);
  for (int k = 1; k <= 10; k++) {
    np_depth_cursors_advance(&cursors, end * k / 10);
    assert_true(np_depth_cursors_sum(&cursors) >= before - 1e-9); /* what is left is summed anew */
    before = np_depth_cursors_sum(&cursors);
  }
  return before;
}

/* All ways along a ray meet the same matter. */
static void rays_meet_every_place(void **state) {
  (void)state;
  crowd c;
  crowd_create(&c, 100.0);
  np_random random = np_random_start(9, 0, 0, 0, 0);
  int met = 0;
  for (int i = 0; i < 300; i++) {
    const np_dvec3 origin = {random_in(&random, 0, 100), random_in(&random, 0, 100), random_in(&random, 0, 20)};
    const np_vec3 direction = np_vec3_normalize(random_direction(&random));
    const double end = 80.0, expected = compute_depth(&c, origin, direction, end);
    np_random own = np_random_start(1, 0, 0, 0, 0);
    const float passed = np_track_transmittance(&c.all, origin, direction, end, INFINITY, &own);
    assert_near(-log((double)passed), expected, 1e-5 * (1.0 + expected)); /* floats, in another order */
    /* 64 midpoints in each stretch of 8 voxels at most: second derivatives of some 0.1, (1/8)²/24 of that. */
    assert_near(sum_intervals(&c, origin, direction, end), expected, 1e-3 * (1.0 + expected));
    assert_near(sum_cursors(&c, origin, direction, end), expected, 1e-5 * (1.0 + expected));
    met += expected > 0.5;
  }
  assert_true(met > 100);
  crowd_destroy(&c);
}

static void points_meet_every_place(void **state) {
  (void)state;
  crowd c;
  crowd_create(&c, 60.0);
  np_random random = np_random_start(3, 0, 0, 0, 0);
  for (int i = 0; i < 2000; i++) {
    const np_dvec3 p = {random_in(&random, 0, 60), random_in(&random, 0, 60), random_in(&random, 0, 20)};
    float sum = 0.0f;
    const float expected = np_instances_extinction(&c.in_turn, p);
    assert_near((double)np_instances_extinction(&c.all, p), (double)expected, 1e-6);
    np_places_add_extinction(&c.places, p, 2.0f, &sum);
    assert_near((double)sum, 2.0 * (double)expected, 2e-6);
  }
  crowd_destroy(&c);
}

/* A queue hands out each place of a long ray once, in order, over many batches. */
static void queue_is_in_order(void **state) {
  (void)state;
  crowd c;
  crowd_create(&c, 30.0);
  np_place_queue queue;
  bool has_been[PLACES] = {false};
  double last = 0.0;
  int count = 0;
  const np_dvec3 origin = {-20.0, 14.0, 9.0};
  const np_vec3 direction = {1.0f, 0.0f, 0.0f};
  np_place_queue_start(&queue, &c.all, origin, direction, INFINITY);
  for (; isfinite(np_place_queue_get_next(&queue)); count++) {
    assert_true(np_place_queue_get_next(&queue) >= last);
    last = np_place_queue_get_next(&queue);
    const size_t place = (size_t)(np_place_queue_take(&queue) - c.places.at);
    assert_false(has_been[place]);
    has_been[place] = true;
  }
  assert_true(count > 2 * NP_PLACE_BATCH);
  for (int i = 0; i < PLACES; i++) {
    np_brick_walk walk;
    np_brick_span span;
    np_track_start(&walk, &c.places.at[i], origin, direction, 0.0, INFINITY);
    if (np_brick_walk_next(&walk, &span)) assert_true(has_been[i]);
  }
  crowd_destroy(&c);
}

/* The crowd's densest point, against a lattice of points: one of them never holds more than the limit that is kept. */
static void crowds_are_counted(void **state) {
  (void)state;
  crowd c;
  crowd_create(&c, 60.0);
  bool is_crowded = true;
  np_dvec3 point;
  unsigned limit = 1;
  while (limit < PLACES && is_crowded) {
    assert_int_equal(np_places_search_crowd(c.context, &c.places, limit, &is_crowded, &point), NEPH_OK);
    const double p[3] = {point.x, point.y, point.z};
    const np_instance *met[PLACES];
    if (is_crowded) assert_true(np_places_list_in_box(&c.places, p, p, PLACES, met) > limit);
    limit += is_crowded;
  }
  assert_in_range(limit, 5, PLACES - 1);
  for (int i = 0; i < 20 * 20 * 8; i++) {
    const double p[3] = {3.0 * (i % 20), 3.0 * (i / 20 % 20), 3.0 * (i / 400)};
    assert_true(np_places_list_in_box(&c.places, p, p, 0, NULL) <= limit);
  }
  crowd_destroy(&c);
}

/* ---- Pictures ---- */

static const char scene_head[] =
    "version: 1\n"
    "camera: {position: [0 m, -4 km, 900 m], look_at: [0, 0, 700 m], fov: 45 deg, resolution: [48, 27]}\n"
    "sun: {elevation: 25 deg, azimuth: 120 deg}\n"
    "render: {samples: 4}\n";

static const char bake[] =
    "bake: {preset: cumulus_mediocris, extent: 800 m, cell: 500 m, base: 500 m, thickness: 500 m,"
    " voxel: 50 m, coverage: 0.7, seed: 3}";

typedef struct pictures {
  test_log log;
  neph_context *context;
  char *folder, rows[8192], places[2048], csv[512];
} pictures;

static int set_up_pictures(void **state) {
  pictures *p = calloc(1, sizeof *p);
  test_log_start(&p->log);
  p->context = test_context_create_cached(2, &p->log);
  p->folder = test_folder_create();
  (void)snprintf(p->csv, sizeof p->csv, "%s/places.csv", p->folder);
  (void)snprintf(p->places, sizeof p->places, "%sclouds:\n  - {name: c, %s, places: %s}\n", scene_head, bake, p->csv);
  *state = p;
  return 0;
}

static int tear_down_pictures(void **state) {
  pictures *p = *state;
  neph_context_destroy(p->context);
  test_folder_destroy(p->folder);
  free(p);
  return 0;
}

/* Ten places, as a file and as clouds of their own; the last two overlap. */
static void write_ten(pictures *p) {
  char text[2048] = "x_m,y_m,z_m,rotation_deg,scale\n";
  (void)snprintf(p->rows, sizeof p->rows, "%sclouds:\n", scene_head);
  for (int i = 0; i < 10; i++) {
    const int x = i < 9 ? -1500 + 370 * i : 1300, y = 140 * (i * 7 % 5) - 300, turn = 40 * i;
    const double scale = 0.6 + 0.07 * i;
    size_t length = strlen(text);
    (void)snprintf(text + length, sizeof text - length, "%d,%d,500,%d,%g\n", x, y, turn, scale);
    length = strlen(p->rows);
    (void)snprintf(p->rows + length, sizeof p->rows - length,
                   "  - {name: c%d, %s, position: [%d m, %d m, 500 m], rotation: %d deg, scale: %g}\n", i, bake, x, y,
                   turn, scale);
  }
  test_file_write_text(p->csv, text);
}

static neph_image *render(pictures *p, const char *text, const char *integrator, const char *method) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  neph_result result = neph_scene_load_text(p->context, text, "test.yaml", &scene);
  if (!result) result = neph_scene_set(scene, "render.integrator", integrator);
  if (!result) result = neph_scene_set(scene, "render.multiple_scattering", method);
  if (!result && !strcmp(integrator, "path")) result = neph_scene_set(scene, "render.samples", "16");
  if (!result) result = neph_render_image(scene, NULL, &image);
  if (result) fail_msg("%s: %s", integrator, p->log.text);
  neph_scene_destroy(scene);
  return image;
}

static neph_image_difference compare(pictures *p, const char *integrator, const char *method) {
  neph_image *rows = render(p, p->rows, integrator, method), *places = render(p, p->places, integrator, method);
  neph_image_difference d = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(neph_image_compare(p->context, places, rows, &d), NEPH_OK);
  neph_image_destroy(rows);
  neph_image_destroy(places);
  return d;
}

/* Steps of the march are cut where boxes are entered, and no lattice differs: by a tenth of its tolerance of 2 %. */
static void ten_places_are_ten_clouds(void **state) {
  pictures *p = *state;
  write_ten(p);
  assert_true(compare(p, "march", "ordinates").block_rms < 2e-3);
}

/* Light of the surroundings is one random direction a step: two pictures differ by its noise alone. */
static void approximations_see_places(void **state) {
  pictures *p = *state;
  static const char *const methods[] = {"octaves", "derivative"};
  write_ten(p);
  for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
    const neph_image_difference d = compare(p, "march", methods[i]);
    if (!(fabs(d.bias) < 2.0 * d.bias_interval + 1e-4))
      fail_msg("%s: bias %g, with 95 %% in %g", methods[i], d.bias, d.bias_interval);
    assert_true(d.block_rms < 0.1);
  }
}

/* Two pictures of other random paths: four times the standard error of their difference, of which the interval is
 * two. */
static void paths_meet_places(void **state) {
  pictures *p = *state;
  write_ten(p);
  const neph_image_difference d = compare(p, "path", "ordinates");
  assert_true(fabs(d.bias) < 2.0 * d.bias_interval);
}

/* A thousand copies share one volume; the second of two pictures has what the first baked. */
static void a_thousand_places_render(void **state) {
  pictures *p = *state;
  FILE *file = fopen(p->csv, "w");
  fprintf(file, "x_m,y_m,z_m,rotation_deg,scale\n");
  for (int i = 0; i < 1000; i++)
    fprintf(file, "%d,%d,500,%d,0.15\n", i % 40 * 90 - 1800, i / 40 * 90 - 500, i * 37 % 360);
  fclose(file);
  const char *const integrators[] = {"march", "path"};
  for (int i = 0; i < 2; i++) {
    neph_image *image = render(p, p->places, integrators[i], "ordinates");
    neph_image_destroy(image);
  }
}

/* ---- Refusals ---- */

static neph_result try_places(pictures *p, const char *csv, const char *key, const char *value) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  test_log_clear(&p->log);
  test_file_write_text(p->csv, csv);
  neph_result result = neph_scene_load_text(p->context, p->places, "test.yaml", &scene);
  if (!result && key) result = neph_scene_set(scene, key, value);
  if (!result) result = neph_render_image(scene, NULL, &image);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return result;
}

static void files_of_places_are_checked(void **state) {
  pictures *p = *state;
  static const struct {
    const char *csv, *part;
  } cases[] = {{"x_m,y_m,z_m\n", "has 0 places of cloud c, must have from 1"},
               {"x_m,y_m,z_m,scale\n0,0,500,1\n0,0,500,0\n", "places.csv:3:"},
               {"x_m,y_m,z_m,scale\n0,0,500,-2\n", "scale"},
               {"x_m,y_m,z_m\n0,zero,500\n", "places.csv:2:"},
               {"x_m,y_m\n0,0\n", "z_m"}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    assert_int_equal(try_places(p, cases[i].csv, NULL, NULL), NEPH_ERROR_BAD_FILE);
    if (!strstr(p->log.text, cases[i].part)) fail_msg("%s: not in %s", cases[i].part, p->log.text);
  }
}

static void keys_beside_places_are_refused(void **state) {
  pictures *p = *state;
  static const char *const beside[] = {"position: [0 m, 0 m, 0 m]", "emission: {flame: none}"};
  test_file_write_text(p->csv, "x_m,y_m,z_m\n0,0,500\n");
  for (int i = 0; i < 2; i++) {
    char text[2048];
    neph_scene *scene = NULL;
    test_log_clear(&p->log);
    (void)snprintf(text, sizeof text, "%sclouds: [{vdb: smoke.vdb, %s, places: %s}]\n", scene_head, beside[i], p->csv);
    neph_result result = neph_scene_load_text(p->context, text, "test.yaml", &scene);
    if (!result) result = neph_scene_check(scene);
    assert_int_equal(result, NEPH_ERROR_BAD_SCENE);
    assert_non_null(strstr(p->log.text, "exclude each other"));
    neph_scene_destroy(scene);
  }
}

static void files_of_places_must_be_there(void **state) {
  pictures *p = *state;
  assert_int_equal(try_places(p, "x_m,y_m,z_m\n0,0,500\n", "clouds[0].places", "none.csv"), NEPH_ERROR_NOT_FOUND);
  assert_non_null(strstr(p->log.text, "none.csv, which cannot be read"));
}

static void too_many_at_one_point_are_refused(void **state) {
  pictures *p = *state;
  char text[4096] = "x_m,y_m,z_m\n";
  for (int i = 0; i <= NP_PLACES_OVERLAP_MAX; i++) strcat(text, i % 2 ? "10,0,500\n" : "0,5,500\n");
  assert_int_equal(try_places(p, text, NULL, NULL), NEPH_ERROR_BAD_SCENE);
  assert_non_null(strstr(p->log.text, "the boxes of more than 48 places lie over each other at"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rays_meet_every_place),
      cmocka_unit_test(points_meet_every_place),
      cmocka_unit_test(queue_is_in_order),
      cmocka_unit_test(crowds_are_counted),
      cmocka_unit_test_setup_teardown(ten_places_are_ten_clouds, set_up_pictures, tear_down_pictures),
      cmocka_unit_test_setup_teardown(approximations_see_places, set_up_pictures, tear_down_pictures),
      cmocka_unit_test_setup_teardown(paths_meet_places, set_up_pictures, tear_down_pictures),
      cmocka_unit_test_setup_teardown(a_thousand_places_render, set_up_pictures, tear_down_pictures),
      cmocka_unit_test_setup_teardown(files_of_places_are_checked, set_up_pictures, tear_down_pictures),
      cmocka_unit_test_setup_teardown(keys_beside_places_are_refused, set_up_pictures, tear_down_pictures),
      cmocka_unit_test_setup_teardown(files_of_places_must_be_there, set_up_pictures, tear_down_pictures),
      cmocka_unit_test_setup_teardown(too_many_at_one_point_are_refused, set_up_pictures, tear_down_pictures),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
