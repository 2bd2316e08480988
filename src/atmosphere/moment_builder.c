/* SPDX-License-Identifier: Apache-2.0 */
/* Successive orders of scattering (Chandrasekhar 1950, "Radiative Transfer", section 2), with six moments for the
 * source.
 *
 * At each node (altitude, sun cosine) the radiance of one order is gathered over directions and reduced to its moments,
 * which give the source of the next order everywhere. The rule over zenith angles is split at the true horizon, where
 * the radiance jumps. Orders 1 to 4, in opaque air to 12, are summed one by one; later ones are a geometric series with
 * the ratio of the last two, which is nearly constant once light has reached the ground. */
#include "atmosphere/moment_builder.h"

#include "atmosphere/scattering_moments.h"
#include "core/alloc.h"

/* Last gathered order; later ones form a geometric series. */
enum { SERIES_ORDER = 4, SERIES_ORDER_OPAQUE = 12 };

/* Upper limit for the ratio of the geometric series. */
static const float ratio_max = 0.9f;
/* Disk for which the table is built; its size matters little, and only at the horizon. */
static const double disk_angular_radius_rad = 0.00467396;

/* ---- Nodes ---- */

/* Directions at one altitude: Gauss points in the root of the distance to the horizon, on either side of it. */
static void place_directions(np_moment_builder *b, size_t row, const np_path_rule *rule) {
  const int up_count = b->n->up;
  const np_quadrature up = np_quadrature_gauss(up_count), down = np_quadrature_gauss(b->n->down);
  const double altitude = np_moment_altitude_of_node(b, row), horizon = np_horizon_cosine(b->medium, altitude);
  np_moment_direction *first = b->directions + row * (size_t)np_moment_count_directions(b);
  for (int k = 0; k < np_moment_count_directions(b); k++) {
    np_moment_direction *d = first + k;
    const np_quadrature *q = k < up_count ? &up : &down;
    const int at = k < up_count ? k : k - up_count;
    const double u = q->x[at], range = k < up_count ? 1.0 - horizon : -(1.0 + horizon);
    d->wz = (float)(horizon + range * u * u);
    d->weight = (float)(fabs(range) * 2.0 * u * q->weight[at] * 2.0 * NP_PI / NP_MOMENT_AZIMUTHS);
    d->ray = np_ray_on_side(b->medium, altitude, d->wz, k >= up_count);
    np_path_build(b->medium, &d->ray, rule, &d->path);
  }
}

static void place_nodes(np_moment_builder *b) {
  const np_path_rule rule = np_path_rule_make(b->n->points);
  for (int row = 0; row < b->n->node_rows; row++) place_directions(b, (size_t)row, &rule);
  for (int i = 0; i < b->n->node_columns; i++) {
    const float cosine = np_sun_scale_cosine(&b->table->sun, (double)i / (b->n->node_columns - 1));
    b->sun_cosine[i] = cosine;
    b->sun_sine[i] = sqrtf(np_maxf(1.0f - cosine * cosine, 0.0f));
  }
  for (int p = 0; p < NP_MOMENT_AZIMUTHS; p++) b->cos_azimuth[p] = (float)cos(NP_PI * (p + 0.5) / NP_MOMENT_AZIMUTHS);
}

/* ---- Orders ---- */

/* Factor from the last order to the sum of it and all later orders. */
static np_bands sum_series(np_bands last, np_bands before) {
  const np_bands ratio =
      np_bands_min(last / np_bands_max(before, np_bands_grey(np_moment_least)), np_bands_grey(ratio_max));
  return 1.0f / (1.0f - ratio);
}

/* Adds the current order to the sums. */
static void add_order(np_moment_builder *b) {
  const bool is_last = b->is_series && b->order == b->order_max;
  for (size_t i = 0; i < b->node_count; i++) {
    const np_bands m = b->gathered[i * NP_MOMENT_COUNT];
    const np_bands factor = is_last ? sum_series(m, b->last[i]) : np_bands_grey(1.0f);
    for (size_t k = 0; k < NP_MOMENT_COUNT; k++)
      b->total[i * NP_MOMENT_COUNT + k] += factor * b->gathered[i * NP_MOMENT_COUNT + k];
    b->last[i] = m;
  }
  for (size_t i = 0; i < b->node_count; i++) {
    const np_bands e = b->irradiance[i];
    b->irradiance_total[i] += e * (is_last ? sum_series(e, b->irradiance_last[i]) : np_bands_grey(1.0f));
    b->irradiance_last[i] = e;
  }
}

static neph_result sum_orders(np_moment_builder *b) {
  for (b->order = 1; b->order <= b->order_max; b->order++) {
    np_monitor_set_range(b->monitor, (b->order - 1.0) / b->order_max, (double)b->order / b->order_max);
    memset(b->gathered, 0, b->node_count * NP_MOMENT_COUNT * sizeof(np_bands));
    memset(b->irradiance, 0, b->node_count * sizeof(np_bands));
    neph_result result = b->order == 1 ? np_moment_gather_first(b) : np_moment_gather_later(b);
    if (result) return result;
    add_order(b);
    if (b->order < b->order_max) np_moment_refine_order(b);
  }
  np_moment_refine_total(b);
  return NEPH_OK;
}

