/* SPDX-License-Identifier: Apache-2.0 */
/* Exported clouds: their values stand where the scene has them, pictures of them are those of the scene, and a USD
 * layer names them. */
#include <nephos/nephos.h>

#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/file.h"
#include "test_box_files.h"
#include "test_color_files.h"

/* Two boxes, so that no turn goes unseen. */
static const test_box boxes[] = {{{8, 8, 8}, {24, 20, 16}, 1.0f}, {{24, 10, 9}, {30, 14, 12}, 0.3f}};

static int set_up(void **state) {
  const int failed = test_set_up(state, 2, "b.vdb");
  const test_fixture *f = *state;
  if (!failed) test_boxes_write(f->context, f->path, "density", boxes, 2);
  return failed;
}

static neph_scene *load(const test_fixture *f, const char *integrator, const char *cloud) {
  char text[1200];
  (void)snprintf(
      text, sizeof text,
      "version: 1\n"
      "camera: {position: [0 m, -200 m, 60 m], look_at: [0 m, 0 m, 60 m], fov: 40 deg, resolution: [32, 18]}\n"
      "sun: {elevation: 40 deg, azimuth: 240 deg}\n"
      "atmosphere: none\n"
      "clouds: [{name: \"b 1\", albedo: 0.9, phase: {hg: 0.5}, %s}]\n"
      "render: {integrator: %s, samples: 16}\n"
      "output: {pixel_type: float}\n",
      cloud, integrator);
  neph_scene *scene = NULL;
  char *path = test_path(f->folder, "scene.yaml");
  assert_int_equal(neph_scene_load_text(f->context, text, path, &scene), NEPH_OK);
  free(path);
  return scene;
}

static const char placed[] =
    "vdb: b.vdb, up: y, voxel: 3 m, scale: [1, -1, 1.5], rotation: 30 deg, tilt: [10 deg, -5 deg], "
    "position: [5 m, 10 m, 30 m], optical_depth: 6";

static neph_exported_cloud export_frame(neph_renderer *renderer, const neph_scene *scene, int frame,
                                        neph_precision precision, const char *path) {
  neph_export_desc desc = NEPH_EXPORT_DESC_DEFAULT;
  neph_exported_cloud out = NEPH_EXPORTED_CLOUD_DEFAULT;
  desc.precision = precision;
  desc.renderer = renderer;
  assert_int_equal(neph_scene_export_cloud(scene, 0, frame, &desc, path, &out), NEPH_OK);
  return out;
}

static neph_exported_cloud export_cloud(const test_fixture *f, neph_scene *scene, int frame, neph_precision precision,
                                        const char *path) {
  (void)f;
  return export_frame(NULL, scene, frame, precision, path);
}

/* ---- Places and values ---- */

static void values_stand_in_the_world(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb");
  neph_scene *scene =
      load(f, "march", "vdb: b.vdb, up: y, extinction: 0.25 1/m, position: [100 m, 0, 0], pivot: origin");
  const neph_exported_cloud out = export_cloud(f, scene, 1, NEPH_PRECISION_FLOAT, path);
  assert_near(out.extinction_per_value, 1.0, 0.0);
  /* x from 100 + 8 to 100 + 30, y from −16 to −8, z from 8 to 20, and half a voxel less at the low end. */
  const double low[3] = {107.5, -15.5, 7.5}, high[3] = {129.5, -7.5, 19.5};
  for (int a = 0; a < 3; a++) assert_near(out.bounds_min_m[a], low[a], 1e-12);
  for (int a = 0; a < 3; a++) assert_near(out.bounds_max_m[a], high[a], 1e-12);
  neph_volume *volume = NULL;
  neph_volume_load_desc load_desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  load_desc.precision = NEPH_PRECISION_FLOAT;
  assert_int_equal(neph_volume_load(f->context, path, &load_desc, &volume), NEPH_OK);
  const double at[] = {110, -12, 15, 127, -10, 12, 90, -12, 15}; /* in one box, in the other, in none */
  float values[3];
  neph_volume_sample(volume, 3, at, values);
  assert_near((double)values[0], 0.25, 0.0);
  assert_near((double)values[1], (double)(0.25f * 0.3f), 1e-8); /* a float of 0.075 */
  assert_near((double)values[2], 0.0, 0.0);
  neph_volume_release(volume);
  neph_scene_destroy(scene);
  free(path);
}

