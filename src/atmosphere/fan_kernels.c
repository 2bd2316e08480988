/* SPDX-License-Identifier: Apache-2.0 */
/* Table look-ups for a fan's rays at one point: sunlight, and the source of scattered light.
 *
 * Along a fan the ray's zenith cosine ωz, the altitude and all coefficients are the same. So the source of later orders
 *
 * J(ω) = a·M + b·F·ω + c·ω·Kω
 *
 * is reduced, once for the fan, to a quadratic in ωx for each column of sun cosines. A ray evaluates the quadratics of
 * the two columns around its sun, and interpolates. Vectors hold two columns of three bands each.
 *
 * Every lane is computed by the same operations at any width: all instruction sets give the same bits. */
#include "atmosphere/fan.h"
#include "core/isa.h"

/* A vector of one or two columns, whichever fills the registers of the instruction set. */
#if defined(__AVX__)
typedef float block __attribute__((vector_size(32), aligned(16), may_alias));
#else
typedef float block __attribute__((vector_size(16), aligned(16), may_alias));
#endif

enum { BANDS = sizeof(np_bands) / sizeof(float), BLOCK = sizeof(block) / sizeof(np_bands) };

/* ---- Sunlight ---- */

/* State of the suns in a step for np_depth_row_sun: all high, some disks possibly cut by the horizon, or all set. */
typedef enum daylight { IS_NIGHT, IS_CUT, IS_HIGH } daylight;

static daylight classify(const np_depth_row *row, np_sun_disk disk, const float *sun) {
  float low = sun[0], high = sun[0];
  for (int i = 1; i < NP_FAN_STEP; i++) {
    low = np_minf(low, sun[i]);
    high = np_maxf(high, sun[i]);
  }
  if (-2.0f * (high - row->horizon_cosine) * row->disk_scale * disk.inverse_diameter >= 1.0f) return IS_NIGHT;
  return low >= 0.0f && (low - row->horizon_cosine) * row->disk_scale > 0.2f ? IS_HIGH : IS_CUT;
}

/* np_disk_rule_make: visible parts of the disks, and two cosines for each. */
static void split_disks(const np_depth_row *row, np_sun_disk disk, const float *sun, float *out_visible, float *out_low,
                        float *out_high) {
  const float radius = 0.5f / (disk.inverse_diameter * row->disk_scale);
#pragma omp simd
  for (int i = 0; i < NP_FAN_STEP; i++) {
    const float above = (sun[i] - row->horizon_cosine) * row->disk_scale;
    const float horizon = np_clampf(-2.0f * above * disk.inverse_diameter, -1.0f, 1.0f);
    const float half_chord = sqrtf(np_maxf(1.0f - horizon * horizon, 0.0f));
    const float visible = (np_acos_coarse(horizon) - horizon * half_chord) * (1.0f / NP_PI_F);
    const float center = (2.0f / 3.0f) * half_chord * half_chord * half_chord / (NP_PI_F * np_maxf(visible, 1e-4f));
    const float spread = 0.25f * (1.0f - horizon);
    out_visible[i] = disk.is_point ? np_point_sun_visible(horizon) : visible > 1e-4f ? visible : 0.0f;
    out_low[i] = np_maxf(disk.is_point ? sun[i] : sun[i] + radius * (center - spread), row->horizon_cosine);
    out_high[i] = np_maxf(disk.is_point ? sun[i] : sun[i] + radius * (center + spread), row->horizon_cosine);
  }
}

/* np_depth_row_level for descending rays, whose perigees are level. */
static void add_level_depths(const np_depth_row *row, const float *cosine, np_bands *depth) {
  for (int i = 0; i < NP_FAN_STEP; i++) {
    if (cosine[i] >= 0.0f) continue;
    const float c = cosine[i], lowest = row->altitude_m - row->r * c * c / (1.0f + sqrtf(1.0f - c * c));
    depth[i] = 2.0f * (np_depth_row_level(row, lowest) + row->level_offset) - depth[i];
  }
}

