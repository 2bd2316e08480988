/* SPDX-License-Identifier: Apache-2.0 */
/* A density model made ready: amplitudes and frequencies of its noises, its state at the description's time, and the
 * waterline that gives the coverage asked for. */
#include <math.h>

#include "cloud/cloud_kinds.h"
#include "cloud/repeat.h"
#include "cloud/shape.h"
#include "cloud/thermals.h"
#include "core/alloc.h"

/* Mean and largest of the noises, from noise.h. */
static const float base_mean = 0.85f, erosion_mean = 0.30f, sheet_mean = 0.5f;

static const float base_reach = 3.2f;     /* of the base billows at billowiness 1, in their own size */
static const float detail_reach = 1.35f;  /* of an octave of detail at erosion 1, in its own size */
static const float detail_boost = 1.2f;   /* of an octave's amplitude over its size, from one octave to the next */
static const float detail_size = 0.46f;   /* of the first octave of detail, in largest billows */
static const float octave_ratio = 0.47f;  /* from one octave to the next: not ½, or lattices would line up */
static const float base_ramp_size = 0.1f; /* over which the base thickens, in largest billows */
static const float edge_size = 0.03f;     /* of the crisp edge, in largest billows */
static const float soft_edge = 0.9f;      /* of the softest, in depth */
static const float curl_size = 0.55f;     /* of the eddies, in largest billows */
static const float curl_reach = 0.12f;    /* of the displacement at turbulence 1, in largest billows */
static const float sheet_curl_size = 2.2f, sheet_curl_reach = 0.9f;   /* the same of a slab */
static const float sheet_relief_min = 0.15f, sheet_relief_max = 1.1f; /* of a slab's noise, by erosion, in depth */
static const float turnovers = 3.0f; /* of the billows, in their own size, in the lifetime of a cell */

static bool is_slab(const np_cloud_model *model) { return model->desc.model == NEPH_CLOUD_MODEL_SLAB; }

static void set_sheet(np_cloud_model *model) {
  const float erosion = (float)model->desc.erosion;
  model->base.amplitude = sheet_relief_min + erosion * (sheet_relief_max - sheet_relief_min);
  model->base_gain_max = model->base.amplitude;
  model->detail_gain_max = model->detail_loss_max = 0.0f;
}

static void set_billows(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  const float billow_m = (float)desc->billow_m;
  model->base.amplitude = base_reach * (float)desc->billowiness * billow_m * model->slope_per_m;
  model->base_gain_max = model->base.amplitude * (1.0f - base_mean);
  float amplitude = detail_reach * (float)desc->erosion * detail_size * billow_m * model->slope_per_m;
  for (unsigned k = 0; k < model->detail_count; k++, amplitude *= octave_ratio * detail_boost)
    model->detail[k].amplitude = amplitude;
  const float turned = 2.0f * (float)desc->wispiness - 1.0f; /* less the sign at the base, where it is negative */
  float sum = 0.0f;
  for (unsigned k = model->detail_count; k-- > 0;) {
    sum += model->detail[k].amplitude;
    model->detail[k].gain_max = sum * fmaxf(erosion_mean, turned * (1.0f - erosion_mean));
    model->detail[k].loss_max = sum * fmaxf(1.0f - erosion_mean, turned * erosion_mean);
  }
  model->detail_gain_max = model->detail_count ? model->detail[0].gain_max : 0.0f;
  model->detail_loss_max = model->detail_count ? model->detail[0].loss_max : 0.0f;
  model->base_ramp_inverse = (float)desc->thickness_m / (base_ramp_size * billow_m);
}

/* Sets what follows from the slope at outlines. */
static void set_edges(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  model->edge = model->slope_per_m * fmaxf(edge_size * (float)desc->billow_m, 0.75f * (float)desc->voxel_m) +
                soft_edge * (float)(desc->softness * desc->softness);
  if (is_slab(model))
    set_sheet(model);
  else if (!np_cloud_kind_get(desc->model) && !np_cloud_model_has_thermals(model))
    set_billows(model);
}

/* Sets the waterline and what follows from it. */
static void set_waterline(np_cloud_model *model, float waterline) {
  const float range = model->map.highest - waterline;
  model->waterline = waterline;
  model->depth_scale = 1.0f / range;
  model->depth_offset = -waterline / range;
  model->slope_per_m = 2.0f / (model->map.radius_m * sqrtf(range));
  set_edges(model);
}

