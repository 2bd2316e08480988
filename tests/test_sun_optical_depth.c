/* SPDX-License-Identifier: Apache-2.0 */
/* The sun optical-depth volume: exact where depth is linear, within its tolerance elsewhere, the same as walking from
 * outside; what it costs; that it fails cleanly; and what pictures of a dense cloud are wrong by with it. */
#include "test_world.h"

#include <nephos/image.h>
#include <nephos/render.h>
#include <nephos/scene.h>

enum { EDGE = 40 };

typedef struct fixture {
  test_world base;
  np_sun_optical_depth_desc desc;
  np_sun_optical_depth cache;
} fixture;

static float lump(double x, double y, double z) {
  const double edge = 300.0 - x * x - y * y - z * z;
  return edge > 0.0 ? (float)(fmin(edge, 100.0) / 100.0 * (1.0 + 0.5 * sin(0.5 * x) * cos(0.5 * y + 0.4 * z))) : 0.0f;
}

static float block(double x, double y, double z) { return fmax(fabs(x), fmax(fabs(y), fabs(z))) < 12.0 ? 1.0f : 0.0f; }

/* EDGE³ samples at whole metres, from x = `first_m` and the origin on. */
static neph_result add(fixture *f, test_field field, double first_m) {
  test_cloud cloud = test_cloud_make(field, 0.2f, np_phase_isotropic());
  const double middle = 0.5 * (EDGE - 1);
  cloud.edge = EDGE;
  cloud.middle_m = np_dvec3_make(first_m + middle, middle, middle);
  return test_world_add(&f->base, cloud);
}

static neph_result create(fixture *f, neph_context *context, test_field field) {
  *f = (fixture){.desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT};
  test_world_init(&f->base, context);
  f->base.world.to_sun = np_vec3_make(0.6f, 0.0f, 0.8f);
  return add(f, field, 0.0);
}

static void start(fixture *f, unsigned threads, test_field field) {
  assert_int_equal(create(f, test_context_create(threads, NULL), field), NEPH_OK);
}

static void build(fixture *f) {
  np_sun_optical_depth_clear(&f->cache);
  assert_int_equal(np_sun_optical_depth_build(f->base.context, &f->base.world, &f->desc, NULL, &f->cache), NEPH_OK);
}

static void end(fixture *f) {
  np_sun_optical_depth_clear(&f->cache);
  test_world_destroy(&f->base);
}

static float walk(const fixture *f, np_dvec3 position, np_vec3 to_sun) {
  const np_sun_optical_depths depths = {.clouds = &f->base.world.clouds};
  return np_sun_optical_depths_get(&depths, position, to_sun, 100.0f);
}

static float look_up(const fixture *f, np_dvec3 position, np_vec3 to_sun) {
  const np_sun_optical_depths depths = {.clouds = &f->base.world.clouds, .cache = &f->cache};
  return np_sun_optical_depths_get(&depths, position, to_sun, 100.0f);
}

static np_dvec3 draw_place(np_random *random, double low, double high) {
  const double x = np_random_double(random), y = np_random_double(random), z = np_random_double(random);
  return np_dvec3_make(low + (high - low) * x, low + (high - low) * y, low + (high - low) * z);
}

/* Root mean square of the error in light over places in the cloud. */
static double measure_error(const fixture *f) {
  np_random random = np_random_start(1, 2, 3, 4, 5);
  double squares = 0.0;
  int count = 0;
  while (count < 20000) {
    const np_dvec3 place = draw_place(&random, 0, EDGE - 1);
    if (!(np_instance_extinction(&f->base.placed[0], place) > 0.0f)) continue;
    const double light = (double)np_transmittance(walk(f, place, f->base.world.to_sun));
    const double error = (double)np_transmittance(look_up(f, place, f->base.world.to_sun)) - light;
    squares += error * error;
    count++;
  }
  return sqrt(squares / count);
}

/* Inside a homogeneous block, two metres off its faces, the depth is its extinction times the way out, to sums of
 * floats. Cells at the lit face, from 24 to 32 m, keep the straight line through their ends. A cell's second
 * difference is the mean over three axes, and here only one axis has any: √3 times the tolerance in the middle; at 29 m
 * the line is 5/4 as far off, and the light e^0.2 as bright: 2.65 times. Elsewhere nodes are halves, whose relative
 * error of 2⁻¹² is at most 2⁻¹²/e of the light: 9e-5. From outside, where nothing is interpolated along the ray, 1e-3.
 */
