/* SPDX-License-Identifier: Apache-2.0 */
/* Renderers: what pictures share, their callbacks, and cancellation. */
#include "test_scenes.h"

#include <pthread.h>
#include <sched.h>
#include <sys/stat.h>
#include <time.h>

#include <nephos/nephos.h>

#include "core/context_private.h"
#include "plan/plan.h"

static const char landscape[] =
    "{camera: {position: [0, -4 km, 500 m], look_at: [0, 0, 1.3 km], fov: 60 deg, resolution: [53, 29]},"
    " sun: {elevation: 25 deg, azimuth: 220 deg}, terrain: {ridges: {samples: 65, relief: 300 m}},"
    " clouds: [{name: heap, bake: {extent: 3 km, voxel: 100 m, coverage: 0.6}}],"
    " render: {samples: 2, wavelengths: 3}}";

static int set_up(void **state) { return set_up_scene_verbose(state, 2, landscape); }

typedef struct key_value {
  const char *key, *value;
} key_value;

/* All stages in coarse tables and few cells: reuse, by its bits and messages, is that of finer ones. */
static const key_value coarse_keys[] = {{"atmosphere.tolerance", "0.1"},   {"render.light_memory", "0.001 GB"},
                                        {"render.light_degree", "3"},      {"render.light_residual", "0.03"},
                                        {"clouds[0].bake.extent", "2 km"}, {NULL, NULL}};
/* Single scattering: tiles, cancels and calls at the same time do not depend on the light. */
static const key_value plain_keys[] = {
    {"atmosphere.tolerance", "0.1"}, {"render.multiple_scattering", "none"}, {NULL, NULL}};

static void set_keys(neph_scene *scene, const key_value *keys) {
  for (; keys->key; keys++) assert_int_equal(neph_scene_set(scene, keys->key, keys->value), NEPH_OK);
}

static int set_up_coarse(void **state) {
  const int result = set_up(state);
  set_keys(((fixture *)*state)->scene, coarse_keys);
  return result;
}

static int set_up_plain(void **state) {
  const int result = set_up_scene_cached(state, 2, landscape);
  set_keys(((fixture *)*state)->scene, plain_keys);
  return result;
}

static neph_renderer *create(fixture *f) {
  neph_renderer *renderer;
  assert_int_equal(neph_renderer_create(f->context, &renderer), NEPH_OK);
  return renderer;
}

static neph_render_desc describe(fixture *f, int frame) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  desc.frame = frame;
  return desc;
}

static neph_scene *load(fixture *f, const key_value *keys) {
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, landscape, "dir/other.yaml", &scene), NEPH_OK);
  set_keys(scene, keys);
  return scene;
}

static neph_image *render(neph_renderer *renderer, neph_scene *scene, const neph_render_desc *desc) {
  neph_image *image;
  assert_int_equal(neph_renderer_render(renderer, scene, desc, &image), NEPH_OK);
  return image;
}

static void assert_same_bits(neph_context *context, neph_image *ours, neph_image *theirs) {
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(neph_image_compare(context, ours, theirs, &difference), NEPH_OK);
  assert_int_equal(difference.differing_count, 0);
  neph_image_destroy(ours);
  neph_image_destroy(theirs);
}

/* ---- Reuse ---- */

static const char *const shared[] = {"cloud heap: reused", "terrain: reused", "atmosphere: reused",
                                     "camera sky: reused", "cloud sky: reused"};

static bool is_all_kept(const test_log *log) {
  for (size_t i = 0; i < sizeof shared / sizeof *shared; i++)
    if (!strstr(log->text, shared[i])) return false;
  return !strstr(log->text, ": rebuilt") && !strstr(log->text, ": built");
}

