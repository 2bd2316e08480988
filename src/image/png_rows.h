/* SPDX-License-Identifier: Apache-2.0 */
/* The image data of a PNG file, filtered and compressed by all threads. The bytes do not depend on their number. */
#ifndef NP_IMAGE_PNG_ROWS_H
#define NP_IMAGE_PNG_ROWS_H

#include "core/context_private.h"

typedef struct np_png_rows {
  size_t height, row_bytes;
  unsigned pixel_bytes;
  void (*pack)(const void *user, size_t row, uint8_t *out_row); /* writes a row as the file has it; from any thread */
  const void *user;
} np_png_rows;

/* Contents of one IDAT chunk. */
typedef struct np_png_strip {
  uint8_t *bytes;
  size_t size;
} np_png_strip;

/* Compresses all rows; the strips follow each other in the file. On failure nothing is left. */
neph_result np_png_rows_compress(neph_context *context, const np_png_rows *rows, np_png_strip **out_strips,
                                 size_t *out_count);
void np_png_strips_free(neph_context *context, np_png_strip *strips, size_t count);

#endif
