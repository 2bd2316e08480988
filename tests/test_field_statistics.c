/* SPDX-License-Identifier: Apache-2.0 */
/* The measure of cloud fields (tests/bench), on shapes whose statistics are known. */
#include "test_support.h"

#include <stdlib.h>

#include "bench/field_statistics.h"
#include "core/random.h"

enum { MAP = 2048 };

static uint8_t *clear_map(void) {
  uint8_t *map = calloc(MAP, MAP);
  assert_non_null(map);
  return map;
}

/* Squares of random sizes on shelves, one cell apart. */
static size_t fill_shelves(uint8_t *map, const double *sizes, size_t count) {
  int x = 1, y = 1, shelf = 0;
  for (size_t n = 0; n < count; n++) {
    const int edge = (int)(sizes[n] + 0.5);
    if (x + edge + 1 >= MAP) x = 1, y += shelf + 1, shelf = 0;
    if (y + edge + 1 >= MAP) return n;
    for (int j = 0; j < edge; j++) memset(map + (size_t)(y + j) * MAP + x, 1, (size_t)edge);
    x += edge + 1;
    if (edge > shelf) shelf = edge;
  }
  return count;
}

/* A size of n ∝ L^−below from 4 to the break, L^−above beyond it. */
static double draw_size(np_random *random, double below, double above, double break_size) {
  const double low = pow(4 / break_size, 1 - below), mass_below = (low - 1) / (below - 1), mass_above = 1 / (above - 1);
  const double u = np_random_double(random) * (mass_below + mass_above);
  if (u < mass_below) return break_size * pow(low - u * (below - 1), 1 / (1 - below));
  return break_size * pow(1 - (u - mass_below) / mass_above, 1 / (1 - above));
}

/* Exponents within four of their standard errors, about (exponent − 1)/√n; the break within a third. */
static void power_laws_are_recovered(void **state) {
  (void)state;
  enum { COUNT = 5000 };
  static double sizes[COUNT];
  const double below[] = {1.7, 2.3}, above[] = {3.2, 4.5};
  for (int n = 0; n < 2; n++) {
    np_random random = np_random_start(3, 0, (uint32_t)n, 0, 0);
    for (int i = 0; i < COUNT; i++) sizes[i] = draw_size(&random, below[n], above[n], 40);
    field_power_law law;
    assert_true(field_fit_power_law(sizes, COUNT, 4, &law));
    print_message("-%.3f ± %.3f below %.1f, -%.2f above, gain %.0f\n", law.below, law.below_error, law.break_size,
                  law.above, law.gain);
    assert_near(law.below, below[n], 4 * law.below_error);
    assert_near(law.above, above[n], 0.4);
    assert_near_relative(law.break_size, 40, 0.33);
    assert_true(law.gain > 10);
  }
  assert_false(field_fit_power_law(sizes, 19, 4, &(field_power_law){0}));
}

/* Measured on the map itself: rounding to cells shifts sizes by at most half a cell, an eighth of the least. */
static void sizes_of_a_map_follow_their_law(void **state) {
  (void)state;
  enum { COUNT = 1500 };
  static double sizes[COUNT];
  uint8_t *map = clear_map();
  np_random random = np_random_start(9, 0, 0, 0, 0);
  for (int i = 0; i < COUNT; i++) sizes[i] = fmin(draw_size(&random, 2, 4, 60), 300);
  const size_t placed = fill_shelves(map, sizes, COUNT);
  assert_int_equal(placed, COUNT);
  size_t count;
  field_region *regions = field_label_regions(MAP, MAP, map, NULL, &count);
  assert_int_equal(count, placed);
  for (size_t r = 0; r < count; r++) {
    assert_near(regions[r].perimeter, 4 * sqrt(regions[r].area), 0);
    sizes[r] = sqrt(regions[r].area);
  }
  field_power_law law;
  assert_true(field_fit_power_law(sizes, count, 5.5, &law));
  print_message("-%.3f ± %.3f below %.0f\n", law.below, law.below_error, law.break_size);
  assert_near(law.below, 2, 4 * law.below_error);
  const field_line line = field_fit_dimension(regions, count, 30);
  assert_near(line.slope, 1, 1e-9);
  assert_true(line.decades > 2);
  free(regions);
  free(map);
}

/* ---- Koch's snowflake ---- */

typedef struct outline {
  double (*points)[2];
  size_t count;
} outline;

static void add_side(outline *o, double ax, double ay, double bx, double by, int depth) {
  const double dx = (bx - ax) / 3, dy = (by - ay) / 3;
  if (depth == 0) {
    o->points[o->count][0] = ax;
    o->points[o->count++][1] = ay;
    return;
  }
  const double px = ax + 1.5 * dx + 0.8660254037844386 * dy, py = ay + 1.5 * dy - 0.8660254037844386 * dx;
  add_side(o, ax, ay, ax + dx, ay + dy, depth - 1);
  add_side(o, ax + dx, ay + dy, px, py, depth - 1);
  add_side(o, px, py, bx - dx, by - dy, depth - 1);
  add_side(o, bx - dx, by - dy, bx, by, depth - 1);
}

static void fill_outline(uint8_t *map, const outline *o, double x0, double y0, double scale) {
  for (size_t n = 0; n < o->count; n++) {
    const double *a = o->points[n], *b = o->points[(n + 1) % o->count];
    const double ay = y0 + scale * a[1], by = y0 + scale * b[1];
    for (int j = (int)ceil(fmin(ay, by)); j < fmax(ay, by); j++) {
      const double x = x0 + scale * (a[0] + (b[0] - a[0]) * (j - ay) / (by - ay));
      for (int i = (int)ceil(x); i < MAP; i++) map[(size_t)j * MAP + (size_t)i] ^= 1;
    }
  }
}