static void assert_second_frame_is_that_of_the_scene_alone(fixture *f, const char *integrator) {
  neph_scene *alone = load(f, coarse_keys);
  set(f, "render.integrator", integrator);
  assert_int_equal(neph_scene_set(alone, "render.integrator", integrator), NEPH_OK);
  neph_renderer *renderer = create(f);
  const neph_render_desc first = describe(f, 1), second = describe(f, 2);
  neph_image_destroy(render(renderer, f->scene, &first));
  assert_false(is_all_kept(&f->log));
  test_log_clear(&f->log);
  neph_image *ours = render(renderer, f->scene, &second), *theirs;
  assert_null(strstr(f->log.text, ": rebuilt"));
  assert_null(strstr(f->log.text, ": built"));
  assert_null(strstr(f->log.text, ": solved"));
  assert_null(strstr(f->log.text, ": found"));
  assert_int_equal(neph_render_image(alone, &second, &theirs), NEPH_OK);
  assert_same_bits(f->context, ours, theirs);
  neph_renderer_destroy(renderer);
  neph_scene_destroy(alone);
}

static void a_second_frame_makes_nothing_again_and_is_the_same(void **state) {
  fixture *f = *state;
  assert_second_frame_is_that_of_the_scene_alone(f, "march");
  assert_second_frame_is_that_of_the_scene_alone(f, "path");
}

static void another_scene_shares_what_is_the_same(void **state) {
  fixture *f = *state;
  neph_scene *other = load(f, coarse_keys);
  neph_renderer *renderer = create(f);
  neph_image *first = render(renderer, f->scene, NULL);
  test_log_clear(&f->log);
  neph_image *second = render(renderer, other, NULL);
  assert_true(is_all_kept(&f->log));
  assert_same_bits(f->context, first, second);
  neph_scene_destroy(other);
  neph_image_destroy(render(renderer, f->scene, NULL)); /* outlives a scene that has used it */
  neph_renderer_destroy(renderer);
}

static void what_has_changed_is_made_again(void **state) {
  fixture *f = *state;
  neph_renderer *renderer = create(f);
  neph_image_destroy(render(renderer, f->scene, NULL));
  set(f, "clouds[0].bake.seed", "9");
  test_log_clear(&f->log);
  neph_image_destroy(render(renderer, f->scene, NULL));
  assert_non_null(strstr(f->log.text, "cloud heap: rebuilt"));
  assert_non_null(strstr(f->log.text, "terrain: reused"));
  assert_non_null(strstr(f->log.text, "atmosphere: reused"));
  set(f, "terrain.ridges.relief", "310 m");
  test_log_clear(&f->log);
  neph_image_destroy(render(renderer, f->scene, NULL));
  assert_non_null(strstr(f->log.text, "cloud heap: reused"));
  assert_non_null(strstr(f->log.text, "terrain: rebuilt"));
  neph_renderer_destroy(renderer);
}

/* Two clouds of one file each reuse their volume; a file that was written over is read again. */
static void files_are_read_again_when_they_have_changed(void **state) {
  fixture *f = *state;
  char *folder = test_folder_create(), *path = test_path(folder, "cloud.vdb");
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  char text[512];
  neph_scene *scene;
  cloud.extent_m[0] = cloud.extent_m[1] = 1500;
  cloud.voxel_m = 100;
  assert_int_equal(neph_cloud_bake_file(f->context, &cloud, NULL, "density", path), NEPH_OK);
  (void)snprintf(text, sizeof text,
                 "{camera: {resolution: [8, 6]}, atmosphere: none, environment: {radiance: 1}, clouds: [{name: a, vdb: "
                 "%s, extinction: 1}, {name: b, vdb: %s, extinction: 1, position: [0, 0, 0]}]}",
                 path, path);
  assert_int_equal(neph_scene_load_text(f->context, text, "dir/files.yaml", &scene), NEPH_OK);
  neph_renderer *renderer = create(f);
  neph_image_destroy(render(renderer, scene, NULL));
  test_log_clear(&f->log);
  neph_image_destroy(render(renderer, scene, NULL));
  assert_non_null(strstr(f->log.text, "cloud a: reused"));
  assert_non_null(strstr(f->log.text, "cloud b: reused"));
  cloud.seed = 5;
  assert_int_equal(neph_cloud_bake_file(f->context, &cloud, NULL, "density", path), NEPH_OK);
  test_log_clear(&f->log);
  neph_image_destroy(render(renderer, scene, NULL));
  assert_non_null(strstr(f->log.text, "cloud a: rebuilt"));
  assert_int_equal(remove(path), 0);
  neph_image *image;
  assert_int_equal(neph_renderer_render(renderer, scene, NULL, &image), NEPH_ERROR_NOT_FOUND);
  assert_null(image);
  neph_renderer_destroy(renderer);
  neph_scene_destroy(scene);
  free(path);
  test_folder_destroy(folder);
}

