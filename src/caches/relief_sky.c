/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/relief_sky.h"

#include <stdlib.h>

#include "atmosphere/atmosphere_private.h"

enum { RINGS = NP_RELIEF_RINGS, AZIMUTHS = NP_RELIEF_SKY_AZIMUTHS, SAMPLES = 3 /* places on a patch */ };

/* Times the median of a ring of the sky beyond which its light belongs to the glow. */
static const float glow_least = 2.0f;

/* Distances between which the first order is measured: from 50 m, each 1.6 times the one before. */
enum { CELLS = 18 };
static const double first_cell_m = 50.0, cell_ratio = 1.6;

/* ---- Samples ---- */

typedef struct sky_samples {
  np_spectrum at[RINGS][AZIMUTHS][SAMPLES];
} sky_samples;

np_vec3 np_relief_make_direction(float sine, float azimuth) {
  const float cosine = sqrtf(fmaxf(0.0f, 1.0f - sine * sine));
  return np_vec3_make(cosine * cosf(azimuth), cosine * sinf(azimuth), sine);
}

static float get_height(int ring) { return np_relief_ring_edges[ring + 1] - np_relief_ring_edges[ring]; }

static np_vec3 get_direction(int ring, int k, int sample) {
  return np_relief_make_direction(np_relief_ring_edges[ring] + get_height(ring) * ((float)sample + 0.5f) / SAMPLES,
                                  ((float)k + 0.5f) * (2.0f * NP_PI_F / AZIMUTHS));
}

static float get_solid_angle(int ring) { return get_height(ring) * (2.0f * NP_PI_F / (AZIMUTHS * SAMPLES)); }

static const neph_sky *get_tables(const np_world *world) {
  return world->cloud_sky ? world->cloud_sky : world->camera_sky;
}

static np_spectrum trace_sky(const np_world *world, np_dvec3 origin, np_vec3 towards) {
  const neph_sky *sky = get_tables(world);
  const np_spectrum air = sky ? np_sky_trace_air(sky, origin, towards, INFINITY).inscatter : np_spectrum_grey(0.0f);
  return np_world_add_beyond(world, origin, towards, air);
}

/* Traces all samples; 1 over their irradiance on level ground. */
static np_spectrum trace_samples(const np_world *world, np_dvec3 origin, sky_samples *out) {
  np_spectrum level = np_spectrum_grey(0.0f), per = level;
  for (int ring = 0; ring < RINGS; ring++)
    for (int k = 0; k < AZIMUTHS; k++)
      for (int s = 0; s < SAMPLES; s++) {
        const np_vec3 towards = get_direction(ring, k, s);
        out->at[ring][k][s] = trace_sky(world, origin, towards);
        level = np_spectrum_add_scaled(level, towards.z * get_solid_angle(ring), out->at[ring][k][s]);
      }
  for (int b = 0; b < NP_BAND_COUNT; b++) per.band[b] = level.band[b] > 0.0f ? 1.0f / level.band[b] : 0.0f;
  return per;
}

/* ---- Where the air scatters sunlight first ---- */

/* No light from a hemisphere: the parts that hold what becomes of it are not read. */
static const np_hemisphere_shares no_shares;

/* Distances of equal parts of the first order, which is known up to the ends of cells. */
static void place_parts(const double ends_m[CELLS], const np_air_parts parts[CELLS], double out_m[NP_RELIEF_PARTS]) {
  const float step = np_spectrum_mean(parts[CELLS - 1].first) / NP_RELIEF_PARTS;
  int k = 0;
  for (int part = 0; part < NP_RELIEF_PARTS; part++) {
    const float wanted = ((float)part + 0.5f) * step;
    while (k < CELLS - 1 && np_spectrum_mean(parts[k].first) < wanted) k++;
    const double begin_m = k > 0 ? ends_m[k - 1] : 0.0;
    const float before = k > 0 ? np_spectrum_mean(parts[k - 1].first) : 0.0f,
                inside = np_spectrum_mean(parts[k].first) - before;
    const float place = inside > 0.0f ? np_clampf((wanted - before) / inside, 0.0f, 1.0f) : 0.5f;
    out_m[part] = begin_m + (double)place * (ends_m[k] - begin_m);
  }
}

