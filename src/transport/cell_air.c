/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/cell_air.h"

#include "atmosphere/sky_along.h"
#include "core/alloc.h"
#include "core/parallel.h"
#include "core/units.h"
#include "transport/transport_level.h"

/* Scattering optical depth from the bottom of the box to its top, in the band that has most, below which the air in it
 * is left out: half of it is the share of sunlight that would be added. */
static const float depth_least = 0.01f;

/* Optical depth of cloud behind which air counts as dark. */
static const float dark_depth = 16.0f;

/* ---- Layers ---- */

static np_dvec3 get_middle(const np_transport_grid *g, double height_m) {
  double middle[2];
  for (int a = 0; a < 2; a++) middle[a] = 0.5 * (g->edge_m[a][0] + g->edge_m[a][g->size[a]]);
  return np_dvec3_make(middle[0], middle[1], height_m);
}

/* Light that a layer scatters to either side out of the sun's, over the sun's irradiance, 1/sr. */
static np_air_parts trace_layer(const np_transport_grid *g, const np_world *world, double low_m, double high_m,
                                const np_hemisphere_shares *shares) {
  const double height_m = high_m - low_m;
  np_air_parts out;
  np_sky_trace_parts(world->cloud_sky, get_middle(g, low_m), np_vec3_make(0.0f, 0.0f, 1.0f), &height_m, 1, shares,
                     &out);
  return out;
}

/* The share of sunlight that aerosols scatter down is that of light from an even upper hemisphere which they scatter
 * along the direction to the sun, by reciprocity. */
static np_hemisphere_shares compute_shares(const np_world *world) {
  return np_sky_compute_hemisphere_shares(world->cloud_sky, world->to_sun);
}

static bool is_lit(const np_transport_grid *g, const np_world *world) {
  if (!world->cloud_sky || np_transport_grid_is_column(g)) return false;
  const np_hemisphere_shares shares = compute_shares(world);
  const np_air_parts box = trace_layer(g, world, g->edge_m[2][0], g->edge_m[2][g->size[2]], &shares);
  return 2.0f * NP_PI_F * np_spectrum_max(np_spectrum_add(box.upper, box.lower)) >= depth_least;
}

/* The light of a layer in the sun, over its thickness, by its way. */
static void light_layer(const np_transport_grid *g, const np_world *world, int32_t k,
                        const np_hemisphere_shares *shares, np_spectrum out[NP_CELL_AIR_WAYS]) {
  const double low = g->edge_m[2][k], high = g->edge_m[2][k + 1];
  const np_air_parts parts = trace_layer(g, world, low, high, shares);
  const np_spectrum sun = np_world_sunlight(world, get_middle(g, 0.5 * (low + high)), world->to_sun);
  const np_spectrum per_metre = np_spectrum_scale(sun, (float)(1.0 / (high - low)));
  out[NP_CELL_AIR_DOWN] = np_spectrum_multiply(parts.upper, per_metre);
  out[NP_CELL_AIR_UP] = np_spectrum_multiply(parts.lower, per_metre);
}

void np_cell_air_set_band(const np_transport_grid *grid, const np_world *world, unsigned band, np_cell_air *air) {
  if (!air->sunlit) return;
  const np_hemisphere_shares shares = compute_shares(world);
  for (int32_t k = 0; k < grid->size[2]; k++) {
    np_spectrum light[NP_CELL_AIR_WAYS];
    light_layer(grid, world, k, &shares, light);
    for (int way = 0; way < NP_CELL_AIR_WAYS; way++) air->radiance[k][way] = light[way].band[band];
  }
}

/* ∫ cos θ·min(H/cos θ, W/(2 sin θ)) dω over a hemisphere, over 2πH: light of a box of height H and width W on the
 * middle of its end, over that of an endless layer. */
static double compute_share_of_layer(double height_m, double width_m) {
  const double half = 0.5 * width_m / height_m, cosine = 1.0 / sqrt(1.0 + half * half);
  return 1.0 - cosine + half * (1.0 - sqrt(1.0 - cosine * cosine));
}