/* ---- Progress, tiles ---- */

typedef struct watch {
  unsigned width, height;
  unsigned char covered[64][64]; /* passes over each pixel */
  float shown[64][64];           /* alpha of the last */
  unsigned pass_count, tile_count;
  bool is_final, is_wrong;
  double fraction, stages; /* the last, and the number of its changes of stage */
  const char *stage;
  bool had_remaining;
  unsigned calls_left; /* after which it cancels; 0: never */
} watch;

static bool see_tile(void *user, const neph_tile *tile) {
  watch *w = user;
  const float *alpha = neph_image_get_values(tile->image, "A");
  w->width = neph_image_get_width(tile->image);
  w->height = neph_image_get_height(tile->image);
  w->is_wrong |= tile->max[0] > w->width || tile->max[1] > w->height || tile->min[0] >= tile->max[0];
  w->is_wrong |= tile->pass_index + 1 < w->pass_count;
  w->pass_count = tile->pass_index + 1;
  w->is_final = tile->is_final;
  w->tile_count++;
  for (unsigned y = tile->min[1]; y < tile->max[1]; y++)
    for (unsigned x = tile->min[0]; x < tile->max[0]; x++) {
      w->is_wrong |= w->covered[y][x] != tile->pass_index;
      w->covered[y][x]++;
      w->shown[y][x] = alpha[y * w->width + x];
    }
  return !w->calls_left || --w->calls_left;
}

static bool see_progress(void *user, const neph_progress *progress) {
  watch *w = user;
  w->is_wrong |= progress->fraction < w->fraction || !(progress->remaining_s >= 0.0) || !progress->stage;
  w->fraction = progress->fraction;
  w->had_remaining |= isfinite(progress->remaining_s);
  if (!w->stage || strcmp(w->stage, progress->stage) != 0) w->stages++;
  w->stage = progress->stage;
  return true;
}

static neph_render_desc describe_watched(fixture *f, watch *w) {
  neph_render_desc desc = describe(f, 1);
  desc.tile = see_tile;
  desc.progress = see_progress;
  desc.tile_user = desc.progress_user = w;
  return desc;
}

static void assert_all_seen(const watch *w, neph_image *image) {
  const float *alpha = neph_image_get_values(image, "A");
  assert_false(w->is_wrong);
  assert_true(w->is_final);
  assert_int_equal(w->width, neph_image_get_width(image));
  for (unsigned y = 0; y < w->height; y++)
    for (unsigned x = 0; x < w->width; x++) {
      assert_int_equal(w->covered[y][x], w->pass_count);
      assert_true(w->shown[y][x] == alpha[y * w->width + x]);
    }
}

static void tiles_cover_each_pixel_once(void **state) {
  fixture *f = *state;
  watch w = {.width = 0};
  neph_render_desc desc = describe_watched(f, &w);
  desc.crop_min[0] = 3;
  desc.crop_min[1] = 2;
  neph_renderer *renderer = create(f);
  neph_image *image = render(renderer, f->scene, &desc), *plain;
  assert_all_seen(&w, image);
  assert_int_equal(w.pass_count, 1);
  assert_true(w.stages >= 3 && w.had_remaining);
  desc.tile = NULL;
  assert_int_equal(neph_render_image(f->scene, &desc, &plain), NEPH_OK);
  assert_same_bits(f->context, image, plain);
  neph_renderer_destroy(renderer);
}