static void depth_of_a_block_is_its_length(void **state) {
  (void)state;
  fixture f;
  start(&f, 2, block);
  f.base.world.to_sun = np_vec3_make(0, 0, 1);
  build(&f);
  np_random random = np_random_start(1, 2, 3, 4, 5);
  for (int n = 0; n < 1000; n++) {
    const np_dvec3 place =
        np_dvec3_make(10.0 + 19.0 * np_random_double(&random), 19.5, 10.0 + 19.0 * np_random_double(&random));
    assert_near((double)np_transmittance(look_up(&f, place, f.base.world.to_sun)), exp(-0.2 * (31.5 - place.z)),
                place.z < 24.0 ? 9e-5 : 2.65 * (double)f.desc.tolerance);
  }
  assert_near((double)look_up(&f, np_dvec3_make(19.5, 19.5, -1e5), f.base.world.to_sun), 0.2 * 24.0, 1e-3);
  assert_near((double)look_up(&f, np_dvec3_make(19.5, 19.5, 50.0), f.base.world.to_sun), 0.0, 0.0);
  assert_near((double)look_up(&f, np_dvec3_make(-100.0, 19.5, -10.0), f.base.world.to_sun), 0.0, 0.0);
  end(&f);
}

/* The sun is high, low, level and below the horizon: rms within the tolerance. */
static void light_is_right_within_the_tolerance(void **state) {
  (void)state;
  static const np_vec3 suns[] = {{0, 0, 1}, {0.6f, 0, 0.8f}, {-0.7f, 0.7f, 0.1f}, {0, 1, 0}, {0.48f, -0.64f, -0.6f}};
  fixture f;
  start(&f, 2, lump);
  for (size_t s = 0; s < sizeof suns / sizeof *suns; s++) {
    f.base.world.to_sun = np_vec3_normalize(suns[s]);
    build(&f);
    const double error = measure_error(&f);
    if (!(error <= (double)f.desc.tolerance)) fail_msg("sun %zu: rms error of light %g", s, error);
  }
  end(&f);
}

/* Nodes a voxel apart miss three times the tolerance in steep cells; half as far apart a quarter of that, so that all
 * cells but a few need no walk. Where they do not fit the memory the cells stay steep. */
static void steep_cells_keep_finer_nodes(void **state) {
  (void)state;
  fixture f;
  start(&f, 2, lump);
  f.desc.tolerance = 0.003f;
  build(&f);
  const uint64_t fine = f.cache.level_cells[0], left = f.cache.steep_cells;
  assert_true(fine > 5 * left);
  const double error = measure_error(&f);
  if (!(error <= (double)f.desc.tolerance)) fail_msg("rms error of light %g", error);
  f.desc.bytes_max = f.cache.bytes - 1;
  build(&f);
  assert_int_equal(f.cache.level_cells[0], 0);
  assert_int_equal(f.cache.steep_cells, fine + left);
  end(&f);
}

static void a_smaller_tolerance_costs_memory_and_buys_light(void **state) {
  (void)state;
  fixture f;
  start(&f, 2, lump);
  f.desc.tolerance = 0.1f;
  build(&f);
  const double coarse = measure_error(&f);
  const size_t coarse_bytes = f.cache.bytes;
  f.desc.tolerance = 0.003f;
  build(&f);
  assert_true(measure_error(&f) < 0.3 * coarse);
  assert_true(f.cache.bytes > coarse_bytes);
  f.desc.bytes_max = 20000;
  build(&f);
  assert_in_range(f.cache.bytes, 1, f.desc.bytes_max);
  end(&f);
}

/* Rays start outside, like from a hill or the ground. A ray must give the same as a walk, within the interpolation
 * error at its entry. Towards the rim of a disk of 0.26 degrees, which a ray from 1 km away passes 4 m beside the
 * centre, everything but the change of direction inside the cloud, 0.16 m over its breadth, must be included; a ray
 * towards the centre would be wrong by 0.07 rms. */
static void from_outside_the_ray_enters_where_it_should(void **state) {
  (void)state;
  fixture f;
  start(&f, 2, lump);
  f.desc.tolerance = 0.003f;
  build(&f);
  const np_vec3 rim = np_vec3_normalize(np_vec3_make(0.602f, 0.003f, 0.8f));
  np_random random = np_random_start(1, 2, 3, 4, 5);
  double worst = 0.0, squares = 0.0;
  for (int n = 0; n < 5000; n++) {
    np_dvec3 place = draw_place(&random, 0, EDGE - 1);
    place = np_dvec3_along(place, f.base.world.to_sun, -1000.0);
    worst = fmax(worst, fabs((double)(np_transmittance(look_up(&f, place, f.base.world.to_sun)) -
                                      np_transmittance(walk(&f, place, f.base.world.to_sun)))));
    const double error = (double)(np_transmittance(look_up(&f, place, rim)) - np_transmittance(walk(&f, place, rim)));
    squares += error * error;
  }
  assert_true(worst < 0.03);
  assert_true(sqrt(squares / 5000) < 0.01);
  end(&f);
}

