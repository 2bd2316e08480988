/* SPDX-License-Identifier: Apache-2.0 */
/* Light on the ground under clouds, gathered from the solution of the multiple scattering (cloud_gather.h).
 *
 * With the directions of one cosine-weighted set, the same at every point, so that neighbours differ by what they see
 * alone. Smoke around a flame is bright in a small part of a dark sky, which such a set meets or misses: where there is
 * emission, two more are drawn, towards it and towards the clouds' box, and all are weighted by the balance heuristic
 * (Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering"). Hills between clouds
 * and ground are left out; a slope sees its share of everything.
 */
#include "caches/ground_light.h"

#include <string.h>

#include "core/alloc.h"
#include "core/units.h"

enum { DIRECTIONS = 96, TO_EMISSION = 48, TO_BOX = 64, POINTS_MAX = 40, STEPS_MAX = 192 };

/* Distance from the clouds, in heights of their tops, beyond which the sky is clear. */
static const double reach_heights = 3.0;

typedef struct ground_fill {
  const np_cloud_gather *gather;
  double step_m;
  np_ground_light *cache;
  np_cloud_direction *directions;
} ground_fill;

/* A direction of a cosine-weighted set of DIRECTIONS. */
static np_vec3 get_even_direction(unsigned i) {
  const double cosine = sqrt(1.0 - (i + 0.5) / DIRECTIONS), sine = sqrt(1.0 - cosine * cosine);
  const double azimuth = i * (NP_PI * (3.0 - sqrt(5.0)));
  return np_vec3_make((float)(sine * cos(azimuth)), (float)(sine * sin(azimuth)), (float)cosine);
}

/* Density per solid angle of the direction to a point of the clouds' box. */
static double compute_box_density(const np_cloud_gather *g, np_dvec3 position, np_vec3 towards) {
  const np_dvec3 size = np_dvec3_subtract(g->bounds_max, g->bounds_min);
  double begin, end;
  if (!np_cloud_gather_clip(g, position, towards, &begin, &end)) return 0.0;
  return (end * end * end - begin * begin * begin) / (3.0 * size.x * size.y * size.z);
}

/* MIS weight of the even set for light from one direction, among all sets that could have sampled it. */
static float weigh(const np_cloud_gather *g, np_dvec3 position, np_vec3 towards) {
  if (!g->world->emission) return 1.0f;
  const double even = (double)towards.z * (DIRECTIONS / NP_PI);
  const double to_emission = TO_EMISSION * (double)np_emission_direction_density(g->world->emission, position, towards);
  return (float)(even / (even + to_emission + TO_BOX * compute_box_density(g, position, towards)));
}

/* Offset of the i-th direction's steps. */
static double get_offset(unsigned i) { return fmod(0.5 + 0.6180339887498949 * i, 1.0); }

/* The i-th point of a set that fills the clouds' box evenly (Roberts 2018, "The Unreasonable Effectiveness of
 * Quasirandom Sequences"). */
static np_dvec3 get_box_point(const np_cloud_gather *g, unsigned i) {
  const np_dvec3 low = g->bounds_min, size = np_dvec3_subtract(g->bounds_max, low);
  return np_dvec3_make(low.x + size.x * fmod(0.5 + 0.8191725133961645 * i, 1.0),
                       low.y + size.y * fmod(0.5 + 0.6710436067037893 * i, 1.0),
                       low.z + size.z * fmod(0.5 + 0.5497004779019703 * i, 1.0));
}

/* Marches the i-th direction of a set. */
static float follow(const ground_fill *f, const np_cloud_direction *d, np_dvec3 position, unsigned i,
                    np_spectrum *out_light) {
  const np_cloud_steps steps = {f->step_m, get_offset(i), STEPS_MAX};
  return np_cloud_gather_follow(f->gather, d, position, &steps, out_light);
}

/* Adds light from the direction of a place. */
static void gather_from(const ground_fill *f, np_dvec3 position, np_dvec3 place, unsigned i, np_spectrum *sum) {
  const np_vec3 away = np_dvec3_to_float(np_dvec3_subtract(place, position));
  np_cloud_direction d;
  np_spectrum light;
  if (!(away.z > 0.0f)) return;
  np_cloud_gather_aim(f->gather, np_vec3_normalize(away), &d);
  (void)follow(f, &d, position, i, &light);
  *sum = np_spectrum_add_scaled(*sum, weigh(f->gather, position, d.towards), light);
}