/* Eight samples and more take several passes under a limit that is never reached. */
static void passes_under_a_time_limit_cover_each_pixel_once_each(void **state) {
  fixture *f = *state;
  watch w = {.width = 0};
  neph_render_desc desc = describe_watched(f, &w);
  desc.sample_count = 48;
  desc.time_limit_s = 1000;
  neph_renderer *renderer = create(f);
  neph_image *image = render(renderer, f->scene, &desc), *plain;
  assert_all_seen(&w, image);
  assert_true(w.pass_count >= 3);
  desc.tile = NULL;
  assert_int_equal(neph_render_image(f->scene, &desc, &plain), NEPH_OK);
  assert_same_bits(f->context, image, plain);
  neph_renderer_destroy(renderer);
}

static void a_tile_may_cancel(void **state) {
  fixture *f = *state;
  watch w = {.calls_left = 1};
  neph_render_desc desc = describe_watched(f, &w);
  neph_renderer *renderer = create(f);
  neph_image *image;
  assert_int_equal(neph_renderer_render(renderer, f->scene, &desc, &image), NEPH_ERROR_CANCELLED);
  assert_null(image);
  assert_int_equal(w.tile_count, 1);
  neph_renderer_destroy(renderer);
}

/* Keeps the first row of the first tile, and cancels. */
static bool see_first(void *user, const neph_tile *tile) {
  *(unsigned *)user = tile->min[1];
  return false;
}

static unsigned get_first_row(neph_renderer *renderer, const neph_scene *scene, const neph_render_desc *desc) {
  neph_image *image;
  unsigned row = UINT32_MAX;
  neph_render_desc first = *desc;
  first.tile = see_first;
  first.tile_user = &row;
  first.sample_count = 400; /* a picture that takes long: few of its tiles are delivered at once */
  assert_int_equal(neph_renderer_render(renderer, scene, &first, &image), NEPH_ERROR_CANCELLED);
  return row;
}

static void tiles_may_come_from_a_focus_outwards(void **state) {
  fixture *f = *state;
  watch w = {.width = 0};
  neph_render_desc desc = describe_watched(f, &w);
  neph_renderer *renderer = create(f);
  desc.crop_max[0] = desc.width = 60;
  desc.crop_max[1] = desc.height = 60;
  neph_image *plain = render(renderer, f->scene, &desc);
  assert_true(get_first_row(renderer, f->scene, &desc) < 30);
  assert_int_equal(neph_renderer_set_focus(renderer, 0.5, 1.0), NEPH_OK);
  assert_true(get_first_row(renderer, f->scene, &desc) >= 30);
  w = (watch){.width = 0};
  neph_image *image = render(renderer, f->scene, &desc);
  assert_all_seen(&w, image);
  assert_same_bits(f->context, image, plain);
  assert_int_equal(neph_renderer_set_focus(renderer, NAN, 0.0), NEPH_OK);
  assert_true(get_first_row(renderer, f->scene, &desc) < 30);
  neph_renderer_destroy(renderer);
}

/* ---- Cancelling ---- */

typedef struct canceller {
  neph_renderer *renderer;
  atomic_bool has_begun;
  struct timespec at;
} canceller;

static void *cancel_soon(void *user) {
  canceller *c = user;
  while (!atomic_load(&c->has_begun)) nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
  nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
  clock_gettime(CLOCK_MONOTONIC, &c->at);
  neph_renderer_cancel(c->renderer);
  return NULL;
}

static bool note_begin(void *user, const neph_progress *progress) {
  canceller *c = user;
  (void)progress;
  atomic_store(&c->has_begun, true);
  return true;
}

static void another_thread_cancels_within_half_a_second(void **state) {
  fixture *f = *state;
  canceller c = {.renderer = create(f)};
  neph_render_desc desc = describe(f, 1);
  neph_image *image;
  pthread_t thread;
  struct timespec end;
  desc.sample_count = 1u << 24; /* hours */
  desc.progress = note_begin;
  desc.progress_user = &c;
  assert_int_equal(pthread_create(&thread, NULL, cancel_soon, &c), 0);
  assert_int_equal(neph_renderer_render(c.renderer, f->scene, &desc, &image), NEPH_ERROR_CANCELLED);
  clock_gettime(CLOCK_MONOTONIC, &end);
  pthread_join(thread, NULL);
  assert_null(image);
  assert_true((double)(end.tv_sec - c.at.tv_sec) + 1e-9 * (double)(end.tv_nsec - c.at.tv_nsec) < 0.5);
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 0);
  neph_image_destroy(render(c.renderer, f->scene, NULL)); /* the next is not */
  neph_renderer_destroy(c.renderer);
}

