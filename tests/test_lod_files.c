/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail in files: bakes that come back as they are in memory, and what is refused. */
#include <stdlib.h>
#include <unistd.h>

#include "test_clouds.h"
#include "test_scenes.h"

#include "cloud/bake_file.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/random.h"
#include "volume/brick_motion.h"
#include "volume/volume_levels.h"
#include "volume/volume_tint.h"

/* ---- Bakes ---- */

enum { LEVELS = 3 };

typedef struct lod_files {
  test_log log;
  neph_context *context;
  char *folder, *path;
  neph_cloud_desc cloud;
  neph_bake_desc desc;
} lod_files;

static int set_up_files(void **state) {
  lod_files *f = calloc(1, sizeof *f);
  test_log_start(&f->log);
  f->context = test_context_create(2, &f->log);
  f->folder = test_folder_create();
  f->path = test_path(f->folder, "field.vdb");
  f->cloud = test_small_field(3);
  f->cloud.voxel_m = 20;
  f->desc = (neph_bake_desc)NEPH_BAKE_DESC_DEFAULT;
  f->desc.precision = NEPH_PRECISION_FLOAT;
  f->desc.lod_count = LEVELS;
  f->desc.lod_angle_rad = 0.04;
  for (int a = 0; a < 3; a++) f->desc.lod_viewer_min_m[a] = f->desc.lod_viewer_max_m[a] = a < 2 ? -2500 : 1500;
  assert_int_equal(neph_cloud_bake_file(f->context, &f->cloud, &f->desc, "density", f->path), NEPH_OK);
  *state = f;
  return 0;
}

static int tear_down_files(void **state) {
  lod_files *f = *state;
  free(f->path);
  test_folder_destroy(f->folder);
  neph_context_destroy(f->context);
  free(f);
  return 0;
}

static neph_result load(lod_files *f, neph_volume **out_volume) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.precision = NEPH_PRECISION_FLOAT;
  test_log_clear(&f->log);
  return neph_volume_load(f->context, f->path, &desc, out_volume);
}

/* The files hold each level's own voxels, to the bit. In the last voxel before a coarser level its samples are between
 * those there, the bake's the model's: some hundredths of the places differ, and the mean by less than a thousandth. */
static void files_are_the_field(void **state) {
  lod_files *f = *state;
  neph_volume *made, *loaded;
  enum { POINTS = 50000 };
  np_random random = np_random_start(5, 0, 0, 0, 0);
  double sum = 0, loaded_sum = 0;
  int differ = 0, cloudy = 0;
  assert_int_equal(neph_cloud_bake(f->context, &f->cloud, &f->desc, &made), NEPH_OK);
  assert_int_equal(load(f, &loaded), NEPH_OK);
  assert_int_equal(np_volume_count_parts(loaded), LEVELS);
  assert_memory_equal(made->active_min, loaded->active_min, sizeof made->active_min);
  assert_memory_equal(made->active_max, loaded->active_max, sizeof made->active_max);
  for (unsigned k = 0; k < LEVELS; k++) {
    const uint64_t count = np_volume_get_part(made, k)->active_voxel_count; /* the first counts all */
    assert_true(count > 1000);
    assert_int_equal(np_volume_get_part(loaded, k)->active_voxel_count, count);
  }
  for (int n = 0; n < POINTS; n++) {
    double at[3];
    float one, other;
    for (int a = 0; a < 3; a++) at[a] = (np_random_double(&random) - 0.5) * 5000;
    at[2] = f->cloud.base_altitude_m + f->cloud.thickness_m * np_random_double(&random);
    neph_volume_sample(made, 1, at, &one);
    neph_volume_sample(loaded, 1, at, &other);
    cloudy += one > 0;
    differ += one != other;
    sum += (double)one;
    loaded_sum += (double)other;
  }
  print_message("%d of %d cloudy places differ, mean by %.2g\n", differ, cloudy, loaded_sum / sum - 1);
  assert_true(cloudy > POINTS / 100);
  assert_true(differ < cloudy / 20);
  assert_near(loaded_sum / sum, 1, 1e-3);
  neph_volume_release(made);
  neph_volume_release(loaded);
}

