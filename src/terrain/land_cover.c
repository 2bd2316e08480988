/* SPDX-License-Identifier: Apache-2.0 */
/* Albedos are of the order of those of the ASTER and USGS spectral libraries at 680, 550 and 440 nm; shares, lengths
 * and limits were adjusted by the look of rendered pictures. */
#include "terrain/land_cover.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/math.h"
#include "core/random.h"
#include "core/units.h"

enum { CLASSES_MAX = 9, CLIMATES = NEPH_GROUND_COVER_SAVANNA + 1 };

/* A class covers the `share` of the ground within its limits, in patches; or whole parcels of farmland. A limit of 0 is
 * none. */
typedef struct land_class {
  float albedo[3];
  float low_m, high_m;         /* elevations between which it lies */
  float gentle_deg, steep_deg; /* slopes between which it lies */
  float aspect_m;              /* elevation by which a wall to the north counts as higher */
  float share, patch_m;        /* patch_m 0: all of the ground there */
  float parcels[2];            /* range of the parcels' numbers, 0 to 1; 0: no parcels */
} land_class;

/* clang-format off */
static const land_class climates[CLIMATES][CLASSES_MAX] = {
    [NEPH_GROUND_COVER_TEMPERATE] = {
        {.albedo = {0.058f, 0.094f, 0.036f}},
        {.albedo = {0.115f, 0.125f, 0.060f}, .share = 0.35f, .patch_m = 900},
        {.albedo = {0.210f, 0.170f, 0.095f}, .high_m = 800, .steep_deg = 10, .parcels = {0.0f, 0.22f}},
        {.albedo = {0.120f, 0.092f, 0.062f}, .high_m = 800, .steep_deg = 10, .parcels = {0.22f, 0.36f}},
        {.albedo = {0.060f, 0.106f, 0.042f}, .high_m = 800, .steep_deg = 10, .parcels = {0.36f, 0.60f}},
        {.albedo = {0.026f, 0.043f, 0.018f}, .high_m = 1750, .steep_deg = 44, .aspect_m = 150, .share = 0.42f,
         .patch_m = 1300},
        {.albedo = {0.200f, 0.190f, 0.175f}, .low_m = 1600, .gentle_deg = 28, .share = 0.6f, .patch_m = 200},
        {.albedo = {0.160f, 0.150f, 0.135f}, .gentle_deg = 41},
        {.albedo = {0.820f, 0.850f, 0.880f}, .low_m = 2700, .steep_deg = 50, .aspect_m = 350, .share = 0.9f,
         .patch_m = 300}},
    [NEPH_GROUND_COVER_ALPINE] = {
        {.albedo = {0.070f, 0.095f, 0.040f}},
        {.albedo = {0.080f, 0.072f, 0.046f}, .share = 0.4f, .patch_m = 300},
        {.albedo = {0.024f, 0.038f, 0.018f}, .high_m = 1250, .steep_deg = 46, .aspect_m = 150, .share = 0.65f,
         .patch_m = 700},
        {.albedo = {0.215f, 0.205f, 0.190f}, .low_m = 1200, .gentle_deg = 24, .share = 0.65f, .patch_m = 160},
        {.albedo = {0.150f, 0.142f, 0.130f}, .low_m = 1500, .share = 0.45f, .patch_m = 250},
        {.albedo = {0.165f, 0.152f, 0.136f}, .gentle_deg = 37},
        {.albedo = {0.820f, 0.850f, 0.880f}, .low_m = 1700, .steep_deg = 50, .aspect_m = 400, .share = 0.9f,
         .patch_m = 350}},
    [NEPH_GROUND_COVER_DESERT] = {
        {.albedo = {0.360f, 0.270f, 0.170f}},
        {.albedo = {0.270f, 0.210f, 0.150f}, .share = 0.45f, .patch_m = 1200},
        {.albedo = {0.150f, 0.112f, 0.086f}, .share = 0.25f, .patch_m = 500},
        {.albedo = {0.420f, 0.360f, 0.280f}, .steep_deg = 6, .share = 0.12f, .patch_m = 260},
        {.albedo = {0.110f, 0.105f, 0.060f}, .steep_deg = 20, .share = 0.12f, .patch_m = 25},
        {.albedo = {0.240f, 0.165f, 0.115f}, .gentle_deg = 22},
        {.albedo = {0.190f, 0.130f, 0.095f}, .gentle_deg = 36, .share = 0.7f, .patch_m = 120}},
    [NEPH_GROUND_COVER_SAVANNA] = {
        {.albedo = {0.200f, 0.160f, 0.085f}},
        {.albedo = {0.090f, 0.110f, 0.045f}, .share = 0.35f, .patch_m = 1500},
        {.albedo = {0.220f, 0.130f, 0.075f}, .share = 0.15f, .patch_m = 400},
        {.albedo = {0.040f, 0.055f, 0.025f}, .steep_deg = 30, .share = 0.12f, .patch_m = 2200},
        {.albedo = {0.040f, 0.055f, 0.025f}, .steep_deg = 35, .share = 0.2f, .patch_m = 30},
        {.albedo = {0.150f, 0.125f, 0.105f}, .gentle_deg = 32}},
};
/* clang-format on */

