/* SPDX-License-Identifier: Apache-2.0 */
/* Ice anvils on towers of thermals.
 *
 * Two faces bound the sheet, as shares of the thickness. The upper one rises from the rim to the centre, and into a
 * dome over the strongest towers (overshooting tops); the lower one flares down to the tower like a trumpet. So the
 * sheet thins to its rim, which has lobes and is frayed by fibres along the wind, bent by eddies; fibres part the ice
 * of its outer half into shreds. Both faces rise and sink by noise as long as the groups of mammatus, pouches that hang
 * from the lower face: hemispheres. */
#include "cloud/anvil.h"

#include <math.h>

#include "cloud/cloud_column.h"
#include "cloud/cloud_streams.h"
#include "cloud/kind_points.h"
#include "core/math.h"

static const float rim = 0.80f, rise = 0.055f,
                   rise_strength = 0.6f; /* upper face, and the strength at which it has risen */
static const float dome = 0.120f, dome_from = 0.15f,
                   dome_width = 0.7f; /* dome over towers from a strength on, and the width of its rise in strength */
static const float sheet = 0.13f, flare = 0.33f; /* lower face: rim − sheet·anvil − flare·anvil·tower² */
static const float roll = 0.9f, heave = 0.8f; /* variation of the sheet's depth and of the upper face's rise by noise */
static const float lobe_size = 1.1f, lobe_reach = 0.6f; /* sizes in billows, displacements in strength */
static const float fibre_size = 0.24f, fibre_stretch = 9.0f, fibre_reach = 0.22f;
static const float eddy_size = 2.3f, eddy_reach = 0.30f;     /* eddies that bend fibres */
static const float pouch_size = 0.34f, pouch_reach = 0.056f; /* depth as a share of the thickness */
static const float pouch_thickness = 1.2f; /* thickness of pouches relative to the centre: they carry most of the ice */
static const float group_size = 2.6f;      /* size of groups of pouches */
static const float rim_edge = 0.060f,
                   heart_edge = 0.025f; /* widths of both faces at the rim, where ice sublimes, and at the heart */
static const float shred_from = 0.1f, shred_reach = 0.7f,
                   shred_width = 0.55f; /* in strength: begin, amplitude and step of the shreds of the rim */
static const float ridge_size = 0.36f, ridge_reach = 0.045f,
                   streak = 1.7f; /* amplitude of fibres on both faces, and in the ice */
static const float thinness = 0.13f,
                   rim_thinness = 0.05f; /* extinction of ice relative to water, and of the rim relative to ice */
static const float rim_width = 1.15f;    /* range of strength over which ice thickens from the rim to the centre */
static const float layering =
    1.3f; /* anisotropy of noise, width over height: ice forms layers, visible from the side */
static const float extinction_floor = 0.002f;
static const float bound_margin = 1e-4f; /* margin for rounding */

/* `waves`, in [−1, 1], makes the sheet rise and sink, and thicker and thinner. */
static float eval_upper(float anvil, float tower, float waves) {
  return rim + rise * (1.0f + heave * waves) * np_smoothstepf(anvil / rise_strength) +
         dome * np_smoothstepf((tower - dome_from) / dome_width);
}

static float eval_lower(float anvil, float tower, float waves) {
  const float near = np_clampf(tower, 0.0f, 1.0f);
  return rim - (sheet * (1.0f + roll * waves) + flare * near * near) * anvil;
}

/* False only if there is no ice in a range of shares of the thickness, for columns of at most these strengths: both
 * raise the upper face, the anvil's lowers the other. */
static bool is_possible(float anvil_max, float tower_max, const np_interval *shares) {
  const float anvil = np_minf(anvil_max + 0.5f * (lobe_reach + fibre_reach), 1.5f);
  if (!(anvil > 0.0f)) return false;
  const float ridge = 0.5f * ridge_reach;
  return shares->low < eval_upper(anvil, tower_max, 1.0f) + ridge &&
         shares->high > eval_lower(anvil, tower_max, 1.0f) - pouch_reach - ridge;
}

