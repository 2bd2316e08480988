/* SPDX-License-Identifier: Apache-2.0 */
/* First level of a cumulus: thermals, stacks of balls on a jittered grid in the frame of the air.
 *
 * The strength of the weather map at a thermal limits the height of its top; random numbers give its actual height and
 * its age. From a broad foot it narrows to a waist and widens to a head with a crown of balls. Lower thermals between
 * them fill the body of the cloud. Scraps surround the outlines, fewer with distance: clumps of a few old balls, with
 * n(r) ∝ r^−2, the size distribution of small clouds (Neggers et al. 2003, Zhao and Di Girolamo 2007). Each random
 * number is a hash of (seed, kind, cell, item), and radii vanish at the end of a thermal's life: everything is
 * continuous in time. */
#include "cloud/thermals.h"

#include "cloud/ball_rows.h"
#include "cloud/cloud_column.h"
#include "cloud/cloud_streams.h"
#include "cloud/repeat.h"
#include "core/math.h"
#include "core/random.h"

enum { STACK_MIN = 4, STACK_MAX = 14, CROWN = 5, SCRAP_MIN = 4, SCRAP_MAX = 8 };

/* Lengths in largest billows. */
typedef struct thermal_kind {
  np_cloud_stream stream;
  float spacing, jitter;      /* jitter in spacings */
  float radius, radius_grown; /* radius of the head: at the ground, and the increase for a thermal of full height */
  float height, height_drawn; /* height relative to the limit of the map: least value, and range above it */
  float share;                /* share of cells with a thermal */
  float outline;              /* strength at full size; 0: outside the outline */
  float shelf;                /* strength below the outline at which shelves still occur, below anvils alone */
  bool has_crown;
} thermal_kind;

static const thermal_kind kinds[] = {
    {.stream = NP_CLOUD_STREAM_THERMALS,
     .spacing = 0.92f,
     .jitter = 0.62f,
     .radius = 0.20f,
     .radius_grown = 0.38f,
     .height = 0.30f,
     .height_drawn = 0.70f,
     .share = 1.0f,
     .outline = 0.10f,
     .has_crown = true},
    {.stream = NP_CLOUD_STREAM_FILLERS,
     .spacing = 0.50f,
     .jitter = 0.9f,
     .radius = 0.24f,
     .radius_grown = 0.16f,
     .height = 0.14f,
     .height_drawn = 0.34f,
     .share = 0.9f,
     .outline = 0.14f},
    {.stream = NP_CLOUD_STREAM_SCRAPS,
     .spacing = 0.85f,
     .jitter = 0.9f,
     .radius = 0.10f,
     .radius_grown = 0.45f,
     .share = 1.0f},
    {.stream = NP_CLOUD_STREAM_SHELVES,
     .spacing = 0.42f,
     .jitter = 0.9f,
     .radius = 0.28f,
     .radius_grown = 0.10f,
     .height = 0.10f,
     .share = 1.0f,
     .outline = 0.10f,
     .shelf = 0.22f},
};

enum { KIND_COUNT = sizeof kinds / sizeof *kinds };

static const float scrap_reach = 1.2f,
                   scrap_share = 0.8f;  /* strength below the outline; share of cells at the outline */
static const float shelf_anvil = 0.25f; /* strength of the anvil for a full shelf */
static const float head_room = 0.30f; /* height of billows above the top of a thermal, in sizes of the largest billow */

static float take(np_random *random) { return np_random_float(random); }

/* Random direction over the full circle. */
static void draw_direction(np_random *random, float *out_x, float *out_y) {
  const uint64_t bits = np_random_bits(random);
  const float turn = 2.0f * (float)(bits >> 40) * 0x1p-24f - 1.0f, norm = 1.0f / (1.0f + turn * turn);
  const float side = bits & 1 ? 1.0f : -1.0f;
  *out_x = side * (1.0f - turn * turn) * norm;
  *out_y = side * 2.0f * turn * norm;
}

/* Life of a thermal: it rises, stays, then sinks and ages; it ends in the state of its start. */
typedef struct life {
  float vigour, age;
} life;