/* Each is a file of its own. */
static void each_level_is_verified_and_read_alone(void **state) {
  lod_files *f = *state;
  uint64_t count = 0;
  neph_volume *whole;
  assert_int_equal(load(f, &whole), NEPH_OK);
  for (unsigned k = 0; k < LEVELS; k++) {
    char *path = np_volume_name_level(f->context, f->path, k);
    bool is_same = false;
    neph_volume *alone;
    assert_int_equal(neph_cloud_verify_file(f->context, path, NULL, NULL, &is_same), NEPH_OK);
    assert_true(is_same);
    if (k > 0) {
      assert_int_equal(neph_volume_load(f->context, path, NULL, &alone), NEPH_OK);
      assert_int_equal(np_volume_count_parts(alone), 1);
      count += alone->active_voxel_count;
      neph_volume_release(alone);
    }
    np_alloc_free(f->context, path);
  }
  assert_true(count < whole->active_voxel_count); /* the rest is the finest level's, which stands for all */
  neph_volume_release(whole);
}

static bool is_current(lod_files *f, const neph_bake_desc *desc) {
  bool is_same = false;
  assert_int_equal(np_cloud_file_is_current(f->context, f->path, &f->cloud, desc, &is_same), NEPH_OK);
  return is_same;
}

static void a_level_that_is_missing_or_of_another_bake_is_refused(void **state) {
  lod_files *f = *state;
  neph_volume *volume;
  neph_bake_desc other = f->desc;
  np_grid_header header;
  const neph_volume_load_desc load_desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  char *level = np_volume_name_level(f->context, f->path, 1), *kept = test_path(f->folder, "kept.vdb");
  other.lod_viewer_min_m[0] = other.lod_viewer_max_m[0] = 900;
  assert_true(is_current(f, &f->desc));
  assert_false(is_current(f, &other));
  assert_int_equal(rename(level, kept), 0);
  assert_false(is_current(f, &f->desc));
  assert_int_equal(load(f, &volume), NEPH_ERROR_NOT_FOUND);
  assert_non_null(strstr(f->log.text, "field.lod1.vdb: is not there, must be beside "));
  assert_int_not_equal(np_volume_read_header(f->context, f->path, &load_desc, NULL, &header), NEPH_OK);
  assert_int_equal(neph_cloud_bake_file(f->context, &f->cloud, &other, "density", f->path), NEPH_OK);
  assert_int_equal(np_volume_read_header(f->context, f->path, &load_desc, NULL, &header), NEPH_OK);
  assert_int_equal(header.level_count, LEVELS);
  assert_int_equal(rename(kept, level), 0);
  assert_int_equal(load(f, &volume), NEPH_ERROR_BAD_FILE);
  assert_non_null(strstr(f->log.text, "field.lod1.vdb: is not level of detail 1 of 3 of the bake that "));
  free(kept);
  np_alloc_free(f->context, level);
}

/* Two levels of three, of fewer voxels, with the matter of all: means keep it but for the last voxels before a cell
 * that is in no level, and roundings of floats. */
