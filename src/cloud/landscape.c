/* SPDX-License-Identifier: Apache-2.0 */
/* The landscape under the weather map: the strength of cloud growth at each position.
 *
 * Cells: a jittered grid of paraboloids a − r²/R², with equal curvature and random height a, and a finer grid of small
 * cells between them. The landscape is the maximum of all, with turrets of the small cells on the large ones. Cut by a
 * waterline t it has rounded islands of radius R·√(a − t), as varied as the heights: many small, few large.
 * Low-frequency Perlin noise raises groups of cells and leaves clearings; a divergence-free swirl makes outlines
 * irregular. The landscape of a slab is Perlin noise alone, stretched along the wind. A hero is one large paraboloid
 * with smaller ones around it. Everything drifts with the wind, grows and decays. */
#include "cloud/landscape.h"

#include <math.h>

#include "cloud/cloud_streams.h"
#include "cloud/cloud_wind.h"
#include "cloud/repeat.h"
#include "cloud/weather_picture.h"
#include "core/math.h"
#include "core/random.h"

/* Lengths in units of the cell spacing. */
static const float cell_radius = 0.52f, swirl_reach = 0.14f, group_size = 4.3f;
static const float small_spacing = 0.43f, small_height = 0.40f, turret_height = 0.22f;
static const float shore_width = 0.35f, shore_depth = 1.2f; /* descent of the landscape towards the field's border */
static const float sheet_height = 2.45f;                    /* scale of a slab's noise, to a range of about 1 */

/* Anvils: least height of their cells, and their spread at anvil 1. Their extent before the tower, against the shear,
 * and behind it, where they widen with the distance like a plume. */
static const float anvil_height = 0.8f; /* share of the thickness */
static const float anvil_from = 0.5f, anvil_spread = 4.0f;
static const float anvil_upwind = 0.55f, anvil_downwind = 1.9f, anvil_plume = 0.30f;
/* Descent of an anvil from its centre to the ellipse that touches the field's borders; in cells, the least distance of
 * those, and the distance of centres below which anvils are lower. */
static const float anvil_fit = 0.7f, anvil_room = 0.2f, anvil_shore = 0.45f;

/* Radius of a hero, relative to half the shorter side of its field. */
static const float hero_radius = 0.8f, hero_reach = 0.62f;
enum { CELL_REACH = 2, ANVIL_REACH = 5 }; /* cells on each side that may contribute */
enum { HERO_PARTS = 11 };

typedef struct cell {
  float x, y, height;            /* centre, relative to the cell's corner */
  float axis_x, axis_y, stretch; /* the outline is an ellipse, elongated along the axis by stretch² */
} cell;

static float get_fraction(uint64_t bits, int field) { return (float)(bits >> (16 * field) & 0xffffu) * 0x1p-16f; }

/* Triangle wave between 0 and 1, uniformly distributed at any time if `start` is; its period differs between cells. */
static float age(float start, float pace, double lifetimes) {
  double phase = 0.5 * (double)start + (0.35 + 0.3 * (double)pace) * lifetimes, turn = 2.0 * (phase - floor(phase));
  return (float)(turn > 1.0 ? 2.0 - turn : turn);
}

/* Axis direction (over half a turn) from a number in [−1, 1], approximately uniform. */
static void compute_axis(float turn, float *out_x, float *out_y) {
  const float norm = 1.0f / (1.0f + turn * turn);
  *out_x = (1.0f - turn * turn) * norm;
  *out_y = 2.0f * turn * norm;
}

static cell draw_cell(uint64_t seed, int32_t i, int32_t j, double lifetimes) {
  const uint64_t bits = np_random_absorb(seed, (uint64_t)(uint32_t)i << 32 | (uint32_t)j), more = np_random_mix(bits);
  const float u = age(get_fraction(bits, 2), get_fraction(more, 1), lifetimes);
  cell c = {.x = get_fraction(bits, 0),
            .y = get_fraction(bits, 1),
            .height = 0.08f + 0.92f * u * u,
            .stretch = 1.0f + 0.35f * get_fraction(more, 0)};
  compute_axis(2.0f * get_fraction(bits, 3) - 1.0f, &c.axis_x, &c.axis_y);
  return c;
}

typedef struct relief {
  uint64_t seed;
  float height, curvature; /* curvature is 1/R² */
  float lowest_cell;       /* lower cells are left out */
  int32_t period;          /* period in cells; 0: not repeating */
  const float *shear;      /* direction of anvils; NULL: plain cells */
  const float *place;      /* position of the air at the anvils' height in the field; NULL: no borders */
  const float *half;       /* half the field's extent */
} relief;

