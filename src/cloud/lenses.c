/* SPDX-License-Identifier: Apache-2.0 */
/* Lenticular clouds: piles of lenses in moist layers of air that are lifted over the crests of mountain waves.
 *
 * The weather map is the lift of the air by the waves (mountain_wave.c), 0 at the condensation level. In each layer its
 * strength s gives a lens: a lower face arched by the wave, and an upper face s·(3 − s)/2 above it, with sharp rims.
 * Layers differ in thickness, in moisture and so in the size of their lenses, and are laminated; noise along the wind
 * adds fibres. On the lee side, where the air sinks and mixes, that noise erodes the rims. */
#include <math.h>

#include "cloud/cloud_kinds.h"
#include "cloud/kind_points.h"
#include "cloud/waterline.h"
#include "core/math.h"
#include "core/random.h"

enum { LAYERS_MAX = 16 };

/* Heights in pitches, the distances between layers. */
static const float lowest = 0.1f, arch = 0.25f, thickest = 1.15f;
static const float head_room = 0.5f;     /* height of the upper layer beyond its pitch */
static const float pitch_spread = 0.7f;  /* largest deviation of a pitch from the mean, before the pile is fitted */
static const float drier_max = 0.42f;    /* reduction of strength in the driest layer */
static const float swell_reach = 0.22f;  /* variation of strength, at erosion 1 */
static const float lamina_reach = 0.18f; /* variation of strength, at erosion 1 */
static const float fibre_reach = 0.20f;  /* in pitches, at erosion 1 */
static const float lamina_share = 0.14f; /* thickness of laminae, in pitches */
static const float lamina_stretch = 40.0f;
static const float fibre_stretch = 2.2f;
static const float lee_way =
    0.07f; /* distance upwind, in wavelengths, at which air is compared: in the lee it was higher */
static const float lee_fall = 0.15f; /* decrease of strength over that distance for full lee */
static const float lee_reach = 0.9f; /* reduction of strength by noise on the lee side, at erosion 1 */
static const float extinction_floor = 0.004f;

/* Pitch of equal layers. */
static float get_pitch_m(const neph_cloud_desc *desc) {
  return (float)desc->thickness_m / ((float)desc->sublayers + head_room);
}

typedef struct lens_layer {
  float floor_m, pitch_m; /* height of its floor above the base, and distance to the next layer's */
  float lack;             /* reduction of strength */
} lens_layer;

/* A layer with its pitch in units of the mean. */
static lens_layer draw_layer(const neph_cloud_desc *desc, unsigned layer) {
  const uint64_t bits = np_random_absorb(np_random_absorb(desc->seed, NP_CLOUD_STREAM_SHEET), layer);
  const float drawn = (float)(bits >> 40) * 0x1p-24f, other = (float)(np_random_mix(bits) >> 40) * 0x1p-24f;
  const float middle = fabsf((float)layer + 0.5f - 0.5f * (float)desc->sublayers) / (0.5f * (float)desc->sublayers);
  return (lens_layer){.pitch_m = 1.0f + pitch_spread * (2.0f * other - 1.0f),
                      .lack = drier_max * (0.55f * drawn + 0.45f * middle)};
}

/* The pile of layers, as thick as the cloud. */
static void make_layers(const neph_cloud_desc *desc, lens_layer out[LAYERS_MAX]) {
  float pile = 0.0f;
  for (unsigned layer = 0; layer < desc->sublayers; layer++) {
    out[layer] = draw_layer(desc, layer);
    pile += out[layer].pitch_m;
  }
  const float scale_m = (float)desc->thickness_m / (pile + head_room * out[desc->sublayers - 1].pitch_m);
  float floor_m = 0.0f;
  for (unsigned layer = 0; layer < desc->sublayers; layer++) {
    out[layer].floor_m = floor_m;
    out[layer].pitch_m *= scale_m;
    floor_m += out[layer].pitch_m;
  }
}

static void prepare_lenses(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  np_kind_noises *k = &model->noises;
  const float pitch_m = get_pitch_m(desc), voxel_m = (float)desc->voxel_m;
  k->coarse = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_BASE);
  k->medium = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_DETAIL);
  k->fine = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_WISPS);
  k->fine_m = np_maxf(0.55f * (float)desc->billow_m, 3.0f * voxel_m);
  k->fine_octaves = np_kind_count_octaves(desc, k->fine_m);
  k->edge_m = np_maxf((0.06f + 0.5f * (float)(desc->softness * desc->softness)) * pitch_m, 1.2f * voxel_m);
}

/* Strength with the variation of the layers; `out_fibre` is in [−½, ½]. */
static void compute_strengths(const np_cloud_model *model, np_kind_points *p, float *out_strength, float *out_fibre) {
  const neph_cloud_desc *desc = &model->desc;
  const np_kind_noises *k = &model->noises;
  const np_noise_octaves octaves = {.count = k->fine_octaves, .gain = 0.6f};
  const float erosion = (float)desc->erosion,
              lamina_m = np_maxf(lamina_share * get_pitch_m(desc), 2.0f * (float)desc->voxel_m);
  np_noise_points points = np_kind_scale(model, p, 2.5f * (float)desc->billow_m, 1.0f);
  model->noise->value(&k->coarse, &points, p->noise);
  for (size_t i = 0; i < p->count; i++)
    out_strength[i] = p->strength[i] + 2.0f * swell_reach * erosion * (p->noise[i] - 0.5f);
  points = np_kind_scale(model, p, lamina_m, lamina_stretch);
  for (size_t i = 0; i < p->count; i++) p->sy[i] /= lamina_stretch;
  model->noise->value(&k->medium, &points, p->noise);
  for (size_t i = 0; i < p->count; i++) out_strength[i] += 2.0f * lamina_reach * erosion * (p->noise[i] - 0.5f);
  points = np_kind_scale(model, p, k->fine_m, fibre_stretch);
  model->noise->value_fbm(&k->fine, &octaves, &points, out_fibre);
  for (size_t i = 0; i < p->count; i++) out_fibre[i] -= 0.5f;
}