static double compute_difference(neph_image *a, neph_image *b) {
  const float *p = neph_image_get_channel(a, "G"), *q = neph_image_get_channel(b, "G");
  double sum = 0.0, mean = 0.0;
  for (int i = 0; i < 32 * 18; i++) {
    sum += ((double)p[i] - (double)q[i]) * ((double)p[i] - (double)q[i]);
    mean += (double)p[i] / (32 * 18);
  }
  return sqrt(sum / (32 * 18)) / mean;
}

static neph_image *render(neph_scene *scene) {
  neph_image *image = NULL;
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  return image;
}

static void pictures_are_those_of_the_scene(void **state) {
  static const char *const integrators[] = {"march", "path"};
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb"), cloud[200];
  for (int i = 0; i < 4; i++) {
    neph_scene *scene = load(f, integrators[i / 2], placed);
    const neph_exported_cloud out = export_cloud(f, scene, 1, i % 2 ? NEPH_PRECISION_HALF : NEPH_PRECISION_FLOAT, path);
    assert_int_equal(out.is_half, i % 2);
    (void)snprintf(cloud, sizeof cloud, "vdb: out.vdb, extinction: %.9g 1/m", out.extinction_per_value);
    neph_scene *again = load(f, integrators[i / 2], cloud);
    neph_image *before = render(scene), *after = render(again);
    /* Halves of bricks, 2⁻¹² of a value each; a path whose collision falls elsewhere by that much may end elsewhere. */
    assert_true(compute_difference(before, after) < (i / 2 ? 0.02 : 5e-4));
    neph_image_destroy(before);
    neph_image_destroy(after);
    neph_scene_destroy(again);
    neph_scene_destroy(scene);
  }
  free(path);
}

static void baked_clouds_are_exported_too(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb");
  neph_scene *scene = load(f, "march", "bake: {preset: cumulus_humilis, extent: 1 km, voxel: 50 m}");
  const neph_exported_cloud out = export_cloud(f, scene, 1, NEPH_PRECISION_FLOAT, path);
  assert_false(out.is_empty);
  neph_volume *volume = NULL;
  assert_int_equal(neph_volume_load(f->context, path, NULL, &volume), NEPH_OK);
  neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
  assert_int_equal(neph_volume_get_info(volume, &info), NEPH_OK);
  for (int a = 0; a < 3; a++) assert_near(info.bounds_min_m[a] - out.bounds_min_m[a], 25.0, 1e-6); /* half a voxel */
  neph_volume_release(volume);
  neph_scene_destroy(scene);
  free(path);
}

static bool stop_later(void *user, const neph_progress *progress) {
  unsigned *calls = user;
  (void)progress;
  return (*calls)-- > 0;
}

static unsigned count_files(const test_fixture *f) {
  DIR *folder = opendir(f->folder);
  unsigned count = 0;
  assert_non_null(folder);
  for (const struct dirent *entry; (entry = readdir(folder));) count += entry->d_name[0] != '.';
  closedir(folder);
  return count;
}

/* A bake that is cancelled, at whichever call, leaves the file that was there, and no other. */
static void a_cancelled_export_leaves_the_folder_as_it_was(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb");
  static const char before[] = "a cloud of yesterday";
  char now[sizeof before];
  neph_scene *scene = load(f, "march", "bake: {preset: cumulus_humilis, extent: 1 km, voxel: 50 m}");
  neph_export_desc desc = NEPH_EXPORT_DESC_DEFAULT;
  neph_exported_cloud out = NEPH_EXPORTED_CLOUD_DEFAULT;
  neph_result result = NEPH_ERROR_CANCELLED;
  unsigned stop_at = 0;
  char *beside = test_path(f->folder, "out.bake.vdb"); /* a file of the user's */
  test_boxes_write(f->context, beside, "density", boxes, 2);
  desc.progress = stop_later;
  for (; result == NEPH_ERROR_CANCELLED; stop_at++) {
    unsigned calls = stop_at;
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(before, sizeof before, 1, file), 1);
    assert_int_equal(fclose(file), 0);
    const unsigned files = count_files(f);
    desc.progress_user = &calls;
    result = neph_scene_export_cloud(scene, 0, 1, &desc, path, &out);
    assert_int_equal(count_files(f), files);
    file = fopen(path, "r");
    assert_non_null(file);
    assert_int_equal(fread(now, sizeof now, 1, file), 1);
    (void)fclose(file);
    assert_int_equal(memcmp(now, before, sizeof before) == 0, result == NEPH_ERROR_CANCELLED);
  }
  assert_int_equal(result, NEPH_OK);
  assert_true(stop_at > 2);
  assert_int_equal(access(beside, F_OK), 0);
  neph_scene_destroy(scene);
  free(beside);
  free(path);
}

