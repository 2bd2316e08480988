/* SPDX-License-Identifier: Apache-2.0 */
/* Detail finer than voxels: bounds that hold whatever is looked up, a mean that is the grid's, tracking without bias,
 * the same bits for any number of threads and instruction set, and what a scene makes of its keys. */
#include <nephos/nephos.h>

#include "core/context_private.h"
#include "core/isa.h"
#include "core/units.h"
#include "plan/plan_detail.h"
#include "scene/scene_private.h"
#include "test_support.h"
#include "volume/brick_detail.h"
#include "volume/detail_voxel.h"
#include "volume/tracking.h"
#include "volume/volume_private.h"

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

enum { EDGE = 48 };

/* A ball of 1 with an edge three voxels wide; or noise of any values. */
static float sample_ball(const int at[3]) {
  float sum = 0.0f;
  for (int a = 0; a < 3; a++) sum += ((float)at[a] - 23.3f) * ((float)at[a] - 23.3f);
  return np_clampf((17.0f - sqrtf(sum)) / 3.0f, 0.0f, 1.0f);
}

static float sample_noise(const int at[3]) {
  np_random random = np_random_start(5, 0, (uint32_t)at[0], (uint32_t)at[1], (uint32_t)at[2]);
  const float value = np_random_float(&random);
  return np_random_float(&random) < 0.5f ? value * value * value : value;
}

static neph_volume *make_volume(neph_context *context, float (*sample)(const int at[3]), bool is_periodic) {
  static float values[EDGE * EDGE * EDGE];
  for (int n = 0; n < EDGE * EDGE * EDGE; n++)
    values[n] = sample((const int[3]){n % EDGE, n / EDGE % EDGE, n / EDGE / EDGE});
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  for (int a = 0; a < 3; a++) desc.size[a] = EDGE;
  desc.values = values;
  desc.is_periodic_x = desc.is_periodic_y = is_periodic;
  neph_volume *volume;
  if (neph_volume_create_dense(context, &desc, &volume)) return NULL;
  return volume;
}

static np_detailed_bricks *add_detail(neph_context *context, const neph_volume *volume, float strength, double size,
                                      uint64_t seed) {
  const np_brick_detail_desc desc = {
      .source = &volume->bricks, .strength = strength, .size_voxels = {size, size, size}, .seed = seed};
  np_detailed_bricks *detailed;
  assert_int_equal(np_detailed_bricks_build(context, &desc, NULL, &detailed), NEPH_OK);
  return detailed;
}

static np_dvec3 draw_place(np_random *random) {
  return np_dvec3_make(EDGE * np_random_double(random), EDGE * np_random_double(random),
                       EDGE * np_random_double(random));
}

/* ---- Values ---- */

static void check_bounds(const np_bricks *bricks, int points, unsigned *changed) {
  np_random random = np_random_start(2, 0, 0, 0, 0);
  for (int n = 0; n < points; n++) {
    const np_dvec3 at = draw_place(&random);
    int32_t cell[3];
    np_vec3 local;
    if (!np_bricks_locate(bricks, at, cell, &local)) continue;
    const np_brick_place place = np_bricks_get_place(bricks, cell);
    const float value = np_bricks_sample(bricks, at);
    for (int level = 0; level < NP_BRICK_LEVELS; level++) {
      const np_brick_range range = np_bricks_get_range(bricks, &place, level);
      if (!(value >= range.min && value <= range.max))
        fail_msg("%g is not in [%g, %g] of level %d", (double)value, (double)range.min, (double)range.max, level);
    }
    const uint32_t brick = np_bricks_get_brick(bricks, &place);
    *changed += brick != NP_BRICK_NONE && value != np_brick_sample(bricks, brick, local);
  }
}

static void majorants_are_never_exceeded(void **state) {
  test_fixture *f = *state;
  static const float strengths[] = {1.0f, 0.3f};
  static const double sizes[] = {0.3, 2.0, 20.0};
  for (int kind = 0; kind < 3; kind++) {
    neph_volume *volume = make_volume(f->context, kind == 0 ? sample_ball : sample_noise, kind == 2);
    assert_non_null(volume);
    for (int n = 0; n < 6; n++) {
      np_detailed_bricks *detailed = add_detail(f->context, volume, strengths[n % 2], sizes[n / 2], 7);
      unsigned changed = 0;
      check_bounds(&detailed->bricks, 40000, &changed);
      assert_true(changed > 2000);
      np_detailed_bricks_destroy(detailed);
    }
    neph_volume_release(volume);
  }
}

