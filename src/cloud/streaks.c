/* SPDX-License-Identifier: Apache-2.0 */
/* Fall streaks of ice: cirrus.
 *
 * Ice forms in small heads at the top and falls out of them. Without skew a streak hangs vertically below its head and
 * fades with depth; the wind, weaker below, bends it to a hook (the shift grows with the square of the height). A
 * streak is a bundle of fibres: noise across it down to two voxels, hardly any along it. */
#include <math.h>
#include <string.h>

#include "cloud/cloud_kinds.h"
#include "cloud/kind_points.h"
#include "cloud/waterline.h"
#include "core/math.h"

static const float head_share = 0.16f;    /* relative to the thickness */
static const float bundle_stretch = 3.5f; /* along the wind at `stretch` 12; scales with its square root */
static const float fibre_size = 0.3f;     /* in billows */
static const float fall_size = 2.3f;      /* size of the noise of the fall distance, in billows */
static const float fibre_upright = 0.04f; /* variation of fibres along their height, relative to across */
static const float group_strength = 0.5f; /* strength of the map at which heads are densest */
static const float roof_size = 5.0f,
                   roof_drop =
                       0.42f; /* variation of the heads' level: size in billows, amplitude relative to the thickness */
static const float fibre_layers = 2.5f; /* layers of voxels that displace a fibre by a cell of its finest noise */
static const float veil = 0.12f;        /* ice between fibres of a closed sky, relative to theirs */
static const float veil_from = 0.5f;    /* cover from which on there is any */
static const float extinction_floor = 0.01f;

static float get_stretch(const neph_cloud_desc *desc) { return bundle_stretch * sqrtf((float)desc->stretch / 12.0f); }

/* Largest horizontal displacement over a metre of height. */
static float compute_shear(const np_cloud_model *model) {
  enum { LAYERS = 16 };
  const float layer_m = (float)model->desc.thickness_m / LAYERS;
  float before_m[2], after_m[2], shear = 0.0f;
  np_cloud_wind_shift(&model->wind, 0.0f, before_m);
  for (int k = 1; k <= LAYERS; k++) {
    np_cloud_wind_shift(&model->wind, layer_m * (float)k, after_m);
    const float dx_m = after_m[0] - before_m[0], dy_m = after_m[1] - before_m[1];
    shear = np_maxf(shear, sqrtf(dx_m * dx_m + dy_m * dy_m) / layer_m);
    memcpy(before_m, after_m, sizeof before_m);
  }
  return shear;
}

static void prepare_streaks(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  np_kind_noises *k = &model->noises;
  k->coarse = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_SHEET);
  k->medium = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_BASE);
  k->fine = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_WISPS);
  k->fine_m = np_maxf(fibre_size * (float)desc->billow_m, 2.5f * (float)desc->voxel_m);
  k->fine_octaves = np_kind_count_octaves(desc, k->fine_m);
  k->edge_m = 0.0f;
  k->shear = compute_shear(model);
}

/* Stretch of the fibres. A layer of voxels displaces them by shear times its height: their finest noise is longer, or
 * layers would show as a lattice of dashes. */
static float get_fibre_stretch(const np_cloud_model *model) {
  const np_kind_noises *k = &model->noises;
  const float finest_m = k->fine_m / (float)(1u << (k->fine_octaves - 1));
  return np_maxf(get_stretch(&model->desc), fibre_layers * model->noises.shear * (float)model->desc.voxel_m / finest_m);
}

/* Level of the heads, at layers that supply moisture: shares of the thickness below its top. */
static void compute_roof(const np_cloud_model *model, np_kind_points *p, float *out_drop) {
  static const np_noise_octaves octaves = {.count = 2, .gain = 0.5f};
  const float size_m = roof_size * (float)model->desc.billow_m;
  const np_noise_lattice lattice = np_kind_wrap(model, &model->noises.medium, size_m, 2.0f);
  const np_noise_points points = np_kind_scale(model, p, size_m, 2.0f);
  for (size_t i = 0; i < p->count; i++) p->sz[i] = 0.29f + 0.2f * model->turnover;
  model->noise->value_fbm(&lattice, &octaves, &points, out_drop);
  for (size_t i = 0; i < p->count; i++)
    out_drop[i] = roof_drop * np_clampf(0.5f + 1.8f * (out_drop[i] - 0.5f), 0.0f, 1.0f);
}