/* ---- Levels of detail ---- */

enum { SIDE = 8 }; /* columns of the coarsest level that the boxes lie in, along x and along y */

/* Mean vertical optical depth over columns of `edge`² voxels; the file's z is up. Returns the length of a voxel. */
static double gather_depths(const test_fixture *f, const char *name, int edge, double depths[SIDE][SIDE]) {
  char *path = test_path(f->folder, name);
  const neph_volume_load_desc load_desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  np_sparse_grid grid;
  bool has_content;
  assert_int_equal(np_volume_load_grid(f->context, path, &load_desc, NULL, &grid, &has_content), NEPH_OK);
  assert_true(has_content && grid.tile_count == 0);
  const double voxel_m = grid.index_to_world.m[2][2];
  memset(depths, 0, sizeof(double[SIDE][SIDE]));
  for (size_t l = 0; l < grid.leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const double value = (double)grid.leaves[l].values[n];
      const int i = grid.leaves[l].origin[0] + n / 64, j = grid.leaves[l].origin[1] + n / 8 % 8;
      if (!(value > 0)) continue;
      assert_in_range(i / edge, 0, SIDE - 1);
      assert_in_range(j / edge, 0, SIDE - 1);
      depths[i / edge][j / edge] += value * voxel_m / (edge * edge);
    }
  np_sparse_grid_clear(&grid);
  free(path);
  return voxel_m;
}

/* Levels are the same cloud with voxels of twice and four times the length: columns keep their optical depth. */
static void levels_keep_the_optical_depth(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb");
  neph_export_desc desc = NEPH_EXPORT_DESC_DEFAULT;
  neph_scene *scene = load(f, "march", "vdb: b.vdb, up: z, extinction: 0.25 1/m, position: [0, 0, 0], pivot: origin");
  neph_exported_cloud out = NEPH_EXPORTED_CLOUD_DEFAULT;
  double depths[3][SIDE][SIDE], whole = 0;
  desc.level_count = 3;
  assert_int_equal(neph_scene_export_cloud(scene, 0, 1, &desc, path, &out), NEPH_OK);
  const double voxel_m = gather_depths(f, "out.vdb", 4, depths[0]);
  assert_near(gather_depths(f, "out.lod1.vdb", 2, depths[1]), 2 * voxel_m, 1e-9);
  assert_near(gather_depths(f, "out.lod2.vdb", 1, depths[2]), 4 * voxel_m, 1e-9);
  for (int i = 0; i < SIDE; i++)
    for (int j = 0; j < SIDE; j++) {
      whole += depths[0][i][j];
      for (int k = 1; k < 3; k++) assert_near(depths[k][i][j], depths[0][i][j], 1e-6); /* sums of floats */
    }
  assert_true(whole > 1);
  char *third = test_path(f->folder, "out.lod3.vdb");
  assert_int_equal(access(third, F_OK), -1);
  free(third);
  for (unsigned bad = 0; bad <= NEPH_BAKE_LEVELS_MAX + 1; bad += NEPH_BAKE_LEVELS_MAX + 1) {
    desc.level_count = bad;
    assert_int_equal(neph_scene_export_cloud(scene, 0, 1, &desc, path, &out), NEPH_ERROR_INVALID_ARGUMENT);
    assert_one_error(&f->log, "level_count");
  }
  neph_scene_destroy(scene);
  free(path);
}

/* ---- Beside the density ---- */