static np_noise_lattice make_lattice(const np_cloud_model *model, unsigned stream) {
  return (np_noise_lattice){np_noise_derive_seed(model->desc.seed, stream),
                            {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
}

/* Octaves of detail as long as a billow covers two voxels. */
static void choose_detail(np_cloud_model *model, float size_m) {
  for (unsigned k = 0; k < NP_CLOUD_OCTAVES_MAX && size_m >= 2.0f * (float)model->desc.voxel_m; k++) {
    model->detail[k].lattice = make_lattice(model, NP_CLOUD_STREAM_DETAIL + k);
    model->detail[k].frequency_per_m = 1.0f / np_repeat_fit(&model->desc, size_m);
    np_repeat_set_period(&model->desc, size_m, 1.0f, &model->detail[k].lattice);
    model->detail[k].mean = erosion_mean;
    model->detail_count = k + 1;
    size_m *= octave_ratio;
  }
}

static unsigned count_sheet_octaves(const np_cloud_model *model) {
  unsigned count = 1;
  for (double size_m = 0.5 * model->desc.billow_m; size_m >= 2 * model->desc.voxel_m && count < NP_CLOUD_OCTAVES_MAX;
       size_m *= 0.5)
    count++;
  return count;
}

static void choose_noises(np_cloud_model *model) {
  const float billow_m = (float)model->desc.billow_m;
  const bool slab = is_slab(model);
  model->base.lattice = make_lattice(model, slab ? NP_CLOUD_STREAM_SHEET : NP_CLOUD_STREAM_BASE);
  model->base.frequency_per_m = 1.0f / np_repeat_fit(&model->desc, billow_m);
  np_repeat_set_period(&model->desc, billow_m, slab ? (float)model->desc.stretch : 1.0f, &model->base.lattice);
  model->base.mean = slab ? sheet_mean : base_mean;
  model->curl = make_lattice(model, NP_CLOUD_STREAM_CURL);
  const float curl_m = (slab ? sheet_curl_size : curl_size) * billow_m;
  model->curl_frequency_per_m = 1.0f / np_repeat_fit(&model->desc, curl_m);
  np_repeat_set_period(&model->desc, curl_m, 1.0f, &model->curl);
  model->curl_distance_m = (slab ? sheet_curl_reach : curl_reach) * billow_m * (float)model->desc.turbulence;
  model->rain = make_lattice(model, NP_CLOUD_STREAM_RAIN);
  const np_cloud_kind *kind = np_cloud_kind_get(model->desc.model);
  if (kind)
    kind->set(model);
  else if (slab)
    model->sheet_octave_count = count_sheet_octaves(model);
  else if (np_cloud_model_has_thermals(model))
    np_thermals_set_noises(model);
  else
    choose_detail(model, detail_size * billow_m);
}

/* Displacement of the air since time 0. */
static void set_time(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  for (int i = 0; i < 2; i++) model->drift_m[i] = (float)(desc->wind_m_s[i] * desc->time_s);
  model->turnover = (float)(desc->time_s / desc->lifetime_s) * turnovers;
}

enum { CENSUS_COLUMNS_MAX = 64, CENSUS_HEIGHTS = 24, CENSUS_HEIGHTS_MAX = 48, CENSUS_STEPS = 14 };
enum { CENSUS_WHITE = 1024 };

typedef struct census {
  const np_cloud_model *model;
  int columns[2], heights; /* columns along each axis */
  float cell_m[2], step_m; /* distances between those */
  atomic_size_t covered, wanted;
} census;

static const double census_heights_per_billow = 6; /* of thermals, or what stands out between two is missed */

/* Heights to look at: those of the voxels, if they are not too many. */
static int count_heights(const neph_cloud_desc *desc) {
  const double voxels = ceil(desc->thickness_m / desc->voxel_m);
  double heights = CENSUS_HEIGHTS;
  if (desc->model == NEPH_CLOUD_MODEL_THERMALS || desc->model == NEPH_CLOUD_MODEL_HERO)
    heights = fmax(heights, ceil(census_heights_per_billow * desc->thickness_m / desc->billow_m));
  return (int)fmin(voxels, fmin(heights, CENSUS_HEIGHTS_MAX));
}

/* Census of the columns. Where voxels are coarser than the model it looks at the voxels' own columns, at all of them if
 * they are few, and at each grain: a choice of others would miss by chance. */
static census make_census(const np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  census c = {.model = model, .heights = count_heights(desc)};
  c.step_m = (float)desc->thickness_m / (float)c.heights;
  for (int a = 0; a < 2; a++) {
    const double voxel_m = desc->voxel_m * model->sample_count, voxels = fmax(round(desc->extent_m[a] / voxel_m), 1);
    const bool is_all = model->sample_count > 1 && voxels <= CENSUS_COLUMNS_MAX;
    c.columns[a] = is_all ? (int)voxels : CENSUS_COLUMNS_MAX;
    c.cell_m[a] = is_all ? (float)voxel_m : (float)desc->extent_m[a] / CENSUS_COLUMNS_MAX;
  }
  if (model->sample_count == 1) return c;
  c.heights = (int)fmin(ceil(desc->thickness_m / desc->voxel_m), NP_CLOUD_BLOCK);
  c.step_m = (float)desc->voxel_m;
  return c;
}

/* Columns of a row, and points of those that are not known to be covered. */
typedef struct census_row {
  const census *census;
  bool is_covered[CENSUS_COLUMNS_MAX];
  size_t count;
  uint8_t column[NP_CLOUD_BLOCK];
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK];
} census_row;

static void eval_points(census_row *row) {
  float extinction[NP_CLOUD_BLOCK];
  const np_cloud_points points = {row->count, row->x_m, row->y_m, row->height_m};
  np_cloud_model_eval_points(row->census->model, &points, extinction);
  for (size_t n = 0; n < row->count; n++)
    if (extinction[n] > 0.0f) row->is_covered[row->column[n]] = true;
  row->count = 0;
}

static float compute_place_m(const census *c, int axis, size_t i) {
  return ((float)i + 0.5f - 0.5f * (float)c->columns[axis]) * c->cell_m[axis];
}

/* Adds the heights of a column from `first` on in steps. */
static void add_column(census_row *row, int column, float y_m, int first, int step) {
  const census *c = row->census;
  if (row->count + (size_t)c->heights > NP_CLOUD_BLOCK) eval_points(row);
  for (int i = first; i < c->heights; i += step) {
    const size_t n = row->count++;
    row->column[n] = (uint8_t)column;
    row->x_m[n] = compute_place_m(c, 0, (size_t)column);
    row->y_m[n] = y_m;
    row->height_m[n] = ((float)i + 0.5f) * c->step_m;
  }
}

/* Share of the sky that is to be covered at a place, in whole numbers, whose sum does not depend on threads. */
static size_t get_share(const np_cloud_model *model, float x_m, float y_m) {
  if (!model->map.levels) return (size_t)(model->map.coverage * CENSUS_WHITE + 0.5);
  const float *shares = model->map.planes[NEPH_CLOUD_MAP_COVERAGE];
  return (size_t)(np_weather_map_sample(&model->map, shares, x_m, y_m) * (float)CENSUS_WHITE + 0.5f);
}

/* Counts the columns of one row of the field in which there is any cloud: a few heights find most of them, and the
 * others are looked at where those have found none. Of thermals all are looked at together: a search for balls takes
 * neighbours. */
static void count_covered(census *c, size_t y) {
  static const int first[] = {1, 3, 0, 2};
  const int passes = np_cloud_model_has_thermals(c->model) ? 1 : (int)(sizeof first / sizeof *first);
  census_row row = {.census = c};
  size_t covered = 0, wanted = 0;
  for (int pass = 0; pass < passes; pass++) {
    for (int i = 0; i < c->columns[0]; i++)
      if (!row.is_covered[i]) add_column(&row, i, compute_place_m(c, 1, y), passes > 1 ? first[pass] : 0, passes);
    if (row.count) eval_points(&row);
  }
  for (int i = 0; i < c->columns[0]; i++) {
    const size_t share = get_share(c->model, compute_place_m(c, 0, (size_t)i), compute_place_m(c, 1, y));
    const size_t weight = c->model->map.levels ? share : 1;
    covered += row.is_covered[i] ? weight * CENSUS_WHITE : 0;
    wanted += weight * share;
  }
  atomic_fetch_add(&c->covered, covered);
  atomic_fetch_add(&c->wanted, wanted);
}

static neph_result count_rows(void *user, size_t begin, size_t end, unsigned thread) {
  census *c = user;
  (void)thread;
  for (size_t row = begin; row < end; row++) count_covered(c, row);
  return NEPH_OK;
}

/* Share of the field's sky that is covered. Of a picture columns count by how white it is there, so that its borders,
 * which are grey, do not make up for clear sky within them. */
static neph_result count_field(neph_context *context, np_monitor *monitor, const np_cloud_model *model,
                               double *out_fraction) {
  census c = make_census(model);
  atomic_init(&c.covered, 0);
  atomic_init(&c.wanted, 0);
  neph_result result = np_parallel_for(context, monitor, (size_t)c.columns[1], 1, count_rows, &c);
  const double covered = (double)atomic_load(&c.covered), wanted = (double)atomic_load(&c.wanted);
  *out_fraction = model->map.levels && wanted > 0 ? model->map.coverage * covered / wanted
                                                  : covered / ((double)CENSUS_WHITE * c.columns[0] * c.columns[1]);
  return result;
}

/* A waterline that was tried, and by how much the coverage misses the one that is asked for. */
typedef struct waterline {
  float value;
  double miss;
} waterline;

static void keep_better(np_cloud_model *model, double fraction, waterline *best) {
  const double miss = fabs(fraction - model->map.coverage);
  if (!(miss < best->miss)) return;
  *best = (waterline){model->waterline, miss};
  model->covered = fraction;
}

static neph_result search_shadow(np_monitor *monitor, np_cloud_model *model, double wanted) {
  const float spread = model->map.highest - model->map.lowest;
  float low = model->map.lowest - 0.5f * spread, high = model->map.highest - 0.01f * spread;
  for (int step = 0; step < CENSUS_STEPS; step++) {
    double fraction = 0;
    const float middle = 0.5f * (low + high);
    set_waterline(model, middle);
    neph_result result = np_thermals_count_shadow(model, monitor, &fraction);
    if (result) return result;
    *(fraction > wanted ? &low : &high) = middle;
  }
  set_waterline(model, 0.5f * (low + high));
  return NEPH_OK;
}

/* Whether the best of all waterlines tried is taken: of few columns many change at a time, of a picture's clouds the
 * borders are not in the shadow. */
static bool is_searched_well(const np_cloud_model *model) { return model->sample_count > 1 || model->map.levels; }

/* Corrections of the shadow that are tried at most. Anvils are not in it. */
static int count_corrections(const np_cloud_model *model) {
  enum { CORRECTIONS = 3, CORRECTIONS_MAX = 8 };
  return model->map.anvils || is_searched_well(model) ? CORRECTIONS_MAX : CORRECTIONS;
}

/* The waterline of thermals is found by the shadow of their stacks, a few times over: what the census of all that
 * stands on them makes of it corrects the shadow that is wanted. */
static neph_result search_thermals(neph_context *context, np_monitor *monitor, np_cloud_model *model) {
  enum { CENSUS_LEVELS = 3 };
  const int corrections = count_corrections(model);
  const unsigned levels = np_thermals_count_levels(model);
  const double tolerance = model->map.levels ? 0.01 * model->map.coverage : 0.01;
  double wanted = model->map.coverage;
  waterline best = {.miss = INFINITY};
  if (model->is_empty) return NEPH_OK;
  neph_result result = search_shadow(monitor, model, wanted);
  for (int n = 0; n < corrections && !result; n++) {
    double fraction = 0;
    result = np_thermals_build(model, monitor, levels < CENSUS_LEVELS ? levels : CENSUS_LEVELS);
    if (!result) result = count_field(context, monitor, model, &fraction);
    keep_better(model, fraction, &best);
    if (result || best.miss < tolerance) break;
    wanted *= fmin(fmax(model->map.coverage / fmax(fraction, 1e-3), 0.3), 2.0);
    result = search_shadow(monitor, model, fmin(wanted, 1));
  }
  if (is_searched_well(model)) set_waterline(model, best.value);
  return result;
}

/* The covered fraction falls as the waterline rises: found by halving. What billows add at an outline and creases take
 * from it is in the count, so that no formula for it is needed. */
static neph_result search_waterline(neph_context *context, np_monitor *monitor, np_cloud_model *model) {
  const float spread = model->map.highest - model->map.lowest;
  if (np_cloud_model_has_thermals(model)) return search_thermals(context, monitor, model);
  float low = model->map.lowest - 0.5f * spread, high = model->map.highest - 0.01f * spread;
  waterline best = {.miss = INFINITY};
  for (int step = 0; step < CENSUS_STEPS; step++) {
    double fraction = 0;
    const float middle = 0.5f * (low + high);
    set_waterline(model, middle);
    neph_result result = count_field(context, monitor, model, &fraction);
    if (result) return result;
    keep_better(model, fraction, &best);
    *(fraction > model->map.coverage ? &low : &high) = middle;
  }
  set_waterline(model, is_searched_well(model) ? best.value : 0.5f * (low + high));
  return NEPH_OK;
}

/* The map at the start, whose waterline is kept, or clouds would breathe with the census; then that of the time. */
static neph_result build_maps(neph_context *context, const np_weather_picture *picture, np_monitor *monitor,
                              np_cloud_model *model) {
  neph_cloud_desc start = model->desc;
  start.time_s = 0;
  neph_result result = np_weather_map_build(context, &start, picture, NULL, monitor, &model->map);
  if (result) return result;
  model->is_empty = !(model->map.coverage > 0);
  result = search_waterline(context, monitor, model);
  if (result || model->desc.time_s == 0) return result;
  np_weather_map moved;
  result = np_weather_map_build(context, &model->desc, picture, &model->map, monitor, &moved);
  if (result) return result;
  np_weather_map_clear(&model->map);
  model->map = moved;
  return NEPH_OK;
}

static neph_result build_map_and_waterline(neph_context *context, np_monitor *monitor, np_cloud_model *model) {
  np_weather_picture picture;
  if (np_cloud_desc_has_shape(&model->desc)) return np_shape_build(model, monitor);
  neph_result result = np_weather_picture_load(context, &model->desc, &picture);
  if (!result) result = build_maps(context, &picture, monitor, model);
  np_weather_picture_clear(&picture);
  return result;
}

neph_result np_cloud_model_build(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                 np_cloud_model *out_model) {
  np_cloud_model model = {.desc = np_repeat_round(desc), .noise = np_noise_get_table(context->isa)};
  model.sample_count = np_cloud_grain_count(&model.desc);
  model.desc.voxel_m /= model.sample_count;
  model.balls = (np_ball_heap){.context = context, .kernels = np_ball_get_table(context->isa)};
  desc = &model.desc;
  model.balls.repeat_m = desc->repeat_m > 0 ? (float)desc->extent_m[0] : 0.0f;
  model.lives_per_s = 1.0 / desc->lifetime_s;
  np_cloud_desc_compute_heading(desc, model.heading);
  model.wind = np_cloud_wind_make(desc);
  choose_noises(&model);
  neph_result result = build_map_and_waterline(context, monitor, &model);
  set_time(&model);
  if (!result && np_cloud_model_has_thermals(&model))
    result = np_thermals_build(&model, monitor, np_thermals_count_levels(&model));
  if (result) {
    np_cloud_model_clear(&model);
    return result;
  }
  if (np_cloud_desc_has_shape(desc)) np_shape_check_billows(&model);
  model.rain_depth_m = (float)(desc->precipitation * fmax(desc->base_altitude_m, 0));
  *out_model = model;
  return NEPH_OK;
}

np_cloud_model np_cloud_model_refine(const np_cloud_model *model, double share) {
  np_cloud_model refined = *model;
  refined.desc.voxel_m *= share;
  refined.sample_count = 1;
  choose_noises(&refined);
  set_edges(&refined);
  return refined;
}

void np_cloud_model_clear(np_cloud_model *model) {
  np_ball_heap_cut(&model->balls, 0);
  if (model->shape) {
    neph_context *context = model->balls.context;
    np_shape_grid_clear(model->shape);
    np_alloc_free(context, model->shape);
  }
  np_weather_map_clear(&model->map);
  *model = (np_cloud_model){0};
}