static void a_cancel_before_the_start_ends_the_next_picture_alone(void **state) {
  fixture *f = *state;
  canceller c = {.renderer = create(f)};
  neph_render_desc desc = describe(f, 1);
  neph_image *image;
  desc.sample_count = 1u << 24; /* hours */
  desc.progress = note_begin;
  desc.progress_user = &c;
  neph_renderer_cancel(c.renderer);
  assert_int_equal(neph_renderer_render(c.renderer, f->scene, &desc, &image), NEPH_ERROR_CANCELLED);
  assert_null(image);
  assert_false(atomic_load(&c.has_begun));
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 0);
  neph_image_destroy(render(c.renderer, f->scene, NULL));
  neph_renderer_destroy(c.renderer);
}

typedef struct late_canceller {
  neph_renderer *renderer;
  atomic_uint begun, cancelled; /* numbers of calls */
} late_canceller;

enum { CANCEL_COUNT = 1000 };

/* Cancels each call from 0 to 0.3 ms after its number is known: some cancels come before it, some into it. */
static void *cancel_each(void *user) {
  late_canceller *c = user;
  for (unsigned i = 1; i <= CANCEL_COUNT; i++) {
    while (atomic_load(&c->begun) < i) sched_yield();
    for (volatile unsigned wait = i * 7919 % 1000 * 100; wait; wait--) continue;
    neph_renderer_cancel(c->renderer);
    atomic_store(&c->cancelled, i);
  }
  return NULL;
}

static void no_cancel_around_the_start_of_a_call_is_lost(void **state) {
  fixture *f = *state;
  late_canceller c = {.renderer = create(f)};
  neph_render_desc desc = describe(f, 1);
  pthread_t thread;
  set(f, "terrain", "none");    /* which takes longer to raise than all that the cancels come into */
  desc.sample_count = 1u << 24; /* hours: a cancel that is lost ends by the time limit of the test alone */
  assert_int_equal(pthread_create(&thread, NULL, cancel_each, &c), 0);
  for (unsigned i = 1; i <= CANCEL_COUNT; i++) {
    neph_image *image;
    atomic_store(&c.begun, i);
    assert_int_equal(neph_renderer_render(c.renderer, f->scene, &desc, &image), NEPH_ERROR_CANCELLED);
    while (atomic_load(&c.cancelled) < i) sched_yield();
  }
  pthread_join(thread, NULL);
  neph_image_destroy(render(c.renderer, f->scene, NULL)); /* no cancel is left */
  neph_renderer_destroy(c.renderer);
}

static bool refuse(void *user, const neph_progress *progress) {
  (void)progress;
  ++*(unsigned *)user;
  return false;
}

/* Before anything is baked, loaded or solved. */
static void a_callback_may_cancel_at_once(void **state) {
  fixture *f = *state;
  neph_render_desc desc = describe(f, 1);
  neph_image *image;
  unsigned calls = 0;
  desc.progress = refuse;
  desc.progress_user = &calls;
  test_log_clear(&f->log);
  assert_int_equal(neph_render_image(f->scene, &desc, &image), NEPH_ERROR_CANCELLED);
  assert_null(image);
  assert_int_equal(calls, 1);
  assert_string_equal(f->log.text, "");
}

/* ---- One picture at a time ---- */

typedef struct second_call {
  fixture *f;
  neph_renderer *renderer;
  neph_scene *scene;
  neph_result result;
  unsigned calls;
} second_call;

static void *render_too(void *user) {
  second_call *c = user;
  neph_image *image;
  c->result = neph_renderer_render(c->renderer, c->scene, NULL, &image);
  if (image) c->result = NEPH_OK;
  return NULL;
}

static bool render_on_another_thread(void *user, const neph_progress *progress) {
  second_call *c = user;
  pthread_t thread;
  (void)progress;
  if (c->calls++) return true;
  return !pthread_create(&thread, NULL, render_too, c) && !pthread_join(thread, NULL);
}

