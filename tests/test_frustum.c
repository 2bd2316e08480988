/* SPDX-License-Identifier: Apache-2.0 */
/* Grids of a frustum against OpenVDB's own sampler: line integrals, mass, the densest column, and refusals. */
#include "test_frusta.h"
#include "test_grids.h"

#include <nephos/volume.h>

#include "volume/frustum.h"
#include "volume/volume_tint.h"

static int set_up(void **state) { return test_set_up(state, 2, "cloud.vdb"); }

static double get_width(const test_frustum *f, double z) { return (1.0 + z / f->near) / f->size[0]; }

static np_dvec3 to_index(const test_frustum *f, np_dvec3 p) {
  double m[16], local[3];
  const double away[3] = {p.x - f->at[0], p.y - f->at[1], p.z - f->at[2]};
  test_frustum_make_matrix(f, m);
  for (int a = 0; a < 3; a++)
    local[a] = (m[4 * a] * away[0] + m[4 * a + 1] * away[1] + m[4 * a + 2] * away[2]) / (f->scale * f->scale);
  const double width = get_width(f, local[2]), step = (f->far - f->near) / f->size[2];
  return np_dvec3_make(local[0] / width + 0.5 * f->size[0], local[1] / width + 0.5 * f->size[1], local[2] / step);
}

static np_dvec3 to_world(const test_frustum *f, double i, double j, double k) {
  double m[16];
  const double z = k * (f->far - f->near) / f->size[2], width = get_width(f, z);
  const double local[3] = {width * (i - 0.5 * f->size[0]), width * (j - 0.5 * f->size[1]), z};
  test_frustum_make_matrix(f, m);
  double out[3];
  for (int a = 0; a < 3; a++) out[a] = f->at[a] + local[0] * m[a] + local[1] * m[4 + a] + local[2] * m[8 + a];
  return np_dvec3_make(out[0], out[1], out[2]);
}

/* ---- Files ---- */

static double eval_blobs(const double at[3], double blobs[][4], int count) {
  double sum = 0.0;
  for (int b = 0; b < count; b++) {
    double away = 0.0;
    for (int a = 0; a < 3; a++) away += (at[a] - blobs[b][a]) * (at[a] - blobs[b][a]);
    sum = fmax(sum, 1.0 - away / (blobs[b][3] * blobs[b][3]));
  }
  return sum;
}

/* Balls of the index space, of radius 3 to 8 voxels, densest in the middle. */
static void make_cloud(test_fixture *fixture, const test_frustum *f, np_random *random, np_sparse_grid *out) {
  enum { BLOBS = 12 };
  double blobs[BLOBS][4];
  for (int b = 0; b < BLOBS; b++) {
    blobs[b][3] = test_random_in(random, 3.0, 8.0);
    for (int a = 0; a < 3; a++) blobs[b][a] = test_random_in(random, blobs[b][3], f->size[a] - blobs[b][3]);
  }
  assert_int_equal(np_sparse_grid_init(fixture->context, "density", out), NEPH_OK);
  int32_t origin[3];
  for (origin[0] = 0; origin[0] < f->size[0]; origin[0] += 8)
    for (origin[1] = 0; origin[1] < f->size[1]; origin[1] += 8)
      for (origin[2] = 0; origin[2] < f->size[2]; origin[2] += 8) {
        np_leaf leaf = {{origin[0], origin[1], origin[2]}, {0}, {0}};
        bool is_filled = false;
        for (int n = 0; n < NP_LEAF_SIZE; n++) {
          const double at[3] = {origin[0] + (n >> 6), origin[1] + (n >> 3 & 7), origin[2] + (n & 7)};
          leaf.values[n] = (float)eval_blobs(at, blobs, BLOBS);
          if (leaf.values[n] > 0.0f) leaf.active[n >> 6] |= UINT64_C(1) << (n & 63), is_filled = true;
        }
        if (is_filled) *np_sparse_grid_add_leaf(out, origin) = leaf;
      }
  np_sparse_grid_sort(out);
}