/* Detail changes no value by more than the bound of its voxel, which is 0 in most voxels of a ball. */
static void bounds_of_voxels_hold(void **state) {
  test_fixture *f = *state;
  for (int kind = 0; kind < 2; kind++) {
    neph_volume *volume = make_volume(f->context, kind == 0 ? sample_ball : sample_noise, false);
    np_detailed_bricks *detailed = add_detail(f->context, volume, 0.8f, 2.0, 7);
    const np_bricks *bricks = &detailed->bricks;
    np_random random = np_random_start(4, 0, 0, 0, 0);
    int located = 0, unbounded = 0, changed = 0;
    for (int n = 0; n < 40000; n++) {
      int32_t cell[3];
      np_vec3 local;
      if (!np_bricks_locate(bricks, draw_place(&random), cell, &local)) continue;
      const np_brick_place place = np_bricks_get_place(bricks, cell);
      const uint32_t brick = np_bricks_get_brick(bricks, &place);
      if (brick == NP_BRICK_NONE) continue;
      const np_detail_voxel voxel = np_detail_voxel_load(bricks, brick, local);
      const float excess = np_brick_detail_get_excess((np_brick_ref){bricks, brick, cell}, local, 0.0f);
      const float bound = np_detail_voxel_bound(bricks, brick, &voxel);
      assert_true(np_detail_voxel_mix(bricks, &voxel, local) == np_brick_sample(bricks, brick, local));
      if (!(fabsf(excess) <= bound)) fail_msg("%g is beyond %g", (double)excess, (double)bound);
      located++;
      unbounded += bound == 0.0f;
      changed += excess != 0.0f;
    }
    assert_true(changed > 2000);
    print_message("%d of %d places without a bound, %d changed\n", unbounded, located, changed);
    if (kind == 0) assert_true(unbounded > located / 2);
    np_detailed_bricks_destroy(detailed);
    neph_volume_release(volume);
  }
}

/* Cells whose range the detail does not reach keep that of the grid; the others' is at most their c, or v. */
static void majorants_are_tight(void **state) {
  test_fixture *f = *state;
  neph_volume *volume = make_volume(f->context, sample_ball, false);
  np_detailed_bricks *detailed = add_detail(f->context, volume, 1.0f, 2.0, 7);
  for (size_t node = 0; node < volume->bricks.node_count; node++)
    for (int cell = 0; cell < NP_BRICK_NODE_CELLS; cell++) {
      const np_brick_range before = volume->bricks.nodes[node].range[cell],
                           after = detailed->bricks.nodes[node].range[cell];
      assert_true(after.max <= fmaxf(before.max, 0.7f) + 1e-5f);
      if (before.min > 0.71f) assert_true(after.min == before.min && after.max == before.max);
    }
  np_detailed_bricks_destroy(detailed);
  neph_volume_release(volume);
}

/* The mean over seeds of ∫ v′ is ∫ v. A shell of 8000 voxels holds some 1000 billows, and their sum, of a standard
 * deviation below 0.4 each, that of 12 seeds errs by 0.4 %. */
static void mean_is_that_of_the_grid(void **state) {
  test_fixture *f = *state;
  neph_volume *volume = make_volume(f->context, sample_ball, false);
  double plain = 0.0, with = 0.0;
  for (uint64_t seed = 0; seed < 12; seed++) {
    np_detailed_bricks *detailed = add_detail(f->context, volume, 1.0f, 2.0, seed);
    np_random random = np_random_start(seed, 1, 0, 0, 0);
    for (int n = 0; n < 60000; n++) {
      const np_dvec3 at = draw_place(&random);
      const float value = np_bricks_sample(&volume->bricks, at);
      if (!(value > 0.0f && value < 0.7f)) continue;
      plain += (double)value;
      with += (double)np_bricks_sample(&detailed->bricks, at);
    }
    np_detailed_bricks_destroy(detailed);
  }
  print_message("mean of the edge with detail over that without: %.4f\n", with / plain);
  assert_near(with / plain, 1.0, 0.015);
  neph_volume_release(volume);
}