static void a_second_picture_at_the_same_time_is_refused(void **state) {
  fixture *f = *state;
  second_call c = {.f = f, .renderer = create(f), .scene = load(f, plain_keys), .result = NEPH_OK};
  neph_render_desc desc = describe(f, 1);
  desc.progress = render_on_another_thread;
  desc.progress_user = &c;
  test_log_clear(&f->log);
  neph_image *first = render(c.renderer, f->scene, &desc), *alone;
  assert_int_equal(c.result, NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "a picture under way", "one at a time");
  assert_int_equal(neph_render_image(c.scene, NULL, &alone), NEPH_OK);
  assert_same_bits(f->context, first, alone);            /* which it did not disturb */
  neph_image_destroy(render(c.renderer, c.scene, NULL)); /* free again */
  neph_scene_destroy(c.scene);
  neph_renderer_destroy(c.renderer);
}

/* ---- Memory ---- */

static neph_memory_estimate estimate(neph_scene *scene, const neph_render_desc *desc) {
  neph_memory_estimate e = NEPH_MEMORY_ESTIMATE_DEFAULT;
  assert_int_equal(neph_render_estimate_memory(scene, desc, &e), NEPH_OK);
  assert_int_equal(e.total_bytes, e.program_bytes + e.terrain_bytes + e.volume_bytes + e.light_bytes + e.film_bytes);
  return e;
}

static void memory_goes_with_the_picture(void **state) {
  fixture *f = *state;
  neph_render_desc desc = describe(f, 1);
  set(f, "clouds[0].detail", "none"); /* its noise has one size */
  const neph_memory_estimate small = estimate(f->scene, &desc);
  desc.width = desc.crop_max[0] = 2 * desc.width;
  const neph_memory_estimate wide = estimate(f->scene, &desc);
  assert_int_equal(wide.film_bytes, 2 * small.film_bytes);
  assert_int_equal(wide.terrain_bytes, small.terrain_bytes);
  set(f, "clouds[0].bake.voxel", "50 m");
  /* Eight times the voxels in a cloud's inside, but four times those along its rim: bricks of finer ones fit closer. */
  const double finer = (double)estimate(f->scene, &desc).volume_bytes / (double)wide.volume_bytes;
  assert_true(finer > 4.0 && finer < 8.0 * (1.0 + 1e-3));
  desc.integrator = NEPH_INTEGRATOR_PATH;
  assert_true(estimate(f->scene, &desc).light_bytes < wide.light_bytes);
  set(f, "terrain", "none");
  assert_int_equal(estimate(f->scene, &desc).terrain_bytes, 0);
}

/* A limit at the estimate changes nothing; one that leaves no room for the solution's coarsest cells refuses the
 * render, and its explanation, before anything is built. */
static void memory_is_limited(void **state) {
  fixture *f = *state;
  neph_render_desc desc = describe(f, 1);
  neph_image *image;
  char *text;
  const neph_memory_estimate e = estimate(f->scene, &desc);
  desc.memory_max_bytes = e.total_bytes;
  assert_int_equal(neph_render_image(f->scene, &desc, &image), NEPH_OK);
  assert_null(neph_image_get_attribute(image, "nephos:memorySavings"));
  neph_image_destroy(image);
  desc.memory_max_bytes = e.total_bytes - e.light_bytes;
  assert_int_equal(neph_render_image(f->scene, &desc, &image), NEPH_ERROR_LIMIT);
  assert_null(image);
  assert_non_null(strstr(f->log.text, "the render needs about"));
  assert_int_equal(neph_render_explain(f->scene, &desc, NEPH_TEXT_PLAIN, &text), NEPH_ERROR_LIMIT);
  assert_null(text);
}

/* A cloud in floats that multiple scattering takes much of the memory of. */
static const char heavy[] = "{camera: {resolution: [64, 36]}, atmosphere: none, environment: {radiance: 1},"
                            " clouds: [{precision: float, bake: {extent: 3 km, voxel: 40 m, model: hero}}],"
                            " render: {samples: 1}}";

