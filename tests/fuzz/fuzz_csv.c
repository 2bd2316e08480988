/* SPDX-License-Identifier: Apache-2.0 */
/* A table of comma-separated values: every field of it as a number. */
#include "fuzz_support.h"

#include "core/csv.h"

static void read_fields(const np_csv *csv) {
  double value;
  for (size_t row = 0; row < csv->row_count; row++)
    for (size_t column = 0; column < csv->column_count; column++)
      fuzz_expect(np_csv_get_real(csv, row, (int)column, -1e9, 1e9, &value));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  np_csv csv;
  const neph_result result = np_csv_load(fuzz_get_context(), fuzz_write_file("table.csv", data, size), &csv);
  fuzz_expect(result);
  if (!result) read_fields(&csv);
  np_csv_clear(&csv);
  return 0;
}