static life compute_life(const np_cloud_model *model, float wanted, np_random *random) {
  const double lifetimes = model->desc.time_s * model->lifetimes_per_s;
  const double phase = (double)take(random) + (0.35 + 0.3 * (double)take(random)) * lifetimes;
  const float turn = (float)(phase - floor(phase));
  const float grown = np_smoothstepf(turn / 0.35f) * (1.0f - np_smoothstepf((turn - 0.6f) / 0.4f));
  const float aged = np_smoothstepf((turn - 0.35f) / 0.45f) * (1.0f - np_smoothstepf((turn - 0.88f) / 0.12f));
  return (life){grown,
                np_clampf(aged * np_minf(2.0f * wanted, 1.0f) + np_maxf(2.0f * wanted - 1.0f, 0.0f), 0.0f, 1.0f)};
}

typedef struct thermal {
  const thermal_kind *kind;
  const np_cloud_model *model;
  float x_m, y_m, base_m, top_m, head_m, age;
  float aging;            /* age of the foot less the age of the top */
  float shift_x, shift_y; /* horizontal displacement of the top relative to the foot */
  np_random random;
} thermal;

/* Size factor near the field's border, 0 at the border. */
static float compute_border(const np_cloud_model *model, float x_m, float y_m) {
  const neph_cloud_desc *desc = &model->desc;
  if (desc->repeat_m > 0) return 1.0f;
  const float dx = 0.5f * (float)desc->extent_m[0] - fabsf(x_m), dy = 0.5f * (float)desc->extent_m[1] - fabsf(y_m);
  const float billow_m = model->thermals.billow_m;
  return np_smoothstepf((np_minf(dx, dy) - 0.15f * billow_m) / (0.75f * billow_m));
}

static bool is_scrap(const thermal_kind *kind) { return !(kind->outline > 0.0f); }

/* Size factor in a column. Shelves connect the bases of towers below an anvil. Scraps occur in a share of the cells
 * that grows towards the outline. */
static float compute_presence(const thermal_kind *kind, const np_cloud_column *column, float drawn) {
  const float strength = column->strength;
  if (kind->shelf > 0.0f)
    return sqrtf(np_smoothstepf((strength + kind->shelf) / kind->shelf) * np_smoothstepf(column->anvil / shelf_anvil));
  if (!is_scrap(kind)) return sqrtf(np_smoothstepf(strength / kind->outline));
  const float near = np_smoothstepf(1.0f + strength / scrap_reach), wanted = scrap_share * near * near;
  const float inside = np_smoothstepf(strength / 0.1f);
  return np_smoothstepf(20.0f * (wanted - drawn)) * (1.0f - inside);
}

/* Overall radius of a scrap: n(r) ∝ r^−2 between two radii. */
static float draw_scrap_radius(const thermal_kind *kind, float drawn) {
  const float largest = kind->radius + kind->radius_grown;
  return kind->radius / (1.0f - drawn * (1.0f - kind->radius / largest));
}

/* Sets height, radius and age of a thermal from its column; `share`: of the height that the map allows. */
static void grow_thermal(thermal *t, const np_cloud_column *column, float share, float presence) {
  const np_cloud_model *model = t->model;
  const thermal_kind *kind = t->kind;
  const float billow_m = model->thermals.billow_m, wanted = column->age;
  const float ceiling_m = np_maxf(column->thickness_m - head_room * billow_m, 0.6f * column->thickness_m);
  const life l = compute_life(model, wanted, &t->random);
  t->aging = 0.15f * wanted;
  const float strong = np_smoothstepf((column->strength - 0.7f) / 0.3f);
  const float vigour = np_mixf(l.vigour * (0.35f + 0.65f * take(&t->random)), 1.0f, strong);
  const float height = share * (kind->height + kind->height_drawn * vigour), drawn = take(&t->random);
  if (is_scrap(kind)) {
    t->head_m = billow_m * presence * draw_scrap_radius(kind, drawn) * (0.4f + 0.6f * l.vigour);
    t->head_m = np_minf(t->head_m, 0.5f * ceiling_m);
    t->top_m = 1.5f * t->head_m;
    t->age = np_maxf(l.age, 0.6f * wanted + 0.3f);
    return;
  }
  const float fresh = np_smoothstepf((height - 0.35f) / 0.3f) * (1.0f - wanted);
  t->head_m = billow_m * (kind->radius + kind->radius_grown * sqrtf(height)) * (0.85f + 0.3f * drawn) * presence;
  t->head_m = np_minf(t->head_m, 0.5f * ceiling_m);
  t->top_m = np_maxf(height * ceiling_m, 1.5f * t->head_m);
  t->age = l.age * (1.0f - 0.8f * fresh);
}

