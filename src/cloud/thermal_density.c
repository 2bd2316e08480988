/* SPDX-License-Identifier: Apache-2.0 */
/* Density of a cumulus of thermals, from the distance to its balls.
 *
 * Positions are displaced by divergence-free noise, then the distance is displaced: by billows of Worley noise, the
 * fine ones where the cloud is young, and by fBm where it is old. Extinction rises from the surface inwards over an
 * edge, crisp or soft by age, or over wisps, in which noise and depth select shreds. In the core it follows an
 * adiabatic parcel: liquid water grows with the height above the base, the number of droplets does not, so that
 * extinction is ∝ height^⅔ (Pruppacher and Klett 1997, "Microphysics of Clouds and Precipitation", ch. 2), from a step
 * at the condensation level on. Entrained air thins an old cloud. Noise raises the base by less than a layer of voxels:
 * bases have an edge.
 *
 * Age and depth inside are taken at the undisplaced position; only the remaining distance near the surface is
 * displaced. So a value does not depend on the other points of the evaluation. */
#include "cloud/thermal_density.h"

#include <math.h>
#include <string.h>

#include "cloud/cloud_column.h"
#include "cloud/cloud_streams.h"
#include "cloud/repeat.h"
#include "cloud/thermal_slope.h"
#include "core/math.h"

static const float warp_sizes[NP_THERMAL_WARPS] = {0.57f, 0.23f, 0.09f};    /* in largest billows */
static const float warp_reach[NP_THERMAL_WARPS] = {0.085f, 0.055f, 0.018f}; /* rms displacement, at full turbulence */
static const float warp_limit = 2.0f; /* limit of a component, relative to its rms */
static const float detail_size = 0.42f,
                   detail_ratio = 0.46f; /* size of the first octave in largest billows, and size ratio of octaves */
static const float detail_reach = 0.5f;  /* amplitude of an octave at erosion 1, in units of its size */
static const float crease_reach = 0.95f; /* amplitude of the first octave */
static const float detail_mean = 0.33f;  /* mean of Worley noise */
static const float fray_size = 0.24f, fray_reach = 0.5f, fray_outwards = 0.10f, fray_inwards = 0.6f,
                   fray_offset = 0.06f, fray_gain = 0.65f;
static const float fray_stretch = 1.5f,
                   fray_shear = 0.35f; /* stretch of the noise along the wind, and its shear with height */
static const float wisp_depth = 0.42f,
                   wisp_outwards =
                       0.45f; /* depth in largest billows at a wispiness of 1, and its share outside the surface */
static const float wisp_bite = 16.0f;     /* contrast of the noise, and its weight relative to depth */
static const float wisp_thinness = 0.80f; /* relative loss of extinction at the outer end of wisps */
static const float torn_share = 0.35f, torn_broad = 2.4f, torn_fine = 0.9f,
                   strand_twist = 1.5f; /* weights and frequencies of the noises of wisps */
enum { FINENESS_MAX = 3 };              /* octaves of wisps: frequencies are at most 8 */
static const float wisp_base_max_m = 300.0f,
                   rain_wisps = 0.8f; /* limit of depth at the base; increase of its wisps by precipitation */
static const float crisp_edge = 0.016f, soft_edge = 0.055f; /* in largest billows */
static const float floor_share = 0.05f, floor_max_m = 40.0f, floor_voxels = 0.2f,
                   floor_size = 0.6f;  /* roughness of the base: as much as keeps it between two layers of samples */
static const float floor_wisps = 8.0f; /* wisps at the base are shorter than those of flanks by this factor */
static const float adiabatic_share = 0.4f; /* height of the core's extinction, relative to the thickness */
static const float adiabatic_max = 1.25f;  /* limit of the increase */
static const float adiabatic_min = 0.06f, condensed_max_m = 30.0f; /* step at the base; its limit as a height */
static const float entrained = 0.55f;                              /* relative loss of the oldest cloud */
static const double billow_voxels = 4;
static const double billow_share = 0.18;      /* relative to the shorter side of a field */
static const float extinction_floor = 0.002f; /* relative to the core's extinction: less counts as 0 */

/* Size of the largest billows: small enough for a cloud to end before the border of its field, and large enough for
 * voxels to resolve. */