typedef struct measured_render {
  neph_memory_estimate estimate;
  double peak_bytes;
  double mean;
  char savings[200];
} measured_render;

/* Uses a separate context, to measure its peak; within `bytes`, 0: unlimited. */
static measured_render measure(uint64_t bytes) {
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(2, &log);
  measured_render out = {.savings = ""};
  neph_scene *scene;
  neph_image *image;
  assert_int_equal(neph_scene_load_text(context, heavy, "dir/scene.yaml", &scene), NEPH_OK);
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  out.estimate = estimate(scene, &desc);
  if (bytes) desc.memory_max_bytes = bytes;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  assert_int_equal(log.counts[NEPH_LOG_WARNING], bytes ? 1 : 0);
  out.peak_bytes = (double)atomic_load(&context->allocated_bytes_peak);
  const char *savings = neph_image_get_attribute(image, "nephos:memorySavings");
  (void)snprintf(out.savings, sizeof out.savings, "%s", savings ? savings : "");
  assert_int_equal(sscanf(neph_image_get_attribute(image, "nephos:mean"), "%lf", &out.mean), 1);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return out;
}

/* Working memory of one bake, which counts as the program's, and is free again when light is solved for. */
static double get_bake_bytes(void) {
  np_cost_counts bake = {.of = {0.0}};
  bake.of[NP_UNIT_BAKE] = 1.0;
  return np_costs_sum(&bake).bytes;
}

/* Bytes that are allocated beside the program's. A prediction is of resident memory, as the limit promises it: vectors
 * of the solution are allocated at once and used in turn, so that about half of the bytes of its cells are resident
 * (docs/results/costs.md). Counted is the whole. */
static double predict_allocated(void) {
  neph_context *context = test_context_create(2, NULL);
  neph_scene *scene;
  np_plan plan;
  np_input_store store = {.references = NULL};
  assert_int_equal(neph_scene_load_text(context, heavy, "dir/scene.yaml", &scene), NEPH_OK);
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_int_equal(np_plan_measure_fill(scene, &plan, &store), NEPH_OK);
  const np_stage_forecast *solution = &plan.forecast.stages[NP_STAGE_ORDINATES];
  const double bytes = np_forecast_sum(&plan.forecast).bytes - get_bake_bytes() - solution->cost.bytes +
                       solution->counts.of[NP_UNIT_CELL_BYTE];
  np_plan_clear(&plan);
  np_input_store_clear(context, &store);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return bytes;
}

/* The library's own memory at its peak is within a factor of 1.3 of what is counted; 0.78 of it was measured. */
static void assert_memory_is_of_the_size_that_is_predicted(const measured_render *whole) {
  const double predicted = predict_allocated();
  print_message("%.3g MB of predicted %.3g MB\n", 1e-6 * whole->peak_bytes, 1e-6 * predicted);
  assert_true(whole->peak_bytes > predicted / 1.3 && whole->peak_bytes < 1.3 * predicted);
}

/* Halves first, whose error is 2^-11; then coarser cells. What is said to be enough is: the peak beside the program's
 * own is within the limit. The picture's mean moves by less than a tenth. */
static void memory_is_saved_where_that_is_enough(void **state) {
  (void)state;
  const measured_render whole = measure(0);
  assert_memory_is_of_the_size_that_is_predicted(&whole);
  const neph_memory_estimate *e = &whole.estimate;
  const measured_render halves = measure(e->total_bytes - e->volume_bytes / 4);
  assert_string_equal(halves.savings, "volumes are kept in halves instead of floats");
  assert_near_relative(halves.mean, whole.mean, 1e-3);
  const uint64_t limit = e->total_bytes - e->volume_bytes / 2 - 2 * e->light_bytes / 5;
  const measured_render coarse = measure(limit);
  assert_non_null(strstr(coarse.savings, "halves"));
  assert_non_null(strstr(coarse.savings, "coarser cells"));
  assert_near_relative(coarse.mean, whole.mean, 0.1);
  print_message("%.3g, %.3g and %.3g MB, limit %.3g MB\n", 1e-6 * whole.peak_bytes, 1e-6 * halves.peak_bytes,
                1e-6 * coarse.peak_bytes, 1e-6 * (double)(limit - e->program_bytes));
  assert_true(halves.peak_bytes < whole.peak_bytes);
  assert_true(coarse.peak_bytes < (double)(limit - e->program_bytes) + get_bake_bytes());
}