/* Adds the light of the other sets to the even set's sum: their weight over their density equals that over the even
 * set's. */
static void gather_emitted(const ground_fill *f, np_dvec3 position, np_spectrum *sum) {
  const np_emission *emission = f->gather->world->emission;
  np_random random = np_random_start(0, 0, 0, 0, 0); /* the same at every point */
  for (unsigned i = 0; i < TO_EMISSION; i++) {
    np_dvec3 place;
    if (np_emission_draw(emission, (i + 0.5) / TO_EMISSION, &random, &place)) gather_from(f, position, place, i, sum);
  }
  for (unsigned i = 0; i < TO_BOX; i++) gather_from(f, position, get_box_point(f->gather, i), i, sum);
}

static np_ground_light_value gather_at(const ground_fill *f, np_dvec3 position) {
  const np_world *world = f->gather->world;
  np_spectrum clear = np_spectrum_grey(0.0f), seen = clear;
  np_ground_light_value out = {.added = clear};
  float open = 0.0f;
  for (unsigned i = 0; i < DIRECTIONS; i++) {
    const np_cloud_direction *d = &f->directions[i];
    np_spectrum light;
    const float transmittance = follow(f, d, position, i, &light);
    const np_spectrum sky = np_world_sky_radiance(world, world->cloud_sky, position, d->towards);
    clear = np_spectrum_add(clear, sky);
    seen = np_spectrum_add_scaled(seen, transmittance, sky);
    out.added = np_spectrum_add_scaled(out.added, weigh(f->gather, position, d->towards), light);
    open += transmittance / DIRECTIONS;
  }
  if (world->emission) gather_emitted(f, position, &out.added);
  out.added = np_spectrum_scale(out.added, NP_PI_F / DIRECTIONS);
  for (int b = 0; b < NP_BAND_COUNT; b++) out.open.band[b] = clear.band[b] > 0.0f ? seen.band[b] / clear.band[b] : open;
  return out;
}

static neph_result gather_points(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const ground_fill *f = user;
  const np_ground_light *c = f->cache;
  for (size_t n = begin; n < end; n++) {
    const double x = c->origin_m[0] + c->spacing_m * (double)(n % (size_t)c->size[0]),
                 y = c->origin_m[1] + c->spacing_m * (double)(n / (size_t)c->size[0]);
    c->points[n] = gather_at(f, np_cloud_gather_ground(f->gather, x, y));
  }
  return NEPH_OK;
}

/* Places points a third of the clouds' height above the ground apart, or fewer where their number is limited. */
static void place(const np_cloud_gather *g, np_ground_light *c) {
  const np_dvec3 low = g->bounds_min, high = g->bounds_max;
  const double middle[2] = {0.5 * (low.x + high.x), 0.5 * (low.y + high.y)};
  const double ground = np_cloud_gather_ground(g, middle[0], middle[1]).z;
  const double reach = reach_heights * fmax(high.z - ground, 1.0);
  const double low_m[2] = {low.x, low.y};
  double width[2] = {high.x - low.x + 2.0 * reach, high.y - low.y + 2.0 * reach};
  for (int a = 0; a < 2; a++) {
    c->period_m[a] = g->period_m[a];
    if (c->period_m[a] > 0.0) width[a] = c->period_m[a];
  }
  const double wanted = fmax((low.z - ground) / 3.0, reach / 24.0);
  c->spacing_m = fmax(wanted, fmax(width[0], width[1]) / (POINTS_MAX - 1));
  for (int a = 0; a < 2; a++) {
    c->size[a] = (int32_t)ceil(width[a] / c->spacing_m) + 1;
    c->origin_m[a] = c->period_m[a] > 0.0 ? low_m[a] : middle[a] - 0.5 * (c->size[a] - 1) * c->spacing_m;
  }
}

/* Steps through clouds, in voxels: two are 0.7 % too bright below a deck of seven voxels. */
static const double step_voxels = 1.0;

