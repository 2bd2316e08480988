/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds of files that repeat without end, against the same file copied 3 × 3; and nearest samples. */
#include "test_scenes.h"

#include <stdlib.h>

#include "volume/tracking.h"
#include "volume/volume_private.h"

/* ---- Files ---- */

/* A field of lumps, no two voxels alike, with gaps; neither side is a multiple of 8. */
enum { WIDTH = 20, DEPTH = 12, HEIGHT = 9, VOXELS = WIDTH * DEPTH * HEIGHT };

static const int32_t first_voxel[3] = {-5, 3, 2};
static const double voxel_m = 25.0;

static float get_value(int i, int j, int k) {
  const double lump = sin(2.0 * NP_PI * (i / (double)WIDTH)) * cos(2.0 * NP_PI * (j / (double)DEPTH) + 0.4 * k);
  np_random random = np_random_start(7, (uint32_t)i, (uint32_t)j, (uint32_t)k, 0);
  return lump < -0.6 ? 0.0f : (float)(0.6 + 0.3 * lump) * (0.5f + np_random_float(&random));
}

/* Writes `copies`² copies of the field side by side, around the one that stands where a single one does. */
static void write_field(neph_context *context, const char *path, int copies) {
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(context, "density", &grid), NEPH_OK);
  for (int a = 0; a < 3; a++) grid.index_to_world.m[a][a] = voxel_m;
  const int size[3] = {WIDTH * copies, DEPTH * copies, HEIGHT};
  const int low[3] = {first_voxel[0] - copies / 2 * WIDTH, first_voxel[1] - copies / 2 * DEPTH, first_voxel[2]};
  int32_t origin[3];
  for (origin[0] = low[0] & ~7; origin[0] < low[0] + size[0]; origin[0] += 8)
    for (origin[1] = low[1] & ~7; origin[1] < low[1] + size[1]; origin[1] += 8)
      for (origin[2] = low[2] & ~7; origin[2] < low[2] + size[2]; origin[2] += 8) {
        np_leaf *leaf = np_sparse_grid_add_leaf(&grid, origin);
        for (int n = 0; n < NP_LEAF_SIZE; n++) {
          const int at[3] = {origin[0] + (n >> 6) - low[0], origin[1] + (n >> 3 & 7) - low[1],
                             origin[2] + (n & 7) - low[2]};
          if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= size[0] || at[1] >= size[1] || at[2] >= size[2]) continue;
          leaf->values[n] = get_value(at[0] % WIDTH, at[1] % DEPTH, at[2]);
          leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
        }
      }
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(context, path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

static neph_volume *load(neph_context *context, const char *path, double repeat_x_m, double repeat_y_m,
                         bool is_halved) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  desc.precision = NEPH_PRECISION_FLOAT;
  desc.repeat_m[0] = repeat_x_m;
  desc.repeat_m[1] = repeat_y_m;
  desc.is_halved = is_halved;
  assert_int_equal(neph_volume_load(context, path, &desc, &volume), NEPH_OK);
  return volume;
}

/* ---- Volumes ---- */

enum { POINTS = 4000 };

/* Positions over the middle copy and half of a copy around it, many of them within a voxel of its sides. */
static void list_points(double (*out)[3]) {
  np_random random = np_random_start(11, 0, 0, 0, 0);
  const double size[3] = {WIDTH, DEPTH, HEIGHT};
  for (int n = 0; n < POINTS; n++)
    for (int a = 0; a < 3; a++) {
      const double side = n % 2 ? (double)(n / 2 % 2) : 2.0 * np_random_double(&random) - 0.5;
      out[n][a] = voxel_m * (first_voxel[a] + side * size[a] + 2.0 * np_random_double(&random) - 1.0);
    }
}

/* A volume that repeats has the values of the copies, a period of bricks is one of the file, or of the least number of
 * its copies that fill whole bricks, and any number of periods further on the values are the same. */
