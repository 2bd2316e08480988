/* SPDX-License-Identifier: Apache-2.0 */
/* Decks of closed cells and rolls: stratocumulus.
 *
 * Cells of Worley noise, elongated along the wind by `stretch`, with smaller ones inside. A cell is thick in its
 * centre, where its top bulges, and thins to its rim, where its base rises. Rims that do not touch leave gaps, and thin
 * bright slits run between rolls. Billows of fine Worley noise cover tops and rims; bases are smooth. Liquid water
 * grows with the height above the base. */
#include <math.h>

#include "cloud/cloud_kinds.h"
#include "cloud/kind_points.h"
#include "cloud/waterline.h"
#include "cloud/repeat.h"
#include "core/math.h"

static const float cell_share = 0.55f;  /* size of the pattern's cells, in cells of the weather map */
static const float lobe_size = 0.37f;   /* size of the smaller cells, in cells of the pattern */
static const float lobe_share = 0.42f;  /* height of the smaller cells, relative to the cells */
static const float pattern_top = 1.0f;  /* depth of the pattern at a strength of 1 */
static const float rim_base = 0.42f;    /* rise of the base at a rim, relative to the thickness */
static const float billow_reach = 0.9f; /* amplitude of billows at billowiness 1, in units of their size */
static const float fray_reach = 0.55f;  /* amplitude of the finer billows at erosion 1, in units of their size */
static const float extinction_floor = 0.004f;
static const float slit_size = 0.8f, slit_stretch = 2.5f;  /* in cells; along the heading, times `stretch` */
static const float slit_width = 0.075f, slit_depth = 1.1f; /* in noise and in depth of the pattern */
static const float warp_size = 1.1f, warp_reach = 0.16f;   /* in cells of the pattern */

static float get_cell_m(const neph_cloud_desc *desc) { return cell_share * (float)desc->cell_m; }

static void prepare_deck(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  np_kind_noises *k = &model->noises;
  k->coarse = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_BASE);
  k->medium = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_SMALL_CELLS);
  k->fine = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_DETAIL);
  k->eddies = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_CURL);
  k->fine_m = np_maxf((float)desc->billow_m, 3.0f * (float)desc->voxel_m);
  k->fine_octaves = np_kind_count_octaves(desc, k->fine_m);
  k->edge_m =
      np_maxf((0.08f + (float)(desc->softness * desc->softness)) * (float)desc->billow_m, 1.2f * (float)desc->voxel_m);
}

/* Pattern of the cells: 0 in their centres. */
static void compute_pattern(const np_cloud_model *model, np_kind_points *p, float *out) {
  const neph_cloud_desc *desc = &model->desc;
  const np_kind_noises *k = &model->noises;
  const float cell_m = get_cell_m(desc), stretch = (float)desc->stretch, reach = warp_reach * (float)desc->turbulence;
  float dx[NP_CLOUD_BLOCK], dy[NP_CLOUD_BLOCK];
  np_noise_points points = np_kind_scale(model, p, warp_size * cell_m, 1.0f);
  for (size_t i = 0; i < p->count; i++) p->sz[i] = 0.31f + 0.3f * model->turnover;
  np_noise_lattice lattice = np_kind_wrap(model, &model->noises.eddies, warp_size * cell_m, 1.0f);
  model->noise->swirl(&lattice, &points, dx, dy);
  points = np_kind_scale(model, p, cell_m, stretch);
  for (size_t i = 0; i < p->count; i++) {
    p->sx[i] += reach * dx[i];
    p->sy[i] += reach * dy[i];
    p->sz[i] = 0.37f + 0.3f * model->turnover;
  }
  lattice = np_kind_wrap(model, &k->coarse, cell_m, stretch);
  model->noise->worley(&lattice, &points, out);
  const float lobe_m = lobe_size * cell_m;
  const float along = np_repeat_get_ratio(desc, lobe_m * stretch, cell_m * stretch, lobe_size);
  const float across = np_repeat_get_ratio(desc, lobe_m, cell_m, lobe_size);
  for (size_t i = 0; i < p->count; i++) {
    p->sx[i] /= along;
    p->sy[i] /= across;
    p->sz[i] = 0.61f + 0.5f * model->turnover;
  }
  lattice = np_kind_wrap(model, &k->medium, lobe_m, stretch);
  model->noise->worley(&lattice, &points, p->noise);
  for (size_t i = 0; i < p->count; i++) out[i] = out[i] + lobe_share * (p->noise[i] - 0.3f);
}