/* Transmittance to the top along rays of given cosines: np_depth_row_lookup in a row interpolated to `mixed`. */
static void compute_transmittance(const np_depth_row *row, const np_bands *mixed, const float *cosine, bool may_fall,
                                  np_bands *out) {
  int32_t column[NP_FAN_STEP];
  float upper[NP_FAN_STEP];
#pragma omp simd
  for (int i = 0; i < NP_FAN_STEP; i++) {
    const float b = row->r * fabsf(cosine[i]), distance = row->exit / (b + sqrtf(b * b + row->exit));
    const float x = np_clampf((distance - row->distance_min) * row->texels_per_m, 0.0f, (float)(row->columns - 1));
    column[i] = (int32_t)np_minf(x, (float)(row->columns - 2));
    upper[i] = x - (float)column[i];
  }
  for (int i = 0; i < NP_FAN_STEP; i++) {
    const np_bands *d = mixed + column[i];
    out[i] = np_bands_mix(d[0], d[1], upper[i]);
  }
  if (may_fall) add_level_depths(row, cosine, out);
  float *lane = (float *)out;
#pragma omp simd
  for (int i = 0; i < NP_FAN_STEP * BANDS; i++) lane[i] = np_exp_lane(-lane[i]);
}

static void compute_sunlight_step(const np_depth_row *row, const np_bands *mixed, np_sun_disk disk, const float *sun,
                                  np_bands *out) {
  const daylight kind = classify(row, disk, sun);
  if (kind == IS_NIGHT) memset(out, 0, NP_FAN_STEP * sizeof *out);
  if (kind == IS_HIGH) compute_transmittance(row, mixed, sun, false, out);
  if (kind != IS_CUT) return;
  float visible[NP_FAN_STEP], low[NP_FAN_STEP], high[NP_FAN_STEP];
  np_bands upper[NP_FAN_STEP];
  split_disks(row, disk, sun, visible, low, high);
  compute_transmittance(row, mixed, low, true, out);
  compute_transmittance(row, mixed, high, true, upper);
  for (int i = 0; i < NP_FAN_STEP; i++) out[i] = 0.5f * visible[i] * (out[i] + upper[i]);
}

static void compute_sunlight(const np_depth_row *row, np_sun_disk disk, const np_fan_point *point,
                             np_bands *out_sunlight) {
  np_bands mixed[NP_DEPTH_COLUMNS_MAX];
  for (int i = 0; i < row->columns; i++) mixed[i] = np_bands_mix(row->lower[i], row->upper[i], row->upper_weight);
  for (int i = 0; i < point->count; i += NP_FAN_STEP)
    compute_sunlight_step(row, mixed, disk, point->sun_cosine + i, out_sunlight + i);
}

/* ---- Coordinates of the rays ---- */

static void compute_sun_cosines(const np_fan *fan, float t, float r, np_fan_point *out_point) {
  const float inverse_r = 1.0f / r;
  out_point->count = np_fan_count_steps(fan->count) * NP_FAN_STEP;
#pragma omp simd
  for (int i = 0; i < out_point->count; i++)
    out_point->sun_cosine[i] =
        np_clampf((fan->r * fan->sun_cosine[i] + t * fan->angle_cosine[i]) * inverse_r, -1.0f, 1.0f);
}

static void compute_columns(const np_sun_scale *scale, const np_fan *fan, float cosine, np_fan_point *point) {
  const float last = (float)(scale->columns - 2);
#pragma omp simd
  for (int i = 0; i < point->count; i++) {
    const float column = np_sun_scale_column(scale, point->sun_cosine[i]);
    point->column[i] = (int32_t)np_minf(column, last);
    point->upper[i] = column - (float)point->column[i];
    point->x[i] = np_direction_x(fan->angle_cosine[i], cosine, point->sun_cosine[i]);
  }
}

/* ---- Later orders ---- */

