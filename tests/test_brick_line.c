/* SPDX-License-Identifier: Apache-2.0 */
/* Compiled for x86-64-v3, where look-ups along a line are done four at a time, and by test_brick_line_v4.c for
 * x86-64-v4, where they are eight: the same bits as one at a time. */
#include "test_support.h"

#include "core/isa.h"
#include "core/random.h"
#include "volume/volume_private.h"

enum { EDGE = 40 };

#if defined(__AVX512F__)
static const neph_isa level = NEPH_ISA_X86_64_V4;
#else
static const neph_isa level = NEPH_ISA_X86_64_V3;
#endif

static void assert_lines_are_single_look_ups(neph_precision precision) {
  static float values[EDGE * EDGE * EDGE];
  np_random random = np_random_start(1, 0, 0, 0, 0);
  for (int n = 0; n < EDGE * EDGE * EDGE; n++) values[n] = 1e3f * np_random_float(&random) * np_random_float(&random);
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  for (int a = 0; a < 3; a++) desc.size[a] = EDGE;
  desc.values = values;
  desc.precision = precision;
  neph_context *context = test_context_create(1, NULL);
  neph_volume *volume;
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  static const int32_t cell[3] = {0, 0, 0}; /* unused by bricks at rest */
  for (int i = 0; i < 20000; i++) {
    /* Lines between positions in or near a brick, some of them clamped. */
    float end[6], out[NP_BRICK_LINE];
    for (int k = 0; k < 6; k++) end[k] = 9.0f * np_random_float(&random) - 0.5f;
    const int count = 1 + i % NP_BRICK_LINE;
    const np_vec3 begin = np_vec3_make(end[0], end[1], end[2]);
    const np_vec3 along = np_vec3_subtract(np_vec3_make(end[3], end[4], end[5]), begin);
    const np_vec3 step = np_vec3_scale(along, 1.0f / (float)count);
    const uint32_t brick = (uint32_t)(np_random_float(&random) * (float)volume->bricks.brick_count);
    np_brick_sample_line(&volume->bricks, brick, cell, begin, step, count, out);
    for (int k = 0; k < count; k++) {
      const np_vec3 place = np_vec3_add(begin, np_vec3_scale(step, (float)k));
      assert_true(out[k] == np_brick_sample(&volume->bricks, brick, place));
    }
  }
  neph_volume_release(volume);
  neph_context_destroy(context);
}

static void lines_are_single_look_ups(void **state) {
  (void)state;
  if (np_isa_detect() < level) {
    print_message("this machine has no such instructions\n");
    skip();
  }
  assert_lines_are_single_look_ups(NEPH_PRECISION_HALF);
  assert_lines_are_single_look_ups(NEPH_PRECISION_FLOAT);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(lines_are_single_look_ups)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