static void files_are_read_without_the_finest_level(void **state) {
  lod_files *f = *state;
  neph_volume *whole, *halved;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  double sums[2] = {0, 0};
  np_random random = np_random_start(6, 0, 0, 0, 0);
  assert_int_equal(load(f, &whole), NEPH_OK);
  desc.precision = NEPH_PRECISION_FLOAT;
  desc.is_halved = true;
  assert_int_equal(neph_volume_load(f->context, f->path, &desc, &halved), NEPH_OK);
  assert_int_equal(np_volume_count_parts(halved), LEVELS - 1);
  print_message("%llu voxels, halved %llu\n", (unsigned long long)whole->active_voxel_count,
                (unsigned long long)halved->active_voxel_count);
  assert_true(halved->active_voxel_count < whole->active_voxel_count);
  for (int n = 0; n < 200000; n++) {
    double at[3];
    for (int a = 0; a < 3; a++) at[a] = (np_random_double(&random) - 0.5) * 5000;
    at[2] = f->cloud.base_altitude_m + f->cloud.thickness_m * np_random_double(&random);
    for (int k = 0; k < 2; k++) {
      float value;
      neph_volume_sample(k ? halved : whole, 1, at, &value);
      sums[k] += (double)value;
    }
  }
  print_message("matter %.4g of the whole\n", sums[1] / sums[0]);
  assert_near(sums[1] / sums[0], 1.0, 0.01);
  neph_volume_release(whole);
  neph_volume_release(halved);
}

/* ---- Velocities ---- */

enum { WIND_M_S = 8 };

/* Carried by the wind alone, and cut on one side. */
static int set_up_velocities(void **state) {
  set_up_files(state);
  lod_files *f = *state;
  f->cloud.wind_m_s[0] = WIND_M_S;
  f->cloud.lifetime_s = 1e7; /* growth of under a micrometre a second */
  f->desc.has_velocity = f->desc.has_region = true;
  f->desc.file_precision = NEPH_PRECISION_HALF;
  for (int a = 0; a < 3; a++) f->desc.region_min_m[a] = -9e3, f->desc.region_max_m[a] = a == 0 ? 1503.7 : 9e3;
  assert_int_equal(neph_cloud_bake_file(f->context, &f->cloud, &f->desc, "density", f->path), NEPH_OK);
  return 0;
}

static unsigned load_velocities(lod_files *f, np_sparse_grid grids[3 * NP_TINT_PARTS_MAX]) {
  const np_vector_request request = {NP_VECTOR_VELOCITY, NULL, NEPH_IMPORT_REFUSE};
  unsigned count;
  memset(grids, 0, 3 * NP_TINT_PARTS_MAX * sizeof *grids);
  assert_int_equal(np_volume_load_velocities(f->context, f->path, &request, NULL, grids, &count), NEPH_OK);
  return count;
}

static void clear_velocities(np_sparse_grid grids[3 * NP_TINT_PARTS_MAX]) {
  for (int g = 0; g < 3 * NP_TINT_PARTS_MAX; g++) np_sparse_grid_clear(&grids[g]);
}

/* The wind, at the voxels of each level's density and everywhere else; 8 and 0 m/s are halves. */
static void each_level_has_the_wind(void **state) {
  lod_files *f = *state;
  np_sparse_grid grids[3 * NP_TINT_PARTS_MAX];
  neph_volume *volume;
  assert_int_equal(load_velocities(f, grids), LEVELS);
  assert_int_equal(load(f, &volume), NEPH_OK);
  uint64_t count = 0;
  for (unsigned k = 0; k < LEVELS; k++) {
    for (int a = 0; a < 3; a++) {
      const np_sparse_grid *grid = &grids[3 * k + (unsigned)a];
      const float wind_m_s = a == 0 ? WIND_M_S : 0;
      assert_near(grid->index_to_world.m[a][a], ldexp(f->cloud.voxel_m, (int)k), 1e-9);
      assert_near(grid->background, wind_m_s, 0);
      for (size_t i = 0; i < grid->leaf_count; i++)
        for (int n = 0; n < NP_LEAF_SIZE; n++) assert_near(grid->leaves[i].values[n], wind_m_s, 1e-5);
    }
    const uint64_t active = np_sparse_grid_count_active(&grids[3 * k]);
    assert_true(active > 500);
    if (k > 0) assert_int_equal(active, np_volume_get_part(volume, k)->active_voxel_count);
    count += active;
  }
  assert_int_equal(count, volume->active_voxel_count);
  neph_volume_release(volume);
  clear_velocities(grids);
}