/* Collects points of anvils. `strength` holds the anvil's strength, `ground_m` the tower's, `field_x_m` the share of
 * the height. */
static void collect(const np_cloud_model *model, const np_cloud_points *points, np_kind_points *p) {
  p->count = 0;
  for (size_t i = 0; i < points->count; i++) {
    const float height_m = points->height_m[i];
    if (!(height_m > 0.0f && height_m < (float)model->desc.thickness_m)) continue;
    const np_cloud_column column = np_cloud_column_compute(model, points->x_m[i], points->y_m[i], height_m);
    const float share = (height_m - column.base_m) / column.thickness_m;
    if (!is_possible(column.anvil, column.strength, &(np_interval){share, share})) continue;
    const size_t n = p->count++;
    p->index[n] = (uint16_t)i;
    p->x_m[n] = column.x_m - model->drift_m[0];
    p->y_m[n] = column.y_m - model->drift_m[1];
    p->height_m[n] = height_m;
    p->strength[n] = column.anvil;
    p->ground_m[n] = column.strength;
    p->field_x_m[n] = share;
  }
}

/* Value noise of the anvil, in [−0.5, 0.5]; stretched by `stretch` along the wind. */
static void fill_noise(const np_cloud_model *model, np_kind_points *p, np_cloud_stream stream, float size,
                       float stretch, float *out) {
  const neph_cloud_desc *desc = &model->desc;
  const float size_m = size * (float)desc->billow_m;
  const np_noise_octaves octaves = {.count = np_kind_count_octaves(desc, size_m), .gain = 0.55f};
  np_noise_lattice lattice = np_cloud_make_lattice(desc, stream);
  lattice = np_kind_wrap(model, &lattice, size_m, stretch);
  const np_noise_points points = np_kind_scale(model, p, size_m, stretch);
  for (size_t i = 0; i < p->count; i++) p->sz[i] *= layering;
  model->noise->value_fbm(&lattice, &octaves, &points, out);
  for (size_t i = 0; i < p->count; i++) out[i] = np_clampf(2.0f * (out[i] - 0.5f), -0.5f, 0.5f);
}

/* Adds lobes to the outline and bends fibres inside it: straight ones would end like the teeth of a comb. Fibres of the
 * faces, `out_ridges`, are straight: bent ones would look like marble from above. */
static void add_striations(const np_cloud_model *model, np_kind_points *p, float *lobes, float *out_ridges) {
  const float eddy_m = eddy_size * (float)model->desc.billow_m;
  float dx[NP_CLOUD_BLOCK], dy[NP_CLOUD_BLOCK];
  fill_noise(model, p, NP_CLOUD_STREAM_ANVIL_LOBES, lobe_size, 1.5f, lobes);
  fill_noise(model, p, NP_CLOUD_STREAM_SHEET, ridge_size, fibre_stretch, out_ridges);
  np_noise_lattice lattice = np_cloud_make_lattice(&model->desc, NP_CLOUD_STREAM_ANVIL_EDDIES);
  lattice = np_kind_wrap(model, &lattice, eddy_m, 1.0f);
  const np_noise_points points = np_kind_scale(model, p, eddy_m, 1.0f);
  for (size_t i = 0; i < p->count; i++) p->sz[i] = 0.53f - 0.3f * model->turnover;
  model->noise->swirl(&lattice, &points, dx, dy);
  for (size_t i = 0; i < p->count; i++) {
    p->x_m[i] += eddy_reach * eddy_m * (dx[i] * model->heading[0] - dy[i] * model->heading[1]);
    p->y_m[i] += eddy_reach * eddy_m * (dx[i] * model->heading[1] + dy[i] * model->heading[0]);
  }
  fill_noise(model, p, NP_CLOUD_STREAM_SHEET, fibre_size, fibre_stretch, p->noise);
  for (size_t i = 0; i < p->count; i++) {
    const float at_rim = 1.0f - np_smoothstepf((p->strength[i] - 0.1f) / 0.5f);
    p->strength[i] += at_rim * (lobe_reach * lobes[i] + fibre_reach * p->noise[i]);
  }
}