/* Lines leave out what is finer than their footprint, and nothing of what is not. */
static void lines_follow_their_footprint(void **state) {
  test_fixture *f = *state;
  neph_volume *volume = make_volume(f->context, sample_noise, false);
  np_detailed_bricks *detailed = add_detail(f->context, volume, 0.7f, 3.0, 1);
  static const int32_t cell[3] = {2, 1, 3};
  const uint32_t brick = 40;
  const np_vec3 begin = {1.0f, 7.5f, 0.1f}, along = {0.2f, -0.3f, 0.4f};
  float at[NP_BRICK_LINE], out[NP_BRICK_LINE];
  for (int k = 0; k < NP_BRICK_LINE; k++) at[k] = (float)k;
  static const float footprints[] = {0.0f, 1.5f, 2.0f, 3.0f, 9.0f};
  for (int n = 0; n < 5; n++) {
    const float share = np_clampf(2.0f - 2.0f * footprints[n] / 3.0f, 0.0f, 1.0f);
    np_brick_sample_along_indirect((np_brick_ref){&detailed->bricks, brick, cell}, begin, along, footprints[n], at, 16,
                                   out);
    for (int k = 0; k < NP_BRICK_LINE; k++) {
      const np_vec3 place = np_vec3_add(begin, np_vec3_scale(along, at[k]));
      const float plain = np_brick_sample(&detailed->bricks, brick, place),
                  full = np_brick_eval(&detailed->bricks, brick, cell, place);
      assert_near((double)out[k], (double)(plain + share * (full - plain)), 1e-6);
    }
  }
  np_detailed_bricks_destroy(detailed);
  neph_volume_release(volume);
}

/* Faces between bricks, and those of constant cells, show no step. */
static void faces_are_not_seen(void **state) {
  test_fixture *f = *state;
  neph_volume *volume = make_volume(f->context, sample_ball, false);
  np_detailed_bricks *detailed = add_detail(f->context, volume, 1.0f, 4.0, 2);
  np_random random = np_random_start(9, 0, 0, 0, 0);
  const double step = 1e-5;
  for (int n = 0; n < 60000; n++) {
    double at[3];
    for (int a = 0; a < 3; a++) at[a] = EDGE * np_random_double(&random);
    at[n % 3] = 8.0 * floor(at[n % 3] / 8.0) + 8.0;
    double below[3] = {at[0], at[1], at[2]};
    below[n % 3] -= step;
    at[n % 3] += step;
    const float a = np_bricks_sample(&detailed->bricks, np_dvec3_make(at[0], at[1], at[2])),
                b = np_bricks_sample(&detailed->bricks, np_dvec3_make(below[0], below[1], below[2]));
    assert_near((double)a, (double)b, 7e-3); /* √(2t/w) is steep at 0: √(2·2e-5/3/0.15)·0.7 at most */
  }
  np_detailed_bricks_destroy(detailed);
  neph_volume_release(volume);
}

/* Layers that end early give what all of them give. */
static void layers_end_without_a_difference(void **state) {
  test_fixture *f = *state;
  neph_volume *volume = make_volume(f->context, sample_ball, false);
  np_detailed_bricks *detailed = add_detail(f->context, volume, 1.0f, 2.0, 7);
  const np_brick_detail *detail = &detailed->detail;
  np_random random = np_random_start(3, 0, 0, 0, 0);
  int between = 0;
  for (int n = 0; n < 40000; n++) {
    const np_dvec3 place = draw_place(&random);
    const double at[3] = {place.x, place.y, place.z};
    const float edge = np_brick_detail_get_edge(np_random_float(&random), detail->width);
    const float rank = np_brick_detail_get_rank(detail, np_brick_detail_get_noise(detail, at));
    const float all = np_brick_detail_get_step(detail, edge, rank), early = np_brick_detail_select(detail, at, edge);
    assert_near((double)early, (double)all, 1e-5);
    between += all > 0.0f && all < 1.0f;
  }
  assert_in_range(between, 3000, 9000); /* the width of the step is 0.15 */
  np_detailed_bricks_destroy(detailed);
  neph_volume_release(volume);
}

/* ---- Bits ---- */