static float get_lump(const int32_t at[3]) {
  bool is_inside = true;
  for (int a = 0; a < 3; a++) is_inside = is_inside && at[a] >= 6 && at[a] < 12 + 4 * a;
  return is_inside ? 0.5f : 0.0f;
}

static void get_color(const int32_t at[3], float out[3]) {
  for (int c = 0; c < 3; c++) out[c] = at[c] < 9 ? 0.25f : 0.75f;
}

static void get_light(const int32_t at[3], float out[3]) {
  for (int c = 0; c < 3; c++) out[c] = at[0] < 9 ? 0.125f * (float)c : 0.5f;
}

static void get_flow(const int32_t at[3], float out[3]) {
  for (int c = 0; c < 3; c++) out[c] = (float)(1 + c) * (at[2] < 9 ? 1.0f : -2.0f);
}

static void write_colored(const test_fixture *f) {
  const test_color_file file = {
      get_lump, {{{"v"}, get_flow}, {{"color_r", "color_g", "color_b"}, get_color}, {{"emission"}, get_light}}};
  test_color_write(f->context, f->path, &file);
}

static const char colored[] =
    "vdb: b.vdb, up: y, voxel: 3 m, scale: [1, -1, 1.5], rotation: 30 deg, tilt: [10 deg, -5 deg], "
    "position: [5 m, 10 m, 30 m], optical_depth: 6, velocity_scale: 2, emission: {strength: 0.01}";

/* Vectors turn, grow and are mirrored with the cloud: at the world's place of a voxel it is the linear part of the map
 * of places, times velocity_scale, times the velocity. Colours and light stay what they are. */
static void fields_go_with_the_cloud(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb");
  write_colored(f);
  neph_scene *scene = load(f, "march", colored);
  const neph_exported_cloud out = export_cloud(f, scene, 1, NEPH_PRECISION_FLOAT, path);
  assert_int_equal(out.fields, NEPH_EXPORT_VELOCITY | NEPH_EXPORT_COLOR | NEPH_EXPORT_LIGHT);
  np_sparse_grid before[3], after[3];
  const np_vector_request requests[] = {{NP_VECTOR_VELOCITY, NULL, NEPH_IMPORT_REFUSE},
                                        {NP_VECTOR_COLOR, NULL, NEPH_IMPORT_REFUSE},
                                        {NP_VECTOR_EMISSION, NULL, NEPH_IMPORT_REFUSE}};
  for (int role = 0; role < 3; role++) {
    bool is_found;
    assert_int_equal(np_volume_load_vector(f->context, f->path, &requests[role], NULL, before, &is_found), NEPH_OK);
    assert_int_equal(np_volume_load_vector(f->context, path, &requests[role], NULL, after, &is_found), NEPH_OK);
    assert_true(is_found);
    const np_affine *map = &after[0].index_to_world; /* that of the file is the identity */
    uint64_t active = 0;
    for (size_t i = 0; i < after[0].leaf_count; i++)
      for (int n = 0; n < NP_LEAF_SIZE; n++) {
        if (!(after[0].leaves[i].active[n / 64] >> (n % 64) & 1u)) continue;
        active++;
        for (int a = 0; a < 3; a++) {
          double expected = 0.01 * (double)before[a].leaves[i].values[n];
          if (role == 1) expected = (double)before[a].leaves[i].values[n];
          for (int b = 0; b < 3 && role == 0; b++)
            expected = (b ? expected : 0.0) + 2.0 * map->m[a][b] * (double)before[b].leaves[i].values[n];
          assert_near((double)after[a].leaves[i].values[n], expected, 1e-5); /* floats of up to 60 */
        }
      }
    assert_int_equal(active, 6 * 10 * 14);
    for (int a = 0; a < 3; a++) {
      np_sparse_grid_clear(&before[a]);
      np_sparse_grid_clear(&after[a]);
    }
  }
  neph_scene_destroy(scene);
  free(path);
}

/* Halves of bricks, 2⁻¹² of a value each, of a cloud and of what its corners have of it. What a scene leaves out is not
 * exported. */
