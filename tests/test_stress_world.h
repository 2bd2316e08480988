/* SPDX-License-Identifier: Apache-2.0 */
/* The levels of the stress suite: fields of a few voxels, rays about a corner of their bricks, and optical depths along
 * rays in double precision, by the samples alone. */
#ifndef NP_TEST_STRESS_WORLD_H
#define NP_TEST_STRESS_WORLD_H

#include <stdlib.h>

#include "test_stress_cases.h"
#include "test_world.h"

#include "volume/volume_file.h"

/* STRESS_EDGE³ samples 1 m apart; that of index 8, where four bricks meet, is at 3.5 m along each axis. */
enum { STRESS_EDGE = 10 };

static const double stress_low_m = -4.5;

/* ---- Fields ---- */

typedef enum stress_field {
  STRESS_CONSTANT,
  STRESS_CHECKERBOARD,
  STRESS_ONE_VOXEL,
  STRESS_HALF_NAN,
  STRESS_NEGATIVE,
  STRESS_SUBNORMAL
} stress_field;

static const char *const stress_field_names[] = {
    "constant", "checkerboard of 0 and 1e6", "one voxel", "half NaN", "half negative", "subnormal"};

/* A sample as it is handed over. */
static inline float stress_get_raw(stress_field field, int i, int j, int k) {
  switch (field) {
  case STRESS_CONSTANT:
    return 1.0f;
  case STRESS_CHECKERBOARD:
    return (i + j + k) % 2 ? 1e6f : 0.0f;
  case STRESS_ONE_VOXEL:
    return i == 8 && j == 8 && k == 8 ? 1.0f : 0.0f;
  case STRESS_HALF_NAN:
    return i < STRESS_EDGE / 2 ? NAN : 1.0f;
  case STRESS_NEGATIVE:
    return i < STRESS_EDGE / 2 ? -1.0f : 1.0f;
  case STRESS_SUBNORMAL:
    return 1e-40f;
  default:
    return 1.0f;
  }
}

/* The same as it must be understood: 0 where it is no density, and outside. */
static inline double stress_get_value(stress_field field, int i, int j, int k) {
  const bool is_inside = i >= 0 && j >= 0 && k >= 0 && i < STRESS_EDGE && j < STRESS_EDGE && k < STRESS_EDGE;
  if (!is_inside || field == STRESS_SUBNORMAL) return 0.0;
  const double value = (double)stress_get_raw(field, i, j, k);
  return value > 0.0 ? value : 0.0;
}

static inline neph_volume_dense_desc stress_describe(stress_field field, float *values) {
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  for (int a = 0; a < 3; a++) {
    desc.size[a] = STRESS_EDGE;
    desc.index_to_world[a][3] = stress_low_m;
  }
  for (int n = 0; n < STRESS_EDGE * STRESS_EDGE * STRESS_EDGE; n++)
    values[n] = stress_get_raw(field, n % STRESS_EDGE, n / STRESS_EDGE % STRESS_EDGE, n / (STRESS_EDGE * STRESS_EDGE));
  desc.values = values;
  desc.precision = NEPH_PRECISION_FLOAT;
  return desc;
}

/* The field as a grid that was read from a file. */
static inline void stress_fill_grid(neph_context *context, stress_field field, np_sparse_grid *grid) {
  assert_int_equal(np_sparse_grid_init(context, "density", grid), NEPH_OK);
  for (int a = 0; a < 3; a++) grid->index_to_world.m[a][a] = 1.0, grid->index_to_world.m[a][3] = stress_low_m;
  for (int n = 0; n < 8; n++) {
    np_leaf *leaf = np_sparse_grid_add_leaf(grid, (const int32_t[3]){n & 4 ? 8 : 0, n & 2 ? 8 : 0, n & 1 ? 8 : 0});
    for (int v = 0; v < NP_LEAF_SIZE; v++) {
      const int i = leaf->origin[0] + (v >> 6), j = leaf->origin[1] + (v >> 3 & 7), k = leaf->origin[2] + (v & 7);
      if (i >= STRESS_EDGE || j >= STRESS_EDGE || k >= STRESS_EDGE) continue;
      leaf->values[v] = stress_get_raw(field, i, j, k);
      leaf->active[v >> 6] |= UINT64_C(1) << (v & 63);
    }
  }
  np_sparse_grid_sort(grid);
}

