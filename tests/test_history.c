/* SPDX-License-Identifier: Apache-2.0 */
/* Frames that take pixels from the frame before, and pixels that are interpolated: known pictures, still and moving,
 * the same bits from whichever frame a process begins, and what is refused. */
#include <math.h>
#include <stdio.h>

#include <nephos/nephos.h>

#include "test_films.h"
#include "test_scenes.h"

#define SIZE "resolution: [32, 20]"
#define PIXELS (32 * 20)

static const char *const integrators[] = {"march", "path"};

static test_film load(fixture *f, const char *text) { return film_load(f->context, text, "dir/scene.yaml"); }

static void set_in(test_film film, const char *key, const char *value) {
  assert_int_equal(neph_scene_set(film.scene, key, value), NEPH_OK);
}

static neph_image *render(test_film film, int frame) {
  neph_image *image;
  assert_int_equal(film_render(film, frame, &image), NEPH_OK);
  return image;
}

static const float *get(const neph_image *image, const char *channel) {
  const float *values = neph_image_get_values(image, channel);
  assert_non_null(values);
  return values;
}

/* Percentages of pixels that were rendered, reprojected, interpolated. */
static void get_percents(const neph_image *image, double out[3]) {
  const char *text = neph_image_get_attribute(image, "nephos:pixels");
  assert_non_null(text);
  assert_int_equal(sscanf(text, "%lf %% rendered, %lf %% reprojected, %lf %%", &out[0], &out[1], &out[2]), 3);
}

static void assert_same_bits(fixture *f, const neph_image *ours, const neph_image *theirs) {
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(neph_image_compare(f->context, ours, theirs, &difference), NEPH_OK);
  assert_int_equal(difference.differing_count, 0);
}

/* ---- A sky that is the same everywhere ---- */

static const char constant[] =
    "camera: {position: [0, 0, 500 m], look_at: [0, 1 km, 600 m], " SIZE "}\n"
    "environment: {planet: none, radiance: [0.25, 0.5, 1]}\natmosphere: none\nsun: {irradiance: 0}\n"
    "animate: {camera.look_at: [[1, [0, 1 km, 600 m]], [9, [40 m, 1 km, 650 m]]]}\n"
    "render: {samples: 1, history: reproject}\noutput: {color_space: bands, scale: 1, pixel_type: float}\n";

/* A mean of equal floats, weighted by sums that are 1 up to their rounding. */
static const float rounding = 3e-7f;

static void assert_constant(const neph_image *image) {
  static const char *const names[] = {"R", "G", "B"};
  static const float radiance[] = {0.25f, 0.5f, 1.0f};
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < PIXELS; i++) assert_float_equal(get(image, names[c])[i], radiance[c], rounding * radiance[c]);
}

/* Every value of every key, in both integrators. */
static void a_constant_sky_stays_constant(void **state) {
  static const char *const methods[] = {"none", "reproject"}, *const updates[] = {"1", "4", "16"},
                           *const upsamplings[] = {"1", "2", "4"};
  fixture *f = *state;
  for (int i = 0; i < 2 * 2 * 3 * 3; i++) {
    test_film scene = load(f, constant);
    const int update = i / 4 % 3, upsampling = i / 12;
    set_in(scene, "render.integrator", integrators[i % 2]);
    set_in(scene, "render.history", methods[i / 2 % 2]);
    set_in(scene, "render.history_update", updates[update]);
    set_in(scene, "render.upsample", upsamplings[upsampling]);
    for (int frame = 1; frame <= 3; frame++) {
      neph_image *image = render(scene, frame);
      assert_constant(image);
      neph_image_destroy(image);
    }
    film_destroy(scene);
  }
}

/* Alike pixels around that are rendered have no deviation from the light that is now. */
static void a_sky_that_changes_has_no_lag(void **state) {
  fixture *f = *state;
  for (int i = 0; i < 2; i++) {
    test_film scene = load(f, constant);
    set_in(scene, "render.integrator", integrators[i]);
    set_in(scene, "animate.environment.radiance", "[[1, [0.5, 1, 2]], [6, [0.25, 0.5, 1]]]");
    neph_image *before = render(scene, 5), *image = render(scene, 6);
    double percents[3];
    get_percents(image, percents);
    assert_true(percents[1] > 80.0);
    assert_true(get(before, "G")[0] > 0.55f);
    assert_constant(image);
    neph_image_destroy(before);
    neph_image_destroy(image);
    film_destroy(scene);
  }
}

/* ---- Hills before a sky ---- */