static void pictures_of_fields_are_those_of_the_scene(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb"), cloud[200];
  write_colored(f);
  for (int i = 0; i < 2; i++) {
    neph_scene *scene = load(f, "march", colored);
    const neph_exported_cloud out = export_cloud(f, scene, 1, i ? NEPH_PRECISION_HALF : NEPH_PRECISION_FLOAT, path);
    (void)snprintf(cloud, sizeof cloud, "vdb: out.vdb, extinction: %.9g 1/m, emission: {}", out.extinction_per_value);
    neph_scene *again = load(f, "march", cloud), *both[] = {scene, again};
    for (int k = 0; k < 2; k++) {
      assert_int_equal(neph_scene_set(both[k], "render.samples", "4"), NEPH_OK);
      assert_int_equal(neph_scene_set(both[k], "environment.planet", "none"), NEPH_OK); /* no ground to light by it */
      if (i) assert_int_equal(neph_scene_set(both[k], "camera.motion_blur", "{}"), NEPH_OK);
    }
    neph_image *before = render(scene), *after = render(again);
    assert_true(compute_difference(before, after) < 2e-3);
    neph_image_destroy(before);
    neph_image_destroy(after);
    neph_scene_destroy(again);
    assert_int_equal(neph_scene_set(scene, "clouds[0].color", "none"), NEPH_OK);
    assert_int_equal(neph_scene_set(scene, "clouds[0].velocity", "none"), NEPH_OK);
    assert_int_equal(export_cloud(f, scene, 1, NEPH_PRECISION_FLOAT, path).fields, NEPH_EXPORT_LIGHT);
    neph_scene_destroy(scene);
  }
  free(path);
}

/* Temperatures in kelvin and flames in 1/m: what kelvin, offset, absorption and strength say is done. */
static void fire_is_exported_in_units(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb");
  static const char *const names[] = {"density", "heat", "flames"};
  np_sparse_grid grids[3];
  np_vdb_write_grid outputs[3] = {{0}};
  const test_color_file file = {.get_density = get_lump};
  for (int g = 0; g < 3; g++) {
    test_color_fill(f->context, names[g], &(test_color_source){&file, -1, 0}, &grids[g]);
    outputs[g].grid = &grids[g];
  }
  assert_int_equal(np_volume_save_grids(f->context, f->path, outputs, 3, NULL), NEPH_OK);
  for (int g = 0; g < 3; g++) np_sparse_grid_clear(&grids[g]);
  neph_scene *scene =
      load(f, "march",
           "vdb: b.vdb, extinction: 1 1/m, emission: {temperature: heat, kelvin: 1800 K, offset: 300 K, "
           "flame: flames, absorption: 3 1/m, strength: 5}");
  assert_int_equal(export_cloud(f, scene, 1, NEPH_PRECISION_FLOAT, path).fields,
                   NEPH_EXPORT_TEMPERATURE | NEPH_EXPORT_FLAME);
  static const struct {
    const char *name;
    double value;
  } expected[] = {{"temperature", 300.0 + 1800.0 * 0.5}, {"flame", 3.0 * 5.0 * 0.5}};
  for (int i = 0; i < 2; i++) {
    neph_volume_load_desc load_desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
    neph_volume *volume;
    const double inside[3] = {8.0, 8.0, 8.0};
    float value;
    load_desc.grid = expected[i].name;
    load_desc.precision = NEPH_PRECISION_FLOAT;
    load_desc.policy = NEPH_IMPORT_REPAIR; /* a field's background may be warm */
    assert_int_equal(neph_volume_load(f->context, path, &load_desc, &volume), NEPH_OK);
    neph_volume_sample(volume, 1, inside, &value);
    assert_near((double)value, expected[i].value, 1e-4);
    neph_volume_release(volume);
  }
  neph_scene_destroy(scene);
  free(path);
}