static bool are_same(const np_detailed_bricks *a, const np_detailed_bricks *b) {
  np_random random = np_random_start(4, 0, 0, 0, 0);
  bool is_same = true;
  for (int n = 0; n < 20000; n++) {
    const np_dvec3 at = draw_place(&random);
    is_same = is_same && np_bricks_sample(&a->bricks, at) == np_bricks_sample(&b->bricks, at);
  }
  return is_same && memcmp(a->bricks.nodes, b->bricks.nodes, a->bricks.node_count * sizeof *a->bricks.nodes) == 0;
}

static void bits_are_those_of_any_threads_and_instructions(void **state) {
  test_fixture *f = *state;
  neph_volume *volume = make_volume(f->context, sample_ball, false);
  np_detailed_bricks *first = add_detail(f->context, volume, 0.8f, 2.0, 3),
                     *other = add_detail(f->context, volume, 0.8f, 2.0, 4);
  assert_false(are_same(first, other));
  np_detailed_bricks_destroy(other);
  for (neph_isa isa = NEPH_ISA_X86_64; isa <= np_isa_detect(); isa++) {
    neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
    neph_context *context;
    desc.thread_count = 1 + (unsigned)isa;
    desc.isa_max = isa;
    assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
    other = add_detail(context, volume, 0.8f, 2.0, 3);
    assert_true(are_same(first, other));
    np_detailed_bricks_destroy(other);
    neph_context_destroy(context);
  }
  np_detailed_bricks_destroy(first);
  neph_volume_release(volume);
}

static neph_result attempt(neph_context *context, void *user) {
  (void)user;
  neph_volume *volume = make_volume(context, sample_ball, false);
  if (!volume) return NEPH_ERROR_OUT_OF_MEMORY;
  const np_brick_detail_desc desc = {
      .source = &volume->bricks, .strength = 1.0f, .size_voxels = {1.0, 1.0, 1.0}, .seed = 1};
  np_detailed_bricks *detailed;
  const neph_result result = np_detailed_bricks_build(context, &desc, NULL, &detailed);
  np_detailed_bricks_destroy(detailed);
  neph_volume_release(volume);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  (void)state;
  assert_survives_failed_allocations(attempt, NULL);
}

/* ---- Tracking ---- */

static double integrate(const np_instance *cloud, np_dvec3 origin, np_vec3 direction) {
  enum { STEPS = 40000 };
  double sum = 0.0;
  for (int k = 0; k < STEPS; k++)
    sum += (double)np_instance_extinction(cloud, np_dvec3_along(origin, direction, 64.0 * (k + 0.5) / STEPS));
  return sum * 64.0 / STEPS;
}

static np_vec3 draw_direction(np_random *random) {
  const float z = np_random_float(random) - 0.5f, turn = 2.0f * NP_PI_F * np_random_float(random);
  return np_vec3_make(sqrtf(1.0f - z * z) * cosf(turn), sqrtf(1.0f - z * z) * sinf(turn), z);
}

/* Transmittances and free flights along rays that graze the ball have the mean that the detailed field integrates to,
 * within 3 standard errors. */
static void tracking_is_unbiased(void **state) {
  enum { RAYS = 12, ESTIMATES = 20000 };
  test_fixture *f = *state;
  neph_volume *volume = make_volume(f->context, sample_ball, false);
  np_detailed_bricks *detailed = add_detail(f->context, volume, 1.0f, 1.5, 8);
  const np_instance cloud = {
      .bricks = &detailed->bricks, .world_to_index = np_affine_identity(), .extinction_per_value = 0.4f};
  const np_instances clouds = {.count = 1, .at = &cloud};
  np_random random = np_random_start(6, 0, 0, 0, 0);
  for (int ray = 0; ray < RAYS; ray++) {
    const np_vec3 direction = draw_direction(&random), side = np_vec3_make(direction.y, -direction.x, 0.0f);
    const np_vec3 aside = np_vec3_scale(side, 1.0f / np_vec3_length(side));
    const np_dvec3 middle = np_dvec3_along(np_dvec3_make(23.3, 23.3, 23.3), aside, 13.0 + 0.4 * ray);
    const np_dvec3 origin = np_dvec3_along(middle, direction, -32.0);
    const double expected = exp(-integrate(&cloud, origin, direction));
    double sum = 0.0, squares = 0.0, passed = 0.0;
    for (int n = 0; n < ESTIMATES; n++) {
      const double t = (double)np_track_transmittance(&clouds, origin, direction, 64.0, 3.0, &random);
      np_flight flight = np_flight_start(np_track_flight(&random), 0.0f);
      const np_instance *hit;
      sum += t;
      squares += t * t;
      passed += isinf(np_track_collision(&clouds, origin, direction, 64.0, &flight, &random, &hit));
    }
    const double mean = sum / ESTIMATES, error = sqrt(fmax(squares / ESTIMATES - mean * mean, 0.0) / ESTIMATES);
    assert_near(mean, expected, 3.0 * error + 1e-4 * expected);
    assert_near(passed / ESTIMATES, expected, 3.0 * sqrt(expected * (1.0 - expected) / ESTIMATES) + 1e-5);
  }
  np_detailed_bricks_destroy(detailed);
  neph_volume_release(volume);
}