static void repeats_as_copies(void **state) {
  test_fixture *f = *state;
  static double points[POINTS][3], moved[POINTS][3];
  static float one[POINTS], copied[POINTS], far[POINTS];
  char *nine = test_path(f->folder, "nine.vdb");
  write_field(f->context, f->path, 1);
  write_field(f->context, nine, 3);
  neph_volume *volume = load(f->context, f->path, NEPH_REPEAT_FILE, NEPH_REPEAT_FILE, false);
  neph_volume *copies = load(f->context, nine, 0.0, 0.0, false);
  list_points(points);
  for (int n = 0; n < POINTS; n++) {
    moved[n][0] = points[n][0] + 7 * WIDTH * voxel_m;
    moved[n][1] = points[n][1] - 4 * DEPTH * voxel_m;
    moved[n][2] = points[n][2];
  }
  neph_volume_sample(volume, POINTS, *points, one);
  neph_volume_sample(copies, POINTS, *points, copied);
  neph_volume_sample(volume, POINTS, *moved, far);
  double sum = 0.0;
  for (int n = 0; n < POINTS; n++) {
    assert_near((double)one[n], (double)copied[n], 2e-6); /* rounding of positions in voxels, times a step of 1 */
    assert_near((double)far[n], (double)one[n], 2e-5);    /* 140 voxels away: their rounding is larger */
    sum += (double)one[n];
  }
  assert_true(sum > 0.1 * POINTS);
  assert_int_equal(volume->bricks.period[0], 40);
  assert_int_equal(volume->bricks.period[1], 24);
  neph_volume_release(volume);
  neph_volume_release(copies);
  free(nine);
}

/* Halved voxels repeat too: half as many, of the mean of eight. */
static void repeats_halved(void **state) {
  test_fixture *f = *state;
  write_field(f->context, f->path, 1);
  neph_volume *volume = load(f->context, f->path, NEPH_REPEAT_FILE, NEPH_REPEAT_FILE, true);
  assert_int_equal(volume->bricks.period[0], 40); /* 80 whole voxels: of 16 and 20 the least common multiple */
  assert_int_equal(volume->bricks.period[1], 24);
  const double here[3] = {4.3 * voxel_m, 8.7 * voxel_m, 5.5 * voxel_m};
  const double there[3] = {here[0] - 3 * WIDTH * voxel_m, here[1] + 2 * DEPTH * voxel_m, here[2]};
  float values[2];
  neph_volume_sample(volume, 1, here, &values[0]);
  neph_volume_sample(volume, 1, there, &values[1]);
  assert_true(values[0] > 0.0f);
  assert_near((double)values[0], (double)values[1], 1e-5);
  neph_volume_release(volume);
}

/* A period that is longer than the box leaves a gap without cloud. */
static void leaves_a_gap(void **state) {
  test_fixture *f = *state;
  write_field(f->context, f->path, 1);
  neph_volume *volume = load(f->context, f->path, 32 * voxel_m, NEPH_REPEAT_FILE, false);
  const double y = voxel_m * (first_voxel[1] + 5), z = voxel_m * (first_voxel[2] + 4);
  const double in_gap[3] = {voxel_m * (first_voxel[0] + WIDTH + 5), y, z};
  const double behind[3] = {voxel_m * (first_voxel[0] + 32 + 1), y, z},
               first[3] = {voxel_m * (first_voxel[0] + 1), y, z};
  float values[3];
  neph_volume_sample(volume, 1, in_gap, &values[0]);
  neph_volume_sample(volume, 1, behind, &values[1]);
  neph_volume_sample(volume, 1, first, &values[2]);
  assert_true(values[0] == 0.0f);
  assert_true(values[2] > 0.0f);
  assert_near((double)values[1], (double)values[2], 1e-6);
  neph_volume_release(volume);
}