/* Fails like a render and a dry run. */
static void missing_grids_are_refused(void **state) {
  static const char *const emissions[][2] = {{"temperature: heat", "no grid 'heat'"},
                                             {"", "no grid 'temperature'"},
                                             {"temperature: density, flame: fire", "no grid 'fire'"},
                                             {"color: glow", "no grid 'glow'"}};
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb"), cloud[200];
  for (size_t i = 0; i < sizeof emissions / sizeof *emissions; i++)
    for (int is_dry = 0; is_dry < 2; is_dry++) {
      (void)snprintf(cloud, sizeof cloud, "vdb: b.vdb, extinction: 1 1/m, emission: {%s}", emissions[i][0]);
      neph_scene *scene = load(f, "march", cloud);
      neph_export_desc desc = NEPH_EXPORT_DESC_DEFAULT;
      neph_exported_cloud out = NEPH_EXPORTED_CLOUD_DEFAULT;
      desc.is_dry_run = is_dry;
      assert_int_equal(neph_scene_export_cloud(scene, 0, 1, &desc, path, &out), NEPH_ERROR_BAD_FILE);
      assert_one_error(&f->log, emissions[i][1]);
      assert_int_equal(access(path, F_OK), -1);
      neph_scene_destroy(scene);
    }
  free(path);
}

/* A field of fire is a density where the scene names it, for an export, a render and the plan of one alike. */
static void fields_are_densities_by_name_alone(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb"), *plan;
  const test_color_file file = {.get_density = get_lump};
  np_sparse_grid grid;
  test_color_fill(f->context, "heat", &(test_color_source){&file, -1, 0}, &grid);
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(f->context, f->path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
  for (int is_named = 0; is_named < 2; is_named++) {
    neph_scene *scene =
        load(f, "march", is_named ? "vdb: b.vdb, grid: heat, extinction: 1 1/m" : "vdb: b.vdb, extinction: 1 1/m");
    for (int i = 0; i < 3; i++) {
      const neph_export_desc desc = NEPH_EXPORT_DESC_DEFAULT;
      neph_exported_cloud out = NEPH_EXPORTED_CLOUD_DEFAULT;
      neph_image *image = NULL;
      neph_result result = NEPH_OK;
      test_log_clear(&f->log);
      plan = NULL;
      if (i == 0) result = neph_scene_export_cloud(scene, 0, 1, &desc, path, &out);
      if (i == 1) result = neph_render_image(scene, NULL, &image);
      if (i == 2) result = neph_render_explain(scene, NULL, NEPH_TEXT_PLAIN, &plan);
      assert_int_equal(result, is_named ? NEPH_OK : NEPH_ERROR_BAD_FILE);
      assert_true(is_named || strstr(f->log.text, "heat"));
      neph_image_destroy(image);
      neph_text_destroy(f->context, plan);
    }
    neph_scene_destroy(scene);
  }
  free(path);
}

static void layers_name_the_fields(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "out.vdb"), *layer = test_path(f->folder, "out.usda");
  static const char *const lines[] = {"rel field:density = </World/b_1/density>",
                                      "rel field:vel = </World/b_1/vel>",
                                      "rel field:Cd = </World/b_1/Cd>",
                                      "def OpenVDBAsset \"Ce\"",
                                      "token fieldName = \"vel\"\n      token fieldDataType = \"half3\"\n      token "
                                      "vectorDataRoleHint = \"Vector\"",
                                      "token vectorDataRoleHint = \"Color\""};
  void *text;
  size_t size;
  write_colored(f);
  neph_scene *scene = load(f, "march", colored);
  const neph_exported_cloud out = export_cloud(f, scene, 1, NEPH_PRECISION_HALF, path);
  assert_int_equal(neph_scene_save_volumes_usd(scene, &out, 1, layer), NEPH_OK);
  assert_int_equal(np_file_read(f->context, layer, &text, &size), NEPH_OK);
  char *copy = strndup(text, size);
  np_alloc_free(f->context, text);
  for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
    if (!strstr(copy, lines[i])) fail_msg("%s is not in\n%s", lines[i], copy);
  assert_null(strstr(copy, "flame"));
  free(copy);
  free(layer);
  free(path);
  neph_scene_destroy(scene);
}

/* ---- USD ---- */

static void assert_has(const char *text, const char *line) {
  if (!strstr(text, line)) fail_msg("%s is not in\n%s", line, text);
}