/* ---- Pictures ---- */

enum { WIDTH = 32, HEIGHT = 18, PIXELS = WIDTH * HEIGHT };

static const char scene_text[] =
    "version: 1\n"
    "camera: {position: [0 m, -1500 m, 900 m], look_at: [0 m, 0 m, 1300 m], fov: 50 deg, resolution: [32, 18]}\n"
    "sun: {elevation: 30 deg, azimuth: 120 deg}\n"
    "environment: {radiance: 0.02}\n"
    "atmosphere: none\n"
    "terrain: none\n"
    "clouds: [{bake: {extent: 700 m, model: hero, base: 1000 m, thickness: 600 m, voxel: 40 m}}]\n"
    "render: {samples: 4, light_memory: 0.002 GB}\n";

typedef struct picture {
  float y[PIXELS];
} picture;

static void render(test_fixture *f, const char *integrator, const char *samples, const char *detail, picture *out) {
  neph_scene *scene;
  neph_image *image;
  assert_int_equal(neph_scene_load_text(f->context, scene_text, NULL, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.samples", samples), NEPH_OK);
  if (neph_scene_set(scene, "clouds[0].detail", detail)) fail_msg("%s", f->log.text);
  if (neph_render_image(scene, NULL, &image)) fail_msg("%s", f->log.text);
  memcpy(out->y, neph_image_get_channel(image, "G"), sizeof out->y);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

static double sum_pixels(const picture *p) {
  double sum = 0.0;
  for (int n = 0; n < PIXELS; n++) {
    assert_true(isfinite(p->y[n]));
    sum += (double)p->y[n];
  }
  return sum;
}

static void pictures_follow_the_keys(void **state) {
  test_fixture *f = *state;
  static const char *const integrators[] = {"march", "path"};
  for (int i = 0; i < 2; i++) {
    picture none, zero, some, again, other;
    render(f, integrators[i], "4", "none", &none);
    render(f, integrators[i], "4", "{strength: 0, size: 20 m}", &zero);
    render(f, integrators[i], "4", "{strength: 0.8, size: 30 m, seed: 1}", &some);
    render(f, integrators[i], "4", "{strength: 0.8, size: 30 m, seed: 1}", &again);
    render(f, integrators[i], "4", "{strength: 0.8, size: 30 m, seed: 2}", &other);
    assert_memory_equal(&none, &zero, sizeof none);
    assert_memory_equal(&some, &again, sizeof some);
    assert_memory_not_equal(&some, &none, sizeof some);
    assert_memory_not_equal(&some, &other, sizeof some);
    (void)sum_pixels(&some);
  }
}

/* The march is as close to the path tracer's mean as without detail, except that light tables ignore detail. */
static void march_is_close_to_path(void **state) {
  test_fixture *f = *state;
  static const char *const details[] = {"none", "{strength: 1, size: 40 m}"};
  double ratio[2];
  for (int n = 0; n < 2; n++) {
    picture march, path;
    render(f, "march", "16", details[n], &march);
    render(f, "path", "96", details[n], &path);
    ratio[n] = sum_pixels(&march) / sum_pixels(&path);
  }
  print_message("march over path: %.4f, with detail %.4f\n", ratio[0], ratio[1]);
  assert_near(ratio[1], ratio[0], 0.03);
}

static void bad_values_are_refused(void **state) {
  test_fixture *f = *state;
  static const char *const bad[][2] = {
      {"strength", "-0.1"}, {"strength", "1.01"}, {"size", "0 m"}, {"size", "-3 m"}, {"seed", "-1"}};
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, scene_text, NULL, &scene), NEPH_OK);
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
    char key[64];
    snprintf(key, sizeof key, "clouds[0].detail.%s", bad[n][0]);
    if (!neph_scene_set(scene, key, bad[n][1])) fail_msg("%s: %s is taken", key, bad[n][1]);
    assert_one_error(&f->log, key);
  }
  neph_scene_destroy(scene);
}