static const float below_all = -8.0f; /* lower than any height in use */

static float raise(const cell *c, float height, float curvature, float dx, float dy) {
  float along = (dx * c->axis_x + dy * c->axis_y) / c->stretch, across = (dy * c->axis_x - dx * c->axis_y) * c->stretch;
  return height * c->height - curvature * (along * along + across * across);
}

/* Height of an anvil, displaced along `shear`, which is 0 without wind. */
static float raise_anvil(const cell *c, float height, float curvature, const float shear[2], float dx, float dy) {
  if (shear[0] == 0.0f && shear[1] == 0.0f) return raise(c, height, curvature, dx, dy);
  float along = dx * shear[0] + dy * shear[1], across = dy * shear[0] - dx * shear[1];
  across /= 1.0f + anvil_plume * sqrtf(curvature) * np_maxf(along, 0.0f);
  along /= along > 0.0f ? anvil_downwind : anvil_upwind;
  return height * c->height - curvature * (along * along + across * across);
}

/* Descent of an anvil that keeps it inside the field, from its centre at (x, y) in the air. Its outline is smooth: each
 * quadrant is that of an ellipse which reaches to the border on two sides. Centres close to a border have no anvil, as
 * they have no tower. */
static float compute_fit(const relief *r, float x, float y, float dx, float dy) {
  if (!r->place) return 0.0f;
  x += r->place[0];
  y += r->place[1];
  const float inset = np_minf(r->half[0] - fabsf(x), r->half[1] - fabsf(y));
  const float shore = np_maxf(1.0f - inset / anvil_shore, 0.0f);
  const float room_x = np_maxf(dx > 0.0f ? r->half[0] - x : r->half[0] + x, anvil_room);
  const float room_y = np_maxf(dy > 0.0f ? r->half[1] - y : r->half[1] + y, anvil_room);
  const float share2 = dx * dx / (room_x * room_x) + dy * dy / (room_y * room_y), share4 = share2 * share2;
  return anvil_fit * (share4 * share4 + shore * shore);
}

/* The cells that may contribute at positions in one cell, drawn once for all of them. */
typedef struct patch {
  const relief *relief;
  bool is_drawn;
  int32_t i, j; /* index of the central cell */
  cell cells[(2 * ANVIL_REACH + 1) * (2 * ANVIL_REACH + 1)];
} patch;

static int32_t get_reach(const relief *r) { return r->shear ? ANVIL_REACH : CELL_REACH; }

static void draw_patch(patch *p, double lifetimes, int32_t i, int32_t j) {
  const int32_t reach = get_reach(p->relief), period = p->relief->period;
  cell *next = p->cells;
  if (p->is_drawn && p->i == i && p->j == j) return;
  p->is_drawn = true, p->i = i, p->j = j;
  for (int32_t b = j - reach; b <= j + reach; b++)
    for (int32_t a = i - reach; a <= i + reach; a++)
      *next++ = draw_cell(p->relief->seed, np_repeat_wrap(a, period), np_repeat_wrap(b, period), lifetimes);
}

/* Highest paraboloid at (x, y), in units of the grid's spacing. */
static float compute_highest(patch *p, double lifetimes, double x, double y) {
  const relief *r = p->relief;
  const int32_t i0 = (int32_t)floor(x), j0 = (int32_t)floor(y), reach = get_reach(r);
  float best = below_all;
  draw_patch(p, lifetimes, i0, j0);
  const cell *c = p->cells;
  for (int32_t j = j0 - reach; j <= j0 + reach; j++)
    for (int32_t i = i0 - reach; i <= i0 + reach; i++, c++) {
      const float dx = (float)(x - i) - c->x, dy = (float)(y - j) - c->y;
      if (c->height < r->lowest_cell) continue;
      const float height = r->shear ? raise_anvil(c, r->height, r->curvature, r->shear, dx, dy) -
                                          compute_fit(r, (float)i + c->x, (float)j + c->y, dx, dy)
                                    : raise(c, r->height, r->curvature, dx, dy);
      best = np_maxf(best, height);
    }
  return best;
}

static cell draw_hero_part(const np_landscape *land, unsigned part) {
  const uint64_t bits = np_random_absorb(np_random_absorb(land->seed, NP_CLOUD_STREAM_CELLS), part),
                 more = np_random_mix(bits);
  const float u = get_fraction(bits, 2), grown = age(u, get_fraction(more, 1), land->lifetimes);
  cell c = {.height = part ? 0.2f + 0.6f * grown : 1.0f, .stretch = 1.0f + 0.2f * get_fraction(more, 0)};
  const float reach = part ? hero_reach * sqrtf(0.08f + 0.92f * get_fraction(more, 2)) : 0.0f;
  const float side = part & 1 ? -reach : reach;
  compute_axis(2.0f * get_fraction(bits, 3) - 1.0f, &c.axis_x, &c.axis_y);
  c.x = side * c.axis_y;
  c.y = side * c.axis_x;
  return c;
}

