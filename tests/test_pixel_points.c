/* SPDX-License-Identifier: Apache-2.0 */
/* Points of a pixel: how evenly they lie, and how well they find an edge. */
#include <math.h>

#include "core/random.h"
#include "frame/pixel_points.h"
#include "test_support.h"

typedef uint32_t shift_fn(float number);

typedef struct point {
  float u, v;
} point;

static point get_point(unsigned index, shift_fn *shift, const float number[2]) {
  return (point){np_pixel_coordinate(np_pixel_point_first(index), shift(number[0])),
                 np_pixel_coordinate(np_pixel_point_second(index), shift(number[1]))};
}

static void draw(np_random *random, float out[2]) {
  for (int k = 0; k < 2; k++) out[k] = np_random_float(random);
}

/* Each of 2ᵏ × 2ᵐ⁻ᵏ boxes has one of 2ᵐ points, with every shift: the property of a (0, m, 2)-net in base 2
 * (Niederreiter 1987). */
static void each_box_has_one_point(void **state) {
  (void)state;
  static shift_fn *const shifts[] = {np_pixel_shift, np_pixel_shift_to_middle};
  np_random random = np_random_start(5, 0, 0, 0, 0);
  for (int s = 0; s < 2; s++)
    for (unsigned m = 0; m <= 8; m++)
      for (unsigned k = 0; k <= m; k++) {
        bool is_taken[256] = {false};
        float number[2];
        draw(&random, number);
        for (unsigned i = 0; i < 1u << m; i++) {
          const point p = get_point(i, shifts[s], number);
          const unsigned column = (unsigned)(p.u * (float)(1u << k)), row = (unsigned)(p.v * (float)(1u << (m - k)));
          const unsigned box = column << (m - k) | row;
          assert_true(box < 1u << m && !is_taken[box]);
          is_taken[box] = true;
        }
      }
}

/* Coordinates are even over all shifts; those of the film keep to the middle halves of quarters, evenly about 1/2. */
static void shifts_are_even(void **state) {
  (void)state;
  enum { COUNT = 100000 };
  np_random random = np_random_start(6, 0, 0, 0, 0);
  double sum = 0.0, squares = 0.0, middle = 0.0;
  for (int i = 0; i < COUNT; i++) {
    float number[2];
    draw(&random, number);
    const double u = (double)get_point(0, np_pixel_shift, number).u;
    const double film = (double)get_point(0, np_pixel_shift_to_middle, number).u,
                 place = 4.0 * film - floor(4.0 * film);
    sum += u / COUNT;
    squares += u * u / COUNT;
    middle += film / COUNT;
    assert_true(place >= 0.25 && place <= 0.75);
  }
  /* Five standard errors of a mean of even numbers, 1/√12/√COUNT, and of their squares, √(4/45)/√COUNT */
  assert_true(fabs(sum - 0.5) < 5.0 * 9.1e-4 && fabs(squares - 1.0 / 3.0) < 5.0 * 9.4e-4);
  assert_true(fabs(middle - 0.5) < 5.0 * 9.1e-4);
}

/* Root of the mean square error of the share of a square below a line, tilted by 3°, at four points. */
static void a_tilted_edge_is_found(void **state) {
  (void)state;
  enum { COUNT = 20000 };
  const double tilt = tan(3.0 * 3.14159265358979 / 180.0);
  np_random random = np_random_start(7, 0, 0, 0, 0);
  double squares = 0.0;
  for (int i = 0; i < COUNT; i++) {
    float number[2];
    draw(&random, number);
    const double height = 0.1 + 0.8 * np_random_double(&random);
    double below = 0.0;
    for (unsigned k = 0; k < 4; k++) {
      const point p = get_point(k, np_pixel_shift_to_middle, number);
      below += (double)p.v < height + tilt * ((double)p.u - 0.5) ? 0.25 : 0.0;
    }
    squares += pow(below - height, 2.0) / COUNT;
  }
  /* A line that cuts a quarter at an even place, between points of its middle half: √(1/16·5/48) = 0.081; the tilt
   * moves it by 0.03 at most. Independent points would err by 0.24. */
  assert_true(sqrt(squares) < 0.09);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_box_has_one_point),
      cmocka_unit_test(shifts_are_even),
      cmocka_unit_test(a_tilted_edge_is_found),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