/* Frame 2 of three has no file. What stands still has one extent in all frames. */
static void layers_have_time_samples(void **state) {
  test_fixture *f = *state;
  neph_exported_cloud clouds[3];
  char *paths[3], name[32];
  char *layer = test_path(f->folder, "b.usda");
  for (int frame = 1; frame <= 3; frame += 2) {
    (void)snprintf(name, sizeof name, "b.%04d.vdb", frame);
    char *path = test_path(f->folder, name);
    test_boxes_write(f->context, path, "density", boxes, frame == 1 ? 1 : 2);
    free(path);
  }
  neph_scene *scene = load(f, "march", "vdb: \"b.####.vdb\", extinction: 1 1/m, position: [0, 0, 40 m]");
  neph_renderer *renderer;
  assert_int_equal(neph_renderer_create(f->context, &renderer), NEPH_OK);
  for (int i = 0; i < 3; i++) {
    (void)snprintf(name, sizeof name, "out.%d.vdb", i + 1);
    paths[i] = test_path(f->folder, name);
    clouds[i] = export_frame(renderer, scene, i + 1, NEPH_PRECISION_FLOAT, paths[i]);
    assert_int_equal(clouds[i].is_empty, i == 1);
  }
  neph_renderer_destroy(renderer);
  assert_one_warning(&f->log, "number 2");
  /* The box of frame 1 places all: the second box reaches 6 m beyond it. */
  assert_near(clouds[2].bounds_min_m[0], clouds[0].bounds_min_m[0], 0.0);
  assert_near(clouds[2].bounds_max_m[0], clouds[0].bounds_max_m[0] + 6.0, 1e-9);
  assert_int_equal(neph_scene_save_volumes_usd(scene, clouds, 3, layer), NEPH_OK);
  void *text;
  size_t size;
  assert_int_equal(np_file_read(f->context, layer, &text, &size), NEPH_OK);
  char *copy = strndup(text, size);
  np_alloc_free(f->context, text);
  assert_memory_equal(copy, "#usda 1.0\n", 10);
  static const char *const lines[] = {"metersPerUnit = 1",
                                      "upAxis = \"Z\"",
                                      "startTimeCode = 1",
                                      "endTimeCode = 3",
                                      "def Volume \"b_1\"",
                                      "float3[] extent.timeSamples = {\n      1: [(",
                                      "rel field:density = </World/b_1/density>",
                                      "def OpenVDBAsset \"density\"",
                                      "asset filePath = @./out.1.vdb@",
                                      "1: @./out.1.vdb@,",
                                      "2: None,",
                                      "3: @./out.3.vdb@,",
                                      "token fieldDataType = \"float\""};
  for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) assert_has(copy, lines[i]);
  int depth = 0; /* nesting depth of braces, brackets and parentheses */
  for (const char *c = copy; *c; c++) depth += (strchr("{[(", *c) != NULL) - (strchr("}])", *c) != NULL);
  assert_int_equal(depth, 0);
  free(copy);
  for (int i = 0; i < 3; i++) free(paths[i]);
  free(layer);
  neph_scene_destroy(scene);
}

/* ---- Refusals ---- */

static void what_cannot_be_exported_is_refused(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, "march", placed);
  neph_exported_cloud out = NEPH_EXPORTED_CLOUD_DEFAULT;
  assert_int_equal(neph_scene_export_cloud(scene, 1, 1, NULL, "x.vdb", &out), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "cloud 1 is not one of 1");
  assert_int_equal(neph_scene_export_cloud(scene, 0, 1, NULL, "/nowhere/x.vdb", &out), NEPH_ERROR_IO);
  assert_one_error(&f->log, "/nowhere");
  out.name = "a";
  out.path = "a@b.vdb";
  assert_int_equal(neph_scene_save_volumes_usd(scene, &out, 1, "x.usda"), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "a@b.vdb");
  neph_scene_destroy(scene);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {TEST(values_stand_in_the_world),
                                     TEST(pictures_are_those_of_the_scene),
                                     TEST(baked_clouds_are_exported_too),
                                     TEST(a_cancelled_export_leaves_the_folder_as_it_was),
                                     TEST(layers_have_time_samples),
                                     TEST(fields_go_with_the_cloud),
                                     TEST(pictures_of_fields_are_those_of_the_scene),
                                     TEST(fire_is_exported_in_units),
                                     TEST(layers_name_the_fields),
                                     TEST(missing_grids_are_refused),
                                     TEST(fields_are_densities_by_name_alone),
                                     TEST(levels_keep_the_optical_depth),
                                     TEST(what_cannot_be_exported_is_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
