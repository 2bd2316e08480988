/* SPDX-License-Identifier: Apache-2.0 */
/* Light on the ground under clouds, gathered from the solution of the multiple scattering.
 *
 * With the directions of one cosine-weighted set, the same at every point, so that neighbours differ by what they see
 * alone. Smoke around a flame is bright in a small part of a dark sky, which such a set meets or misses: where there is
 * emission, two more are drawn, towards it and towards the clouds' box, and all are weighted by the balance heuristic
 * (Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering"). Along each the equation
 * of transfer is integrated in the scaled medium of transport/scattering_solver.c,
 *
 *     L += T·S·(1 − e^{−σ′h})/σ′,   S = Σ ϖσ·((1−f)·p′·E·e^{−kτ} + Σ (χ_l − f)·φ_lm·Y_lm)
 *
 * and the sky behind is seen through what T is left. The forward peak has no part in S: what it scatters down belongs
 * to the sun's beam, which fades with kτ (np_ground_light.fade), and to the sky behind. Air between clouds and ground
 * is left out: it takes from the clouds' light about what it adds. So are hills; a slope sees its share of everything.
 */
#include "caches/ground_light.h"

#include <assert.h>

#include "core/alloc.h"
#include "core/units.h"
#include "caches/sun_optical_depth.h"

enum { DIRECTIONS = 96, TO_EMISSION = 48, TO_BOX = 64, POINTS_MAX = 40, STEPS_MAX = 192 };

/* Distance from the clouds, in heights of their tops, beyond which the sky is clear. */
static const double reach_heights = 3.0;

typedef struct gather_direction {
  np_vec3 towards;
  float harmonics[NP_HARMONIC_COUNT_MAX]; /* spherical harmonics in this direction */
  float broad[NP_INSTANCES_MAX];          /* (1−f)·p′ of each cloud for sunlight */
} gather_direction;

typedef struct gather {
  const np_ground_light_desc *desc;
  const np_world *world;
  double step_m;
  np_ground_light *cache;
  gather_direction *directions;
} gather;

static void fill_direction(const np_ground_light_desc *desc, np_vec3 towards, gather_direction *out) {
  out->towards = towards;
  np_scattering_field_fill_harmonics(desc->scattering, np_vec3_scale(towards, -1.0f), out->harmonics);
  for (unsigned v = 0; v < desc->world->clouds.count; v++) {
    np_peak_column column;
    np_scattering_field_fill_column(desc->scattering, v, np_vec3_versine(towards, desc->world->to_sun), &column);
    out->broad[v] = fmaxf(0.0f, column.broad);
  }
}

/* A direction of a cosine-weighted set of DIRECTIONS. */
static np_vec3 get_even_direction(unsigned i) {
  const double cosine = sqrt(1.0 - (i + 0.5) / DIRECTIONS), sine = sqrt(1.0 - cosine * cosine);
  const double azimuth = i * (NP_PI * (3.0 - sqrt(5.0)));
  return np_vec3_make((float)(sine * cos(azimuth)), (float)(sine * sin(azimuth)), (float)cosine);
}

/* Clips a ray to the clouds' box, which has no sides where they repeat; false when it misses. */
static bool clip(const gather *g, np_dvec3 origin, np_vec3 direction, double *out_begin, double *out_end) {
  const double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
  const double low[3] = {g->desc->bounds_min.x, g->desc->bounds_min.y, g->desc->bounds_min.z},
               high[3] = {g->desc->bounds_max.x, g->desc->bounds_max.y, g->desc->bounds_max.z};
  *out_begin = 0.0;
  *out_end = HUGE_VAL;
  for (int a = 0; a < 3; a++) {
    if (a < 2 && g->desc->period_m[a] > 0.0) continue;
    if (fabs(d[a]) < 1e-12) {
      if (o[a] < low[a] || o[a] > high[a]) return false;
      continue;
    }
    const double t[2] = {(low[a] - o[a]) / d[a], (high[a] - o[a]) / d[a]};
    *out_begin = fmax(*out_begin, fmin(t[0], t[1]));
    *out_end = fmin(*out_end, fmax(t[0], t[1]));
  }
  return *out_begin < *out_end;
}