static const float presence_min = 0.02f; /* least size factor of a thermal */

/* False: the cell has none. */
static bool draw_thermal(const np_cloud_model *model, const thermal_kind *kind, const int32_t at[2], thermal *out) {
  const neph_cloud_desc *desc = &model->desc;
  const float spacing_m = np_repeat_fit(desc, kind->spacing * model->thermals.billow_m);
  const int32_t period = desc->repeat_m > 0 ? np_repeat_count(desc->extent_m[0], (double)spacing_m) : 0;
  thermal t = {.kind = kind, .model = model};
  if (kind->shelf > 0.0f && !model->map.anvils) return false;
  t.random = np_random_start(np_random_absorb(desc->seed, (uint64_t)kind->stream), 0,
                             (uint32_t)np_repeat_wrap(at[0], period), (uint32_t)np_repeat_wrap(at[1], period), 0);
  const float drawn = take(&t.random);
  if (drawn >= kind->share) return false;
  const float dx = kind->jitter * (take(&t.random) - 0.5f), dy = kind->jitter * (take(&t.random) - 0.5f);
  t.x_m = ((float)at[0] + 0.5f + dx) * spacing_m + model->drift_m[0];
  t.y_m = ((float)at[1] + 0.5f + dy) * spacing_m + model->drift_m[1];
  const np_cloud_column column = np_cloud_column_compute(model, t.x_m, t.y_m, 0.0f);
  float shift_m[2], presence = compute_presence(kind, &column, drawn);
  if (!(presence > presence_min)) return false;
  const float share = np_cloud_column_compute_top(model, &column);
  np_cloud_wind_shift(&model->wind, share * (float)desc->thickness_m, shift_m);
  presence *=
      np_minf(compute_border(model, t.x_m, t.y_m), compute_border(model, t.x_m + shift_m[0], t.y_m + shift_m[1]));
  if (!(presence > presence_min)) return false;
  t.base_m = column.base_m;
  grow_thermal(&t, &column, share, presence);
  draw_direction(&t.random, &t.shift_x, &t.shift_y);
  t.shift_x = 0.08f * t.top_m * (t.shift_x + model->heading[0]);
  t.shift_y = 0.08f * t.top_m * (t.shift_y + model->heading[1]);
  *out = t;
  return true;
}

static neph_result add_ball(np_ball_list *list, const thermal *t, float x_m, float y_m, float z_m, float radius_m,
                            float age) {
  float shift_m[2];
  np_cloud_wind_shift(&t->model->wind, t->base_m + z_m, shift_m);
  const np_ball ball = {.x_m = t->x_m + x_m + shift_m[0],
                        .y_m = t->y_m + y_m + shift_m[1],
                        .z_m = t->base_m + z_m,
                        .radius_m = radius_m,
                        .age = np_clampf(age, 0.0f, 1.0f)};
  return np_ball_list_add(t->model->context, list, &ball);
}

static neph_result add_crown(np_ball_list *list, thermal *t, const np_ball *head) {
  neph_result result = NEPH_OK;
  for (int i = 0; i < CROWN && !result; i++) {
    float x, y;
    draw_direction(&t->random, &x, &y);
    const float off_m = t->head_m * (0.55f + 0.35f * take(&t->random));
    const float drawn = take(&t->random), radius_m = t->head_m * (0.42f + 0.38f * drawn * drawn);
    const float z_m = np_maxf(head->z_m - t->head_m * (0.5f - 0.5f * take(&t->random)), 0.3f * radius_m);
    result = add_ball(list, t, head->x_m + x * off_m, head->y_m + y * off_m, z_m, radius_m, t->age);
  }
  return result;
}

static int count_stack(const np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  return (int)np_clampf((float)(desc->thickness_m / (0.3 * (double)model->thermals.billow_m)), STACK_MIN, STACK_MAX);
}