/* Height of a hero. Positions are relative to the field's centre, in units of half its shorter side. */
static float compute_hero(const np_landscape *land, float x, float y) {
  const float curvature = 1.0f / (hero_radius * hero_radius);
  float best = below_all;
  for (unsigned part = 0; part < HERO_PARTS; part++) {
    const cell c = draw_hero_part(land, part);
    best = np_maxf(best, raise(&c, 1.0f, part ? 3.0f * curvature : curvature, x - c.x, y - c.y));
  }
  return best;
}

typedef struct landscape_block {
  size_t count;
  bool is_turned;                                              /* x is along the heading */
  const float *x, *y;                                          /* in the field, in units of the cell spacing */
  double air_x[NP_LANDSCAPE_BLOCK], air_y[NP_LANDSCAPE_BLOCK]; /* in the frame of the air, which drifts and swirls */
} landscape_block;

/* Noise positions in a lattice of given cell size; `z` changes with time. */
typedef struct lattice_points {
  float x[NP_LANDSCAPE_BLOCK], y[NP_LANDSCAPE_BLOCK], z[NP_LANDSCAPE_BLOCK];
} lattice_points;

static np_noise_points scale_points(const np_landscape *land, const landscape_block *b, float size,
                                    lattice_points *out) {
  for (size_t i = 0; i < b->count; i++) {
    out->x[i] = (float)(b->air_x[i] / (double)size);
    out->y[i] = (float)(b->air_y[i] / (double)size);
    out->z[i] = 0.37f + 0.15f * (float)land->lifetimes; /* between lattice points, where gradient noise would vanish */
  }
  return (np_noise_points){b->count, out->x, out->y, out->z};
}