static float compute_billow_m(const neph_cloud_desc *desc) {
  return (float)fmin(fmax(desc->billow_m, billow_voxels * desc->voxel_m),
                     billow_share * fmin(desc->extent_m[0], desc->extent_m[1]));
}

static void set_detail(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  float size_m = detail_size * model->thermals.billow_m, sum_m = 0.0f;
  model->detail_count = 0;
  for (unsigned k = 0; k < NP_CLOUD_OCTAVES_MAX && size_m >= 2.0f * (float)desc->voxel_m; k++, size_m *= detail_ratio) {
    model->detail[k].lattice = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_DETAIL + k);
    model->detail[k].frequency_per_m = 1.0f / np_repeat_fit(desc, size_m);
    np_repeat_set_period(desc, size_m, 1.0f, &model->detail[k].lattice);
    model->detail[k].amplitude = (k ? detail_reach : crease_reach) * (float)desc->erosion * size_m;
    sum_m += model->detail[k].amplitude;
    model->detail_count = k + 1;
  }
  model->thermals.gain_max_m = sum_m * detail_mean;
  model->thermals.loss_max_m = sum_m * (1.0f - detail_mean);
}

float np_thermals_count_octaves(double frequency) {
  float octaves = 0.0f;
  for (; frequency >= 2; frequency *= 0.5) octaves += 1.0f;
  return octaves + (float)frequency - 1.0f;
}

/* Sets the wisps. Rain adds some at the base; none are finer than two voxels. */
static void set_wisps(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  np_thermal_noises *t = &model->thermals;
  float shares[NEPH_CLOUD_PARTS];
  for (int p = 0; p < NEPH_CLOUD_PARTS; p++) shares[p] = (float)fmin(desc->wispiness * desc->wisp_amounts[p], 1);
  shares[2] += (1.0f - shares[2]) * rain_wisps * (float)desc->precipitation;
  for (int p = 0; p < NEPH_CLOUD_PARTS; p++) t->wisp_m[p] = wisp_depth * t->billow_m * shares[p];
  t->wisp_m[2] = np_minf(t->wisp_m[2], wisp_base_max_m * shares[2]);
  t->wisp_max_m = np_maxf(np_maxf(t->wisp_m[0], t->wisp_m[1]), t->wisp_m[2]);
  for (int p = 0; p < NEPH_CLOUD_PARTS; p++)
    t->wisp_fineness[p] = np_minf(np_thermals_count_octaves(desc->wisp_frequencies[p]), (float)(t->wisp_octaves - 1));
}

static float compute_warp_max_m(float warp_m) { return 1.7321f * warp_limit * warp_m * 1.001f; }

void np_thermals_prepare(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  const float billow_m = compute_billow_m(desc), voxel_m = (float)desc->voxel_m;
  np_thermal_noises *t = &model->thermals;
  *t = (np_thermal_noises){.billow_m = billow_m,
                           .floor = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_FLOOR),
                           .wisps = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_WISPS),
                           .wisp_size_m = fray_size * billow_m,
                           .fray_m = fray_reach * billow_m * (0.3f + 1.3f * (float)desc->erosion)};
  set_detail(model);
  for (unsigned k = 0; k < NP_THERMAL_WARPS; k++) {
    t->warp[k] = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_WARP + k);
    t->warp_size_m[k] = np_repeat_fit(desc, warp_sizes[k] * billow_m);
    np_repeat_set_period(desc, t->warp_size_m[k], 1.0f, &t->warp[k]);
    t->warp_m[k] = warp_reach[k] * billow_m * (float)desc->turbulence;
    t->warp_max_m += compute_warp_max_m(t->warp_m[k]);
  }
  t->wisp_size_m = np_repeat_fit(desc, t->wisp_size_m);
  np_repeat_set_period(desc, t->wisp_size_m, fray_stretch, &t->wisps);
  t->floor_size_m = np_repeat_fit(desc, floor_size * billow_m);
  np_repeat_set_period(desc, t->floor_size_m, 1.0f, &t->floor);
  t->wisp_octaves = 1;
  for (float size_m = 0.5f * t->wisp_size_m; size_m >= 2.0f * voxel_m && t->wisp_octaves < 5; size_m *= 0.5f)
    t->wisp_octaves++;
  set_wisps(model);
  t->floor_m =
      np_minf(floor_share * (float)desc->thickness_m, np_minf(floor_max_m, floor_voxels * (float)desc->voxel_m));
  const float softness = (float)desc->softness;
  t->crisp_m = np_maxf(crisp_edge * billow_m, 0.75f * voxel_m) + 0.25f * softness * softness * billow_m;
  t->soft_m = np_maxf(soft_edge * billow_m, t->crisp_m);
  t->fray_gain_max_m = np_maxf(fray_outwards * t->fray_m - fray_offset * billow_m, 0.0f);
  t->fray_loss_max_m = fray_inwards * t->fray_m + fray_offset * billow_m;
  t->gain_max_m += t->fray_gain_max_m;
  t->loss_max_m += t->fray_loss_max_m;
  t->reach_max_m = t->gain_max_m + wisp_outwards * t->wisp_max_m;
}