static neph_volume *load(test_fixture *fixture) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume = NULL;
  desc.precision = NEPH_PRECISION_FLOAT;
  if (neph_volume_load(fixture->context, fixture->path, &desc, &volume)) fail_msg("%s", fixture->log.text);
  return volume;
}

/* ---- Fields ---- */

/* Sums of both fields at places on a line, or in a box. */
typedef struct sums {
  double own, reference;
} sums;

static sums add_up(const test_frustum *f, const np_vdb_module *module, const np_sparse_grid *grid,
                   const neph_volume *volume, const np_dvec3 *places, size_t count) {
  sums out = {0.0, 0.0};
  np_vdb_error error;
  double *world = malloc(3 * count * sizeof *world), *index = malloc(3 * count * sizeof *index);
  float *own = malloc(count * sizeof *own), *reference = malloc(count * sizeof *reference);
  for (size_t i = 0; i < count; i++) {
    const np_dvec3 at = to_index(f, places[i]);
    world[3 * i] = places[i].x, world[3 * i + 1] = places[i].y, world[3 * i + 2] = places[i].z;
    index[3 * i] = at.x, index[3 * i + 1] = at.y, index[3 * i + 2] = at.z;
  }
  neph_volume_sample(volume, count, world, own);
  assert_int_equal(module->sample(grid, count, index, reference, &error), NEPH_OK);
  for (size_t i = 0; i < count; i++) out.own += (double)own[i], out.reference += (double)reference[i];
  free(world), free(index), free(own), free(reference);
  return out;
}

static np_dvec3 draw_place(const test_frustum *f, np_random *random) {
  return to_world(f, test_random_in(random, 0, f->size[0]), test_random_in(random, 0, f->size[1]),
                  test_random_in(random, 0, f->size[2]));
}

enum { STEPS = 4000, LINES = 60, PLACES = 200000 };

/* Lines from one drawn place to another: the largest difference among those through 0.3 of the mean or more. */
static double compare_lines(const test_frustum *f, const np_vdb_module *module, const np_sparse_grid *grid,
                            const neph_volume *volume, np_random *random) {
  static np_dvec3 places[STEPS];
  sums all[LINES], mean = {0.0, 0.0};
  double worst = 0.0;
  for (int n = 0; n < LINES; n++) {
    const np_dvec3 a = draw_place(f, random), b = draw_place(f, random);
    for (int i = 0; i < STEPS; i++)
      places[i] = np_dvec3_add(a, np_dvec3_scale(np_dvec3_subtract(b, a), (i + 0.5) / STEPS));
    all[n] = add_up(f, module, grid, volume, places, STEPS);
    mean.reference += all[n].reference / LINES;
  }
  for (int n = 0; n < LINES; n++)
    if (all[n].reference > 0.3 * mean.reference) worst = fmax(worst, fabs(all[n].own / all[n].reference - 1.0));
  return worst;
}

/* Places even in the frustum, each of which stands for its share of the volume: narrow ones count as wide ones. */
static double compare_masses(const test_frustum *f, const np_vdb_module *module, const np_sparse_grid *grid,
                             const neph_volume *volume, np_random *random) {
  static np_dvec3 places[PLACES];
  double own = 0.0, reference = 0.0;
  enum { LAYERS = 50 };
  for (int n = 0; n < LAYERS; n++) {
    const double low = f->size[2] * n / LAYERS, high = f->size[2] * (n + 1) / LAYERS;
    const double z = 0.5 * (low + high) * (f->far - f->near) / f->size[2], width = get_width(f, z);
    for (int i = 0; i < PLACES / LAYERS; i++)
      places[i] = to_world(f, test_random_in(random, 0, f->size[0]), test_random_in(random, 0, f->size[1]),
                           test_random_in(random, low, high));
    const sums of_layer = add_up(f, module, grid, volume, places, PLACES / LAYERS);
    own += width * width * of_layer.own;
    reference += width * width * of_layer.reference;
  }
  return own / reference - 1.0;
}