/* Light that the clouds at a place scatter along a direction, per metre; returns the scaled extinction there. */
static float compute_source(const gather *g, const gather_direction *d, np_dvec3 position, np_spectrum *out_source) {
  const np_world *world = g->world;
  float extinction[NP_INSTANCES_MAX], scaled = 0.0f;
  for (unsigned v = 0; v < world->clouds.count; v++)
    extinction[v] = world->clouds.places ? 0.0f : np_instance_extinction(&world->clouds.at[v], position);
  if (world->clouds.places) np_places_add_extinction(world->clouds.places, position, 1.0f, extinction);
  for (unsigned v = 0; v < world->clouds.count; v++) scaled += g->cache->fade[v] * extinction[v];
  if (!(scaled > 0.0f)) return 0.0f;
  np_light_moments moments;
  np_scattering_field_gather(g->desc->scattering, position, &moments);
  const float depth = np_sun_optical_depths_get_scaled(g->desc->depths, position, world->to_sun, g->cache->fade, 16.0f);
  const np_spectrum sun = np_spectrum_scale(np_world_sunlight(world, position, world->to_sun), np_transmittance(depth));
  *out_source = np_spectrum_grey(0.0f);
  for (unsigned v = 0; v < world->clouds.count; v++) {
    float outgoing[NP_HARMONIC_COUNT_MAX];
    np_scattering_field_fill_outgoing(g->desc->scattering, v, d->harmonics, outgoing);
    np_spectrum light = np_scattering_field_get_outgoing(g->desc->scattering, &moments, outgoing);
    light = np_spectrum_multiply(np_spectrum_add_scaled(light, d->broad[v], sun), world->clouds.at[v].albedo);
    *out_source = np_spectrum_add_scaled(*out_source, extinction[v], light);
  }
  return scaled;
}

/* Marches one direction upwards: the transmittance to the sky, and the light of the clouds. `offset` shifts the
 * steps. */
static float follow(const gather *g, const gather_direction *d, np_dvec3 origin, double offset,
                    np_spectrum *out_light) {
  *out_light = np_spectrum_grey(0.0f);
  double begin, end;
  if (!clip(g, origin, d->towards, &begin, &end)) return 1.0f;
  const int count = (int)np_clamp(ceil((end - begin) / g->step_m), 1.0, STEPS_MAX);
  const double length = (end - begin) / count;
  float transmittance = 1.0f;
  assert(length > 0.0 && offset >= 0.0 && offset <= 1.0);
  for (int k = 0; k < count && transmittance > 1e-3f; k++) {
    np_spectrum source;
    const np_dvec3 position = np_dvec3_along(origin, d->towards, begin + (k + offset) * length);
    const float scaled = compute_source(g, d, position, &source);
    if (!(scaled > 0.0f)) continue;
    const float passed = np_transmittance(scaled * (float)length);
    assert(passed >= 0.0f && passed <= 1.0f);
    *out_light = np_spectrum_add_scaled(*out_light, transmittance * (1.0f - passed) / scaled, source);
    transmittance *= passed;
  }
  return transmittance;
}

/* Density per solid angle of the direction to a point of the clouds' box. */
static double compute_box_density(const gather *g, np_dvec3 position, np_vec3 towards) {
  const np_dvec3 size = np_dvec3_subtract(g->desc->bounds_max, g->desc->bounds_min);
  double begin, end;
  if (!clip(g, position, towards, &begin, &end)) return 0.0;
  return (end * end * end - begin * begin * begin) / (3.0 * size.x * size.y * size.z);
}

/* MIS weight of the even set for light from one direction, among all sets that could have sampled it. */
static float weigh(const gather *g, np_dvec3 position, np_vec3 towards) {
  if (!g->world->emission) return 1.0f;
  const double even = (double)towards.z * (DIRECTIONS / NP_PI);
  const double to_emission = TO_EMISSION * (double)np_emission_direction_density(g->world->emission, position, towards);
  return (float)(even / (even + to_emission + TO_BOX * compute_box_density(g, position, towards)));
}

/* Offset of the i-th direction's steps. */
static double get_offset(unsigned i) { return fmod(0.5 + 0.6180339887498949 * i, 1.0); }

/* The i-th point of a set that fills the clouds' box evenly (Roberts 2018, "The Unreasonable Effectiveness of
 * Quasirandom Sequences"). */