/* M, and the quadratics in ωx, for each column. */
typedef struct folded_source {
  np_bands constant[NP_MOMENT_COLUMNS_MAX + 2], linear[NP_MOMENT_COLUMNS_MAX + 2], square[NP_MOMENT_COLUMNS_MAX + 2];
  np_bands total[NP_MOMENT_COLUMNS_MAX + 2];
} folded_source;

static inline void set_block(np_bands value, block *out) {
  const np_bands both[2] = {value, value};
  *out = *(const block *)both;
}

/* Interpolates one moment between two rows, for a block of columns. */
static inline void mix_rows(const np_bands *low, const np_bands *high, float upper, block *out) {
  const block below = *(const block *)low;
  *out = below + upper * (*(const block *)high - below);
}

/* Range of columns that a point's rays use. */
static void compute_range(const np_fan_point *point, int *out_first, int *out_last) {
  int first = point->column[0], last = first;
  for (int i = 1; i < point->count; i++) {
    first = point->column[i] < first ? point->column[i] : first;
    last = point->column[i] > last ? point->column[i] : last;
  }
  *out_first = first;
  *out_last = last + 1;
}

static void fold_source(const np_fan_source *source, int first, int last, folded_source *out) {
  const np_moment_table *table = source->table;
  const int columns = table->sun.columns;
  float upper;
  const np_bands *low = np_moment_table_at_row(table, np_moment_table_row(table, (double)source->altitude_m, &upper));
  const np_bands *high = low + columns * NP_MOMENT_COUNT;
  const float z = source->cosine;
  block a, b, c;
  set_block(source->isotropic, &a);
  set_block(source->linear, &b);
  set_block(source->quadratic, &c);
  const block bz = z * b, cyy = (1.0f - z * z) * c, czz = (z * z) * c, cxz = (2.0f * z) * c;
  for (int i = first; i <= last; i += BLOCK) {
    block m[NP_MOMENT_COUNT];
    for (int k = 0; k < NP_MOMENT_COUNT; k++) mix_rows(low + k * columns + i, high + k * columns + i, upper, &m[k]);
    const block kyy = m[NP_MOMENT_M] - m[NP_MOMENT_KXX] - m[NP_MOMENT_KZZ];
    *(block *)(out->constant + i) = (a * m[NP_MOMENT_M] + bz * m[NP_MOMENT_FZ]) + (cyy * kyy + czz * m[NP_MOMENT_KZZ]);
    *(block *)(out->linear + i) = b * m[NP_MOMENT_FX] + cxz * m[NP_MOMENT_KXZ];
    *(block *)(out->square + i) = c * (m[NP_MOMENT_KXX] - kyy);
    *(block *)(out->total + i) = m[NP_MOMENT_M];
  }
}

/* Interpolates the quadratics of two adjacent columns at one ωx. */
static inline np_bands evaluate(const folded_source *folded, int column, float x, float upper) {
  np_bands both[2];
  for (int i = 0; i < 2; i += BLOCK) {
    const block *constant = (const block *)(folded->constant + column + i);
    const block *linear = (const block *)(folded->linear + column + i);
    const block *square = (const block *)(folded->square + column + i);
    *(block *)(both + i) = *constant + x * (*linear + x * *square);
  }
  return np_bands_mix(both[0], both[1], upper);
}

static void add_source(const np_fan_source *source, const np_fan_point *point, np_bands *sums, np_bands *out_totals) {
  folded_source folded;
  int first, last;
  compute_range(point, &first, &last);
  fold_source(source, first, last, &folded);
  for (int i = 0; i < point->count; i++) sums[i] += evaluate(&folded, point->column[i], point->x[i], point->upper[i]);
  for (int i = 0; out_totals && i < point->count; i++) {
    const np_bands *total = folded.total + point->column[i];
    out_totals[i] = np_bands_mix(total[0], total[1], point->upper[i]);
  }
}

const np_fan_kernels NP_KERNEL(np_fan_kernels) = {
    .compute_sun_cosines = compute_sun_cosines,
    .compute_sunlight = compute_sunlight,
    .compute_columns = compute_columns,
    .add_source = add_source,
};
