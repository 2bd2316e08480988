/* SPDX-License-Identifier: Apache-2.0 */
/* A table of numbers of the I3RC, a small one. */
#include "fuzz_support.h"

#include "probe/i3rc_case.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  enum { COUNT = 8 };
  double numbers[COUNT];
  fuzz_expect(np_i3rc_read_numbers(fuzz_get_context(), fuzz_write_file("table.txt", data, size), COUNT, numbers));
  return 0;
}