/* ---- Points ---- */

/* Points that cheap bounds leave undecided: neither surely inside nor surely outside of cloud. Positions are in metres
 * from the field's centre. */
typedef struct thermal_work {
  size_t count;
  uint16_t index[NP_CLOUD_BLOCK];
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], z_m[NP_CLOUD_BLOCK];
  float above_m[NP_CLOUD_BLOCK];                          /* height above the base */
  float air_x_m[NP_CLOUD_BLOCK], air_y_m[NP_CLOUD_BLOCK]; /* origin of the air, before the wind displaced it */
  float distance_m[NP_CLOUD_BLOCK], age[NP_CLOUD_BLOCK];
  float reach_m[NP_CLOUD_BLOCK];    /* depth of wisps, from the surface inwards */
  float fineness[NP_CLOUD_BLOCK];   /* fineness of wisps, in octaves */
  float moved_m[3][NP_CLOUD_BLOCK]; /* displacement by the warps so far */
  float sx[NP_CLOUD_BLOCK], sy[NP_CLOUD_BLOCK], sz[NP_CLOUD_BLOCK], noise[NP_CLOUD_BLOCK]; /* scratch */
} thermal_work;

static void copy_point(thermal_work *w, size_t from, size_t to) {
  if (from == to) return;
  w->index[to] = w->index[from];
  w->x_m[to] = w->x_m[from];
  w->y_m[to] = w->y_m[from];
  w->z_m[to] = w->z_m[from];
  w->above_m[to] = w->above_m[from];
  w->air_x_m[to] = w->air_x_m[from];
  w->air_y_m[to] = w->air_y_m[from];
  w->distance_m[to] = w->distance_m[from];
  w->age[to] = w->age[from];
  w->reach_m[to] = w->reach_m[from];
  w->fineness[to] = w->fineness[from];
  for (int a = 0; a < 3; a++) w->moved_m[a][to] = w->moved_m[a][from];
  w->sx[to] = w->sx[from];
  w->sy[to] = w->sy[from];
  w->sz[to] = w->sz[from];
  w->noise[to] = w->noise[from];
}

/* Positions in the frame of the air, in units of a noise's size. */
static np_noise_points scale_positions(const np_cloud_model *model, thermal_work *w, float size_m) {
  const float frequency_per_m = 1.0f / size_m, rise_m = model->turnover * model->thermals.billow_m;
  for (size_t i = 0; i < w->count; i++) {
    w->sx[i] = w->air_x_m[i] * frequency_per_m;
    w->sy[i] = w->air_y_m[i] * frequency_per_m;
    w->sz[i] = (w->z_m[i] - rise_m) * frequency_per_m;
  }
  return (np_noise_points){w->count, w->sx, w->sy, w->sz};
}