/* Transmittance along x from the first voxel of a field that ends at a reach; 0: nowhere. */
static double pass_field(neph_context *context, const char *path, double reach_m) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  desc.repeat_m[0] = desc.repeat_m[1] = NEPH_REPEAT_FILE;
  desc.repeat_reach_m[0] = desc.repeat_reach_m[1] = reach_m;
  assert_int_equal(neph_volume_load(context, path, &desc, &volume), NEPH_OK);
  const np_instance placed = {
      .bricks = &volume->bricks, .world_to_index = volume->world_to_index, .extinction_per_value = 1e-4f};
  const np_instances clouds = {.count = 1, .at = &placed};
  const double y = voxel_m * (first_voxel[1] + 5), z = voxel_m * (first_voxel[2] + 4);
  np_random random = np_random_start(5, 0, 0, 0, 0);
  const double passed = (double)np_track_transmittance(&clouds, np_dvec3_make(voxel_m * first_voxel[0], y, z),
                                                       np_vec3_make(1.0f, 0.0f, 0.0f), INFINITY, 700.0, &random);
  neph_volume_release(volume);
  return passed;
}

/* A ray passes twice the depth of a field that reaches twice as far, and nothing gets through one without end. Both
 * reaches are whole numbers of the stored period, two of the file's. */
static void ends_at_its_reach(void **state) {
  test_fixture *f = *state;
  write_field(f->context, f->path, 1);
  const double near = pass_field(f->context, f->path, 5e3), far = pass_field(f->context, f->path, 10e3);
  assert_true(near > 0.5 && near < 0.95);
  assert_near(log(far) / log(near), 2.0, 1e-4);
  assert_true(pass_field(f->context, f->path, 0.0) < 1e-100);
}

/* ---- Nearest samples ---- */

static neph_volume *create_step(neph_context *context, neph_interpolation interpolation, neph_precision precision) {
  enum { LENGTH = 16 };
  float values[LENGTH];
  for (int i = 0; i < LENGTH; i++) values[i] = i < LENGTH / 2 ? 0.25f : 2.0f;
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  neph_volume *volume;
  desc.size[0] = LENGTH;
  desc.size[1] = desc.size[2] = 1;
  desc.values = values;
  desc.is_periodic_x = desc.is_periodic_y = true;
  desc.precision = precision;
  desc.interpolation = interpolation;
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  return volume;
}

/* The value of a sample reaches half a voxel to all sides, along z to half a voxel beyond the last. */
static void keeps_steps_sharp(void **state) {
  test_fixture *f = *state;
  for (int k = 0; k < 2; k++) {
    neph_volume *volume =
        create_step(f->context, NEPH_INTERPOLATION_NEAREST, k ? NEPH_PRECISION_FLOAT : NEPH_PRECISION_HALF);
    const double points[][3] = {{7.49, 0, 0},  {7.51, 0.3, 0}, {15.49, 0, 0},    {15.51, 0, 0},
                                {-0.49, 0, 0}, {-0.51, 0, 0},  {3.0, 5.0, 0.49}, {3.0, 5.0, 0.51}};
    const double expected[] = {0.25, 2.0, 2.0, 0.25, 0.25, 2.0, 0.25, 0.0};
    float values[8];
    neph_volume_sample(volume, 8, *points, values);
    for (int n = 0; n < 8; n++) assert_near((double)values[n], expected[n], 0.0);
    neph_volume_release(volume);
  }
}

/* Optical depth of a ray through columns of 0.25 and 2 in turn, each 8 voxels wide, 1 voxel high: the ray passes the
 * layer from z = −½ to ½. */
static double compute_depth(double x, double slope) {
  enum { STEPS = 2000000 };
  double sum = 0.0;
  for (int n = 0; n < STEPS; n++) {
    const double at = x + slope * ((n + 0.5) / STEPS - 0.5) + 0.5, column = at - 16.0 * floor(at / 16.0);
    sum += column < 8.0 ? 0.25 : 2.0;
  }
  return sum / STEPS * sqrt(1.0 + slope * slope);
}