static void draw_triangle(outline *o, int depth) {
  const double corners[3][2] = {{0, 1}, {-0.8660254037844386, -0.5}, {0.8660254037844386, -0.5}};
  o->count = 0;
  for (int n = 0; n < 3; n++) {
    const double *a = corners[n], *b = corners[(n + 1) % 3];
    add_side(o, a[0], a[1], b[0], b[1], depth);
  }
}

/* Outlines of sizes from 5 to 500 cells: the least edge of their polygons is below a cell. log 4/log 3 = 1.262, but for
 * its steps by factors of three, over which the bins' places leave 0.04. Discs give 1, to 0.02. */
static void dimensions_are_those_of_shapes(void **state) {
  (void)state;
  enum { DEPTH = 6, SHAPES = 60 };
  outline o = {calloc(3 * 4096, sizeof *o.points), 0};
  uint8_t *map = clear_map();
  for (int is_disc = 0; is_disc < 2; is_disc++) {
    field_region regions[SHAPES * 4];
    size_t kept = 0;
    draw_triangle(&o, DEPTH);
    for (int n = 0; n < SHAPES; n++) {
      const double radius = 4 * pow(125, n / (SHAPES - 1.0));
      memset(map, 0, (size_t)MAP * MAP);
      if (!is_disc) fill_outline(map, &o, MAP / 2 + 0.37, MAP / 2 + 0.41, radius);
      for (int j = -(int)radius - 1; j <= radius + 1 && is_disc; j++)
        for (int i = -(int)radius - 1; i <= radius + 1; i++)
          map[(MAP / 2 + j) * MAP + MAP / 2 + i] = i * i + j * j < radius * radius;
      size_t count;
      field_region *all = field_label_regions(MAP, MAP, map, NULL, &count);
      for (int copy = 0; copy < 4; copy++) regions[kept++] = all[count / 2];
      free(all);
    }
    const field_line line = field_fit_dimension(regions, kept, 60);
    print_message("%s: %.3f ± %.3f over %.1f decades\n", is_disc ? "disc" : "snowflake", line.slope, line.error,
                  line.decades);
    assert_true(line.decades > 3);
    assert_near(line.slope, is_disc ? 1 : 1.2619, is_disc ? 0.02 : 0.04);
  }
  free(o.points);
  free(map);
}

/* Plane waves of all directions, their numbers spread evenly in ln k: squares of amplitudes ∝ k^(1 − β) make spectra of
 * lines ∝ k^−β. A tenth of a decade has 30 waves, which leaves 0.15 of the slope. */
static void spectra_have_their_slope(void **state) {
  (void)state;
  enum { EDGE = 256, WAVES = 600 };
  static float map[EDGE * EDGE];
  const double slopes[] = {5.0 / 3, 2.5};
  for (int n = 0; n < 2; n++) {
    np_random random = np_random_start(4, 0, (uint32_t)n, 0, 0);
    memset(map, 0, sizeof map);
    for (int w = 0; w < WAVES; w++) {
      const double k = exp(log(100) * (w + np_random_double(&random)) / WAVES), size = pow(k, 0.5 * (1 - slopes[n]));
      const double turn = 6.283185307179586 * np_random_double(&random), phase = 10 * np_random_double(&random);
      const double kx = 6.283185307179586 / EDGE * k * cos(turn), ky = 6.283185307179586 / EDGE * k * sin(turn);
      for (int j = 0; j < EDGE; j++)
        for (int i = 0; i < EDGE; i++) map[j * EDGE + i] += (float)(size * cos(kx * i + ky * j + phase));
    }
    field_line line;
    assert_true(field_fit_spectrum(EDGE, EDGE, map, 6, 60, &line));
    print_message("%.3f ± %.3f for -%.3f\n", line.slope, line.error, slopes[n]);
    assert_near(line.slope, -slopes[n], 0.15);
  }
}

static void components_are_counted(void **state) {
  (void)state;
  const int32_t size[3] = {4, 5, 6};
  uint8_t map[4 * 5 * 6] = {0};
  for (int i = 0; i < 4; i++) map[(i * 5 + 0) * 6 + 2] = 1;                           /* a bar */
  map[(3 * 5 + 1) * 6 + 2] = map[(3 * 5 + 2) * 6 + 2] = 1;                            /* its arm */
  map[(0 * 5 + 2) * 6 + 2] = map[(1 * 5 + 2) * 6 + 2] = map[(2 * 5 + 2) * 6 + 2] = 1; /* which turns back */
  map[(1 * 5 + 4) * 6 + 5] = 1;
  size_t count;
  field_component *components = field_label_components(size, map, &count);
  assert_int_equal(count, 2);
  assert_near(components[0].volume, 9, 0);
  assert_int_equal(components[0].lowest, 2);
  assert_near(components[1].volume, 1, 0);
  assert_int_equal(components[1].lowest, 5);
  free(components);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(power_laws_are_recovered),       cmocka_unit_test(sizes_of_a_map_follow_their_law),
      cmocka_unit_test(dimensions_are_those_of_shapes), cmocka_unit_test(spectra_have_their_slope),
      cmocka_unit_test(components_are_counted),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