/* Erodes rims on the lee side; it only reduces strength, so that bounds hold. */
static void fray_lee(const np_cloud_model *model, const np_kind_points *p, const float *fibre, float *strength) {
  const np_weather_map *map = &model->map;
  const float way_m = lee_way * (float)model->desc.cell_m, *heading = model->heading;
  for (size_t i = 0; i < p->count; i++) {
    const float x_m = p->field_x_m[i], y_m = p->field_y_m[i];
    const float here = np_weather_map_sample(map, map->values, x_m, y_m);
    const float upwind = np_weather_map_sample(map, map->values, x_m - way_m * heading[0], y_m - way_m * heading[1]);
    const float lee = np_smoothstepf((upwind - here) * model->depth_scale / lee_fall);
    strength[i] -= lee_reach * (float)model->desc.erosion * lee * np_clampf(0.5f + 3.0f * fibre[i], 0.0f, 1.0f);
  }
}

/* Depth inside the lens of a layer; negative outside. */
static float compute_depth(const lens_layer *layer, float strength, float height_m) {
  const float s = np_minf((strength - layer->lack) / (1.0f - layer->lack), 1.0f);
  if (!(s > 0.0f)) return -1.0f;
  const float low_m = layer->floor_m + layer->pitch_m * (lowest + arch * s);
  const float high_m = low_m + layer->pitch_m * thickest * s * (1.5f - 0.5f * s);
  return np_minf(height_m - low_m, high_m - height_m);
}

static void eval_lenses(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_kind_points p;
  if (!np_kind_points_collect(model, points, &p)) return;
  const neph_cloud_desc *desc = &model->desc;
  const float fibre_m = 2.0f * fibre_reach * (float)desc->erosion * get_pitch_m(desc);
  lens_layer layers[LAYERS_MAX];
  float strength[NP_CLOUD_BLOCK], fibre[NP_CLOUD_BLOCK], depth_m[NP_CLOUD_BLOCK];
  make_layers(desc, layers);
  compute_strengths(model, &p, strength, fibre);
  fray_lee(model, &p, fibre, strength);
  for (size_t i = 0; i < p.count; i++) depth_m[i] = -1.0f;
  for (unsigned layer = 0; layer < desc->sublayers; layer++)
    for (size_t i = 0; i < p.count; i++)
      depth_m[i] = np_maxf(depth_m[i], compute_depth(&layers[layer], strength[i], p.height_m[i]));
  for (size_t i = 0; i < p.count; i++) {
    if (!(depth_m[i] > 0.0f)) continue;
    const float body = np_smoothstepf((depth_m[i] + fibre_m * np_minf(fibre[i], 0.0f)) / model->noises.edge_m);
    if (body > extinction_floor) out_extinction_per_m[p.index[i]] = (float)desc->extinction_per_m * body;
  }
}

static bool is_lens_empty(const np_cloud_model *model, const np_cloud_box *box) {
  np_kind_box bounded;
  if (!np_kind_box_make(model, box, &bounded)) return true;
  const neph_cloud_desc *desc = &model->desc;
  const float gain = (swell_reach + lamina_reach) * (float)desc->erosion + 1e-3f;
  const float low_m = bounded.box.min_m[2] - bounded.base_m.high, high_m = bounded.box.max_m[2] - bounded.base_m.low;
  lens_layer layers[LAYERS_MAX];
  make_layers(desc, layers);
  for (unsigned n = 0; n < desc->sublayers; n++) {
    const lens_layer *layer = &layers[n];
    const float s = np_minf((bounded.strength.high + gain - layer->lack) / (1.0f - layer->lack), 1.0f);
    if (!(s > 0.0f)) continue;
    const float bottom_m = layer->floor_m + layer->pitch_m * lowest;
    const float top_m = bottom_m + layer->pitch_m * s * (arch + thickest * (1.5f - 0.5f * s));
    if (high_m > bottom_m - 0.01f && low_m < top_m + 0.01f) return false;
  }
  return true;
}

const np_cloud_kind np_lenses_kind = {
    .name = "lenses",
    .landscape = {.form = NP_LANDSCAPE_SHEET, .swirl_size = 1.3f, .has_mountain_waves = true, .has_ground = true},
    .more_cover = "beyond its waves the air stays clear; reduce extent, or take a stratus",
    .less_cover = "lenses of this size cover no less; enlarge extent, or reduce cell",
    .repeat_obstacle = "which follow mountains",
    .has_thin_rims = true,
    .billow_grains = 7,
    .census_passes = 4,
    .prepare = prepare_lenses,
    .search_waterline = np_waterline_search,
    .eval = eval_lenses,
    .is_empty = is_lens_empty,
};