static void depths_of_clouds_add_up(void **state) {
  (void)state;
  fixture f;
  start(&f, 2, lump);
  assert_int_equal(add(&f, lump, 25.0), NEPH_OK);
  f.desc.tolerance = 0.003f;
  build(&f);
  np_random random = np_random_start(1, 2, 3, 4, 5);
  double squares = 0.0;
  for (int n = 0; n < 5000; n++) {
    const np_dvec3 place = draw_place(&random, 0, EDGE - 1);
    const double error = (double)(np_transmittance(look_up(&f, place, f.base.world.to_sun)) -
                                  np_transmittance(walk(&f, place, f.base.world.to_sun)));
    squares += error * error;
  }
  assert_true(sqrt(squares / 5000) < 2.0 * (double)f.desc.tolerance);
  end(&f);
}

static void threads_change_no_bit(void **state) {
  (void)state;
  fixture one, two;
  start(&one, 1, lump);
  start(&two, 3, lump);
  build(&one);
  build(&two);
  assert_int_equal(one.cache.bytes, two.cache.bytes);
  np_random random = np_random_start(1, 2, 3, 4, 5);
  for (int n = 0; n < 5000; n++) {
    const np_dvec3 place = draw_place(&random, -5, EDGE + 5);
    const float a = look_up(&one, place, one.base.world.to_sun), b = look_up(&two, place, two.base.world.to_sun);
    assert_memory_equal(&a, &b, sizeof a);
  }
  end(&one);
  end(&two);
}

static void cancelling_leaves_nothing(void **state) {
  (void)state;
  fixture f;
  start(&f, 2, lump);
  np_monitor monitor;
  np_monitor_start(&monitor, f.base.context, NULL, NULL);
  atomic_store(&monitor.is_cancelled, true);
  assert_int_equal(np_sun_optical_depth_build(f.base.context, &f.base.world, &f.desc, &monitor, &f.cache),
                   NEPH_ERROR_CANCELLED);
  assert_null(f.cache.lattices);
  end(&f);
}

static neph_result attempt(neph_context *context, void *user) {
  fixture *f = user;
  neph_result result = create(f, context, block);
  if (!result) result = np_sun_optical_depth_build(context, &f->base.world, &f->desc, NULL, &f->cache);
  np_sun_optical_depth_clear(&f->cache);
  test_world_clear(&f->base);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  fixture f;
  assert_survives_failed_allocations(attempt, &f);
}

/* ---- Pictures ---- */

static neph_image *render(neph_context *context, const char *cloud, double depth, double azimuth_deg,
                          const char *sun_optical_depth) {
  char text[1024];
  snprintf(text, sizeof text,
           "camera: {position: [0 m, -6 km, 1800 m], look_at: [0, 0, 2400 m], fov: 40 deg, resolution: [112, 64]}\n"
           "sun: {elevation: 30 deg, azimuth: %g deg, angular_radius: 0}\n"
           "environment: {planet: none}\n"
           "clouds: [{vdb: \"%s\", up: y, voxel: 20 m, optical_depth: %g, position: [0, 0, 1400 m], albedo: 1,\n"
           "          phase: {hg: 0.85}}]\n"
           "render: {samples: 4, multiple_scattering: none, sun_optical_depth: %s}\n",
           azimuth_deg, cloud, depth, sun_optical_depth);
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  assert_int_equal(neph_scene_load_text(context, text, "scene.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

/* Sunlight scattered once in the Disney cloud, whose voxels are up to 0.9 and 3.4 thick, front and back lit: the case
 * that the volume is for. Both pictures have the same rays, so that the difference is the volume's alone. With light
 * scattered more than once it is a third of this. */
static void pictures_are_right_front_and_back_lit(void **state) {
  (void)state;
  char *cloud = test_data_path("vdb/wdas_cloud_sixteenth.vdb");
  neph_context *context = test_context_create(2, NULL);
  static const double depths[] = {40, 150}, azimuths[] = {130, 20};
  for (int n = 0; n < 4; n++) {
    neph_image *volume = render(context, cloud, depths[n / 2], azimuths[n % 2], "volume");
    neph_image *march = render(context, cloud, depths[n / 2], azimuths[n % 2], "march");
    neph_image_difference d = NEPH_IMAGE_DIFFERENCE_DEFAULT;
    assert_int_equal(neph_image_compare(context, volume, march, &d), NEPH_OK);
    if (!(fabs(d.bias) <= 0.01 && d.block_rms <= 0.015))
      fail_msg("depth %g, azimuth %g: bias %g, block rms %g", depths[n / 2], azimuths[n % 2], d.bias, d.block_rms);
    neph_image_destroy(volume);
    neph_image_destroy(march);
  }
  neph_context_destroy(context);
  free(cloud);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(depth_of_a_block_is_its_length),
      cmocka_unit_test(light_is_right_within_the_tolerance),
      cmocka_unit_test(steep_cells_keep_finer_nodes),
      cmocka_unit_test(a_smaller_tolerance_costs_memory_and_buys_light),
      cmocka_unit_test(from_outside_the_ray_enters_where_it_should),
      cmocka_unit_test(depths_of_clouds_add_up),
      cmocka_unit_test(threads_change_no_bit),
      cmocka_unit_test(cancelling_leaves_nothing),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
      cmocka_unit_test(pictures_are_right_front_and_back_lit),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