neph_result np_ground_light_build(neph_context *context, const np_cloud_gather *gather, np_monitor *monitor,
                                  np_ground_light *out) {
  *out = (np_ground_light){.context = context};
  ground_fill f = {gather, step_voxels * np_cloud_gather_compute_voxel(gather->world), out, NULL};
  memcpy(out->fade, gather->fade, sizeof out->fade);
  place(gather, out);
  const size_t count = (size_t)out->size[0] * (size_t)out->size[1];
  out->points = np_alloc(context, count, sizeof *out->points);
  f.directions = np_alloc(context, DIRECTIONS, sizeof *f.directions);
  neph_result result = out->points && f.directions ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; !result && i < DIRECTIONS; i++)
    np_cloud_gather_aim(gather, get_even_direction(i), &f.directions[i]);
  np_monitor_set_stage(monitor, "lighting the ground");
  if (!result) result = np_parallel_for(context, monitor, count, 8, gather_points, &f);
  np_alloc_free(context, f.directions);
  if (result) np_ground_light_clear(out);
  return result;
}

void np_ground_light_clear(np_ground_light *cache) {
  np_alloc_free(cache->context, cache->points);
  *cache = (np_ground_light){0};
}

static size_t count_points(const np_ground_light *cache) { return (size_t)cache->size[0] * (size_t)cache->size[1]; }

void np_ground_light_save(const np_ground_light *cache, np_cache_entry *entry) {
  NP_CACHE_WRITE(entry, cache->size);
  NP_CACHE_WRITE(entry, cache->origin_m);
  NP_CACHE_WRITE(entry, cache->spacing_m);
  NP_CACHE_WRITE(entry, cache->period_m);
  NP_CACHE_WRITE(entry, cache->fade);
  np_cache_write(entry, cache->points, count_points(cache) * sizeof *cache->points);
}

/* Whether a loaded cache is valid: a look-up needs two points along each axis. */
static bool is_sound(const np_ground_light *cache) {
  for (int a = 0; a < 2; a++)
    if (cache->size[a] < 2 || cache->size[a] > POINTS_MAX + 1 || !isfinite(cache->origin_m[a]) ||
        !(cache->period_m[a] >= 0.0 && isfinite(cache->period_m[a])))
      return false;
  return cache->spacing_m > 0.0 && isfinite(cache->spacing_m) && np_cache_are_finite(cache->fade, NP_INSTANCES_MAX);
}

bool np_ground_light_load(neph_context *context, np_cache_entry *entry, np_ground_light *out) {
  *out = (np_ground_light){.context = context};
  if (!NP_CACHE_READ(entry, out->size) || !NP_CACHE_READ(entry, out->origin_m) ||
      !NP_CACHE_READ(entry, out->spacing_m) || !NP_CACHE_READ(entry, out->period_m) || !NP_CACHE_READ(entry, out->fade))
    return false;
  if (!np_cache_read_check(entry, is_sound(out))) return false;
  out->points = np_cache_read_block(entry, count_points(out), sizeof *out->points);
  return out->points;
}

np_ground_light_value np_ground_light_get(const np_ground_light *c, np_dvec3 position) {
  const double p[2] = {position.x, position.y};
  int32_t lower[2];
  float w[2], rim = 1.0f;
  for (int a = 0; a < 2; a++) {
    const bool is_wrapped = c->period_m[a] > 0.0;
    const double turns = is_wrapped ? floor((p[a] - c->origin_m[a]) / c->period_m[a]) : 0.0;
    const double at = p[a] - turns * c->period_m[a];
    const double last = c->size[a] - 1, u = np_clamp((at - c->origin_m[a]) / c->spacing_m, 0.0, last);
    lower[a] = (int32_t)u < c->size[a] - 2 ? (int32_t)u : c->size[a] - 2;
    w[a] = (float)(u - lower[a]);
    if (!is_wrapped) rim *= np_smoothstepf((float)(fmin(u, last - u) / (0.15 * last)));
  }
  np_ground_light_value out = {np_spectrum_grey(1.0f - rim), np_spectrum_grey(0.0f)};
  for (int corner = 0; corner < 4; corner++) {
    const int i = corner & 1, j = corner >> 1;
    const float weight = rim * (i ? w[0] : 1.0f - w[0]) * (j ? w[1] : 1.0f - w[1]);
    const np_ground_light_value *near =
        &c->points[(size_t)(lower[1] + j) * (size_t)c->size[0] + (size_t)(lower[0] + i)];
    out.open = np_spectrum_add_scaled(out.open, weight, near->open);
    out.added = np_spectrum_add_scaled(out.added, weight, near->added);
  }
  return out;
}