static np_noise_lattice make_lattice(const np_landscape *land, np_cloud_stream stream) {
  return (np_noise_lattice){np_noise_derive_seed(land->seed, stream),
                            {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
}

/* Nearest size in cells that divides the period into a whole number; sets the lattice's period to that number. */
static float fit_size(const np_landscape *land, float size, np_noise_lattice *lattice) {
  if (land->period == 0) return size;
  const int32_t count = np_repeat_count((double)land->period, (double)size);
  if (lattice) lattice->period[0] = lattice->period[1] = count;
  return (float)land->period / (float)count;
}

static void fill_noise(const np_landscape *land, np_cloud_stream stream, float size, unsigned octave_count, float gain,
                       const landscape_block *b, float *out) {
  np_noise_lattice lattice = make_lattice(land, stream);
  size = fit_size(land, size, &lattice);
  if (land->period && b->is_turned) lattice.period[0] = land->sheet_period;
  const np_noise_octaves octaves = {.count = octave_count, .gain = gain};
  lattice_points at;
  const np_noise_points points = scale_points(land, b, size, &at);
  land->noise->perlin_fbm(&lattice, &octaves, &points, out);
}

/* Displaces the air by low-frequency curl noise. */
static void swirl(const np_landscape *land, landscape_block *b) {
  np_noise_lattice lattice = make_lattice(land, NP_CLOUD_STREAM_SWIRL);
  const float size = fit_size(land, land->rule->swirl_size, &lattice);
  float x[NP_LANDSCAPE_BLOCK], y[NP_LANDSCAPE_BLOCK];
  lattice_points at;
  const np_noise_points points = scale_points(land, b, size, &at);
  land->noise->swirl(&lattice, &points, x, y);
  for (size_t i = 0; i < b->count; i++) {
    b->air_x[i] += (double)(land->swirl * size * x[i]);
    b->air_y[i] += (double)(land->swirl * size * y[i]);
  }
}

/* Descent of the landscape towards the border, so that clouds end there naturally; less with more cover. */
static float compute_shore(const np_landscape *land, float x, float y) {
  if (land->period) return 0.0f;
  float dx = land->half_extent[0] - fabsf(x), dy = land->half_extent[1] - fabsf(y);
  float s = 1.0f - np_clampf(np_minf(dx, dy) / shore_width, 0.0f, 1.0f);
  return land->shore_depth * s * s;
}

static void fill_cells(const np_landscape *land, const landscape_block *b, float *out, float *out_anvils) {
  float group[NP_LANDSCAPE_BLOCK];
  const np_landscape_rule *rule = land->rule;
  const float group_height = rule->group_height * np_mesoscale_get_ground_share(&land->mesoscale);
  fill_noise(land, NP_CLOUD_STREAM_GROUPS, group_size, rule->group_octaves, rule->group_gain, b, group);
  for (size_t i = 0; i < b->count; i++) group[i] *= group_height;
  np_mesoscale_add(&land->mesoscale, b->count, b->air_x, b->air_y, group);
  const float spacing = fit_size(land, small_spacing, NULL);
  const float curvature = 1.0f / (cell_radius * cell_radius), wide = 1.0f / (1.0f + anvil_spread * land->anvil);
  const relief cells = {
      np_random_absorb(land->seed, NP_CLOUD_STREAM_CELLS), 1.0f, curvature, 0.0f, land->period, NULL, NULL, NULL};
  const relief small = {np_random_absorb(land->seed, NP_CLOUD_STREAM_SMALL_CELLS),
                        small_height,
                        curvature * spacing * spacing,
                        0.0f,
                        land->period ? np_repeat_count((double)land->period, (double)spacing) : 0,
                        NULL,
                        NULL,
                        NULL};
  float place[2];
  for (int a = 0; a < 2; a++) place[a] = (float)land->drift[a] + land->anvil_shift[a];
  const relief anvils = {cells.seed,   1.0f,        curvature * wide * wide,     anvil_from,
                         land->period, land->shear, land->period ? NULL : place, land->half_extent};
  patch cell_patch = {.relief = &cells}, small_patch = {.relief = &small}, anvil_patch = {.relief = &anvils};
  for (size_t i = 0; i < b->count; i++) {
    const double x = b->air_x[i], y = b->air_y[i], s = (double)spacing;
    const float large = compute_highest(&cell_patch, land->lifetimes, x, y);
    const float between = compute_highest(&small_patch, land->lifetimes, x / s, y / s);
    const float raised = group[i] - compute_shore(land, b->x[i], b->y[i]);
    out[i] = np_maxf(large + turret_height * np_maxf(between, 0.0f), between) + raised;
    if (out_anvils) out_anvils[i] = group[i] + compute_highest(&anvil_patch, land->lifetimes, x, y);
  }
}

/* Fills the noise of a sheet, stretched along the heading. */
static void fill_sheet(const np_landscape *land, const landscape_block *b, float *out) {
  landscape_block turned = {.count = b->count, .is_turned = true};
  for (size_t i = 0; i < b->count; i++) {
    const double x = b->air_x[i], y = b->air_y[i], hx = (double)land->heading[0], hy = (double)land->heading[1];
    turned.air_x[i] = (x * hx + y * hy) * (double)land->sheet_shrink;
    turned.air_y[i] = y * hx - x * hy;
  }
  fill_noise(land, NP_CLOUD_STREAM_GROUPS, 1.0f, 4, 0.5f, &turned, out);
  const float height = sheet_height * np_mesoscale_get_ground_share(&land->mesoscale);
  for (size_t i = 0; i < b->count; i++) out[i] = height * out[i] - compute_shore(land, b->x[i], b->y[i]);
  np_mesoscale_add(&land->mesoscale, b->count, b->air_x, b->air_y, out);
}

static void fill_hero(const np_landscape *land, const landscape_block *b, float *out) {
  const double unit = 1.0 / (double)np_minf(land->half_extent[0], land->half_extent[1]);
  for (size_t i = 0; i < b->count; i++)
    out[i] = compute_hero(land, (float)(b->air_x[i] * unit), (float)(b->air_y[i] * unit));
}

void np_landscape_eval(const np_landscape *land, size_t count, const float *x_m, const float *y_m,
                       const np_landscape_out *out) {
  const float per_cell = (float)(1.0 / land->cell_m);
  float x[NP_LANDSCAPE_BLOCK], y[NP_LANDSCAPE_BLOCK];
  landscape_block b = {.count = count, .x = x, .y = y};
  for (size_t i = 0; i < count; i++) {
    x[i] = x_m[i] * per_cell;
    y[i] = y_m[i] * per_cell;
    b.air_x[i] = (double)x[i] - land->drift[0];
    b.air_y[i] = (double)y[i] - land->drift[1];
  }
  for (size_t i = 0; i < count; i++) {
    out->air_x_m[i] = b.air_x[i] * land->cell_m;
    out->air_y_m[i] = b.air_y[i] * land->cell_m;
  }
  swirl(land, &b);
  switch (land->rule->form) {
  case NP_LANDSCAPE_CELLS:
    fill_cells(land, &b, out->height, out->anvil);
    return;
  case NP_LANDSCAPE_SHEET:
    fill_sheet(land, &b, out->height);
    return;
  case NP_LANDSCAPE_HERO:
    fill_hero(land, &b, out->height);
    return;
  }
}

static void compute_direction(const double v[2], float fallback_x, float fallback_y, float out[2]) {
  const double length = sqrt(v[0] * v[0] + v[1] * v[1]);
  out[0] = length > 0 ? (float)(v[0] / length) : fallback_x;
  out[1] = length > 0 ? (float)(v[1] / length) : fallback_y;
}

/* Computes the heading: along the wind at the base, or, without that, along the shear of the wind profile. */
void np_cloud_desc_compute_heading(const neph_cloud_desc *desc, float out_heading[2]) {
  const np_cloud_wind wind = np_cloud_wind_make(desc, NP_CLOUD_SKEW_EVEN);
  const float *top_m = wind.at_m[NEPH_CLOUD_PROFILE_POINTS - 1];
  compute_direction((const double[2]){(double)top_m[0], (double)top_m[1]}, 1.0f, 0.0f, out_heading);
  compute_direction(desc->wind_m_s, out_heading[0], out_heading[1], out_heading);
}

/* Direction of anvils, by the skew, and by the wind up to their height; and their displacement by both, in cells. */
static void compute_shear(const neph_cloud_desc *desc, float out_shear[2], float out_shift[2]) {
  enum { ANVIL_HEIGHT = NEPH_CLOUD_PROFILE_POINTS - 2 };
  const np_cloud_wind wind = np_cloud_wind_make(desc, NP_CLOUD_SKEW_EVEN);
  np_cloud_wind_shift(&wind, anvil_height * (float)desc->thickness_m, out_shift);
  for (int a = 0; a < 2; a++) out_shift[a] /= (float)desc->cell_m;
  const double carried_m[2] = {desc->skew_m[0] + (double)wind.at_m[ANVIL_HEIGHT][0],
                               desc->skew_m[1] + (double)wind.at_m[ANVIL_HEIGHT][1]};
  compute_direction(carried_m, 0.0f, 0.0f, out_shear);
}

static np_mesoscale make_patterns(const np_landscape *land, const neph_cloud_desc *desc) {
  if (!land->rule->has_patterns) return (np_mesoscale){.streets = 0};
  return (np_mesoscale){.noise = land->noise,
                        .seed = land->seed,
                        .lifetimes = land->lifetimes,
                        .heading = {land->heading[0], land->heading[1]},
                        .streets = (float)desc->streets,
                        .cells_size = (float)(desc->cells_size_m / desc->cell_m),
                        .cells_kind = desc->cells_kind,
                        .period = land->period};
}

np_landscape np_landscape_make(const np_noise_table *noise, const neph_cloud_desc *desc) {
  np_landscape land = {.noise = noise,
                       .rule = &np_cloud_kind_get(desc->model)->landscape,
                       .seed = desc->seed,
                       .cell_m = desc->cell_m,
                       .lifetimes = desc->time_s / desc->lifetime_s,
                       .shore_depth = shore_depth * (float)(1.0 - np_cloud_desc_get_coverage(desc)),
                       .sheet_shrink = (float)(1.0 / sqrt(desc->stretch)),
                       .anvil = (float)desc->anvil,
                       .swirl = swirl_reach * (float)desc->turbulence};
  np_cloud_desc_compute_heading(desc, land.heading);
  compute_shear(desc, land.shear, land.anvil_shift);
  if (desc->repeat_m > 0) {
    land.period = np_repeat_count(desc->extent_m[0], desc->cell_m);
    land.cell_m = desc->extent_m[0] / land.period;
    land.sheet_period = np_repeat_count((double)land.period, sqrt(desc->stretch));
    land.sheet_shrink = (float)land.sheet_period / (float)land.period;
  }
  for (int i = 0; i < 2; i++) {
    land.drift[i] = desc->wind_m_s[i] * desc->time_s / land.cell_m;
    land.half_extent[i] = (float)(0.5 * desc->extent_m[i] / land.cell_m);
  }
  land.mesoscale = make_patterns(&land, desc);
  const double shorter_m = fmin(desc->extent_m[0], desc->extent_m[1]);
  land.radius_m = land.rule->form == NP_LANDSCAPE_HERO ? (float)(0.5 * shorter_m * (double)hero_radius)
                                                       : (float)(land.cell_m * (double)cell_radius);
  return land;
}