static np_relief_air measure_air(const np_world *world, np_dvec3 origin, np_vec3 towards) {
  np_relief_air out = {.share = np_spectrum_grey(0.0f)};
  const neph_sky *sky = get_tables(world);
  if (!sky) return out;
  double ends_m[CELLS];
  np_air_parts parts[CELLS];
  for (int k = 0; k < CELLS; k++) ends_m[k] = first_cell_m * pow(cell_ratio, k);
  np_sky_trace_parts(sky, origin, towards, ends_m, CELLS, &no_shares, parts);
  const np_spectrum all = np_sky_trace_air(sky, origin, towards, INFINITY).inscatter, first = parts[CELLS - 1].first;
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out.share.band[b] =
        all.band[b] > 0.0f ? np_mixf(np_higher_lost, 1.0f, np_clampf(first.band[b] / all.band[b], 0.0f, 1.0f)) : 0.0f;
  place_parts(ends_m, parts, out.distance_m);
  return out;
}

np_spectrum np_relief_air_shade(const np_relief_air *air, const np_world *world, np_dvec3 origin, np_vec3 towards,
                                int count, np_random *random) {
  int hidden = 0;
  if (np_spectrum_is_zero(air->share)) return air->share;
  for (int i = 0; i < count; i++) {
    const int part = (int)(((float)i + np_random_float(random)) * NP_RELIEF_PARTS / (float)count);
    const double place_m = air->distance_m[part < NP_RELIEF_PARTS ? part : NP_RELIEF_PARTS - 1];
    hidden += np_world_is_sun_hidden(world, np_dvec3_along(origin, towards, place_m), world->to_sun);
  }
  return np_spectrum_scale(air->share, (float)hidden / (float)count);
}

/* Places in the air before ground from which the sun may be hidden. */
enum { GROUND_PLACES = 2 };

bool np_relief_trace_air(const np_world *world, np_dvec3 origin, np_vec3 direction, double distance_m,
                         np_random *random, np_air_parts *out) {
  const neph_sky *sky = get_tables(world);
  if (!sky) return false;
  np_sky_trace_parts(sky, origin, direction, &distance_m, 1, &no_shares, out);
  int hidden = 0;
  for (int i = 0; i < GROUND_PLACES; i++) {
    const double place_m = distance_m * (i + np_random_double(random)) / GROUND_PLACES;
    hidden += np_world_is_sun_hidden(world, np_dvec3_along(origin, direction, place_m), world->to_sun);
  }
  const np_spectrum lost = np_spectrum_mix(out->first, out->all, np_higher_lost);
  out->all = np_spectrum_add_scaled(out->all, -(float)hidden / GROUND_PLACES, lost);
  return true;
}

/* ---- The glow ---- */

static int compare_floats(const void *a, const void *b) {
  const float x = *(const float *)a, y = *(const float *)b;
  return (x > y) - (x < y);
}

static np_spectrum find_cap(const sky_samples *sky, int ring, int sample) {
  np_spectrum out;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    float values[AZIMUTHS];
    for (int k = 0; k < AZIMUTHS; k++) values[k] = sky->at[ring][k][sample].band[b];
    qsort(values, AZIMUTHS, sizeof *values, compare_floats);
    out.band[b] = glow_least * values[AZIMUTHS / 2];
  }
  return out;
}

/* Takes the glow out of the samples. */
static void split_glow(sky_samples *sky, sky_samples *out_glow) {
  for (int ring = 0; ring < RINGS; ring++)
    for (int s = 0; s < SAMPLES; s++) {
      const np_spectrum cap = find_cap(sky, ring, s);
      for (int k = 0; k < AZIMUTHS; k++)
        for (int b = 0; b < NP_BAND_COUNT; b++) {
          float *light = &sky->at[ring][k][s].band[b];
          out_glow->at[ring][k][s].band[b] = fmaxf(0.0f, *light - cap.band[b]);
          *light = fminf(*light, cap.band[b]);
        }
    }
}

