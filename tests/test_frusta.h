/* SPDX-License-Identifier: Apache-2.0 */
/* Files of grids whose voxels are those of a frustum. */
#ifndef NP_TEST_FRUSTA_H
#define NP_TEST_FRUSTA_H

#include "test_support.h"

#include "vdb_edit.h"
#include "volume/volume_private.h"

/* A frustum as OpenVDB has it: index (i, j, k) of a box to x = s·(i − i₀), y = s·(j − j₀), z = step·k, where
 * s = (1 + γ·z) / width; then turned, enlarged and moved. */
typedef struct test_frustum {
  double size[3];     /* size of the index box, which begins at 0 */
  double near, far;   /* distances from the eye, in units of the near plane's width */
  double scale, turn; /* scale and rotation of the whole */
  double at[3];       /* world position of the near plane's centre */
} test_frustum;

static inline void test_frustum_make_matrix(const test_frustum *f, double out[16]) {
  const double c = f->scale * cos(f->turn), s = f->scale * sin(f->turn);
  const double rows[16] = {c, s, 0, 0, 0, 0, f->scale, 0, s, -c, 0, 0, f->at[0], f->at[1], f->at[2], 1};
  memcpy(out, rows, sizeof rows);
}

/* Writes grids, and makes each one of the frustum. */
static inline void test_frustum_write(test_fixture *fixture, const test_frustum *f, const np_vdb_write_grid *grids,
                                      size_t count) {
  double matrix[16];
  const double map[8] = {0, 0, 0, f->size[0], f->size[1], f->size[2], f->near / f->far, f->far - f->near};
  vdb_edit e = {.data = NULL};
  test_frustum_make_matrix(f, matrix);
  assert_int_equal(np_volume_save_grids(fixture->context, fixture->path, grids, count, NULL), NEPH_OK);
  FILE *file = fopen(fixture->path, "rb");
  assert_non_null(file);
  assert_int_equal(fseek(file, 0, SEEK_END), 0);
  e.size = (size_t)ftell(file);
  rewind(file);
  e.data = malloc(e.size);
  assert_non_null(e.data);
  assert_int_equal(fread(e.data, 1, e.size, file), e.size);
  assert_int_equal(fclose(file), 0);
  assert_true(vdb_edit_parse(&e));
  for (size_t g = 0; g < count; g++) assert_true(vdb_edit_set_frustum(&e, g, map, matrix));
  file = fopen(fixture->path, "wb");
  assert_int_equal(fwrite(e.data, 1, e.size, file), e.size);
  assert_int_equal(fclose(file), 0);
  free(e.data);
}

#endif