static np_dvec3 get_box_point(const np_ground_light_desc *desc, unsigned i) {
  const np_dvec3 low = desc->bounds_min, size = np_dvec3_subtract(desc->bounds_max, low);
  return np_dvec3_make(low.x + size.x * fmod(0.5 + 0.8191725133961645 * i, 1.0),
                       low.y + size.y * fmod(0.5 + 0.6710436067037893 * i, 1.0),
                       low.z + size.z * fmod(0.5 + 0.5497004779019703 * i, 1.0));
}

/* Adds light of one of cosine-weighted directions to the sums for irradiance and for actinic flux. */
static void add_light(const gather_direction *d, float weight, np_spectrum light, np_ground_light_value *sum) {
  sum->added = np_spectrum_add_scaled(sum->added, weight, light);
  sum->actinic = np_spectrum_add_scaled(sum->actinic, weight / d->towards.z, light);
}

/* Adds light from the direction of a place. */
static void gather_from(const gather *g, np_dvec3 position, np_dvec3 place, unsigned i, np_ground_light_value *sum) {
  const np_vec3 away = np_dvec3_to_float(np_dvec3_subtract(place, position));
  gather_direction d;
  np_spectrum light;
  if (!(away.z > 0.0f)) return;
  fill_direction(g->desc, np_vec3_normalize(away), &d);
  (void)follow(g, &d, position, get_offset(i), &light);
  add_light(&d, weigh(g, position, d.towards), light, sum);
}

/* Adds the light of the other sets to the even set's sum: their weight over their density equals that over the even
 * set's. */
static void gather_emitted(const gather *g, np_dvec3 position, np_ground_light_value *sum) {
  np_random random = np_random_start(0, 0, 0, 0, 0); /* the same at every point */
  for (unsigned i = 0; i < TO_EMISSION; i++) {
    np_dvec3 place;
    if (np_emission_draw(g->world->emission, (i + 0.5) / TO_EMISSION, &random, &place))
      gather_from(g, position, place, i, sum);
  }
  for (unsigned i = 0; i < TO_BOX; i++) gather_from(g, position, get_box_point(g->desc, i), i, sum);
}

static np_ground_light_value gather_at(const gather *g, np_dvec3 position) {
  np_spectrum clear = np_spectrum_grey(0.0f), seen = clear;
  np_ground_light_value out = {.added = clear, .actinic = clear};
  float open = 0.0f;
  for (unsigned i = 0; i < DIRECTIONS; i++) {
    const gather_direction *d = &g->directions[i];
    np_spectrum light;
    const float transmittance = follow(g, d, position, get_offset(i), &light);
    const np_spectrum sky = np_world_sky_radiance(g->world, g->world->cloud_sky, position, d->towards);
    clear = np_spectrum_add(clear, sky);
    seen = np_spectrum_add_scaled(seen, transmittance, sky);
    add_light(d, weigh(g, position, d->towards), light, &out);
    out.actinic = np_spectrum_add_scaled(out.actinic, (transmittance - 1.0f) / d->towards.z, sky);
    open += transmittance / DIRECTIONS;
  }
  if (g->world->emission) gather_emitted(g, position, &out);
  out.added = np_spectrum_scale(out.added, NP_PI_F / DIRECTIONS);
  out.actinic = np_spectrum_scale(out.actinic, NP_PI_F / DIRECTIONS);
  for (int b = 0; b < NP_BAND_COUNT; b++) out.open.band[b] = clear.band[b] > 0.0f ? seen.band[b] / clear.band[b] : open;
  return out;
}

/* Ground below a place; sea level where there is none. */
static np_dvec3 compute_ground(const np_world *world, double x, double y, double top_m) {
  const np_dvec3 above = np_dvec3_make(x, y, top_m);
  np_ground_hit hit;
  return np_world_intersect_ground(world, above, np_vec3_make(0, 0, -1), &hit) ? hit.position
                                                                               : np_dvec3_make(x, y, 0.0);
}