/* All levels move by all velocities: what is at a place was upwind of it, in whichever level. Velocities are halves, of
 * which 8 is one; positions of look-ups are floats, of some hundred voxels. */
static void levels_move_as_one(void **state) {
  lod_files *f = *state;
  np_sparse_grid grids[3 * NP_TINT_PARTS_MAX];
  neph_volume *volume;
  np_moving_bricks *moving[LEVELS];
  np_random random = np_random_start(9, 0, 0, 0, 0);
  const double time_s = 10;
  int cloudy = 0, crossed = 0;
  const unsigned level_count = load_velocities(f, grids);
  assert_int_equal(load(f, &volume), NEPH_OK);
  for (unsigned k = 0; k < LEVELS; k++) {
    const neph_volume *level = np_volume_get_part(volume, k);
    const np_brick_motion_desc desc = {&level->bricks, level->index_to_world, grids, level_count, 1, 0, time_s};
    assert_int_equal(np_moving_bricks_build(f->context, &desc, NULL, &moving[k]), NEPH_OK);
  }
  for (int n = 0; n < 50000; n++) {
    double at[3], was[3], sum = 0;
    float expected;
    unsigned own = LEVELS, other = LEVELS;
    for (int a = 0; a < 3; a++) was[a] = at[a] = (np_random_double(&random) - 0.5) * 3000;
    was[2] = at[2] = f->cloud.base_altitude_m + f->cloud.thickness_m * np_random_double(&random);
    was[0] -= time_s * WIND_M_S;
    neph_volume_sample(volume, 1, was, &expected);
    for (unsigned k = 0; k < LEVELS; k++) {
      const neph_volume *level = np_volume_get_part(volume, k);
      np_brick_motion motion = moving[k]->motion;
      np_bricks bricks = moving[k]->bricks;
      const np_dvec3 index = np_affine_point(&level->world_to_index, np_dvec3_make(at[0], at[1], at[2]));
      motion.time_s = (float)time_s;
      bricks.motion = &motion;
      sum += (double)np_bricks_sample(&bricks, index);
      if (np_bricks_sample(&level->bricks, index) > 0) own = k;
      if (np_bricks_sample(&bricks, index) > 0) other = k;
    }
    cloudy += expected > 0;
    crossed += own < LEVELS && other < LEVELS && own != other;
    assert_near(sum, (double)expected, 1e-3 * f->cloud.extinction_per_m);
  }
  print_message("%d cloudy places, %d with cloud of another level\n", cloudy, crossed);
  assert_true(cloudy > 1000 && crossed > 10);
  for (unsigned k = 0; k < LEVELS; k++) np_moving_bricks_destroy(moving[k]);
  neph_volume_release(volume);
  clear_velocities(grids);
}

/* A level that was baked again without is no part of a cloud with velocities. */
static void a_level_without_velocities_is_refused(void **state) {
  lod_files *f = *state;
  const np_vector_request request = {NP_VECTOR_VELOCITY, NULL, NEPH_IMPORT_REFUSE};
  np_sparse_grid grids[3 * NP_TINT_PARTS_MAX] = {0};
  unsigned count;
  char *level = np_volume_name_level(f->context, f->path, 1), *other = test_path(f->folder, "other.vdb"),
       *other_level = np_volume_name_level(f->context, other, 1);
  f->desc.has_velocity = false;
  assert_int_equal(neph_cloud_bake_file(f->context, &f->cloud, &f->desc, "density", other), NEPH_OK);
  assert_int_equal(rename(other_level, level), 0);
  test_log_clear(&f->log);
  assert_int_equal(np_volume_load_velocities(f->context, f->path, &request, NULL, grids, &count), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "field.lod1.vdb: has no velocity", "bake all of them again");
  clear_velocities(grids);
  np_alloc_free(f->context, other_level);
  np_alloc_free(f->context, level);
  free(other);
}