/* Ice between fibres, at a position of the picture: fibres alone do not close a sky. */
static float get_veil(const np_cloud_model *model, float x_m, float y_m) {
  const float *shares = model->map.planes[NEPH_CLOUD_MAP_COVERAGE];
  const float cover = shares ? np_weather_map_sample(&model->map, shares, x_m, y_m) : (float)model->map.coverage;
  return veil * np_smoothstepf((cover - veil_from) / (1.0f - veil_from));
}

static void eval_streaks(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_kind_points p;
  if (!np_kind_points_collect(model, points, &p)) return;
  const neph_cloud_desc *desc = &model->desc;
  const np_kind_noises *k = &model->noises;
  const np_noise_octaves two = {.count = 2, .gain = 0.45f}, all = {.count = k->fine_octaves, .gain = 0.6f};
  const float billow_m = (float)desc->billow_m, top_m = (float)desc->thickness_m;
  float fall[NP_CLOUD_BLOCK], fibre[NP_CLOUD_BLOCK], drop[NP_CLOUD_BLOCK];
  compute_roof(model, &p, drop);
  np_noise_points at = np_kind_scale(model, &p, fall_size * billow_m, get_stretch(desc));
  for (size_t i = 0; i < p.count; i++) p.sz[i] = 0.37f + 0.2f * model->turnover;
  np_noise_lattice lattice = np_kind_wrap(model, &k->coarse, fall_size * billow_m, get_stretch(desc));
  model->noise->value_fbm(&lattice, &two, &at, fall);
  const float stretch = get_fibre_stretch(model);
  at = np_kind_scale(model, &p, k->fine_m, stretch);
  for (size_t i = 0; i < p.count; i++) p.sz[i] *= fibre_upright;
  lattice = np_kind_wrap(model, &k->fine, k->fine_m, stretch);
  model->noise->value_fbm(&lattice, &all, &at, fibre);
  at = np_kind_scale(model, &p, billow_m, get_stretch(desc));
  for (size_t i = 0; i < p.count; i++) p.sz[i] *= fibre_upright;
  lattice = np_kind_wrap(model, &k->medium, billow_m, get_stretch(desc));
  model->noise->value_fbm(&lattice, &two, &at, p.noise);
  for (size_t i = 0; i < p.count; i++) {
    const float group = np_smoothstepf(p.strength[i] / group_strength), s = p.height_m[i] / top_m + drop[i];
    const float fallen = np_clampf((1.0f - head_share - s) / (1.0f - head_share), 0.0f, 1.0f);
    const float depth = np_clampf(1.2f * fall[i] - 0.1f, 0.05f, 1.0f);
    const float tail = 1.0f - np_smoothstepf(fallen / depth);
    const float roof = 1.0f - np_smoothstepf((s - 1.0f + head_share) / head_share);
    const float frayed =
        p.noise[i] + (float)desc->erosion * (fibre[i] - 0.5f) - np_mixf(0.75f, 0.36f, group) - 0.14f * fallen;
    const float ice = np_smoothstepf(frayed / (0.12f + 0.3f * (float)desc->softness));
    const float body =
        np_mixf(get_veil(model, points->x_m[p.index[i]], points->y_m[p.index[i]]), 1.0f, ice) * tail * roof;
    const float share = body * np_mixf(1.0f, 0.3f, fallen) * group;
    if (share > extinction_floor) out_extinction_per_m[p.index[i]] = (float)desc->extinction_per_m * share;
  }
}

static bool is_streak_empty(const np_cloud_model *model, const np_cloud_box *box) {
  np_kind_box bounded;
  return !np_kind_box_make(model, box, &bounded); /* there may be streaks wherever the map is positive */
}

const np_cloud_kind np_streaks_kind = {
    .name = "streaks",
    .landscape = {.form = NP_LANDSCAPE_SHEET, .swirl_size = 1.3f},
    .more_cover = NP_GAPS_STAY_CLEAR,
    .less_cover = NP_CLOUDS_COVER_NO_LESS,
    .skew = NP_CLOUD_SKEW_HOOKED,
    .billow_grains = 7,
    .census_passes = 4,
    .prepare = prepare_streaks,
    .search_waterline = np_waterline_search,
    .eval = eval_streaks,
    .is_empty = is_streak_empty,
};