/* Black hills before a white sky: the camera rises beside them, and they sink by two pixels a frame and more. */
static const char sinking_hills[] =
    "camera: {position: [0, -3 km, 300 m], look_at: [0, 0, 700 m], fov: 60 deg, " SIZE "}\n"
    "sun: {irradiance: 0}\natmosphere: none\nenvironment: {radiance: [1, 1, 1]}\n"
    "terrain: {ridges: {samples: 65, relief: 900 m, seed: 2}, width: 8 km, albedo: 0}\n"
    "animate: {camera.position: [[1, [0, -3 km, 300 m]], [9, [500 m, -3 km, 1500 m]]],"
    " camera.look_at: [[1, [0, 0, 700 m]], [9, [500 m, 0, 1900 m]]]}\n"
    "render: {samples: 4, history: reproject}\noutput: {color_space: bands, scale: 1, pixel_type: float}\n";

/* The filter of a pixel reaches into the next ones: only where all nine show the same is the value known. */
static int classify(const float *depth, int x, int y) {
  int sky = 0;
  if (x < 1 || y < 1 || x > 30 || y > 18) return -1;
  for (int k = 0; k < 9; k++) sky += isinf(depth[(y + k / 3 - 1) * 32 + x + k % 3 - 1]) != 0;
  return sky == 9 ? 1 : sky == 0 ? 0 : -1;
}

/* The largest error of a pixel whose value is known, and the number of those of hills, of the sky, and of the sky that
 * was hill in the frame before. */
static float compute_worst(const neph_image *image, bool *was_hill, unsigned out_counts[3]) {
  const float *depth = get(image, "Z"), *green = get(image, "G");
  float worst = 0.0f;
  memset(out_counts, 0, 3 * sizeof *out_counts);
  for (int y = 0; y < 20; y++)
    for (int x = 0; x < 32; x++) {
      const int known = classify(depth, x, y);
      out_counts[2] += known == 1 && was_hill[y * 32 + x];
      was_hill[y * 32 + x] = known == 0;
      if (known < 0) continue;
      out_counts[known]++;
      worst = fmaxf(worst, fabsf(green[y * 32 + x] - (float)known));
    }
  return worst;
}

/* A pixel that the ridge uncovers or covers has nothing of what it showed before, and nothing of its neighbours beyond
 * the edge. */
static void a_ridge_leaves_no_ghost(void **state) {
  static const char *const upsamplings[] = {"1", "2", "4"};
  fixture *f = *state;
  for (int i = 0; i < 2 * 3; i++) {
    test_film scene = load(f, sinking_hills);
    unsigned counts[3], uncovered = 0;
    bool was_hill[PIXELS] = {false};
    double percents[3];
    set_in(scene, "render.integrator", integrators[i % 2]);
    set_in(scene, "render.upsample", upsamplings[i / 2]);
    for (int frame = 1; frame <= 8; frame++) {
      neph_image *image = render(scene, frame);
      const float worst = compute_worst(image, was_hill, counts);
      if (worst > rounding)
        fail_msg("%s, upsample %s, frame %d: a pixel has %.3g of other light", integrators[i % 2], upsamplings[i / 2],
                 frame, (double)worst);
      assert_true(counts[0] > PIXELS / 8 && counts[1] > PIXELS / 8);
      uncovered += counts[2];
      get_percents(image, percents);
      if (frame > 1) assert_true(percents[1] > 50.0);
      neph_image_destroy(image);
    }
    assert_true(uncovered > 16);
    film_destroy(scene);
  }
}

/* ---- A camera that rests ---- */

static const char cumulus[] =
    "camera: {position: [0, -3 km, 400 m], look_at: [0, 0, 800 m], fov: 30 deg, " SIZE "}\n"
    "sun: {elevation: 30 deg, azimuth: 140 deg}\natmosphere: none\nenvironment: {radiance: 0.02}\n"
    "clouds: [{name: a, extinction: 1 1/m, bake: {preset: cumulus_mediocris, model: hero, seed: 11,"
    " extent: [800 m, 800 m], voxel: 50 m}}]\n"
    "animate: {camera.position: {interpolation: step, keys: [[1, [0, -3 km, 400 m]], [41, [0, -3.2 km, 400 m]],"
    " [42, [3 km, 0, 400 m]]]}}\n"
    "render: {samples: 1, history: reproject, history_frames: 64, multiple_scattering: none}\n"
    "output: {pixel_type: float}\n";

static test_film load_cumulus(fixture *f, const char *integrator, const char *method) {
  test_film scene = load(f, cumulus);
  set_in(scene, "render.integrator", integrator);
  set_in(scene, "render.max_scatterings", "1");
  set_in(scene, "render.history", method);
  return scene;
}

static bool is_same_at(const neph_image *a, const neph_image *b, int place) {
  for (int p = 0; p < PIXELS; p++)
    if (p / 32 % 4 * 4 + p % 4 == place && memcmp(&get(a, "G")[p], &get(b, "G")[p], sizeof(float))) return false;
  return true;
}