/* Depth of the pouches, in [0, 1]. */
static void compute_pouches(const np_cloud_model *model, np_kind_points *p, const float *groups, float *out) {
  const float size_m = pouch_size * (float)model->desc.billow_m;
  np_noise_lattice lattice = np_cloud_make_lattice(&model->desc, NP_CLOUD_STREAM_BASE);
  lattice = np_kind_wrap(model, &lattice, size_m, 1.0f);
  const np_noise_points points = np_kind_scale(model, p, size_m, 1.0f);
  for (size_t i = 0; i < p->count; i++) p->sz[i] = 0.41f - model->turnover;
  model->noise->worley(&lattice, &points, out);
  for (size_t i = 0; i < p->count; i++)
    out[i] = sqrtf(np_maxf(1.0f - 1.6f * out[i], 0.0f)) * np_smoothstepf(0.75f + 2.0f * groups[i]);
}

void np_anvil_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_kind_points p;
  if (!model->map.anvils) return;
  const float voxel = (float)(model->desc.voxel_m / model->desc.thickness_m);
  collect(model, points, &p);
  if (p.count == 0) return;
  float groups[NP_CLOUD_BLOCK], pouches[NP_CLOUD_BLOCK], lobes[NP_CLOUD_BLOCK], ridges[NP_CLOUD_BLOCK];
  fill_noise(model, &p, NP_CLOUD_STREAM_ANVIL_GROUPS, group_size, 1.0f, groups);
  compute_pouches(model, &p, groups, pouches);
  add_striations(model, &p, lobes, ridges);
  for (size_t i = 0; i < p.count; i++) {
    const float anvil = np_minf(p.strength[i], 1.5f), share = p.field_x_m[i];
    if (!(anvil > 0.0f)) continue;
    const float hanging = np_smoothstepf((anvil - 0.35f) / 0.25f) * (1.0f - np_smoothstepf((anvil - 0.7f) / 0.35f));
    const float waves = np_clampf(1.4f * groups[i] + 0.8f * lobes[i], -1.0f, 1.0f);
    const float ridge = ridge_reach * ridges[i];
    const float above = share - eval_lower(anvil, p.ground_m[i], waves) + pouch_reach * hanging * pouches[i] + ridge;
    const float below = eval_upper(anvil, p.ground_m[i], waves) - share + ridge;
    const float edge = np_maxf(np_mixf(rim_edge, heart_edge, np_smoothstepf(anvil / 0.8f)), 0.9f * voxel);
    const float fibres = p.noise[i] + 0.7f * ridges[i];
    const float shreds = np_smoothstepf((anvil - shred_from + shred_reach * fibres) / shred_width);
    const float ice = np_maxf(1.0f + streak * ridges[i], 0.0f), grown = np_smoothstepf(anvil / rim_width);
    const float body = np_smoothstepf(below / edge) * np_smoothstepf(above / edge) * thinness * ice * shreds *
                       np_maxf(np_mixf(rim_thinness, 1.0f, grown * grown),
                               pouch_thickness * hanging * np_smoothstepf(0.3f + 1.4f * pouches[i]));
    float *out = &out_extinction_per_m[p.index[i]];
    if (body > extinction_floor) *out = np_maxf(*out, (float)model->desc.extinction_per_m * body);
  }
}

bool np_anvil_is_empty(const np_cloud_model *model, const np_cloud_box *box) {
  const float top_m = (float)model->desc.thickness_m;
  if (!model->map.anvils || box->max_m[2] <= 0.0f || box->min_m[2] >= top_m) return true;
  const float low_m = fmaxf(box->min_m[2], 0.0f), high_m = fminf(box->max_m[2], top_m);
  const np_cloud_columns c = np_cloud_columns_make(model, box, low_m, high_m);
  np_interval shares;
  if (!np_cloud_columns_bound_shares(model, &c, low_m, high_m, &shares)) return true;
  const float anvil = np_cloud_columns_bound_anvil(model, &c), tower = np_cloud_columns_bound_strength(model, &c);
  shares.low -= bound_margin;
  shares.high += bound_margin;
  return !is_possible(anvil + bound_margin, tower + bound_margin, &shares);
}