/* Widths of the limits. */
static const float level_width_m = 160.0f, slope_width_deg = 6.0f, patch_width = 0.12f;

/* Displacement of limits by noise, per unit of it. */
static const float level_sway_m = 900.0f, slope_sway_deg = 30.0f, sway_m = 350.0f;

/* Noise of patches, and the reach of its sum with that of regions. */
static const np_noise_octaves patch_octaves = {.count = 5, .gain = 0.55f};
static const float noise_reach = 0.18f;

/* Regions have more or fewer patches: lengths of a region in patches, octaves, and weights of both noises. */
static const double region_length = 6.3;
static const np_noise_octaves region_octaves = {.count = 2, .gain = 0.5f};
static const float patch_weight = 0.7f, region_weight = 0.55f;

/* Grain: amplitude of an octave, the shortest, and their number. */
static const float grain_amplitude = 1.04f, grain_shortest_m = 1.0f;
enum { GRAIN_OCTAVES = 11 };

/* Parcels of farmland: size along and across the rows, and their turn. */
static const double parcel_m[2] = {260.0, 170.0}, parcel_turn[2] = {0.94, 0.342};
static const float parcels_end = 0.6f; /* numbers from here on are not tilled */

static float eval_noise(const np_noise_table *noise, const np_noise_octaves *octaves, const np_cover_place *place,
                        uint32_t seed, double length_m) {
  const np_noise_lattice lattice = {.seed = seed, .period = {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, 1}};
  const float x = (float)(place->east_m / length_m), y = (float)(place->north_m / length_m), z = 0.5f;
  float value;
  noise->perlin_fbm(&lattice, octaves, &(np_noise_points){1, &x, &y, &z}, &value);
  return value;
}

/* Share of noise of a length that a footprint resolves, from 0 at one to 1 at two footprints. */
static float compute_resolution(const np_cover_place *place, float length_m) {
  if (!(place->footprint_m > 0.0f)) return 1.0f;
  return np_clampf(length_m / place->footprint_m - 1.0f, 0.0f, 1.0f);
}

/* Place of a value of both noises in its distribution, 0 to 1. */
static float compute_rank(float value) { return np_smoothstepf(0.5f + 0.5f * value / noise_reach); }

static float eval_patches(const np_noise_table *noise, const np_cover_place *place, const land_class *c,
                          uint32_t seed) {
  if (!(c->patch_m > 0.0f)) return 1.0f;
  const float resolution = compute_resolution(place, c->patch_m);
  if (!(resolution > 0.0f)) return c->share;
  const float patches = eval_noise(noise, &patch_octaves, place, seed, (double)c->patch_m);
  const float regions = eval_noise(noise, &region_octaves, place, 50 + seed, region_length * (double)c->patch_m);
  const float rank = compute_rank(patch_weight * patches + region_weight * regions);
  const float patch = np_smoothstepf((rank - 1.0f + c->share) / patch_width + 0.5f);
  return np_mixf(c->share, patch, resolution);
}