/* Transmittances of oblique rays are exact, as far as floats go, and free flights agree with them: cells bound them by
 * the largest sample, so that some flights are null collisions. */
static void integrates_steps(void **state) {
  test_fixture *f = *state;
  enum { FLIGHTS = 40000 };
  neph_volume *volume = create_step(f->context, NEPH_INTERPOLATION_NEAREST, NEPH_PRECISION_FLOAT);
  const np_instance placed = {
      .bricks = &volume->bricks, .world_to_index = volume->world_to_index, .extinction_per_value = 0.3f};
  const np_instances clouds = {.count = 1, .at = &placed};
  const double slopes[] = {0.0, 1.3, -6.0, 40.0};
  np_random random = np_random_start(3, 0, 0, 0, 0);
  for (int n = 0; n < 4; n++) {
    const double x = 6.1, length = sqrt(1.0 + slopes[n] * slopes[n]);
    const np_dvec3 origin = np_dvec3_make(x - slopes[n], 0.2, -1.0);
    const np_vec3 along = np_vec3_make((float)(slopes[n] / length), 0.0f, (float)(1.0 / length));
    const double expected = exp(-0.3 * compute_depth(x, slopes[n]));
    const double passed = (double)np_track_transmittance(&clouds, origin, along, INFINITY, 700.0, &random);
    assert_near(passed, expected, 2e-5);
    unsigned through = 0;
    for (int i = 0; i < FLIGHTS; i++) {
      np_flight flight = np_flight_start(np_track_flight(&random), 0.0);
      const np_instance *met;
      through += !isfinite(np_track_collision(&clouds, origin, along, INFINITY, &flight, &random, &met));
    }
    const double share = through / (double)FLIGHTS;
    assert_near(share, expected, 4.0 * sqrt(expected * (1.0 - expected) / FLIGHTS));
  }
  neph_volume_release(volume);
}

/* ---- Pictures ---- */

/* A camera over the middle of the single field, whose narrow view ends within it. */
#define SCENE                                                                                                          \
  "version: 1\n"                                                                                                       \
  "camera: {position: [115 m, 235 m, 3 km], look_at: [115 m, 236 m, 0 m], fov: 4 deg, "                                \
  "resolution: [12, 12]}\n"                                                                                            \
  "sun: {elevation: 70 deg, azimuth: 200 deg}\n"                                                                       \
  "atmosphere: {preset: none}\n"                                                                                       \
  "environment: {planet: none}\n"                                                                                      \
  "render: {samples: 64}\n"