static void levels_are_no_one_grid(void **state) {
  lod_files *f = *state;
  np_sparse_grid grid;
  bool has_content;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  assert_int_equal(np_volume_load_grid(f->context, f->path, &desc, NULL, &grid, &has_content), NEPH_ERROR_BAD_FILE);
  assert_non_null(strstr(f->log.text, "is the first of 3 files"));
  np_sparse_grid_clear(&grid);
}

/* ---- Scenes ---- */

static const char scene[] = "version: 1\n"
                            "camera: {position: [0 m, -1500 m, 900 m], look_at: [0 m, 0 m, 1100 m], fov: 60 deg,\n"
                            "  resolution: [48, 27]}\n"
                            "sun: {elevation: 20 deg, azimuth: 12 deg}\n"
                            "clouds:\n"
                            "  - bake: {extent: 2400 m, cell: 600 m, billow: 200 m, base: 900 m, thickness: 800 m,\n"
                            "      coverage: 0.6, voxel: 20 m, levels: 3, level_pixels: 1}\n"
                            "atmosphere: {tolerance: 0.1}\n"
                            "render: {samples: 4, light_memory: 0.001 GB, light_degree: 3, light_residual: 0.03}\n";

static double render_mean(fixture *f) {
  neph_image *image;
  test_log_clear(&f->log);
  if (neph_render_image(f->scene, NULL, &image)) fail_msg("%s", f->log.text);
  const float *red = neph_image_get_values(image, "R");
  double sum = 0;
  for (int i = 0; i < 48 * 27; i++) sum += (double)red[i];
  neph_image_destroy(image);
  return sum / (48 * 27);
}

/* A scene bakes to its file once, and again when its camera has moved. A thousandth: what differs between the file and
 * memory, and noise of what follows. */
static void a_scene_bakes_its_levels_to_files(void **state) {
  static const char *const integrators[] = {"march", "path"};
  char *folder = test_folder_create(), *path = test_path(folder, "field.vdb"),
       *last = test_path(folder, "field.lod2.vdb");
  for (int i = 0; i < 2; i++) {
    assert_int_equal(set_up_scene(state, 2, scene), 0);
    fixture *f = *state;
    set(f, "render.integrator", integrators[i]);
    const double expected = render_mean(f);
    set(f, "clouds[0].vdb", path);
    const double baked = render_mean(f), loaded = render_mean(f);
    assert_int_equal(access(last, R_OK), 0);
    assert_null(strstr(f->log.text, "rebaked"));
    print_message("%-5s %.5g in memory, %.5g of files\n", integrators[i], expected, loaded);
    assert_near(baked / loaded, 1, 1e-6);
    assert_near(loaded / expected, 1, i ? 5e-3 : 1e-3);
    set(f, "camera.position", "[0 m, -1400 m, 900 m]");
    render_mean(f);
    assert_non_null(strstr(f->log.text, "rebaked"));
    set(f, "camera.position", "[0 m, -1500 m, 900 m]");
    render_mean(f);
    assert_int_equal(tear_down(state), 0);
  }
  free(last);
  free(path);
  test_folder_destroy(folder);
}

/* The cloud moves by the wind in each pixel, whatever its level: by one frame's way over its depth, in focal lengths of
 * 48 pixels. A pixel that blends places is off by what their depths differ, their mean by far less. */