/* Without resolution, the share of parcels among those that no class of later parcels covers. */
static float eval_parcels(const np_cover_place *place, const land_class *c) {
  const float share = (c->parcels[1] - c->parcels[0]) / (1.0f - parcels_end + c->parcels[1]);
  const float resolution = compute_resolution(place, (float)parcel_m[1]);
  if (!(resolution > 0.0f)) return share;
  const double along = parcel_turn[0] * place->east_m + parcel_turn[1] * place->north_m;
  const double across = parcel_turn[0] * place->north_m - parcel_turn[1] * place->east_m;
  const int64_t row = (int64_t)floor(across / parcel_m[1]);
  const uint64_t start = np_random_absorb(7, (uint64_t)row);
  const int64_t column = (int64_t)floor(along / parcel_m[0] + (double)(start >> 40) * 0x1p-24);
  const float number = (float)(np_random_absorb(start, (uint64_t)column) >> 40) * 0x1p-24f;
  return np_mixf(share, number >= c->parcels[0] && number < c->parcels[1], resolution);
}

/* Share inside of limits from `low` to `high`, of which 0 is none. */
static float eval_limits(float value, float low, float high, float width) {
  const float above = low > 0.0f ? np_smoothstepf((value - low) / width + 0.5f) : 1.0f;
  return above * (high > 0.0f ? np_smoothstepf((high - value) / width + 0.5f) : 1.0f);
}

/* Product over the octaves that the footprint resolves; its mean is 1. */
static float eval_grain(const np_noise_table *noise, const np_cover_place *place) {
  static const np_noise_octaves one = {.count = 1, .gain = 1.0f};
  float grain = 1.0f, length_m = grain_shortest_m;
  for (uint32_t k = 0; k < GRAIN_OCTAVES; k++, length_m *= 2.0f) {
    const float resolution = compute_resolution(place, length_m);
    if (resolution > 0.0f)
      grain *= 1.0f + grain_amplitude * resolution * eval_noise(noise, &one, place, 100 + k, (double)length_m);
  }
  return grain;
}

void np_land_cover_eval(neph_ground_cover climate, const np_noise_table *noise, const np_cover_place *place,
                        float out_albedo[3]) {
  assert((unsigned)climate < CLIMATES && climate != NEPH_GROUND_COVER_NONE);
  const land_class *classes = climates[climate];
  const float swayed = compute_resolution(place, sway_m);
  const float sway = swayed > 0.0f ? swayed * eval_noise(noise, &patch_octaves, place, 99, (double)sway_m) : 0.0f;
  const float slope_deg = place->slope_rad / (float)NP_DEGREE + slope_sway_deg * sway;
  memcpy(out_albedo, classes[0].albedo, sizeof classes[0].albedo);
  for (uint32_t i = 1; i < CLASSES_MAX && classes[i].albedo[0] > 0.0f; i++) {
    const land_class *c = &classes[i];
    const float level_m = place->elevation_m + level_sway_m * sway + c->aspect_m * place->north_face;
    float share = eval_limits(level_m, c->low_m, c->high_m, level_width_m) *
                  eval_limits(slope_deg, c->gentle_deg, c->steep_deg, slope_width_deg);
    if (!(share > 0.0f)) continue;
    share *= c->parcels[1] > 0.0f ? eval_parcels(place, c) : eval_patches(noise, place, c, i);
    for (int b = 0; b < 3; b++) out_albedo[b] = np_mixf(out_albedo[b], c->albedo[b], share);
  }
  const float excess = eval_grain(noise, place) - 1.0f;
  for (int b = 0; b < 3; b++) {
    const float albedo = out_albedo[b], contrast = 1.0f - albedo * albedo; /* snow has less than soil */
    out_albedo[b] = np_clampf(albedo * (1.0f + contrast * excess), 0.0f, 1.0f);
  }
}

float np_land_cover_get_roughness(neph_ground_cover climate) { return climate == NEPH_GROUND_COVER_NONE ? 0.0f : 0.5f; }
