/* SPDX-License-Identifier: Apache-2.0 */
#include "operator_new.h"

#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>

static atomic_int allocations_left = TEST_ALLOCATIONS_ALL;

void test_operator_new_limit(int count) { allocations_left = count; }

/* Names in the C++ ABI: std::__throw_bad_alloc() and operator new(size_t). */
_Noreturn void _ZSt17__throw_bad_allocv(void);
__attribute__((visibility("default"))) void *_Znwm(size_t bytes);

void *_Znwm(size_t bytes) {
  void *block = atomic_fetch_sub(&allocations_left, 1) > 0 ? malloc(bytes ? bytes : 1) : NULL;
  if (!block) _ZSt17__throw_bad_allocv();
  return block;
}