np_spectrum np_cell_air_compute_irradiance(const np_transport_grid *grid, const np_world *world, int way) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  if (!is_lit(grid, world)) return sum;
  const np_hemisphere_shares shares = compute_shares(world);
  double width_m = INFINITY;
  for (int a = 0; a < 2; a++)
    if (!grid->is_wrapped[a]) width_m = fmin(width_m, grid->edge_m[a][grid->size[a]] - grid->edge_m[a][0]);
  const double height_m = grid->edge_m[2][grid->size[2]] - grid->edge_m[2][0];
  const double share = isfinite(width_m) ? compute_share_of_layer(height_m, width_m) : 1.0;
  for (int32_t k = 0; k < grid->size[2]; k++) {
    np_spectrum light[NP_CELL_AIR_WAYS];
    light_layer(grid, world, k, &shares, light);
    sum =
        np_spectrum_add_scaled(sum, 2.0f * NP_PI_F * (float)(share * np_transport_grid_width(grid, 2, k)), light[way]);
  }
  return sum;
}

/* ---- Cells ---- */

typedef struct sunlight_fill {
  const np_transport_grid *grid;
  const np_world *world;
  const np_sun_optical_depth_source *depths;
  const float *fade;
  np_monitor *monitor;
  float *sunlit;
} sunlight_fill;

/* Cells along an axis that share their middle: sunlight on air is a small part of all light, and smooth. */
enum { TOGETHER = 2 };

static int32_t count_groups(int32_t cells) { return (cells + TOGETHER - 1) / TOGETHER; }

/* The middle of the cells [begin, begin + TOGETHER) of an axis; `*out_end`: the end of those that there are. */
static double get_group(const np_transport_grid *g, int axis, int32_t begin, int32_t *out_end) {
  *out_end = begin + TOGETHER < g->size[axis] ? begin + TOGETHER : g->size[axis];
  return 0.5 * (g->edge_m[axis][begin] + g->edge_m[axis][*out_end]);
}

static void light_group(const sunlight_fill *f, const int32_t begin[3]) {
  const np_transport_grid *g = f->grid;
  int32_t end[3], at[3];
  double middle[3];
  for (int a = 0; a < 3; a++) middle[a] = get_group(g, a, begin[a], &end[a]);
  const float depth = f->depths->get(f->depths->user, np_dvec3_make(middle[0], middle[1], middle[2]), f->world->to_sun,
                                     f->fade, dark_depth);
  const float sunlit = depth < dark_depth ? expf(-depth) : 0.0f;
  for (at[2] = begin[2]; at[2] < end[2]; at[2]++)
    for (at[1] = begin[1]; at[1] < end[1]; at[1]++)
      for (at[0] = begin[0]; at[0] < end[0]; at[0]++) f->sunlit[np_transport_grid_join(g, at)] = sunlit;
}

static neph_result light_rows(void *user, size_t first, size_t last, unsigned thread) {
  (void)thread;
  const sunlight_fill *f = user;
  const int32_t rows = count_groups(f->grid->size[1]);
  if (np_monitor_is_cancelled(f->monitor)) return NEPH_ERROR_CANCELLED;
  for (size_t row = first; row < last; row++) {
    int32_t begin[3] = {0, TOGETHER * ((int32_t)row % rows), TOGETHER * ((int32_t)row / rows)};
    for (; begin[0] < f->grid->size[0]; begin[0] += TOGETHER) light_group(f, begin);
  }
  return NEPH_OK;
}

neph_result np_cell_air_fill(const np_transport_grid *grid, const np_world *world,
                             const np_sun_optical_depth_source *depths, const float *fade, np_monitor *monitor,
                             np_cell_air *out) {
  if (!is_lit(grid, world)) return NEPH_OK;
  const size_t count = (size_t)grid->size[0] * (size_t)grid->size[1] * (size_t)grid->size[2];
  out->sunlit = np_alloc(grid->context, count, sizeof *out->sunlit);
  out->radiance = np_alloc(grid->context, (size_t)grid->size[2], sizeof *out->radiance);
  if (!out->sunlit || !out->radiance) return NEPH_ERROR_OUT_OF_MEMORY;
  sunlight_fill f = {grid, world, depths, fade, monitor, out->sunlit};
  const size_t rows = (size_t)count_groups(grid->size[1]) * (size_t)count_groups(grid->size[2]);
  return np_parallel_for(grid->context, monitor, rows, 4, light_rows, &f);
}

np_cell_air np_cell_air_borrow(const np_cell_air *air) {
  return (np_cell_air){.sunlit = air->sunlit, .radiance = air->radiance, .is_borrowed = true};
}

void np_cell_air_clear(neph_context *context, np_cell_air *air) {
  if (!air->is_borrowed) {
    np_alloc_free(context, air->sunlit);
    np_alloc_free(context, air->radiance);
  }
  *air = (np_cell_air){NULL};
}
