/* SPDX-License-Identifier: Apache-2.0 */
/* Catmull-Rom splines of log M, and of the other moments divided by M, refine the nodes to a finer table once for each
 * order, so that every look-up is bilinear. */
#include "atmosphere/moment_builder.h"
#include "atmosphere/spline.h"

/* Refines one quantity from the nodes to the table: along the node rows first, then across rows. */
static void refine(const np_moment_builder *b, const np_bands *nodes) {
  const int columns = b->table->sun.columns, node_columns = b->n->node_columns, node_rows = b->n->node_rows;
  for (int i = 0; i < columns; i++) {
    const np_spline s = np_spline_make(i, columns, node_columns);
    for (int row = 0; row < node_rows; row++)
      b->refined_rows[row * columns + i] = np_spline_eval(&s, nodes + np_moment_node_at(b, (size_t)row, 0), 1);
  }
  for (int row = 0; row < b->table->rows; row++) {
    const np_spline s = np_spline_make(row, b->table->rows, node_rows);
    for (int i = 0; i < columns; i++)
      b->refined[row * columns + i] = np_spline_eval(&s, b->refined_rows + i, (size_t)columns);
  }
}

static np_bands log_of(np_bands value) { return np_bands_log(np_bands_max(value, np_bands_grey(np_moment_least))); }

/* Refines one moment: M as a logarithm, the others divided by M. */
static void refine_moment(const np_moment_builder *b, const np_bands *values, size_t k) {
  for (size_t i = 0; i < b->node_count; i++) {
    const np_bands value = values[i * NP_MOMENT_COUNT + k], whole = values[i * NP_MOMENT_COUNT];
    b->quantity[i] = k == NP_MOMENT_M ? log_of(value) : value / np_bands_max(whole, np_bands_grey(np_moment_least));
  }
  refine(b, b->quantity);
}

/* Fade-out of light over the last quarter of the night columns. */
static float fade_at(const np_sun_scale *sun, int column) {
  const float cosine = np_sun_scale_cosine(sun, (double)column / (sun->columns - 1));
  return np_smoothstepf((cosine - sun->lowest) / (-0.2f * sun->lowest));
}

static void refine_moments(const np_moment_builder *b, const np_bands *values) {
  const int columns = b->table->sun.columns;
  for (int k = 0; k < NP_MOMENT_COUNT; k++) {
    refine_moment(b, values, (size_t)k);
    for (int row = 0; row < b->table->rows; row++) {
      const np_bands *fine = b->refined + row * columns;
      np_bands *total = b->table->moments + (size_t)(row * NP_MOMENT_COUNT * columns), *out = total + k * columns;
      for (int i = 0; i < columns; i++) out[i] = k == NP_MOMENT_M ? np_bands_exp(fine[i]) : fine[i] * total[i];
    }
  }
}

static void fade_moments(const np_moment_builder *b) {
  const int columns = b->table->sun.columns;
  for (int i = 0; i < columns; i++) {
    const float fade = fade_at(&b->table->sun, i);
    for (int run = 0; fade < 1.0f && run < b->table->rows * NP_MOMENT_COUNT; run++)
      b->table->moments[run * columns + i] *= fade;
  }
}

static void refine_irradiance(const np_moment_builder *b, const np_bands *values, bool is_final) {
  const int columns = b->table->sun.columns;
  for (size_t i = 0; i < b->node_count; i++) b->quantity[i] = log_of(values[i]);
  refine(b, b->quantity);
  for (int i = 0; i < b->table->rows * columns; i++)
    b->table->irradiance[i] = np_bands_exp(b->refined[i]) * (is_final ? fade_at(&b->table->sun, i % columns) : 1.0f);
}

void np_moment_refine_order(np_moment_builder *b) {
  refine_moments(b, b->gathered);
  refine_irradiance(b, b->irradiance, false);
}

void np_moment_refine_total(np_moment_builder *b) {
  refine_moments(b, b->total);
  fade_moments(b);
  refine_irradiance(b, b->irradiance_total, true);
}