static void motion_vectors_are_of_all_levels(void **state) {
  lod_files *f = *state;
  char text[1024];
  void *own = NULL;
  neph_image *image;
  double sum = 0;
  int count = 0, far_count = 0;
  snprintf(text, sizeof text,
           "version: 1\n"
           "frame_rate: 1\n"
           "camera: {position: [-1000 m, -2800 m, 1500 m], look_at: [-1000 m, 0 m, 1500 m], fov: 53.1301 deg,\n"
           "  resolution: [48, 27]}\n"
           "sun: {elevation: 40 deg, azimuth: 180 deg}\n"
           "atmosphere: none\n"
           "clouds: [{vdb: %s, extinction: 1 1/m}]\n"
           "render: {samples: 4, light_memory: 0.001 GB}\n"
           "output: {aovs: [motion, position, transmittance], pixel_type: float}\n",
           f->path);
  assert_int_equal(set_up_scene(&own, 2, text), 0);
  if (neph_render_image(((fixture *)own)->scene, NULL, &image)) fail_msg("%s", ((fixture *)own)->log.text);
  const float *shift = neph_image_get_channel(image, "forward.u"), *y = neph_image_get_channel(image, "position.Y"),
              *clear = neph_image_get_channel(image, "transmittance");
  assert_non_null(shift);
  for (int i = 0; i < 48 * 27; i++) {
    if (clear[i] > 0.01f) continue;
    const double depth_m = (double)y[i] + 2800;
    const double share = (double)shift[i] * depth_m / (48 * WIND_M_S);
    assert_near(share, 1, 0.5);
    sum += share;
    count++;
    far_count += depth_m > 1300; /* beyond the finest level */
  }
  print_message("%d pixels of cloud, %d of them far away, mean %.4f\n", count, far_count, sum / count);
  assert_true(count > 30 && far_count > 10);
  assert_near(sum / count, 1, 0.02);
  neph_image_destroy(image);
  assert_int_equal(tear_down(&own), 0);
}

/* A copy of such a cloud keeps its levels; its light is solved apart. */
static void copies_have_levels(void **state) {
  lod_files *f = *state;
  char text[2048], *list = test_path(f->folder, "places.csv");
  double means[2];
  FILE *file = fopen(list, "w");
  assert_non_null(file);
  fprintf(file, "x_m,y_m,z_m\n0,0,1200\n");
  assert_int_equal(fclose(file), 0);
  snprintf(text, sizeof text,
           "version: 1\n"
           "camera: {position: [0 m, -9 km, 1500 m], look_at: [0 m, 0 m, 1500 m], fov: 50 deg, resolution: [48, 27]}\n"
           "sun: {elevation: 40 deg, azimuth: 180 deg}\n"
           "clouds: [{vdb: %s, extinction: 1 1/m}]\n"
           "render: {samples: 4, light_memory: 0.001 GB}\n",
           f->path);
  for (int n = 0; n < 2; n++) {
    void *own = NULL;
    assert_int_equal(set_up_scene(&own, 2, text), 0);
    if (n == 0)
      set(own, "clouds[0].position", "[0 m, 0 m, 1200 m]");
    else
      set(own, "clouds[0].places", list);
    means[n] = render_mean(own);
    assert_int_equal(tear_down(&own), 0);
  }
  print_message("a copy %.6g for %.6g\n", means[1], means[0]);
  assert_near(means[1] / means[0], 1, 0.01);
  free(list);
}

static neph_memory_estimate estimate(fixture *f) {
  neph_memory_estimate e = NEPH_MEMORY_ESTIMATE_DEFAULT;
  assert_int_equal(neph_render_estimate_memory(f->scene, NULL, &e), NEPH_OK);
  return e;
}

/* Mean of a picture within a limit on memory, and what was given up for it. */
static double render_within(fixture *f, uint64_t bytes, char savings[240]) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image;
  double mean;
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  desc.memory_max_bytes = bytes;
  test_log_clear(&f->log);
  if (neph_render_image(f->scene, &desc, &image)) fail_msg("%s", f->log.text);
  const char *text = neph_image_get_attribute(image, "nephos:memorySavings");
  (void)snprintf(savings, 240, "%s", text ? text : "");
  assert_int_equal(sscanf(neph_image_get_attribute(image, "nephos:mean"), "%lf", &mean), 1);
  neph_image_destroy(image);
  return mean;
}