/* Adds balls of many sizes beside and on each other, in a flat clump. */
static neph_result add_scrap(np_ball_list *list, thermal *t) {
  const int count = SCRAP_MIN + (int)(take(&t->random) * (SCRAP_MAX - SCRAP_MIN + 1));
  const float rise = 1.4f - 0.6f * (float)t->model->desc.type; /* lower if only strong cells are tall */
  neph_result result = NEPH_OK;
  for (int i = 0; i < count && !result; i++) {
    float x, y;
    draw_direction(&t->random, &x, &y);
    const float drawn = take(&t->random), radius_m = t->head_m * (0.28f + 0.5f * drawn * drawn);
    const float off_m = i ? t->head_m * (0.35f + 0.65f * take(&t->random)) : 0.0f;
    const float z_m = t->model->thermals.floor_m + 0.5f * radius_m + rise * t->head_m * take(&t->random);
    result = add_ball(list, t, x * off_m, y * off_m, z_m, radius_m, t->age);
  }
  return result;
}

/* Adds balls from the foot to the head. */
static neph_result add_thermal(np_ball_list *list, thermal *t) {
  if (is_scrap(t->kind)) return add_scrap(list, t);
  const int count = t->kind->shelf > 0.0f ? STACK_MIN : count_stack(t->model);
  const float foot_m = 0.4f * t->head_m, rise_m = t->top_m - t->head_m - foot_m;
  const float waist = t->kind->has_crown ? 0.70f : 0.95f, foot = 1.12f;
  neph_result result = NEPH_OK;
  np_ball head = {.x_m = 0};
  for (int i = 0; i < count && !result; i++) {
    const float s = (float)i / (float)(count - 1);
    const float radius_m = t->head_m * (0.88f + 0.24f * take(&t->random)) *
                           (s < 0.45f ? np_mixf(foot, waist, np_smoothstepf(s / 0.45f))
                                      : np_mixf(waist, 1.0f, np_smoothstepf((s - 0.45f) / 0.55f)));
    const float stray_m = (i == count - 1 ? 0.3f : 0.9f) * radius_m;
    head.x_m = t->shift_x * s * s + stray_m * (take(&t->random) - 0.5f);
    head.y_m = t->shift_y * s * s + stray_m * (take(&t->random) - 0.5f);
    head.z_m = foot_m + s * rise_m;
    result = add_ball(list, t, head.x_m, head.y_m, head.z_m, radius_m, t->age + t->aging * (1.0f - s));
  }
  return result || !t->kind->has_crown ? result : add_crown(list, t, &head);
}

/* ---- Rows of the grids ---- */

typedef struct grid_rows {
  const np_cloud_model *model;
  int32_t first[KIND_COUNT][2], count[KIND_COUNT][2];
  size_t row_begin[KIND_COUNT + 1];
} grid_rows;

static neph_result add_row(const void *user, size_t row, np_ball_list *list) {
  const grid_rows *grid = user;
  int k = 0;
  while (row >= grid->row_begin[k + 1]) k++;
  neph_result result = NEPH_OK;
  for (int32_t i = 0; i < grid->count[k][0] && !result; i++) {
    const int32_t at[2] = {grid->first[k][0] + i, grid->first[k][1] + (int32_t)(row - grid->row_begin[k])};
    thermal t;
    if (draw_thermal(grid->model, &kinds[k], at, &t)) result = add_thermal(list, &t);
  }
  return result;
}

neph_result np_thermals_add_stacks(np_cloud_model *model, np_monitor *monitor, float blend_m, float bin_m) {
  const neph_cloud_desc *desc = &model->desc;
  grid_rows grid = {.model = model};
  for (int k = 0; k < KIND_COUNT; k++) {
    double spacing_m = (double)kinds[k].spacing * (double)model->thermals.billow_m;
    if (desc->repeat_m > 0) spacing_m = (double)np_repeat_fit(desc, (float)spacing_m);
    for (int a = 0; a < 2; a++) {
      const double low_m = -0.5 * desc->extent_m[a] - (double)model->drift_m[a];
      grid.first[k][a] = (int32_t)floor(low_m / spacing_m) - 1;
      grid.count[k][a] = desc->repeat_m > 0 ? np_repeat_count(desc->extent_m[a], spacing_m)
                                            : (int32_t)ceil(desc->extent_m[a] / spacing_m) + 3;
    }
    grid.row_begin[k + 1] = grid.row_begin[k] + (size_t)grid.count[k][1];
  }
  model->balls.margin_m = 3.6f * model->thermals.billow_m; /* reach of billows beyond the field */
  return np_ball_rows_collect(&model->balls, monitor, grid.row_begin[KIND_COUNT], add_row, &grid, blend_m, bin_m);
}