/* Computes the height above the ragged base; drops points below it. */
static void raise_base(const np_cloud_model *model, thermal_work *w) {
  static const np_noise_octaves octaves = {.count = 4, .gain = 0.55f};
  const float floor_m = model->thermals.floor_m;
  size_t kept = 0;
  bool is_low = false;
  for (size_t i = 0; i < w->count; i++) is_low = is_low || w->above_m[i] < 8.0f * floor_m;
  if (!is_low) return;
  const np_noise_points points = scale_positions(model, w, model->thermals.floor_size_m);
  for (size_t i = 0; i < w->count; i++) w->sz[i] = 0.41f;
  model->noise->perlin_fbm(&model->thermals.floor, &octaves, &points, w->noise);
  for (size_t i = 0; i < w->count; i++) {
    const float raised = 1.0f + np_clampf(3.0f * w->noise[i], -1.0f, 1.0f);
    const float fading = 1.0f - np_clampf(w->above_m[i] / (8.0f * floor_m), 0.0f, 1.0f);
    w->above_m[i] -= floor_m * raised * fading;
    if (w->above_m[i] > 0.0f) copy_point(w, i, kept++);
  }
  w->count = kept;
}

/* Interpolates a value between tops, flanks and base. */
static float blend_parts(const float parts[NEPH_CLOUD_PARTS], float up, float low) {
  return np_mixf(np_mixf(parts[1], parts[0], up), parts[2], low);
}

/* Sets the depth of wisps: by the slope of the thermals, whose billows have tops of their own, and by the height. */
static void set_wisp_reach(const np_cloud_model *model, thermal_work *w) {
  const np_thermal_noises *t = &model->thermals;
  const np_ball_points points = {w->count, w->x_m, w->y_m, w->z_m};
  float normal_z[NP_CLOUD_BLOCK];
  const bool has_slope = w->count > 0 && (t->wisp_m[0] != t->wisp_m[1] || t->wisp_fineness[0] != t->wisp_fineness[1]);
  if (has_slope) np_thermals_eval_slope(model, &points, normal_z);
  for (size_t i = 0; i < w->count; i++) {
    const float low = 1.0f - np_smoothstepf((w->above_m[i] / t->billow_m - 0.06f) / 0.45f);
    const float up = has_slope ? np_smoothstepf((normal_z[i] - 0.1f) / 0.6f) : 0.0f;
    w->reach_m[i] = blend_parts(t->wisp_m, up, low);
    w->fineness[i] = blend_parts(t->wisp_fineness, up, low);
  }
}

/* ---- Extinction ---- */

/* x^⅔ for x in [0, 2]: the cube root of its square, by Newton's method from a parabola as initial value. */
static float compute_two_thirds(float x) {
  const float square = x * x;
  float root = 0.25f + 1.1f * square - 0.28f * square * square;
  if (square > 1.5f) root = 0.6f + 0.35f * square;
  for (int i = 0; i < 4; i++) root = (2.0f * root + square / (root * root)) * (1.0f / 3.0f);
  return root;
}

static float compute_edge(const np_cloud_model *model, float age) {
  return np_mixf(model->thermals.crisp_m, model->thermals.soft_m, age * age);
}

/* Depth below the surface and above the base, relative to edge and wisps: 1 beyond all wisps. */
static float compute_wisp_depth(const np_cloud_model *model, const thermal_work *w, size_t i, float loss_m) {
  const float reach_m = w->reach_m[i], depth_m = -w->distance_m[i] - loss_m + wisp_outwards * reach_m;
  const float edge_m = compute_edge(model, w->age[i]);
  return (reach_m > 0.0f ? np_minf(depth_m, floor_wisps * w->above_m[i]) : depth_m) / (edge_m + reach_m);
}

/* Factor on the core's extinction: an edge, widened by wisps and torn by noise in [0, 1]. */
static float compute_body(const np_cloud_model *model, const thermal_work *w, size_t i, float noise) {
  const float reach_m = w->reach_m[i], deep = compute_wisp_depth(model, w, i, 0.0f);
  const float edge_m = compute_edge(model, w->age[i]), share = reach_m / (edge_m + reach_m);
  const float bite = np_minf(wisp_bite * share, reach_m / edge_m); /* shreds are no crisper than the edge */
  const float torn = deep + bite * (deep - noise);
  const float thinness = wisp_thinness * share * (1.0f - np_clampf(deep, 0.0f, 1.0f));
  return np_smoothstepf(torn) * (1.0f - thinness) * (1.0f - entrained * w->age[i]);
}