/* Files of levels that another scene baked: all of them count, and a limit takes the finest level, where halves and
 * coarser cells of light are not enough. Both pictures have the coarsest cells, of 1 MB: what is left is the finest
 * level, which moves the mean by half a per cent; paths add a noise of 2 %. */
static void levels_keep_within_memory(void **state) {
  lod_files *files = *state;
  static const char *const integrators[] = {"march", "path"};
  char text[1024];
  snprintf(text, sizeof text,
           "version: 1\n"
           "camera: {position: [0 m, -9 km, 1500 m], look_at: [0 m, 0 m, 1500 m], fov: 50 deg, resolution: [48, 27]}\n"
           "sun: {elevation: 40 deg, azimuth: 180 deg}\n"
           "atmosphere: none\n"
           "clouds: [{vdb: %s, extinction: 1 1/m}]\n"
           "render: {samples: 4}\n",
           files->path);
  for (int i = 0; i < 2; i++) {
    char whole[240], coarse[240];
    void *own = NULL;
    assert_int_equal(set_up_scene(&own, 2, text), 0);
    fixture *f = own;
    set(f, "render.integrator", integrators[i]);
    const neph_memory_estimate e = estimate(f);
    const double cells = i ? 0.0 : 1e6, light = i ? 0.0 : (double)e.light_bytes;
    double bytes = 0;
    for (unsigned k = 0; k < LEVELS; k++) { /* halves, of a voxel a byte, in bricks of 729 samples for 512 */
      char *path = np_volume_name_level(files->context, files->path, k);
      bytes += (double)np_file_get_size(path) * 2.0 * 729.0 / 512.0;
      np_alloc_free(files->context, path);
    }
    assert_near_relative((double)e.volume_bytes, bytes, 1e-3);
    const double least = (double)e.total_bytes - light + cells;
    const uint64_t limit = (uint64_t)(least - 0.02 * (double)e.volume_bytes);
    const double mean = render_within(f, (uint64_t)(least + 0.2 * cells), whole);
    const double less = render_within(f, limit, coarse);
    print_message("%-5s %.5g, within memory %.5g: %s\n", integrators[i], mean, less, coarse);
    assert_null(strstr(whole, "voxels"));
    assert_non_null(strstr(coarse, "voxels of files, of levels of detail those of the finest, are twice as long"));
    assert_near(less / mean, 1, i ? 0.04 : 0.01);
    assert_int_equal(tear_down(&own), 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(files_are_the_field, set_up_files, tear_down_files),
      cmocka_unit_test_setup_teardown(each_level_is_verified_and_read_alone, set_up_files, tear_down_files),
      cmocka_unit_test_setup_teardown(each_level_is_verified_and_read_alone, set_up_velocities, tear_down_files),
      cmocka_unit_test_setup_teardown(each_level_has_the_wind, set_up_velocities, tear_down_files),
      cmocka_unit_test_setup_teardown(levels_move_as_one, set_up_velocities, tear_down_files),
      cmocka_unit_test_setup_teardown(a_level_without_velocities_is_refused, set_up_velocities, tear_down_files),
      cmocka_unit_test_setup_teardown(motion_vectors_are_of_all_levels, set_up_velocities, tear_down_files),
      cmocka_unit_test_setup_teardown(a_level_that_is_missing_or_of_another_bake_is_refused, set_up_files,
                                      tear_down_files),
      cmocka_unit_test_setup_teardown(files_are_read_without_the_finest_level, set_up_files, tear_down_files),
      cmocka_unit_test_setup_teardown(levels_are_no_one_grid, set_up_files, tear_down_files),
      cmocka_unit_test_setup_teardown(levels_keep_within_memory, set_up_files, tear_down_files),
      cmocka_unit_test(a_scene_bakes_its_levels_to_files),
      cmocka_unit_test_setup_teardown(copies_have_levels, set_up_files, tear_down_files),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