/* A weight of 1 makes each pixel, bit for bit, the full frame's in which it was rendered last; each of sixteen frames
 * renders one pixel of all squares. */
static void sixteen_frames_renew_every_pixel(void **state) {
  fixture *f = *state;
  for (int i = 0; i < 2; i++) {
    test_film scene = load_cumulus(f, integrators[i], "reproject"), full = load_cumulus(f, integrators[i], "none");
    set_in(scene, "render.history_weight", "1");
    neph_image *image = render(scene, 17);
    unsigned places = 0;
    for (int frame = 2; frame <= 17; frame++) {
      neph_image *theirs = render(full, frame);
      unsigned same = 0;
      for (int place = 0; place < 16; place++) same |= is_same_at(image, theirs, place) ? 1u << place : 0u;
      if (!same || (same & (same - 1)) || (same & places))
        fail_msg("%s, frame %d: places %x are those of the full frame, %x were before", integrators[i], frame, same,
                 places);
      places |= same;
      neph_image_destroy(theirs);
    }
    assert_int_equal(places, 0xffff);
    neph_image_destroy(image);
    film_destroy(scene);
    film_destroy(full);
  }
}

static double compute_square_error(const neph_image *image, const neph_image *reference) {
  double sum = 0.0;
  for (int p = 0; p < PIXELS; p++)
    sum += pow((double)get(image, "G")[p] - (double)get(reference, "G")[p], 2.0) / PIXELS;
  return sum;
}

/* Each pixel has three samples by frame 33: a third of the variance, apart from the reference's 1/64 and chance; half
 * is required, over four seeds. */
static void a_still_picture_converges(void **state) {
  static const char *const seeds[] = {"1", "2", "3", "4"};
  fixture *f = *state;
  for (int i = 0; i < 2; i++) {
    test_film scene = load_cumulus(f, integrators[i], "reproject"), full = load_cumulus(f, integrators[i], "none");
    double renewed = 0.0, single = 0.0;
    set_in(scene, "render.history_weight", "0");
    for (size_t k = 0; k < sizeof seeds / sizeof *seeds; k++) {
      set_in(scene, "render.seed", seeds[k]);
      set_in(full, "render.seed", seeds[k]);
      set_in(full, "render.samples", "1");
      neph_image *one = render(full, 33), *image = render(scene, 33);
      set_in(full, "render.samples", "64");
      neph_image *reference = render(full, 1);
      renewed += compute_square_error(image, reference);
      single += compute_square_error(one, reference);
      neph_image_destroy(one);
      neph_image_destroy(image);
      neph_image_destroy(reference);
    }
    assert_true(renewed < 0.5 * single);
    film_destroy(scene);
    film_destroy(full);
  }
}

/* ---- Cuts and blocks ---- */

/* A camera that jumps to another side renders all pixels, and the first of a block does, too. */
static void a_cut_takes_nothing_from_before(void **state) {
  fixture *f = *state;
  for (int i = 0; i < 2; i++) {
    test_film scene = load_cumulus(f, integrators[i], "reproject"), full = load_cumulus(f, integrators[i], "none");
    static const int frames[] = {1, 40, 42, 65};
    for (int k = 0; k < 4; k++) {
      neph_image *image = render(scene, frames[k]), *theirs = render(full, frames[k]);
      double percents[3];
      get_percents(image, percents);
      if (frames[k] != 40) assert_same_bits(f, image, theirs);
      assert_true(frames[k] == 40 ? percents[1] > 90.0 : percents[0] > 99.9);
      assert_int_equal(strstr(neph_image_get_attribute(image, "nephos:pixels"), "a cut") != NULL, frames[k] == 42);
      neph_image_destroy(image);
      neph_image_destroy(theirs);
    }
    film_destroy(scene);
    film_destroy(full);
  }
}

/* Frames of one process in any order, and of one that begins there, on one thread and on two. */
static void a_frame_alone_is_that_of_the_sequence(void **state) {
  static const int order[] = {1, 2, 3, 5, 6, 4, 6};
  static const char *const upsamplings[] = {"1", "2"};
  fixture *f = *state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  for (int i = 0; i < 2; i++) {
    test_film scene = load(f, sinking_hills);
    set_in(scene, "render.upsample", upsamplings[i]);
    set_in(scene, "render.history_frames", "4");
    for (size_t k = 0; k < sizeof order / sizeof *order; k++) {
      test_film alone = film_load(context, sinking_hills, "dir/scene.yaml");
      set_in(alone, "render.upsample", upsamplings[i]);
      set_in(alone, "render.history_frames", "4");
      neph_image *ours = render(scene, order[k]), *theirs = render(alone, order[k]);
      assert_same_bits(f, ours, theirs);
      neph_image_destroy(ours);
      neph_image_destroy(theirs);
      film_destroy(alone);
    }
    film_destroy(scene);
  }
  neph_context_destroy(context);
}