/* ---- Detail where voxels are seen ---- */

/* A lens narrow enough for a voxel to cover three pixels, and one so wide that it covers less than one. */
static const char narrow[] = "20 deg", wide[] = "90 deg";

/* `detail` NULL: the default. */
static void render_lens(test_fixture *f, const char *integrator, const char *quality, const char *fov,
                        const char *detail, picture *out) {
  neph_scene *scene;
  neph_image *image;
  assert_int_equal(neph_scene_load_text(f->context, scene_text, NULL, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.quality", quality), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "camera.fov", fov), NEPH_OK);
  if (detail && neph_scene_set(scene, "clouds[0].detail", detail)) fail_msg("%s", f->log.text);
  if (neph_render_image(scene, NULL, &image)) fail_msg("%s", f->log.text);
  memcpy(out->y, neph_image_get_channel(image, "G"), sizeof out->y);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

/* Automatic detail, the default of bakes, comes where voxels are seen, in final pictures. Elsewhere a cloud has the
 * bits of none. */
static void detail_comes_where_voxels_are_seen(void **state) {
  test_fixture *f = *state;
  static const char *const integrators[] = {"march", "path"};
  for (int i = 0; i < 2; i++) {
    picture none, seen, unset;
    render_lens(f, integrators[i], "final", narrow, "none", &none);
    render_lens(f, integrators[i], "final", narrow, "auto", &seen);
    render_lens(f, integrators[i], "final", narrow, NULL, &unset);
    assert_memory_not_equal(&seen, &none, sizeof none);
    assert_memory_equal(&unset, &seen, sizeof none);
    assert_near_relative(sum_pixels(&seen), sum_pixels(&none), 0.1);
    render_lens(f, integrators[i], "final", wide, "none", &none);
    render_lens(f, integrators[i], "final", wide, NULL, &unset);
    assert_memory_equal(&unset, &none, sizeof none);
    render_lens(f, integrators[i], "preview", narrow, "none", &none);
    render_lens(f, integrators[i], "preview", narrow, NULL, &unset);
    assert_memory_equal(&unset, &none, sizeof none);
  }
}

/* Strength of the detail of a near cloud that leaves it to the default. */
static double get_default_strength(test_fixture *f, const char *text) {
  const np_request request = {.desc = {.width = 960, .height = 540}};
  neph_scene *scene;
  if (neph_scene_load_text(f->context, text, NULL, &scene)) fail_msg("%s", f->log.text);
  const np_dvec3 low = {-100.0, -1450.0, 800.0}, high = {100.0, -1300.0, 1000.0};
  const double strength = np_plan_get_fine_detail(&request, scene, &scene->clouds[0], 40.0, low, high).strength;
  neph_scene_destroy(scene);
  return strength;
}

/* Bakes with billows have automatic detail by default, unless their interpolation is nearest. Files have none. */
static void bakes_with_billows_have_detail_by_default(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *cloud;
    double strength;
  } cases[] = {{"{bake: {model: hero, voxel: 40 m}}", 0.8},
               {"{bake: {model: thermals, voxel: 40 m}}", 0.8},
               {"{bake: {model: cells, voxel: 40 m}}", 0.8},
               {"{bake: {model: deck, voxel: 40 m}}", 0.8},
               {"{bake: {model: fog, voxel: 40 m}}", 0.0},
               {"{bake: {model: lenses, voxel: 40 m}}", 0.0},
               {"{bake: {model: hero, voxel: 40 m}, interpolation: nearest}", 0.0},
               {"{bake: {model: hero, voxel: 40 m}, detail: none, interpolation: nearest}", 0.0},
               {"{vdb: ball.vdb, extinction: 1 1/m}", 0.0},
               {"{vdb: ball.vdb, extinction: 1 1/m, detail: auto}", 0.8}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char text[512];
    (void)snprintf(text, sizeof text,
                   "version: 1\ncamera: {position: [0 m, -1500 m, 900 m], look_at: [0 m, 0 m, 900 m], fov: 50 deg}\n"
                   "clouds: [%s]\n",
                   cases[n].cloud);
    assert_near(get_default_strength(f, text), cases[n].strength, 1e-9);
  }
}

/* Strength of a cloud's detail, seen from a distance. */
static double get_strength(const neph_scene *scene, double distance_m) {
  const np_request request = {.desc = {.width = 960, .height = 540}};
  const np_dvec3 low = {-100.0, distance_m, -100.0}, high = {100.0, distance_m + 200.0, 100.0};
  return np_plan_get_fine_detail(&request, scene, &scene->clouds[0], 40.0, low, high).strength;
}

/* All of it within three pixels a voxel, nothing from one and a half on, and no step between. */
static void strength_goes_by_pixels_without_a_step(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, scene_text, NULL, &scene), NEPH_OK);
  for (int a = 0; a < 3; a++) scene->camera.position_m[a] = 0.0;
  const double pixel_rad = np_scene_camera_get_pixel_rad(&scene->camera, 960, 540), most = 0.8;
  assert_near(get_strength(scene, 0.0), most, 1e-9);
  assert_near(get_strength(scene, 40.0 / (3.01 * pixel_rad)), most, 1e-9);
  assert_near(get_strength(scene, 40.0 / (2.25 * pixel_rad)), 0.5 * most, 1e-9);
  assert_near(get_strength(scene, 40.0 / (1.49 * pixel_rad)), 0.0, 1e-9);
  double before = most;
  for (double pixels = 3.2; pixels > 1.4; pixels -= 0.01) {
    const double strength = get_strength(scene, 40.0 / (pixels * pixel_rad));
    assert_true(strength <= before + 1e-9 && strength > before - 0.01);
    before = strength;
  }
  neph_scene_destroy(scene);
}