static neph_result gather_points(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const gather *g = user;
  const np_ground_light *c = g->cache;
  for (size_t n = begin; n < end; n++) {
    const double x = c->origin_m[0] + c->spacing_m * (double)(n % (size_t)c->size[0]),
                 y = c->origin_m[1] + c->spacing_m * (double)(n / (size_t)c->size[0]);
    c->points[n] = gather_at(g, compute_ground(g->world, x, y, g->desc->bounds_max.z + 1e4));
  }
  return NEPH_OK;
}

/* Places points a third of the clouds' height above the ground apart, or fewer where their number is limited. */
static void place(gather *g) {
  np_ground_light *c = g->cache;
  const np_dvec3 low = g->desc->bounds_min, high = g->desc->bounds_max;
  const double middle[2] = {0.5 * (low.x + high.x), 0.5 * (low.y + high.y)};
  const double ground = compute_ground(g->world, middle[0], middle[1], high.z + 1e4).z;
  const double reach = reach_heights * fmax(high.z - ground, 1.0);
  const double low_m[2] = {low.x, low.y};
  double width[2] = {high.x - low.x + 2.0 * reach, high.y - low.y + 2.0 * reach};
  for (int a = 0; a < 2; a++) {
    c->period_m[a] = g->desc->period_m[a];
    if (c->period_m[a] > 0.0) width[a] = c->period_m[a];
  }
  const double wanted = fmax((low.z - ground) / 3.0, reach / 24.0);
  c->spacing_m = fmax(wanted, fmax(width[0], width[1]) / (POINTS_MAX - 1));
  for (int a = 0; a < 2; a++) {
    c->size[a] = (int32_t)ceil(width[a] / c->spacing_m) + 1;
    c->origin_m[a] = c->period_m[a] > 0.0 ? low_m[a] : middle[a] - 0.5 * (c->size[a] - 1) * c->spacing_m;
  }
}

/* Step of the march: a voxel of the finest cloud. Two are 0.7 % too bright below a deck of seven voxels. */
static double compute_step(const np_world *world) {
  double finest = INFINITY;
  const np_instance *places = np_instances_get_places(&world->clouds);
  for (unsigned v = 0; v < np_instances_count_places(&world->clouds); v++)
    for (int a = 0; a < 3; a++) {
      const double *row = places[v].world_to_index.m[a];
      finest = fmin(finest, 1.0 / np_dvec3_length(np_dvec3_make(row[0], row[1], row[2])));
    }
  return finest;
}

neph_result np_ground_light_build(neph_context *context, const np_ground_light_desc *desc, np_monitor *monitor,
                                  np_ground_light *out) {
  *out = (np_ground_light){.context = context};
  const np_world *world = desc->world;
  gather g = {desc, world, compute_step(world), out, NULL};
  const np_scattering_medium *medium = np_scattering_field_get_medium(desc->scattering);
  for (unsigned v = 0; v < world->clouds.count; v++)
    out->fade[v] = np_scaled_cloud_get_scale(&medium->clouds[v], world->clouds.at[v].albedo);
  place(&g);
  const size_t count = (size_t)out->size[0] * (size_t)out->size[1];
  out->points = np_alloc(context, count, sizeof *out->points);
  g.directions = np_alloc(context, DIRECTIONS, sizeof *g.directions);
  neph_result result = out->points && g.directions ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; !result && i < DIRECTIONS; i++) fill_direction(desc, get_even_direction(i), &g.directions[i]);
  np_monitor_set_stage(monitor, "lighting the ground");
  if (!result) result = np_parallel_for(context, monitor, count, 8, gather_points, &g);
  np_alloc_free(context, g.directions);
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
  np_ground_light_value out = {np_spectrum_grey(1.0f - rim), np_spectrum_grey(0.0f), np_spectrum_grey(0.0f)};
  for (int corner = 0; corner < 4; corner++) {
    const int i = corner & 1, j = corner >> 1;
    const float weight = rim * (i ? w[0] : 1.0f - w[0]) * (j ? w[1] : 1.0f - w[1]);
    const np_ground_light_value *near =
        &c->points[(size_t)(lower[1] + j) * (size_t)c->size[0] + (size_t)(lower[0] + i)];
    out.open = np_spectrum_add_scaled(out.open, weight, near->open);
    out.added = np_spectrum_add_scaled(out.added, weight, near->added);
    out.actinic = np_spectrum_add_scaled(out.actinic, weight, near->actinic);
  }
  return out;
}