/* Cuts slits along the rolls, where a noise crosses its mean; their width varies with the cells. */
static void cut_slits(const np_cloud_model *model, np_kind_points *p, float *pattern) {
  static const np_noise_octaves octaves = {.count = 3, .gain = 0.45f};
  const neph_cloud_desc *desc = &model->desc;
  const float size_m = slit_size * get_cell_m(desc), stretch = slit_stretch * (float)desc->stretch;
  np_noise_lattice lattice = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_SHEET);
  lattice = np_kind_wrap(model, &lattice, size_m, stretch);
  const np_noise_points points = np_kind_scale(model, p, size_m, stretch);
  for (size_t i = 0; i < p->count; i++) p->sz[i] = 0.83f + 0.3f * model->turnover;
  model->noise->value_fbm(&lattice, &octaves, &points, p->noise);
  for (size_t i = 0; i < p->count; i++) {
    const float width = slit_width * np_clampf(0.25f + 1.8f * pattern[i], 0.05f, 1.6f);
    pattern[i] += slit_depth * (1.0f - np_smoothstepf(fabsf(p->noise[i] - 0.5f) / width));
  }
}

static void compute_billows(const np_cloud_model *model, np_kind_points *p, float *out_billow_m) {
  const neph_cloud_desc *desc = &model->desc;
  const np_kind_noises *k = &model->noises;
  const np_noise_octaves octaves = {.count = k->fine_octaves, .gain = 0.45f * (0.5f + (float)desc->erosion)};
  const float reach_m =
      (billow_reach * (float)desc->billowiness + fray_reach * (float)desc->erosion) * (float)desc->billow_m;
  const np_noise_points points = np_kind_scale(model, p, k->fine_m, 1.0f);
  const np_noise_lattice fine = np_kind_wrap(model, &k->fine, k->fine_m, 1.0f);
  model->noise->worley_fbm(&fine, &octaves, &points, out_billow_m);
  for (size_t i = 0; i < p->count; i++) out_billow_m[i] = reach_m * (1.0f - out_billow_m[i]);
}

static void eval_deck(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_kind_points p;
  if (!np_kind_points_collect(model, points, &p)) return;
  const neph_cloud_desc *desc = &model->desc;
  const float top_m = (float)desc->thickness_m;
  float pattern[NP_CLOUD_BLOCK], billow_m[NP_CLOUD_BLOCK];
  compute_pattern(model, &p, pattern);
  cut_slits(model, &p, pattern);
  compute_billows(model, &p, billow_m);
  for (size_t i = 0; i < p.count; i++) {
    const float full = np_clampf(pattern_top * 1.6f * p.strength[i] - pattern[i], 0.0f, 1.0f);
    const float bulge = full * (2.0f - full), high_m = top_m * np_mixf(0.35f, 1.0f, bulge);
    const float low_m = top_m * rim_base * (1.0f - bulge) * (1.0f - bulge);
    const float above_m = p.height_m[i] - low_m;
    const float up = np_smoothstepf(above_m / (0.45f * top_m)); /* billows are on tops */
    const float rim_m = full * 0.9f * get_cell_m(desc);
    const float depth_m =
        np_minf(np_minf(high_m - p.height_m[i], rim_m) - billow_m[i] * np_mixf(0.25f, 1.0f, up), above_m);
    const float share = np_smoothstepf(depth_m / model->noises.edge_m) * (0.35f + 0.75f * p.height_m[i] / top_m);
    if (share > extinction_floor) out_extinction_per_m[p.index[i]] = (float)desc->extinction_per_m * share;
  }
}

static bool is_deck_empty(const np_cloud_model *model, const np_cloud_box *box) {
  np_kind_box bounded;
  if (!np_kind_box_make(model, box, &bounded)) return true;
  const float full = np_clampf(1.6f * pattern_top * (bounded.strength.high + 1e-4f) + 0.3f * lobe_share, 0.0f, 1.0f);
  const float high_m = (float)model->desc.thickness_m * np_mixf(0.35f, 1.0f, full * (2.0f - full));
  return !(full > 0.0f) || bounded.box.min_m[2] - bounded.base_m.high > high_m + 0.01f;
}

const np_cloud_kind np_deck_kind = {
    .name = "deck",
    .landscape = {.form = NP_LANDSCAPE_SHEET, .swirl_size = 1.3f, .has_patterns = true},
    .more_cover = NP_EDGES_STAY_CLEAR,
    .less_cover = NP_CLOUDS_COVER_NO_LESS,
    .is_thin_at_border = true,
    .billow_grains = 7,
    .census_passes = 4,
    .prepare = prepare_deck,
    .search_waterline = np_waterline_search,
    .eval = eval_deck,
    .is_empty = is_deck_empty,
};
