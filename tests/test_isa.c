/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "core/isa.h"

/* The compiler's own reading of CPUID, feature by feature, as a second opinion. */
static void detection_agrees_with_the_compiler(void **state) {
  (void)state;
  __builtin_cpu_init();
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                  __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
  const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  assert_int_equal(np_isa_detect(), v4 ? NEPH_ISA_X86_64_V4 : v3 ? NEPH_ISA_X86_64_V3 : NEPH_ISA_X86_64);
}

static void levels_have_the_names_of_the_option(void **state) {
  (void)state;
  assert_string_equal(neph_isa_get_name(NEPH_ISA_X86_64), "x86-64");
  assert_string_equal(neph_isa_get_name(NEPH_ISA_X86_64_V3), "x86-64-v3");
  assert_string_equal(neph_isa_get_name(NEPH_ISA_X86_64_V4), "x86-64-v4");
  assert_string_equal(neph_isa_get_name((neph_isa)NP_ISA_COUNT), "unknown");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(detection_agrees_with_the_compiler),
      cmocka_unit_test(levels_have_the_names_of_the_option),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