static float compute_extinction(const np_cloud_model *model, const thermal_work *w, size_t i, float noise) {
  const neph_cloud_desc *desc = &model->desc;
  const float core_m = adiabatic_share * (float)desc->thickness_m;
  const float low = np_minf(adiabatic_min, condensed_max_m / core_m);
  const float height = np_clampf(w->above_m[i] / core_m, low, adiabatic_max);
  const float share = compute_body(model, w, i, noise) * compute_two_thirds(height);
  return share > extinction_floor ? (float)desc->extinction_per_m * share : 0.0f;
}

/* Decides points whose result cannot change: drops those that no gain can bring into the cloud, and writes the
 * extinction of those that no loss can reach. The surface may still move by gain, loss and warps: a displacement
 * changes the distance by at most its length. */
static void decide_points(const np_cloud_model *model, thermal_work *w, float gain_m, float loss_m, float warp_m,
                          float *out_extinction_per_m) {
  size_t kept = 0;
  for (size_t i = 0; i < w->count; i++) {
    const float x = w->moved_m[0][i], y = w->moved_m[1][i], z = w->moved_m[2][i];
    const float stray_m = warp_m + 1.001f * sqrtf(x * x + y * y + z * z);
    if (!(compute_wisp_depth(model, w, i, -(gain_m + stray_m)) > 0.0f)) continue;
    if (compute_wisp_depth(model, w, i, loss_m + stray_m) > 1.0f)
      out_extinction_per_m[w->index[i]] = compute_extinction(model, w, i, 0.0f);
    else
      copy_point(w, i, kept++);
  }
  w->count = kept;
}

/* ---- Displacement ---- */

static float clip_warp(float value) { return np_clampf(value, -warp_limit, warp_limit); }

/* Displaces positions by one noise after the other; decides points that no later noise can bring to the surface. */
static void displace(const np_cloud_model *model, thermal_work *w, float *out_extinction_per_m) {
  const np_thermal_noises *t = &model->thermals;
  float dx[NP_CLOUD_BLOCK], dy[NP_CLOUD_BLOCK], dz[NP_CLOUD_BLOCK], rest_m = t->warp_max_m;
  for (unsigned k = 0; k < NP_THERMAL_WARPS && w->count; k++) {
    const np_noise_points points = scale_positions(model, w, t->warp_size_m[k]);
    model->noise->curl(&t->warp[k], &points, dx, dy, dz);
    for (size_t i = 0; i < w->count; i++) {
      w->moved_m[0][i] += t->warp_m[k] * clip_warp(dx[i]);
      w->moved_m[1][i] += t->warp_m[k] * clip_warp(dy[i]);
      w->moved_m[2][i] += t->warp_m[k] * clip_warp(dz[i]);
    }
    rest_m -= compute_warp_max_m(t->warp_m[k]);
    decide_points(model, w, t->gain_max_m, t->loss_max_m, np_maxf(rest_m, 0.0f), out_extinction_per_m);
  }
  for (size_t i = 0; i < w->count; i++) {
    w->sx[i] = w->x_m[i] + w->moved_m[0][i];
    w->sy[i] = w->y_m[i] + w->moved_m[1][i];
    w->sz[i] = w->z_m[i] + w->moved_m[2][i];
    w->moved_m[0][i] = w->moved_m[1][i] = w->moved_m[2][i] = 0.0f;
  }
  const np_ball_points points = {w->count, w->sx, w->sy, w->sz};
  const np_ball_surface surface = {.distance_m = w->distance_m};
  (void)np_ball_heap_search(&model->balls, &points, t->reach_max_m, &surface);
}

/* ---- Detail ---- */

static void add_detail(const np_cloud_model *model, thermal_work *w) {
  for (unsigned k = 0; k < model->detail_count; k++) {
    const np_cloud_octave *octave = &model->detail[k];
    const np_noise_points points = scale_positions(model, w, 1.0f / octave->frequency_per_m);
    model->noise->worley(&octave->lattice, &points, w->noise);
    for (size_t i = 0; i < w->count; i++)
      w->distance_m[i] += (k ? 1.0f - w->age[i] : 1.0f) * octave->amplitude * (w->noise[i] - detail_mean);
  }
}

