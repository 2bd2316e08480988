/* SPDX-License-Identifier: Apache-2.0 */
/* Patterns wider than a cloud, which raise and lower the landscape: rolls of the boundary layer with cloud streets
 * along the wind, and cells of convection, open or closed.
 *
 * Streets are a wave across the wind with a varying phase. Cells are a Voronoi diagram of jittered hexagon centres;
 * open cells have clouds on their walls, closed cells are clear there. */
#include "cloud/mesoscale.h"

#include <math.h>

#include "cloud/cloud_streams.h"
#include "cloud/repeat.h"
#include "core/math.h"
#include "core/random.h"

/* Spacing in cells of the landscape, about three depths of a boundary layer (AMS Glossary, horizontal convective
 * rolls). */
static const float street_spacing = 2.0f;
static const float street_height = 0.75f; /* amplitude of the wave, relative to the landscape */
static const float wander_along = 5.0f, wander_across = 1.5f,
                   wander_reach =
                       1.0f; /* variation of the phase: scales along and across the wind, and amplitude, in spacings */

/* Lengths in cell sizes. Walls between open cells are as wide as the clouds in them, walls between closed cells are
 * narrow. */
static const float jitter = 0.62f, warp_size = 0.5f, warp_reach = 0.5f, open_width = 0.27f, closed_width = 0.15f;
static const float column = 1.0f, row = 0.8660254f; /* spacings of hexagons with centres 1 apart */
static const float cells_height = 0.85f, open_spread = 2.0f,
                   closed_spread = 0.35f; /* in units of the landscape's height */

/* Knots where walls of open cells meet: their width in cell sizes, and the additional height of clouds there in units
 * of the landscape's. Walls break between knots, which makes optical depth as skewed as in nature. */
static const float knot_width = 0.18f, knot_height = 2.6f;

/* Share of the landscape's own groups that a full pattern replaces. */
static const float streets_share = 0.6f, cells_share = 0.25f;