static const test_frustum frusta[] = {
    {{64, 36, 64}, 1.0, 50.0, 1.0, 0.0, {0, 0, 0}},
    {{48, 48, 64}, 0.5, 100.0, 3.0, 0.7, {5, -9, 2}}, /* 90° wide, 200 times as far */
    {{64, 64, 96}, 2.0, 4.0, 100.0, -2.0, {4e6, 1e5, 0}},
    {{80, 40, 24}, 10.0, 30.0, 1.0, 1.2, {0, 0, 300}},
    {{40, 40, 40}, 1.0, 0.2, 1.0, 0.3, {0, 0, 0}}}; /* narrows away from its first plane */

/* 5 % of a line and 1 % of the mass are the promise of the page of formats. */
static void drawn_frusta_agree_with_the_sampler(void **state) {
  test_fixture *fixture = *state;
  const np_vdb_module *module;
  assert_int_equal(np_vdb_module_get(fixture->context, &module), NEPH_OK);
  for (size_t i = 0; i < sizeof frusta / sizeof *frusta; i++) {
    const test_frustum *f = &frusta[i];
    np_random random = np_random_start(i, 1, 2, 3, 4);
    np_sparse_grid grid;
    make_cloud(fixture, f, &random, &grid);
    const np_vdb_write_grid output = {.grid = &grid};
    test_frustum_write(fixture, f, &output, 1);
    neph_volume *volume = load(fixture);
    const double lines = compare_lines(f, module, &grid, volume, &random);
    const double mass = compare_masses(f, module, &grid, volume, &random);
    print_message("frustum %zu: %u levels, lines %.2f %%, mass %+.3f %%\n", i, np_volume_count_parts(volume),
                  100 * lines, 100 * mass);
    assert_true(lines < 0.05);
    assert_true(fabs(mass) < 0.01);
    neph_volume_release(volume);
    np_sparse_grid_clear(&grid);
  }
}

/* No voxel of a level is larger than the frustum's own at any place of the cells that the level owns. */
static void no_voxel_is_larger_than_the_frustums(void **state) {
  (void)state;
  const test_frustum *f = &frusta[1];
  np_frustum map = {.is_enabled = true,
                    .origin = {0.5 * f->size[0], 0.5 * f->size[1], 0.0},
                    .scale = 1.0 / f->size[0],
                    .growth = 1.0 / f->near,
                    .step = (f->far - f->near) / f->size[2],
                    .local_to_world = np_affine_identity()};
  const np_frustum_block box = {{-1, -1, -1}, {f->size[0], f->size[1], f->size[2]}}; /* a voxel around what it holds */
  np_frustum_lattice lattice;
  assert_true(np_frustum_lattice_make(&map, &box, 1.0, NP_FRUSTUM_LEVELS_MAX, &lattice));
  assert_int_equal(lattice.level_count, 8);
  for (unsigned k = 0; k < lattice.level_count; k++) {
    const np_affine own = np_frustum_lattice_get_affine(&lattice, k);
    const double first = k ? 8.0 * lattice.slabs[k].first : 0.0, begin = own.m[2][3] + own.m[2][2] * first;
    assert_true(own.m[0][0] <= get_width(f, begin) * (1.0 + 1e-9));
    assert_true(own.m[2][2] <= map.step * (1.0 + 1e-9));
    if (k) assert_int_equal(lattice.slabs[k - 1].end, 2 * lattice.slabs[k].first);
  }
}

static neph_result load_once(test_fixture *fixture) {
  neph_volume *volume = NULL;
  test_log_clear(&fixture->log);
  const neph_result result = neph_volume_load(fixture->context, fixture->path, NULL, &volume);
  neph_volume_release(volume);
  return result;
}