/* A placement's members are the keys. */
static void placements_have_detail(void **state) {
  test_fixture *f = *state;
  neph_volume *volume = make_volume(f->context, sample_ball, false);
  neph_placement_desc desc = NEPH_PLACEMENT_DESC_DEFAULT;
  neph_scene *scene;
  char text[64];
  desc.detail_strength = 0.25;
  desc.detail_size_m = 1.5;
  desc.detail_seed = UINT64_C(12345678901234567890);
  assert_int_equal(neph_scene_create(f->context, &scene), NEPH_OK);
  assert_int_equal(neph_scene_add_volume(scene, volume, &desc, NULL), NEPH_OK);
  assert_near(scene->clouds[0].detail.strength, 0.25, 0.0);
  assert_near(scene->clouds[0].detail.size_m, 1.5, 0.0);
  assert_true(scene->clouds[0].detail.seed == desc.detail_seed);
  desc.detail_strength = 1.5;
  assert_int_not_equal(neph_scene_set_placement(scene, 0, &desc), NEPH_OK);
  snprintf(text, sizeof text, "detail.strength");
  assert_one_error(&f->log, text);
  desc.detail_strength = 0.5;
  desc.detail_size_m = -1.0;
  assert_int_not_equal(neph_scene_set_placement(scene, 0, &desc), NEPH_OK);
  assert_one_error(&f->log, "detail.size");
  neph_volume_release(volume);
  neph_scene_destroy(scene);
}

/* ---- Files ---- */

/* Mean and memory of a picture of a ball from a file, of voxels of 20 m, `detail` NULL: as it is. */
static double render_file(test_fixture *f, const char *integrator, const char *detail, neph_memory_estimate *out) {
  neph_scene *scene;
  neph_image *image;
  double mean;
  char text[1024];
  (void)snprintf(text, sizeof text,
                 "version: 1\n"
                 "camera: {position: [0 m, -1500 m, 300 m], look_at: [0 m, 0 m, 300 m], fov: 30 deg, "
                 "resolution: [32, 18]}\n"
                 "sun: {elevation: 30 deg, azimuth: 120 deg}\n"
                 "environment: {radiance: 0.02}\n"
                 "atmosphere: none\n"
                 "clouds: [{name: ball, vdb: %s, voxel: 20 m, position: [0, 0, 0], optical_depth: 10}]\n"
                 "render: {samples: 16, light_memory: 0.002 GB, integrator: %s}\n",
                 f->path, integrator);
  assert_int_equal(neph_scene_load_text(f->context, text, NULL, &scene), NEPH_OK);
  if (detail && neph_scene_set(scene, "clouds[0].detail", detail)) fail_msg("%s", f->log.text);
  *out = (neph_memory_estimate)NEPH_MEMORY_ESTIMATE_DEFAULT;
  assert_int_equal(neph_render_estimate_memory(scene, NULL, out), NEPH_OK);
  test_log_clear(&f->log);
  if (neph_render_image(scene, NULL, &image)) fail_msg("%s", f->log.text);
  assert_int_equal(sscanf(neph_image_get_attribute(image, "nephos:mean"), "%lf", &mean), 1);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return mean;
}