/* Noise that leans with the height and is stretched along the wind. */
static void sample_wisps(const np_cloud_model *model, thermal_work *w) {
  const np_thermal_noises *t = &model->thermals;
  const np_noise_octaves octaves = {.count = t->wisp_octaves, .gain = fray_gain};
  const np_noise_points points = scale_positions(model, w, t->wisp_size_m);
  const float *heading = model->heading, size_m = t->wisp_size_m;
  const float stretch = np_repeat_get_ratio(&model->desc, size_m * fray_stretch, size_m, fray_stretch);
  for (size_t i = 0; i < w->count; i++) {
    const float x = w->sx[i], y = w->sy[i], along = x * heading[0] + y * heading[1] - fray_shear * w->sz[i];
    w->sy[i] = y * heading[0] - x * heading[1];
    w->sx[i] = along / stretch;
  }
  model->noise->perlin_fbm(&t->wisps, &octaves, &points, w->noise);
}

/* Weight of wisps finer by `finer` octaves at a point: linear between integers. */
static float compute_fine_share(const thermal_work *w, size_t i, unsigned finer) {
  return np_maxf(1.0f - fabsf(w->fineness[i] - (float)finer), 0.0f);
}

static np_noise_octaves count_octaves(const np_thermal_noises *t, unsigned finer, float gain) {
  return (np_noise_octaves){.count = t->wisp_octaves > finer ? t->wisp_octaves - finer : 1, .gain = gain};
}

/* Adds the tearing by wisps finer by `finer` octaves, from 0 (strands) to 1. The broad noise, available for the
 * coarsest, twists the fine one, whose sheets lie at its zeros. */
static void add_tears(const np_cloud_model *model, thermal_work *w, unsigned finer, float *torn) {
  const np_thermal_noises *t = &model->thermals;
  const np_noise_octaves broad_octaves = count_octaves(t, finer, fray_gain);
  const np_noise_octaves fine_octaves = count_octaves(t, finer + 1, 0.6f);
  const float scale = (float)(1u << finer);
  float x[NP_CLOUD_BLOCK], y[NP_CLOUD_BLOCK], z[NP_CLOUD_BLOCK], broad[NP_CLOUD_BLOCK], fine[NP_CLOUD_BLOCK];
  const np_noise_points points = {w->count, x, y, z};
  for (size_t i = 0; i < w->count; i++) {
    x[i] = scale * w->sx[i];
    y[i] = scale * w->sy[i];
    z[i] = scale * w->sz[i];
    broad[i] = w->noise[i];
  }
  if (finer > 0) model->noise->perlin_fbm(&t->wisps, &broad_octaves, &points, broad);
  for (size_t i = 0; i < w->count; i++) {
    x[i] = 2.0f * x[i] + strand_twist * broad[i];
    y[i] = 2.0f * y[i] - strand_twist * broad[i];
    z[i] = 2.0f * z[i] + strand_twist * broad[i];
  }
  model->noise->perlin_fbm(&t->wisps, &fine_octaves, &points, fine);
  for (size_t i = 0; i < w->count; i++)
    torn[i] += compute_fine_share(w, i, finer) *
               np_clampf(torn_share + torn_broad * broad[i] + torn_fine * fabsf(fine[i]), 0.0f, 1.0f);
}

static void tear_wisps(const np_cloud_model *model, thermal_work *w, float *torn) {
  for (unsigned finer = 0; finer <= FINENESS_MAX; finer++) {
    bool is_any = false;
    for (size_t i = 0; i < w->count && !is_any; i++) is_any = compute_fine_share(w, i, finer) > 0.0f;
    if (is_any) add_tears(model, w, finer, torn);
  }
}

/* Adds fraying to old surfaces. */
static void add_fray(const np_cloud_model *model, thermal_work *w) {
  const np_thermal_noises *t = &model->thermals;
  for (size_t i = 0; i < w->count; i++)
    w->distance_m[i] +=
        w->age[i] * (t->fray_m * np_clampf(w->noise[i], -fray_outwards, fray_inwards) + fray_offset * t->billow_m);
}