/* Single scattering: of paths by their limit, of the march by its method. */
static neph_image *render(neph_context *context, const char *cloud, const char *integrator) {
  char text[2048];
  snprintf(text, sizeof text, SCENE "clouds: [{extinction: 0.02 1/m, precision: float, phase: {hg: 0.5}, %s}]\n",
           cloud);
  neph_scene *scene;
  neph_image *image;
  assert_int_equal(neph_scene_load_text(context, text, "dir/scene.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator), NEPH_OK);
  const bool is_path = !strcmp(integrator, "path");
  const char *key = is_path ? "render.max_scatterings" : "render.multiple_scattering";
  assert_int_equal(neph_scene_set(scene, key, is_path ? "1" : "none"), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

static double compute_mean(neph_image *image) {
  double sum = 0.0;
  for (int n = 0; n < 144; n++) sum += (double)neph_image_get_channel(image, "G")[n];
  return sum / 144.0;
}

/* Light that is scattered once reaches no further than a copy: pictures of either are alike but for rounding, in both
 * integrators, with nearest samples too. */
static void pictures_equal_copies(void **state) {
  test_fixture *f = *state;
  static const char *const integrators[] = {"march", "path"}, *const kinds[] = {"linear", "nearest"};
  char *nine = test_path(f->folder, "nine.vdb"), one[1024], copies[1024];
  write_field(f->context, f->path, 1);
  write_field(f->context, nine, 3);
  for (int n = 0; n < 4; n++) {
    snprintf(one, sizeof one, "vdb: %s, repeat: file, interpolation: %s", f->path, kinds[n / 2]);
    snprintf(copies, sizeof copies, "vdb: %s, interpolation: %s", nine, kinds[n / 2]);
    neph_image *a = render(f->context, one, integrators[n % 2]);
    neph_image *b = render(f->context, copies, integrators[n % 2]);
    const double mean = compute_mean(b);
    assert_true(mean > 0.0);
    assert_near(compute_mean(a) / mean, 1.0, n % 2 ? 0.02 : 2e-3); /* paths: other random numbers; sun depths: cached */
    neph_image_destroy(a);
    neph_image_destroy(b);
  }
  free(nine);
}

/* Low sun, multiple scattering, and an eye at a distance at which cells are prepared for it. */
static double render_from(const test_fixture *f, double x_m, double y_m, const char *others) {
  char text[2048];
  snprintf(text, sizeof text,
           "version: 1\n"
           "camera: {position: [%.17g m, %.17g m, 3 km], look_at: [%.17g m, %.17g m, 0 m], fov: 4 deg, "
           "resolution: [12, 12]}\n"
           "sun: {elevation: 8 deg, azimuth: 0 deg}\n"
           "atmosphere: {preset: none}\n"
           "environment: {planet: none}\n"
           "render: {samples: 16, sun_optical_depth: march}\n"
           "clouds: [{extinction: 0.02 1/m, precision: float, phase: {hg: 0.8}, vdb: %s, repeat: file}%s]\n",
           x_m, y_m - 2000.0, x_m, y_m, f->path, others);
  neph_scene *scene;
  neph_image *image;
  assert_int_equal(neph_scene_load_text(f->context, text, "dir/scene.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  const double mean = compute_mean(image);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return mean;
}

/* The view from a place is that from any number of periods on, at the same light: light towards the camera differs from
 * period to period, though its cells do not. */
static void periods_look_alike(void **state) {
  const test_fixture *f = *state;
  write_field(f->context, f->path, 1);
  const double here = render_from(f, 115.0, 235.0, "");
  assert_true(here > 0.0);
  assert_near(render_from(f, 115.0 + 6.0 * WIDTH * voxel_m, 235.0, "") / here, 1.0, 1e-3);
  assert_near(render_from(f, 115.0, 235.0 - 14.0 * DEPTH * voxel_m, "") / here, 1.0, 1e-3);
}

/* Clouds so thin that they hide and shine by less than 1e-3 leave a field as it is alone: one that ends, and one that
 * repeats by a length of its own. 2 %: cells are placed anew, and are up to an eighth wider. */
static void thin_clouds_change_nothing(void **state) {
  const test_fixture *f = *state;
  char ending[1024], endless[1024];
  write_field(f->context, f->path, 1);
  snprintf(ending, sizeof ending, ", {vdb: %s, extinction: 1e-7 1/m, position: [0 m, 0 m, 300 m]}", f->path);
  snprintf(endless, sizeof endless, ", {vdb: %s, extinction: 1e-7 1/m, repeat: [575 m, 325 m]}", f->path);
  for (int n = 0; n < 2; n++) {
    const double x_m = 115.0 + (n ? 40.0 * WIDTH * voxel_m : 0.0), alone = render_from(f, x_m, 235.0, "");
    assert_near(render_from(f, x_m, 235.0, ending) / alone, 1.0, 0.02);
    assert_near(render_from(f, x_m, 235.0, endless) / alone, 1.0, 0.02);
  }
}

/* A burning cloud, and another below it, in the dark but for a little sun from below; the camera looks at a place this
 * far east of them. */
static neph_scene *load_fire(const test_fixture *f, const char *fire, double east_m, const char *other,
                             const char *environment) {
  char text[2048];
  neph_scene *scene;
  snprintf(text, sizeof text,
           "version: 1\n"
           "camera: {position: [%.17g m, -1 km, 1 km], look_at: [%.17g m, 235 m, 200 m], fov: 30 deg,\n"
           "  resolution: [12, 12]}\n"
           "sun: {elevation: -30 deg, irradiance: 1e-9 W/m2/nm}\n"
           "atmosphere: {preset: none}\n"
           "environment: %s\n"
           "render: {samples: 8}\n"
           "clouds: [{vdb: %s, extinction: %s}, {extinction: 0.02 1/m, vdb: %s, position: [0 m, 0 m, 500 m],\n"
           "  emission: {flame: density, temperature: none, offset: 1500 K, absorption: 0.002 1/m}}]\n",
           115.0 + east_m, 115.0 + east_m, environment, f->path, other, fire);
  assert_int_equal(neph_scene_load_text(f->context, text, "dir/scene.yaml", &scene), NEPH_OK);
  return scene;
}

/* Light of a place near a burning cloud, in a scene without ground, and the bias that the picture states. */
static double render_fire(const test_fixture *f, const char *fire, double east_m, const char *other, double *out_bias) {
  neph_scene *scene = load_fire(f, fire, east_m, other, "{planet: none}");
  neph_image *image;
  neph_image_error error = NEPH_IMAGE_ERROR_DEFAULT;
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  assert_int_equal(neph_image_get_error(image, &error), NEPH_OK);
  const double mean = compute_mean(image);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  *out_bias = error.bias.value;
  return mean;
}

/* A fire burns once: its light does not come back with the periods of a cloud beside it, thin or thick, nor is it in
 * periods far away, where a picture states that it is missing. 2 %: other cells, as above; beside 5 × 5 copies, which
 * end: 20 % (twice as bright where light enters again by the sides). */
static void fire_burns_once(void **state) {
  const test_fixture *f = *state;
  double bias;
  char fire[1024];
  snprintf(fire, sizeof fire, "%s.fire.vdb", f->path);
  write_field(f->context, fire, 1);
  write_field(f->context, f->path, 1);
  const double alone = render_fire(f, fire, 0.0, "1e-7 1/m", &bias);
  assert_true(alone > 0.0 && bias < 0.5);
  assert_near(render_fire(f, fire, 0.0, "1e-7 1/m, repeat: file", &bias) / alone, 1.0, 0.02);
  const double near = render_fire(f, fire, 0.0, "0.02 1/m, repeat: file", &bias);
  const double beside = render_fire(f, fire, WIDTH * voxel_m, "0.02 1/m, repeat: file", &bias);
  assert_true(near > 0.0 && bias < 0.5);
  const double far = render_fire(f, fire, 60.0 * WIDTH * voxel_m, "0.02 1/m, repeat: file", &bias);
  assert_true(far < 1e-4 * near && bias >= 1.0);
  write_field(f->context, f->path, 5);
  assert_near(beside / render_fire(f, fire, WIDTH * voxel_m, "0.02 1/m", &bias), 1.0, 0.2);
  assert_int_equal(remove(fire), 0);
}

/* Predicted seconds of a picture of a burning cloud beside another, above ground. */
static double predict_fire(const test_fixture *f, const char *fire, const char *other) {
  neph_scene *scene = load_fire(f, fire, 0.0, other, "{}");
  double seconds;
  assert_int_equal(neph_render_estimate_time(scene, NULL, &seconds, NULL), NEPH_OK);
  neph_scene_destroy(scene);
  return seconds;
}

/* A repeated file is predicted to take the time of 6 x 6 copies at least, which are fewer than its stretch has; its
 * ground is below cloud everywhere, theirs in a quarter: some 14 seconds and 4. */
static void repeats_take_the_time_of_copies(void **state) {
  const test_fixture *f = *state;
  char fire[1024];
  snprintf(fire, sizeof fire, "%s.fire.vdb", f->path);
  write_field(f->context, fire, 1);
  write_field(f->context, f->path, 1);
  const double repeated = predict_fire(f, fire, "0.02 1/m, repeat: file");
  write_field(f->context, f->path, 6);
  const double copies = predict_fire(f, fire, "0.02 1/m");
  assert_true(repeated > copies && repeated < 8.0 * copies);
  assert_int_equal(remove(fire), 0);
}

/* ---- Refusals ---- */

static void refuses(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *keys, *words[3];
  } cases[] = {
      {"repeat: [510 m, 300 m]", {"510 m along x", "20.4 voxels of 25 m", "500 m or 525 m"}},
      {"repeat: [500 m, 275 m]", {"275 m along y", "11 voxels", "box of 12 voxels, 300 m"}},
      {"repeat: [500 m, 275 m], voxel: 20 m", {"13.75 voxels of 20 m", "260 m or 280 m", "along y"}},
      {"repeat: [0 m, 300 m]", {"clouds[0].repeat", "0", "must be"}},
      {"repeat: [500 m, -300 m]", {"clouds[0].repeat", "-300", "must be"}},
      {"repeat: file, rotation: 30 deg", {"clouds[0].rotation and clouds[0].repeat exclude", "quarters", "x and y"}},
      {"repeat: file, tilt: [3 deg, 0 deg]", {"clouds[0].tilt and clouds[0].repeat exclude", "", ""}},
      {"repeat: file, up: y", {"clouds[0].up and clouds[0].repeat exclude", "", ""}},
      {"interpolation: nearest, detail: {strength: 0.5}",
       {"clouds[0].interpolation is nearest", "clouds[0].detail", ""}},
  };
  write_field(f->context, f->path, 1);
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char text[2048];
    neph_scene *scene = NULL;
    neph_image *image = NULL;
    test_log_clear(&f->log);
    snprintf(text, sizeof text, SCENE "clouds: [{vdb: %s, extinction: 0.02 1/m, %s}]\n", f->path, cases[n].keys);
    neph_result result = neph_scene_load_text(f->context, text, "dir/scene.yaml", &scene);
    if (!result) result = neph_render_image(scene, NULL, &image);
    if (result != NEPH_ERROR_BAD_SCENE) fail_msg("%s: %s", cases[n].keys, f->log.text);
    assert_one_error(&f->log, cases[n].words[0], cases[n].words[1], cases[n].words[2]);
    neph_scene_destroy(scene);
  }
}

static void refuses_sequences_and_bakes(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *cloud, *word;
  } cases[] = {{"vdb: 'frame.####.vdb', extinction: 1 1/m, repeat: file", "vdb names files of many frames"},
               {"bake: {preset: stratus}, repeat: file", "a baked cloud repeats by clouds[0].bake.repeat"}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char text[2048];
    neph_scene *scene = NULL;
    test_log_clear(&f->log);
    snprintf(text, sizeof text, SCENE "clouds: [{%s}]\n", cases[n].cloud);
    assert_int_equal(neph_scene_load_text(f->context, text, "dir/scene.yaml", &scene), NEPH_ERROR_BAD_SCENE);
    assert_one_error(&f->log, cases[n].word);
  }
}

static int set_up_file(void **state) { return test_set_up(state, 2, "field.vdb"); }

#define ON_FILE(test) cmocka_unit_test_setup_teardown(test, set_up_file, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {ON_FILE(repeats_as_copies),
                                     ON_FILE(repeats_halved),
                                     ON_FILE(leaves_a_gap),
                                     ON_FILE(ends_at_its_reach),
                                     ON_FILE(keeps_steps_sharp),
                                     ON_FILE(integrates_steps),
                                     ON_FILE(pictures_equal_copies),
                                     ON_FILE(periods_look_alike),
                                     ON_FILE(thin_clouds_change_nothing),
                                     ON_FILE(fire_burns_once),
                                     ON_FILE(repeats_take_the_time_of_copies),
                                     ON_FILE(refuses),
                                     ON_FILE(refuses_sequences_and_bakes)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