/* Two million voxels of a wide and deep frustum, all full, are a hundred million even ones. */
static void a_frustum_beyond_memory_is_refused_with_the_numbers(void **state) {
  test_fixture *fixture = *state;
  const test_frustum f = {{128, 128, 128}, 0.5, 100.0, 1.0, 0.0, {0, 0, 0}};
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(fixture->context, "density", &grid), NEPH_OK);
  (void)np_sparse_grid_add_tile(&grid, (const int32_t[3]){0, 0, 0}, 128, 1.0f, true);
  const np_vdb_write_grid output = {.grid = &grid};
  test_frustum_write(fixture, &f, &output, 1);
  assert_int_equal(load_once(fixture), NEPH_ERROR_LIMIT);
  assert_one_error(&fixture->log, "would take", "clip the part nearest to its camera");
  np_sparse_grid_clear(&grid);
}

/* Its voxels have no width 64 planes before the first. */
static void a_frustum_that_narrows_to_a_point_is_refused(void **state) {
  test_fixture *fixture = *state;
  const test_frustum f = {{64, 64, 64}, 1.0, 2.0, 1.0, 0.0, {0, 0, 0}};
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(fixture->context, "density", &grid), NEPH_OK);
  (void)np_sparse_grid_add_tile(&grid, (const int32_t[3]){0, 0, -72}, 8, 1.0f, true);
  (void)np_sparse_grid_add_tile(&grid, (const int32_t[3]){0, 0, 8}, 8, 1.0f, true);
  const np_vdb_write_grid output = {.grid = &grid};
  test_frustum_write(fixture, &f, &output, 1);
  assert_int_equal(load_once(fixture), NEPH_ERROR_BAD_FILE);
  assert_one_error(&fixture->log, "narrow to a point");
  np_sparse_grid_clear(&grid);
}

/* Vertical lines through all levels: the largest of the reference's, a voxel apart in the middle of the depth. */
static void the_densest_column_runs_through_all_levels(void **state) {
  test_fixture *fixture = *state;
  const test_frustum *f = &frusta[1];
  const np_vdb_module *module;
  np_random random = np_random_start(9, 1, 2, 3, 4);
  np_sparse_grid grid;
  np_monitor monitor;
  np_affine place = np_affine_identity();
  static np_dvec3 places[STEPS];
  double column = 0.0, reference = 0.0;
  np_monitor_start(&monitor, fixture->context, NULL, NULL);
  assert_int_equal(np_vdb_module_get(fixture->context, &module), NEPH_OK);
  make_cloud(fixture, f, &random, &grid);
  const np_vdb_write_grid output = {.grid = &grid};
  test_frustum_write(fixture, f, &output, 1);
  neph_volume *volume = load(fixture);
  place = volume->index_to_world;
  assert_int_equal(np_volume_get_column_max(volume, &place, &monitor, &column), NEPH_OK);
  const double half = 0.5 * 300.0, length = 2.0 * half;
  for (int n = 0; n < 400; n++) {
    const np_dvec3 middle = draw_place(f, &random);
    for (int i = 0; i < STEPS; i++)
      places[i] = np_dvec3_make(middle.x, middle.y, f->at[2] - half + length * (i + 0.5) / STEPS);
    reference = fmax(reference, add_up(f, module, &grid, volume, places, STEPS).reference * length / STEPS);
  }
  print_message("column %.4g, drawn ones at most %.4g\n", column, reference);
  assert_true(column > 0.95 * reference && column < 1.3 * reference); /* 400 lines need not meet the densest */
  neph_volume_release(volume);
  np_sparse_grid_clear(&grid);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(drawn_frusta_agree_with_the_sampler, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(no_voxel_is_larger_than_the_frustums, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_frustum_beyond_memory_is_refused_with_the_numbers, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_frustum_that_narrows_to_a_point_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_densest_column_runs_through_all_levels, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