static void set_air(const np_cloud_model *model, thermal_work *w) {
  float carried_m[2] = {0, 0};
  for (size_t i = 0; i < w->count; i++) {
    if (model->wind.has_winds) np_cloud_wind_carry(&model->wind, w->z_m[i], carried_m);
    w->air_x_m[i] = w->x_m[i] - model->drift_m[0] - carried_m[0];
    w->air_y_m[i] = w->y_m[i] - model->drift_m[1] - carried_m[1];
  }
}

/* Computes distance and age at the points, without noise; drops points that no noise brings near the cloud. False: all
 * are dropped. */
static bool search_surface(const np_cloud_model *model, thermal_work *w) {
  const np_ball_points points = {w->count, w->x_m, w->y_m, w->z_m};
  const np_ball_surface surface = {.distance_m = w->distance_m, .age = w->age};
  const float reach_m = model->thermals.reach_max_m + model->thermals.warp_max_m;
  size_t kept = 0;
  if (!np_ball_heap_search(&model->balls, &points, reach_m, &surface)) return false;
  for (size_t i = 0; i < w->count; i++) {
    w->reach_m[i] = model->thermals.wisp_max_m;
    w->fineness[i] = 0.0f;
    w->moved_m[0][i] = w->moved_m[1][i] = w->moved_m[2][i] = 0.0f;
    if (w->distance_m[i] < reach_m) copy_point(w, i, kept++);
  }
  w->count = kept;
  return kept > 0;
}

/* Evaluates points that are close to each other. */
static void eval_run(const np_cloud_model *model, thermal_work *w, float *out_extinction_per_m) {
  const np_thermal_noises *t = &model->thermals;
  const float gain_m = t->gain_max_m, loss_m = t->loss_max_m, warp_m = t->warp_max_m;
  float torn[NP_CLOUD_BLOCK];
  if (!search_surface(model, w)) return;
  raise_base(model, w);
  decide_points(model, w, gain_m, loss_m, warp_m, out_extinction_per_m);
  set_wisp_reach(model, w);
  decide_points(model, w, gain_m, loss_m, warp_m, out_extinction_per_m);
  if (warp_m > 0.0f && w->count) displace(model, w, out_extinction_per_m);
  decide_points(model, w, gain_m, loss_m, 0.0f, out_extinction_per_m);
  if (w->count == 0) return;
  add_detail(model, w);
  decide_points(model, w, t->fray_gain_max_m, t->fray_loss_max_m, 0.0f, out_extinction_per_m);
  sample_wisps(model, w);
  add_fray(model, w);
  decide_points(model, w, 0.0f, 0.0f, 0.0f, out_extinction_per_m);
  memset(torn, 0, w->count * sizeof *torn);
  if (t->wisp_max_m > 0.0f) tear_wisps(model, w, torn);
  for (size_t i = 0; i < w->count; i++) out_extinction_per_m[w->index[i]] = compute_extinction(model, w, i, torn[i]);
}

/* Base of a column; it differs between columns only with a picture. */
static float compute_base_m(const np_cloud_model *model, float x_m, float y_m) {
  if (!model->map.planes[NEPH_CLOUD_MAP_BASE]) return 0.0f;
  return np_cloud_column_compute(model, x_m, y_m, 0.0f).base_m;
}

void np_thermals_eval_run(const np_cloud_model *model, const np_cloud_points *points, const uint16_t *numbers,
                          size_t count, float *out_extinction_per_m) {
  thermal_work w;
  w.count = count;
  for (size_t i = 0; i < count; i++) {
    const uint16_t n = w.index[i] = numbers[i];
    w.x_m[i] = points->x_m[n];
    w.y_m[i] = points->y_m[n];
    w.z_m[i] = points->height_m[n];
    w.above_m[i] = w.z_m[i] - compute_base_m(model, w.x_m[i], w.y_m[i]);
  }
  set_air(model, &w);
  eval_run(model, &w, out_extinction_per_m);
}

bool np_thermals_is_empty(const np_cloud_model *model, const np_cloud_box *box) {
  if (box->max_m[2] <= 0.0f || box->min_m[2] >= (float)model->desc.thickness_m) return true;
  return !np_ball_heap_is_near(&model->balls, box->min_m, box->max_m,
                               model->thermals.reach_max_m + model->thermals.warp_max_m);
}