/* Chooses the glow's directions, each with an equal part of its light. */
static void place_glow(const sky_samples *glow, np_spectrum per, np_relief_sky *out) {
  np_spectrum all = np_spectrum_grey(0.0f);
  for (int ring = 0; ring < RINGS; ring++)
    for (int k = 0; k < AZIMUTHS; k++)
      for (int s = 0; s < SAMPLES; s++) all = np_spectrum_add_scaled(all, get_solid_angle(ring), glow->at[ring][k][s]);
  const float step = np_spectrum_mean(all) / NP_RELIEF_GLOW;
  float passed = 0.0f;
  int placed = 0;
  for (int ring = 0; ring < RINGS; ring++)
    for (int k = 0; k < AZIMUTHS; k++)
      for (int s = 0; s < SAMPLES; s++) {
        passed += get_solid_angle(ring) * np_spectrum_mean(glow->at[ring][k][s]);
        for (; placed < NP_RELIEF_GLOW && passed > ((float)placed + 0.5f) * step; placed++)
          out->glow[placed].towards = get_direction(ring, k, s);
      }
  const bool has_glow = placed == NP_RELIEF_GLOW;
  out->glow_share =
      has_glow ? np_spectrum_scale(np_spectrum_multiply(all, per), 1.0f / NP_RELIEF_GLOW) : np_spectrum_grey(0.0f);
}

np_glow_cosines np_relief_sky_aim(const np_relief_sky *sky, np_vec3 normal) {
  np_glow_cosines out;
  for (int i = 0; i < NP_RELIEF_GLOW; i++) out.to[i] = fmaxf(0.0f, np_vec3_dot(normal, sky->glow[i].towards));
  return out;
}

np_spectrum np_relief_sky_compute_glow(const np_relief_sky *sky, const np_glow_cosines *cosines,
                                       const np_spectrum left[NP_RELIEF_GLOW]) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int i = 0; i < NP_RELIEF_GLOW; i++) sum = np_spectrum_add_scaled(sum, cosines->to[i], left[i]);
  return np_spectrum_multiply(sky->glow_share, sum);
}

/* ---- All of the sky ---- */

void np_relief_sky_build(const np_world *world, np_dvec3 origin, np_relief_sky *out) {
  sky_samples samples, glow;
  *out = (np_relief_sky){.glow_share = np_spectrum_grey(0.0f)};
  const np_spectrum per = trace_samples(world, origin, &samples);
  split_glow(&samples, &glow);
  place_glow(&glow, per, out);
  for (int i = 0; i < NP_RELIEF_GLOW && !np_spectrum_is_zero(out->glow_share); i++)
    out->glow[i].air = measure_air(world, origin, out->glow[i].towards);
  for (int ring = 0; ring < RINGS; ring++)
    for (int k = 0; k < AZIMUTHS; k++) {
      np_relief_patch *patch = &out->patch[ring][k];
      patch->air = measure_air(world, origin, get_direction(ring, k, SAMPLES / 2));
      for (int s = 0; s < SAMPLES; s++) {
        const np_vec3 towards = get_direction(ring, k, s);
        const np_spectrum light = np_spectrum_multiply(samples.at[ring][k][s], per);
        patch->radiance = np_spectrum_add_scaled(patch->radiance, 1.0f / SAMPLES, light);
        np_relief_add_light(towards, np_spectrum_scale(light, get_solid_angle(ring)), &out->clear);
        np_relief_add_share(towards, get_solid_angle(ring) / NP_PI_F, out->even);
      }
    }
}

const np_relief_patch *np_relief_sky_get(const np_relief_sky *sky, int ring, float azimuth) {
  const float turn = azimuth * (0.5f / NP_PI_F);
  const int k = (int)((turn - floorf(turn)) * AZIMUTHS);
  return &sky->patch[ring][k < AZIMUTHS ? k : AZIMUTHS - 1];
}
