/* SPDX-License-Identifier: Apache-2.0 */
/* Noise of a picture by the spread of its samples, where most of it is in a few bright paths. */
#include <math.h>

#include "core/random.h"
#include "frame/error_probes.h"
#include "stages/assembly.h"
#include "test_support.h"

enum { WIDTH = 64, HEIGHT = 36, PIXELS = WIDTH * HEIGHT, SAMPLES = 32 };

/* Samples around 1 that are spread evenly over ±0.5, and now and then one that is brighter by `excess`. */
typedef struct light {
  double chance, excess;
} light;

static double draw_sample(np_random *random, const light *l) {
  const double even = 0.5 + np_random_double(random);
  return np_random_double(random) < l->chance ? even + l->excess : even;
}

static np_pixel_luminance draw_pixel(np_random *random, const light *l) {
  double sum = 0.0, squares = 0.0;
  for (unsigned k = 0; k < SAMPLES; k++) {
    const double value = draw_sample(random, l);
    sum += value;
    squares += value * value;
  }
  const double mean = sum / SAMPLES, variance = (squares / SAMPLES - mean * mean) / (SAMPLES - 1);
  return (np_pixel_luminance){(float)mean, (float)variance, SAMPLES, 1.0f};
}

/* Root of the mean square of the picture's relative error, and what its samples say. */
static void measure(const light *l, uint32_t seed, double *out_true, double *out_stated) {
  static np_pixel_luminance luminances[PIXELS];
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  const double mean = 1.0 + l->chance * l->excess;
  double sum = 0.0;
  for (unsigned i = 0; i < PIXELS; i++) {
    luminances[i] = draw_pixel(&random, l);
    sum += pow((double)luminances[i].value / mean - 1.0, 2.0);
  }
  const np_assembly assembly = {0};
  const np_frame frame = {.assembly = &assembly, .width = WIDTH, .height = HEIGHT, .luminances = luminances};
  np_error_probes probes;
  assert_int_equal(np_error_probes_choose(&frame, 0, 0, &probes), NEPH_OK);
  assert_true(probes.pixel_count == PIXELS);
  *out_true = sqrt(sum / PIXELS);
  *out_stated = sqrt(np_error_probes_average_spread(&probes).value);
}

/* One path in 20 000 makes nine tenths of the noise and more; relative to its own pixel each would count as 1. */
static void rare_bright_paths_count_for_pixels_that_they_missed(void **state) {
  (void)state;
  static const light lights[] = {{0.0, 0.0}, {5e-5, 300.0}, {5e-5, 3000.0}, {1e-3, 100.0}};
  for (size_t i = 0; i < sizeof lights / sizeof *lights; i++)
    for (uint32_t seed = 0; seed < 20; seed++) {
      double truth, stated;
      measure(&lights[i], seed, &truth, &stated);
      if (!(stated < 1.3 * truth && truth < 1.3 * stated))
        fail_msg("light %zu, seed %u: noise of %.3g is stated, %.3g is true", i, seed, stated, truth);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rare_bright_paths_count_for_pixels_that_they_missed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