static void fill_perlin(const np_mesoscale *pattern, np_cloud_stream stream, const int32_t period[2], unsigned octaves,
                        size_t count, const float *x, const float *y, float *out) {
  float z[NP_MESOSCALE_BLOCK];
  const np_noise_lattice lattice = {
      np_noise_derive_seed(pattern->seed, stream),
      {period[0] ? period[0] : NP_NOISE_PERIOD_MAX, period[1] ? period[1] : NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
  for (size_t i = 0; i < count; i++) z[i] = 0.43f + 0.1f * (float)pattern->lifetimes;
  pattern->noise->perlin_fbm(&lattice, &(np_noise_octaves){.count = octaves, .gain = 0.5f},
                             &(np_noise_points){count, x, y, z}, out);
}

/* Length near `size` that divides the tile into a whole number of parts, and that number; 0 for fields that do not
 * repeat. */
static float fit(const np_mesoscale *pattern, float size, int32_t *out_count) {
  *out_count = pattern->period ? np_repeat_count((double)pattern->period, (double)size) : 0;
  return pattern->period ? (float)pattern->period / (float)*out_count : size;
}

/* ---- Streets ---- */

/* 1 − 2S of a triangle wave, with S the smoothstep: close to a cosine, with equal bits everywhere. */
static float eval_wave(float phase) {
  const float t = phase - floorf(phase);
  return 1.0f - 2.0f * np_smoothstepf(1.0f - fabsf(2.0f * t - 1.0f));
}

static void add_streets(const np_mesoscale *pattern, size_t count, const double *air_x, const double *air_y,
                        float *heights) {
  float phase[NP_MESOSCALE_BLOCK], x[NP_MESOSCALE_BLOCK], y[NP_MESOSCALE_BLOCK], wander[NP_MESOSCALE_BLOCK];
  int32_t streets, period[2];
  const float spacing = fit(pattern, street_spacing, &streets);
  const float along = fit(pattern, wander_along * spacing, &period[0]);
  const float across = fit(pattern, wander_across * spacing, &period[1]);
  for (size_t i = 0; i < count; i++) {
    const double hx = (double)pattern->heading[0], hy = (double)pattern->heading[1];
    const double u = air_x[i] * hx + air_y[i] * hy, v = air_y[i] * hx - air_x[i] * hy;
    phase[i] = (float)(v / (double)spacing);
    x[i] = (float)(u / (double)along);
    y[i] = (float)(v / (double)across);
  }
  fill_perlin(pattern, NP_CLOUD_STREAM_STREETS, period, 3, count, x, y, wander);
  for (size_t i = 0; i < count; i++)
    heights[i] += pattern->streets * street_height * eval_wave(phase[i] + wander_reach * wander[i]);
}

/* ---- Cells ---- */

typedef struct heart {
  float x, y, height; /* x in columns, y in rows */
} heart;

/* Columns and rows of hexagons; a repeating field has an even number of rows, because every other one is shifted. */
typedef struct hexagons {
  float pitch[2]; /* in cells of the landscape */
  int32_t period[2];
} hexagons;

static hexagons fit_hexagons(const np_mesoscale *pattern) {
  hexagons h;
  h.pitch[0] = fit(pattern, column * pattern->cells_size, &h.period[0]);
  h.pitch[1] = 0.5f * fit(pattern, 2.0f * row * pattern->cells_size, &h.period[1]);
  h.period[1] *= 2;
  return h;
}

static heart draw_heart(const np_mesoscale *pattern, const hexagons *h, int32_t i, int32_t j) {
  const uint64_t bits = np_random_absorb(np_random_absorb(pattern->seed, NP_CLOUD_STREAM_MESOSCALE),
                                         (uint64_t)(uint32_t)np_repeat_wrap(i, h->period[0]) << 32 |
                                             (uint32_t)np_repeat_wrap(j, h->period[1]));
  const float u = (float)(bits & 0xffffu) * 0x1p-16f, v = (float)(bits >> 16 & 0xffffu) * 0x1p-16f;
  return (heart){0.25f + 0.5f * (float)(j & 1) + jitter * (u - 0.5f), 0.5f + jitter * (v - 0.5f),
                 (float)(bits >> 32 & 0xffffu) * 0x1p-16f};
}

enum { REACH = 2, SIDE = 2 * REACH + 1, AROUND = SIDE * SIDE };

/* Centres around a hexagon, shared by its points; in cell sizes, from its corner. */
typedef struct neighbourhood {
  int32_t i, j;
  bool is_drawn;
  heart hearts[AROUND];
} neighbourhood;

static void draw_neighbourhood(const np_mesoscale *pattern, const hexagons *h, int32_t i, int32_t j,
                               neighbourhood *out) {
  if (out->is_drawn && out->i == i && out->j == j) return;
  *out = (neighbourhood){.i = i, .j = j, .is_drawn = true};
  for (int n = 0; n < AROUND; n++) {
    const int32_t di = n % SIDE - REACH, dj = n / SIDE - REACH;
    heart at = draw_heart(pattern, h, i + di, j + dj);
    at.x = (at.x + (float)di) * column;
    at.y = (at.y + (float)dj) * row;
    out->hearts[n] = at;
  }
}

/* Distances to the two nearest walls, in cell sizes, both 0 where walls meet; and the centre of the cell. */
static void compute_walls(const neighbourhood *around, float x, float y, float out_walls[2], heart *out_heart) {
  heart nearest = around->hearts[0];
  float least = INFINITY, squares[2] = {INFINITY, INFINITY};
  for (int n = 0; n < AROUND; n++) {
    const float dx = around->hearts[n].x - x, dy = around->hearts[n].y - y, distance2 = dx * dx + dy * dy;
    if (distance2 < least) least = distance2, nearest = around->hearts[n];
  }
  for (int n = 0; n < AROUND; n++) {
    const heart *other = &around->hearts[n];
    const float dx = other->x - nearest.x, dy = other->y - nearest.y, between2 = dx * dx + dy * dy;
    const float off = (0.5f * (other->x + nearest.x) - x) * dx + (0.5f * (other->y + nearest.y) - y) * dy;
    if (!(between2 > 0.0f)) continue;
    const float square = off * off / between2;
    squares[1] = np_minf(squares[1], np_maxf(squares[0], square));
    squares[0] = np_minf(squares[0], square);
  }
  *out_heart = nearest;
  for (int k = 0; k < 2; k++) out_walls[k] = sqrtf(squares[k]);
}

static void add_cells(const np_mesoscale *pattern, size_t count, const double *air_x, const double *air_y,
                      float *heights) {
  float x[NP_MESOSCALE_BLOCK], y[NP_MESOSCALE_BLOCK], dx[NP_MESOSCALE_BLOCK], dy[NP_MESOSCALE_BLOCK];
  int32_t eddies;
  neighbourhood around = {.is_drawn = false};
  const hexagons h = fit_hexagons(pattern);
  const float eddy = fit(pattern, warp_size * pattern->cells_size, &eddies);
  const bool is_open = pattern->cells_kind == NEPH_CLOUD_CELLS_OPEN;
  for (size_t i = 0; i < count; i++) {
    x[i] = (float)(air_x[i] / (double)eddy);
    y[i] = (float)(air_y[i] / (double)eddy);
  }
  fill_perlin(pattern, NP_CLOUD_STREAM_MESOSCALE_X, (const int32_t[]){eddies, eddies}, 3, count, x, y, dx);
  fill_perlin(pattern, NP_CLOUD_STREAM_MESOSCALE_Y, (const int32_t[]){eddies, eddies}, 3, count, x, y, dy);
  for (size_t i = 0; i < count; i++) {
    const double at_x = air_x[i] / (double)h.pitch[0] + (double)(warp_reach * dx[i]);
    const double at_y = air_y[i] / (double)h.pitch[1] + (double)(warp_reach * dy[i]);
    const int32_t i0 = (int32_t)floor(at_x), j0 = (int32_t)floor(at_y);
    heart at;
    draw_neighbourhood(pattern, &h, i0, j0, &around);
    float walls[2];
    compute_walls(&around, (float)(at_x - i0) * column, (float)(at_y - j0) * row, walls, &at);
    const float full = is_open ? 1.0f - np_smoothstepf(walls[0] / open_width) : np_smoothstepf(walls[0] / closed_width);
    const float knot = knot_height * (1.0f - np_smoothstepf(walls[1] / knot_width));
    const float spread = is_open ? open_spread * dx[i] + knot : closed_spread * (at.height - 0.5f);
    heights[i] += cells_height * (2.0f * full - 1.0f) + full * spread;
  }
}

float np_mesoscale_get_ground_share(const np_mesoscale *pattern) {
  const float cells = pattern->cells_kind != NEPH_CLOUD_CELLS_NONE ? cells_share : 0.0f;
  return 1.0f - np_maxf(cells, streets_share * pattern->streets);
}

void np_mesoscale_add(const np_mesoscale *pattern, size_t count, const double *air_x, const double *air_y,
                      float *heights) {
  if (pattern->streets > 0.0f) add_streets(pattern, count, air_x, air_y, heights);
  if (pattern->cells_kind != NEPH_CLOUD_CELLS_NONE) add_cells(pattern, count, air_x, air_y, heights);
}