/* Each frame is rendered once where they come in order, and those of its block before it where one comes alone. */
static void frames_before_are_rendered_once(void **state) {
  fixture *f = *state;
  test_film scene = load(f, sinking_hills);
  static const struct {
    int frame;
    const char *said;
  } rows[] = {
      {3, "history: frame 2 is rendered for frame 3"}, {4, NULL}, {6, "history: frame 5 is rendered for frame 6"}};
  for (size_t i = 0; i < 3; i++) {
    test_log_clear(&f->log);
    neph_image_destroy(render(scene, rows[i].frame));
    assert_int_equal(strstr(f->log.text, "history: frame") != NULL, rows[i].said != NULL);
    if (rows[i].said) assert_non_null(strstr(f->log.text, rows[i].said));
  }
  assert_null(strstr(f->log.text, "history: frame 4"));
  film_destroy(scene);
}

/* ---- Refusals ---- */

static void pictures_that_cannot_be_filled_in_are_refused(void **state) {
  fixture *f = *state;
  static const struct {
    const char *key, *value, *said;
  } rows[] = {{"output.aovs", "[variance]", "the variance of output.aovs"},
              {"output.aovs", "[cryptomatte]", "the cryptomatte of output.aovs"},
              {"output.deep", "a.exr", "deep pixels"},
              {"render.target_error", "0.1", "a target error"},
              {"render.time_limit", "10 s", "a time limit"}};
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    test_film scene = load(f, sinking_hills);
    set_in(scene, "render.samples", "2");
    set_in(scene, rows[i].key, rows[i].value);
    test_log_clear(&f->log);
    assert_int_not_equal(neph_render_image(scene.scene, NULL, &image), NEPH_OK);
    assert_one_error(&f->log, "render.history does not go with", rows[i].said);
    film_destroy(scene);
  }
  test_film scene = load(f, sinking_hills);
  set_in(scene, "render.history", "none");
  set_in(scene, "render.upsample", "2");
  assert_int_equal(neph_scene_get_render_desc(scene.scene, &desc), NEPH_OK);
  desc.crop_max[0] = 16;
  test_log_clear(&f->log);
  assert_int_not_equal(neph_render_image(scene.scene, &desc, &image), NEPH_OK);
  assert_one_error(&f->log, "render.upsample does not go with a crop or a tile", "set render.upsample to 1");
  film_destroy(scene);
}

/* A frame that is rendered alone takes the time of those before it as well. */
static void a_frame_alone_is_predicted_with_its_run_up(void **state) {
  fixture *f = *state;
  test_film scene = load(f, constant);
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  double seconds[2], next = 0.0;
  assert_int_equal(neph_scene_get_render_desc(scene.scene, &desc), NEPH_OK);
  for (int i = 0; i < 2; i++) {
    desc.frame = i == 0 ? 3 : 9;
    assert_int_equal(neph_render_estimate_time(scene.scene, &desc, &seconds[i], &next), NEPH_OK);
  }
  assert_true(next > 0.0);
  assert_near(seconds[1] - seconds[0], 6.0 * next, 1e-9 * seconds[1]); /* rounding alone */
  film_destroy(scene);
}

static neph_result attempt(neph_context *context, void *user) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_result result = neph_scene_load_text(context, user, "test.yaml", &scene);
  if (!result) result = neph_scene_get_render_desc(scene, &desc);
  desc.frame = 2;
  if (!result) result = neph_render_image(scene, &desc, &image);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  assert_survives_failed_allocations(attempt, (void *)(uintptr_t)constant);
}

static int set_up(void **state) { return set_up_scene(state, 2, constant); }
static int set_up_verbose(void **state) { return set_up_scene_verbose(state, 2, constant); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_constant_sky_stays_constant, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_sky_that_changes_has_no_lag, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_ridge_leaves_no_ghost, set_up, tear_down),
      cmocka_unit_test_setup_teardown(sixteen_frames_renew_every_pixel, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_still_picture_converges, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_cut_takes_nothing_from_before, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_frame_alone_is_that_of_the_sequence, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_frame_alone_is_predicted_with_its_run_up, set_up, tear_down),
      cmocka_unit_test_setup_teardown(frames_before_are_rendered_once, set_up_verbose, tear_down),
      cmocka_unit_test_setup_teardown(pictures_that_cannot_be_filled_in_are_refused, set_up, tear_down),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
