/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/random.h"

/* Neighbouring pixels, samples and frames must be independent: the correlation of N uniform pairs has a standard
 * deviation of 1/√N, so 5/√N fails by chance once in two million. */
static void assert_uncorrelated(uint32_t frame_step, uint32_t x_step, uint32_t sample_step) {
  enum { STREAMS = 4096, NUMBERS = 16 };
  double sum = 0;
  for (uint32_t i = 0; i < STREAMS; i++) {
    np_random a = np_random_start(7, 1, i * 2, 5, 0);
    np_random b = np_random_start(7, 1 + frame_step, i * 2 + x_step, 5, sample_step);
    for (int k = 0; k < NUMBERS; k++) sum += (np_random_double(&a) - 0.5) * (np_random_double(&b) - 0.5) * 12.0;
  }
  const double count = (double)STREAMS * NUMBERS;
  assert_true(fabs(sum / count) < 5.0 / sqrt(count));
}

static void neighbouring_streams_are_uncorrelated(void **state) {
  (void)state;
  assert_uncorrelated(1, 0, 0);
  assert_uncorrelated(0, 1, 0);
  assert_uncorrelated(0, 0, 1);
}

/* Shifted copies of one stream (seeds that differ by the generator's own increment) would meet: none may. */
static void no_stream_is_a_shifted_copy(void **state) {
  (void)state;
  for (uint32_t i = 0; i < 256; i++) {
    np_random a = np_random_start(i, 0, 0, 0, 0), b = np_random_start(i + 1, 0, 0, 0, 0);
    uint64_t first = np_random_bits(&b);
    for (int k = 0; k < 256; k++) assert_true(np_random_bits(&a) != first);
  }
}

/* Chi-square over 64 bins with 2¹⁸ numbers: 63 degrees of freedom, mean 63, σ 11.2; 6 σ is 130. */
static void numbers_are_uniform(void **state) {
  (void)state;
  enum { BINS = 64, NUMBERS = 1 << 18 };
  unsigned count[BINS] = {0};
  np_random random = np_random_start(1, 2, 3, 4, 5);
  for (int i = 0; i < NUMBERS; i++) count[(int)(np_random_float(&random) * BINS)]++;
  double chi2 = 0, expected = (double)NUMBERS / BINS;
  for (int b = 0; b < BINS; b++) chi2 += (count[b] - expected) * (count[b] - expected) / expected;
  assert_true(chi2 < 130.0);
}

static void numbers_drawn_are_counted(void **state) {
  (void)state;
  for (uint32_t i = 0; i < 100; i++) {
    const np_random start = np_random_start(i, 0, 0, 0, 0);
    np_random random = start;
    for (uint32_t k = 0; k < 1000 * i; k++) (void)np_random_bits(&random);
    assert_int_equal(np_random_count(&start, &random), 1000 * i);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(neighbouring_streams_are_uncorrelated),
      cmocka_unit_test(no_stream_is_a_shifted_copy),
      cmocka_unit_test(numbers_are_uniform),
      cmocka_unit_test(numbers_drawn_are_counted),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