/* Density that falls from the middle of a ball of 16 voxels to its rim. */
static void write_ball(test_fixture *f) {
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(f->context, "density", &grid), NEPH_OK);
  for (int n = 0; n < 64; n++) {
    const int32_t origin[3] = {8 * (n / 16) - 16, 8 * (n / 4 % 4) - 16, 8 * (n % 4) - 16};
    np_leaf *leaf = np_sparse_grid_add_leaf(&grid, origin);
    for (int i = 0; i < NP_LEAF_SIZE; i++) {
      const float x = (float)(origin[0] + i / 64), y = (float)(origin[1] + i / 8 % 8), z = (float)(origin[2] + i % 8);
      leaf->values[i] = np_clampf((14.0f - sqrtf(x * x + y * y + z * z)) / 4.0f, 0.0f, 1.0f);
      leaf->active[i / 64] |= (uint64_t)(leaf->values[i] > 0.0f) << i % 64;
    }
  }
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(f->context, f->path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

/* An import has detail in both integrators. It keeps the mean of matter, of which the mean of the picture, of billows
 * as of a smooth ball, is some per cent off. The plan counts its noise, of 0.75 MB. Billows of a quarter of a voxel are
 * warned of, with both sizes; of two voxels, as by default, they are not. */
static void an_import_has_detail(void **state) {
  test_fixture *f = *state;
  static const char *const integrators[] = {"march", "path"};
  neph_memory_estimate none, some;
  write_ball(f);
  for (int i = 0; i < 2; i++) {
    const double smooth = render_file(f, integrators[i], NULL, &none);
    assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 0);
    const double billowed = render_file(f, integrators[i], "{strength: 0.8, seed: 1}", &some);
    assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 0);
    print_message("%-5s %.5g, with detail %.5g, of %llu bytes more\n", integrators[i], smooth, billowed,
                  (unsigned long long)(some.volume_bytes - none.volume_bytes));
    assert_true(billowed != smooth);
    assert_near_relative(billowed, smooth, 0.1);
    assert_in_range(some.volume_bytes - none.volume_bytes, 750000, 1500000);
    (void)render_file(f, integrators[i], "{size: 5 m}", &some);
    assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 1);
    assert_non_null(strstr(f->log.text, "cloud ball: detail.size is 5 m, and its voxels are 20 m: below 10 m"));
  }
}

/* Detail leaves the light as it is, which the pictures of one cloud share by a cache. */
static int set_up_pictures(void **state) { return test_set_up_cached(state, 2, NULL); }

static int set_up_file(void **state) { return test_set_up(state, 2, "ball.vdb"); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(majorants_are_never_exceeded, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(majorants_are_tight, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(bounds_of_voxels_hold, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(mean_is_that_of_the_grid, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(lines_follow_their_footprint, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(faces_are_not_seen, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(layers_end_without_a_difference, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(bits_are_those_of_any_threads_and_instructions, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(failed_allocations_leave_nothing, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(tracking_is_unbiased, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(pictures_follow_the_keys, set_up_pictures, test_tear_down),
      cmocka_unit_test_setup_teardown(march_is_close_to_path, set_up_pictures, test_tear_down),
      cmocka_unit_test_setup_teardown(an_import_has_detail, set_up_file, test_tear_down),
      cmocka_unit_test_setup_teardown(detail_comes_where_voxels_are_seen, set_up_pictures, test_tear_down),
      cmocka_unit_test_setup_teardown(bakes_with_billows_have_detail_by_default, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(strength_goes_by_pixels_without_a_step, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(bad_values_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(placements_have_detail, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