/* The field as a volume: an array, or, where that is refused, a repaired file. */
static inline neph_volume *stress_create_volume(neph_context *context, stress_field field) {
  neph_volume *volume = NULL;
  float values[STRESS_EDGE * STRESS_EDGE * STRESS_EDGE];
  const neph_volume_dense_desc desc = stress_describe(field, values);
  if (field != STRESS_HALF_NAN && field != STRESS_NEGATIVE) {
    assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
    return volume;
  }
  np_sparse_grid grid;
  stress_fill_grid(context, field, &grid);
  assert_int_equal(np_volume_import_values(context, "stress.vdb", &grid, NP_VALUES_OF_CLOUD, NEPH_IMPORT_REPAIR, NULL),
                   NEPH_OK);
  assert_int_equal(np_volume_create_from_grid(context, &grid, NEPH_PRECISION_FLOAT, NULL, &volume), NEPH_OK);
  np_sparse_grid_clear(&grid);
  return volume;
}

/* ---- Rays ---- */

typedef enum stress_ray {
  STRESS_OUTSIDE,
  STRESS_INSIDE,
  STRESS_FACE,
  STRESS_ALONG_EDGE,
  STRESS_CORNER,
  STRESS_AXIS,
  STRESS_FAR
} stress_ray;

static const char *const stress_ray_names[] = {"outside", "inside", "face", "edge", "corner", "axis", "from 1e7 m"};

/* A ray through the corner of the bricks, or some centimetres past it. */
static inline np_camera_ray stress_make_ray(stress_ray ray) {
  static const float directions[][3] = {
      {0.48f, 0.6f, 0.64f}, {0.36f, 0.48f, 0.8f}, {0.8f, 0.6f, 0.0f}, {1, 0, 0}, {1, 1, 1}, {0, 0, 1},
      {0.6f, -0.64f, 0.48f}};
  static const double back_m[] = {30.0, 2.5, 30.0, 30.0, 30.0, 30.0, 1e7};
  const np_vec3 d = np_vec3_normalize(np_vec3_make(directions[ray][0], directions[ray][1], directions[ray][2]));
  const bool is_even = ray == STRESS_FACE || ray == STRESS_ALONG_EDGE || ray == STRESS_CORNER;
  const np_dvec3 place = is_even ? np_dvec3_make(3.5, 3.5, 3.5) : np_dvec3_make(3.3, 3.6, 3.4);
  return (np_camera_ray){.origin = np_dvec3_along(place, d, -back_m[ray]), .direction = d, .jitter = 0.5f};
}

/* ---- Optical depth ---- */

static inline double stress_sample(stress_field field, const double at[3]) {
  int low[3];
  double sum = 0.0, share[3];
  for (int a = 0; a < 3; a++) share[a] = at[a] - (low[a] = (int)floor(at[a]));
  for (int n = 0; n < 8; n++) {
    const int d[3] = {n & 1, n >> 1 & 1, n >> 2};
    double weight = 1.0;
    for (int a = 0; a < 3; a++) weight *= d[a] ? share[a] : 1.0 - share[a];
    if (weight > 0.0) sum += weight * stress_get_value(field, low[0] + d[0], low[1] + d[1], low[2] + d[2]);
  }
  return sum;
}

/* Nearest face of the lattice of samples past `t`. */
static inline double stress_next_face(const double origin[3], const double d[3], double t) {
  double next = INFINITY;
  for (int a = 0; a < 3; a++) {
    if (d[a] == 0.0) continue;
    const double at = origin[a] + t * d[a];
    double face = d[a] > 0.0 ? floor(at + 1e-9) + 1.0 : ceil(at - 1e-9) - 1.0;
    next = fmin(next, (face - origin[a]) / d[a]);
  }
  return next;
}

/* ∫ value ds from a place on, in metres: two Gauss points between two faces of the lattice. */
static inline double stress_compute_depth(stress_field field, np_dvec3 from, np_vec3 direction) {
  const double d[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
  double t = fmax(0.0, -(from.x * d[0] + from.y * d[1] + from.z * d[2]) - 20.0), sum = 0.0;
  const np_dvec3 begin = np_dvec3_along(from, direction, t);
  const double origin[3] = {begin.x - stress_low_m, begin.y - stress_low_m, begin.z - stress_low_m};
  const double end = np_dvec3_length(begin) > 100.0 ? 0.0 : 40.0;
  for (t = 0.0; t < end;) {
    const double next = fmin(stress_next_face(origin, d, t), end), middle = 0.5 * (t + next);
    const double offset = 0.28867513459481287 * (next - t);
    for (int sign = -1; sign <= 1; sign += 2) {
      double at[3];
      for (int a = 0; a < 3; a++) at[a] = origin[a] + (middle + sign * offset) * d[a];
      sum += 0.5 * (next - t) * stress_sample(field, at);
    }
    t = next;
  }
  return sum;
}

#endif