static size_t count_texels(const np_moment_table *table) { return (size_t)table->rows * (size_t)table->sun.columns; }

/* Allocates one texel more than the moments need: vectors of two texels begin at the last one. */
static bool allocate_table(neph_context *context, np_moment_table *table) {
  const size_t count = count_texels(table);
  table->moments = np_alloc(context, count * NP_MOMENT_COUNT + 1, sizeof(np_bands));
  if (table->moments) table->irradiance = np_alloc(context, count, sizeof(np_bands));
  return table->irradiance;
}

/* Allocates all work arrays as one block of packets. */
static np_bands *allocate_work(np_moment_builder *b) {
  const size_t nodes = b->node_count, refined_rows = (size_t)b->n->node_rows * (size_t)b->table->sun.columns;
  const size_t each = 2 * NP_MOMENT_COUNT + 5;
  np_bands *work = np_alloc(b->context, nodes * each + refined_rows + count_texels(b->table), sizeof(np_bands));
  if (!work) return NULL;
  b->gathered = work;
  b->total = b->gathered + nodes * NP_MOMENT_COUNT;
  b->last = b->total + nodes * NP_MOMENT_COUNT;
  b->irradiance = b->last + nodes;
  b->irradiance_total = b->irradiance + nodes;
  b->irradiance_last = b->irradiance_total + nodes;
  b->quantity = b->irradiance_last + nodes;
  b->refined_rows = b->quantity + nodes;
  b->refined = b->refined_rows + refined_rows;
  return work;
}

neph_result np_moment_table_build(neph_context *context, const np_depth_table *depths, const np_moment_sizes *sizes,
                                  unsigned order_max, bool has_point_sun, np_monitor *monitor,
                                  np_moment_table *out_table) {
  const np_medium *medium = depths->medium;
  const np_sun_scale sun = np_sun_scale_make(medium, sizes->columns);
  *out_table = (np_moment_table){.medium = medium, .sun = sun, .rows = sizes->rows};
  if (!allocate_table(context, out_table)) return NEPH_ERROR_OUT_OF_MEMORY;
  np_moment_builder *b = np_alloc(context, 1, sizeof *b);
  if (!b) return NEPH_ERROR_OUT_OF_MEMORY;
  b->context = context;
  b->monitor = monitor;
  b->kernels = np_fan_get_kernels(context->isa);
  b->medium = medium;
  b->depths = depths;
  b->n = sizes;
  b->table = out_table;
  b->disk = np_sun_disk_make(disk_angular_radius_rad, has_point_sun);
  b->is_series = order_max == NP_ORDERS_ALL;
  b->order_max = !b->is_series ? order_max : medium->is_opaque ? SERIES_ORDER_OPAQUE : SERIES_ORDER;
  b->node_count = (size_t)(sizes->node_rows * sizes->node_columns);
  neph_result result = NEPH_ERROR_OUT_OF_MEMORY;
  np_bands *work = allocate_work(b);
  if (work)
    b->directions =
        np_alloc(context, (size_t)(sizes->node_rows * np_moment_count_directions(b)), sizeof *b->directions);
  if (b->directions) {
    place_nodes(b);
    result = sum_orders(b);
  }
  np_alloc_free(context, b->directions);
  np_alloc_free(context, work);
  np_alloc_free(context, b);
  return result;
}

/* Adds light from a sun of cosine `wz` to one texel of a table. */
static void add_beam(np_moment_table *table, int row, int column, np_bands light, float wz) {
  const int columns = table->sun.columns;
  np_bands *at = table->moments + (size_t)(row * NP_MOMENT_COUNT * columns + column), moments[NP_MOMENT_COUNT];
  for (int k = 0; k < NP_MOMENT_COUNT; k++) moments[k] = at[k * columns];
  np_moment_add(moments, light, sqrtf(np_maxf(1.0f - wz * wz, 0.0f)), wz);
  for (int k = 0; k < NP_MOMENT_COUNT; k++) at[k * columns] = moments[k];
}

void np_moment_table_add_beam(np_moment_table *table, const np_depth_table *brighter, const np_depth_table *darker,
                              bool has_point_sun) {
  const np_sun_disk disk = np_sun_disk_make(disk_angular_radius_rad, has_point_sun);
  const int columns = table->sun.columns;
  for (int row = 0; row < table->rows; row++) {
    const double y = (double)row / (table->rows - 1), altitude = table->medium->top_m * y * y;
    const np_depth_row bright = np_depth_table_row(brighter, altitude), dark = np_depth_table_row(darker, altitude);
    for (int i = 0; i < columns; i++) {
      const float sun = np_sun_scale_cosine(&table->sun, (double)i / (columns - 1));
      const np_bands light =
          np_bands_max(np_depth_row_sun(&bright, sun, disk) - np_depth_row_sun(&dark, sun, disk), np_bands_grey(0.0f));
      add_beam(table, row, i, light, sun);
      table->irradiance[row * columns + i] += np_maxf(sun, 0.0f) * light;
    }
  }
}