/* ---- Failures ---- */

static void a_scene_of_another_context_is_refused(void **state) {
  fixture *f = *state;
  neph_context *other = test_context_create(1, NULL);
  neph_scene *scene;
  neph_image *image = (neph_image *)f; /* anything but NULL */
  neph_renderer *renderer = create(f);
  assert_int_equal(neph_scene_create(other, &scene), NEPH_OK);
  assert_int_equal(neph_renderer_render(renderer, scene, NULL, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(image);
  assert_one_error(&f->log, "the scene belongs to another context than the renderer");
  const neph_render_desc bad = {.struct_size = 4};
  assert_int_equal(neph_renderer_render(renderer, f->scene, &bad, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "neph_render_desc.struct_size is 4");
  neph_scene_destroy(scene);
  neph_renderer_destroy(renderer);
  neph_renderer_destroy(NULL);
  neph_context_destroy(other);
}

static neph_result render_twice(neph_context *context, void *user) {
  neph_scene *scene = NULL;
  neph_renderer *renderer = NULL;
  neph_image *image = NULL;
  watch w = {.width = 0};
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_result result = neph_scene_load_text(context, user, "test.yaml", &scene);
  if (!result) result = neph_renderer_create(context, &renderer);
  if (!result) result = neph_scene_get_render_desc(scene, &desc);
  desc.tile = see_tile;
  desc.tile_user = &w;
  if (!result) result = neph_renderer_render(renderer, scene, &desc, &image);
  neph_image_destroy(image);
  image = NULL;
  desc.tile = NULL;
  if (!result) result = neph_renderer_render(renderer, scene, &desc, &image);
  neph_image_destroy(image);
  neph_renderer_destroy(renderer);
  neph_scene_destroy(scene);
  return result;
}

static void rendering_survives_each_failed_allocation(void **state) {
  (void)state;
  static char scene[] =
      "{camera: {position: [0, 0, 1.2 km], look_at: [1 km, 0, 1.2 km], resolution: [4, 3]}, atmosphere: none,"
      " environment: {radiance: 1}, terrain: {ridges: {samples: 17, ridge: 9 km}},"
      " clouds: [{detail: none, bake: {extent: 400 m, voxel: 100 m, thickness: 300 m}}],"
      " render: {samples: 1, multiple_scattering: none}}"; /* detail fails in test_render */
  assert_survives_failed_allocations(render_twice, scene);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
#define COARSE(name) cmocka_unit_test_setup_teardown(name, set_up_coarse, tear_down)
#define PLAIN(name) cmocka_unit_test_setup_teardown(name, set_up_plain, tear_down)
  const struct CMUnitTest tests[] = {
      COARSE(a_second_frame_makes_nothing_again_and_is_the_same),
      COARSE(another_scene_shares_what_is_the_same),
      COARSE(what_has_changed_is_made_again),
      TEST(files_are_read_again_when_they_have_changed),
      PLAIN(tiles_cover_each_pixel_once),
      PLAIN(passes_under_a_time_limit_cover_each_pixel_once_each),
      PLAIN(a_tile_may_cancel),
      PLAIN(tiles_may_come_from_a_focus_outwards),
      PLAIN(another_thread_cancels_within_half_a_second),
      PLAIN(a_cancel_before_the_start_ends_the_next_picture_alone),
      PLAIN(no_cancel_around_the_start_of_a_call_is_lost),
      PLAIN(a_callback_may_cancel_at_once),
      PLAIN(a_second_picture_at_the_same_time_is_refused),
      TEST(memory_goes_with_the_picture),
      TEST(memory_is_limited),
      cmocka_unit_test(memory_is_saved_where_that_is_enough),
      TEST(a_scene_of_another_context_is_refused),
      cmocka_unit_test(rendering_survives_each_failed_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
