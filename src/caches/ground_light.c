/* SPDX-License-Identifier: Apache-2.0 */
/* Light on the ground under clouds, gathered from the solution of the multiple scattering (cloud_gather.h).
 *
 * With the directions of one cosine-weighted set, the same at every point, so that neighbours differ by what they see
 * alone. Smoke around a flame is bright in a small part of a dark sky, which such a set meets or misses: where there is
 * emission, two more are drawn, towards it and towards the clouds' box, and all are weighted by the balance heuristic
 * (Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering"). Hills end the rays that
 * meet them; a slope sees its share of everything.
 */
#include "caches/ground_light.h"

#include <string.h>

#include "core/alloc.h"
#include "core/units.h"

enum { DIRECTIONS = NP_GROUND_DIRECTIONS, TO_EMISSION = 48, TO_BOX = 64, POINTS_MAX = 40, STEPS_MAX = 192 };

/* Distance from the clouds, in heights of their tops, beyond which the sky is clear. */
static const double reach_heights = 3.0;
static const double clearance_m = 1.0; /* height above the ground from which the air is traced */

typedef struct ground_fill {
  const np_cloud_gather *gather;
  double step_m;
  np_ground_light *cache;
  const np_ground_rays *rays;
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

/* Marches the i-th direction of a set, up to the ground if hills block the ray. */
static np_cloud_view follow(const ground_fill *f, const np_cloud_direction *d, np_dvec3 position, unsigned i,
                            np_ground_hit *out_hill, double *out_end_m) {
  const np_world *world = f->gather->world;
  *out_end_m = world->terrain ? np_cloud_gather_find_ground(f->gather, position, d->towards, out_hill) : HUGE_VAL;
  return np_cloud_gather_follow(f->gather, d, position,
                                &(np_cloud_steps){f->step_m, get_offset(i), *out_end_m, STEPS_MAX});
}

/* Adds light from the direction of a place. */
static void gather_from(const ground_fill *f, np_dvec3 position, np_dvec3 place, unsigned i, np_spectrum *sum) {
  const np_vec3 away = np_dvec3_to_float(np_dvec3_subtract(place, position));
  np_cloud_direction d;
  np_ground_hit hill;
  double end_m;
  if (!(away.z > 0.0f)) return;
  np_cloud_gather_aim(f->gather, np_vec3_normalize(away), &d);
  const np_cloud_view view = follow(f, &d, position, i, &hill, &end_m);
  *sum = np_spectrum_add_scaled(*sum, weigh(f->gather, position, d.towards), view.light);
}

/* Adds emission sampled by other strategies. Each strategy's weight over its density equals that of the uniform
 * directions. */
static void gather_emitted(const ground_fill *f, np_dvec3 position, np_spectrum *sum) {
  const np_emission *emission = f->gather->world->emission;
  np_random random = np_random_start(0, 0, 0, 0, 0); /* equal random numbers at every point */
  for (unsigned i = 0; i < TO_EMISSION; i++) {
    np_dvec3 place;
    if (np_emission_draw(emission, (i + 0.5) / TO_EMISSION, &random, &place)) gather_from(f, position, place, i, sum);
  }
  for (unsigned i = 0; i < TO_BOX; i++) gather_from(f, position, get_box_point(f->gather, i), i, sum);
}

/* Radiance of a hill under a clear sky and the dimmed sun. */
static np_spectrum light_hill(const ground_fill *f, const np_ground_hit *hill) {
  const np_world *world = f->gather->world;
  const float cosine = np_vec3_dot(hill->normal, world->to_sun);
  np_spectrum light = np_spectrum_scale(np_world_level_irradiance(world, hill), np_world_get_sky_share(world, hill));
  const np_spectrum sun = np_world_sunlight(world, hill->position, world->to_sun);
  if (cosine > 0.0f && !np_spectrum_is_zero(sun)) {
    const float depth =
        np_sun_optical_depths_get_scaled(f->gather->depths, hill->position, world->to_sun, f->gather->fade, 16.0f);
    light = np_spectrum_add_scaled(light, cosine * np_transmittance(depth), sun);
  }
  return np_spectrum_scale(np_spectrum_multiply(light, hill->albedo), 1.0f / NP_PI_F);
}

/* Radiances along the even set, summed: of the clear sky, what is left of it, and what the clouds add; behind hills
 * there is no sky, and clouds before them hide their light. */
typedef struct ground_sums {
  np_spectrum clear, seen, added;
  np_spectrum clear_linear[2],
      linear[2]; /* first moments along x and y of the radiances `clear`, and `seen` and `added` */
  float open;
} ground_sums;

static void add_linear(np_spectrum sums[2], np_vec3 towards, np_spectrum light) {
  sums[0] = np_spectrum_add_scaled(sums[0], towards.x / towards.z, light);
  sums[1] = np_spectrum_add_scaled(sums[1], towards.y / towards.z, light);
}

static void gather_along(const ground_fill *f, np_dvec3 position, unsigned i, np_gather_ray *out_ray,
                         ground_sums *sums) {
  const np_ground_direction *d = &f->rays->directions[i];
  const np_vec3 towards = d->gather.towards;
  np_ground_hit hill;
  double end_m;
  const np_cloud_view view = follow(f, &d->gather, position, i, &hill, &end_m);
  *out_ray = (np_gather_ray){{0}, view.transmittance, view.middle_m, (float)end_m};
  const float weight = weigh(f->gather, position, towards);
  np_spectrum added = np_spectrum_scale(np_gather_air_dim(&d->air, out_ray, view.light), weight), seen = {{0}};
  if (isfinite(end_m)) {
    if (view.transmittance < 1.0f)
      added = np_spectrum_add_scaled(added, view.transmittance - 1.0f,
                                     np_gather_air_dim(&d->air, out_ray, light_hill(f, &hill)));
  } else {
    const np_spectrum change = np_gather_air_change(f->gather, &d->air, towards, position, out_ray, get_offset(i));
    seen = np_spectrum_add(d->air.clear, change);
    sums->open += view.transmittance;
    sums->clear = np_spectrum_add(sums->clear, d->air.clear);
    add_linear(sums->clear_linear, towards, d->air.clear);
  }
  sums->seen = np_spectrum_add(sums->seen, seen);
  sums->added = np_spectrum_add(sums->added, added);
  add_linear(sums->linear, towards, np_spectrum_add(seen, added));
}

static np_ground_light_value gather_at(const ground_fill *f, np_dvec3 position, np_gather_ray *rays) {
  ground_sums sums = {.open = 0.0f};
  np_ground_light_value out;
  for (unsigned i = 0; i < DIRECTIONS; i++) gather_along(f, position, i, &rays[i], &sums);
  if (f->gather->world->emission) gather_emitted(f, position, &sums.added);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    out.added.band[b] = fmaxf(0.0f, sums.added.band[b]) * NP_PI_F / DIRECTIONS;
    out.open.band[b] =
        sums.clear.band[b] > 0.0f ? fmaxf(0.0f, sums.seen.band[b]) / sums.clear.band[b] : sums.open / DIRECTIONS;
    for (int a = 0; a < 2; a++)
      out.linear[a].band[b] =
          (sums.linear[a].band[b] - out.open.band[b] * sums.clear_linear[a].band[b]) * NP_PI_F / DIRECTIONS;
  }
  return out;
}

np_dvec3 np_ground_light_get_place(const np_ground_light *c, const np_cloud_gather *gather, size_t n) {
  return np_cloud_gather_ground(gather, c->origin_m[0] + c->spacing_m * (double)(n % (size_t)c->size[0]),
                                c->origin_m[1] + c->spacing_m * (double)(n / (size_t)c->size[0]));
}

static neph_result gather_points(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const ground_fill *f = user;
  for (size_t n = begin; n < end; n++)
    f->cache->points[n] = gather_at(f, np_ground_light_get_place(f->cache, f->gather, n), &f->rays->at[n * DIRECTIONS]);
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
  if (g->is_coarse) c->spacing_m *= 2.0;
  for (int a = 0; a < 2; a++) {
    c->size[a] = (int32_t)ceil(width[a] / c->spacing_m) + 1;
    c->origin_m[a] = c->period_m[a] > 0.0 ? low_m[a] : middle[a] - 0.5 * (c->size[a] - 1) * c->spacing_m;
  }
}

/* Steps through clouds, in voxels: two are 0.7 % too bright below a deck of seven voxels. */
static const double step_voxels = 1.0;

/* Directions, and their air from the middle of the ground. */
static void aim_directions(const np_cloud_gather *g, np_ground_direction *out) {
  const double x = 0.5 * (g->bounds_min.x + g->bounds_max.x), y = 0.5 * (g->bounds_min.y + g->bounds_max.y);
  np_dvec3 from = np_cloud_gather_ground(g, x, y);
  from.z += clearance_m;
  for (unsigned i = 0; i < DIRECTIONS; i++) {
    const np_vec3 towards = get_even_direction(i);
    np_cloud_gather_aim(g, towards, &out[i].gather);
    np_gather_air_trace(g, from, towards, &out[i].air);
    out[i].offset = get_offset(i);
  }
}

neph_result np_ground_light_build(neph_context *context, const np_cloud_gather *gather, np_monitor *monitor,
                                  np_ground_light *out, np_ground_rays *out_rays) {
  *out = (np_ground_light){.context = context};
  ground_fill f = {gather, step_voxels * np_cloud_gather_compute_voxel(gather->world), out, out_rays};
  memcpy(out->fade, gather->fade, sizeof out->fade);
  place(gather, out);
  const size_t count = np_ground_light_count_points(out);
  out->points = np_alloc(context, count, sizeof *out->points);
  out_rays->directions = np_alloc(context, DIRECTIONS, sizeof *out_rays->directions);
  out_rays->at = np_alloc(context, count * DIRECTIONS, sizeof *out_rays->at);
  neph_result result = out->points && out_rays->directions && out_rays->at ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) {
    aim_directions(gather, out_rays->directions);
    np_monitor_set_stage(monitor, "lighting the ground");
    result = np_parallel_for(context, monitor, count, 8, gather_points, &f);
  }
  if (result) np_ground_light_clear(out);
  return result;
}

void np_ground_rays_clear(neph_context *context, np_ground_rays *rays) {
  np_alloc_free(context, rays->at);
  np_alloc_free(context, rays->directions);
  *rays = (np_ground_rays){0};
}

void np_ground_light_clear(np_ground_light *cache) {
  np_alloc_free(cache->context, cache->points);
  *cache = (np_ground_light){0};
}

void np_ground_light_save(const np_ground_light *cache, np_cache_entry *entry) {
  NP_CACHE_WRITE(entry, cache->size);
  NP_CACHE_WRITE(entry, cache->origin_m);
  NP_CACHE_WRITE(entry, cache->spacing_m);
  NP_CACHE_WRITE(entry, cache->period_m);
  NP_CACHE_WRITE(entry, cache->fade);
  np_cache_write(entry, cache->points, np_ground_light_count_points(cache) * sizeof *cache->points);
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
  out->points = np_cache_read_block(entry, np_ground_light_count_points(out), sizeof *out->points);
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
  np_ground_light_value out = {.open = np_spectrum_grey(1.0f - rim)};
  for (int corner = 0; corner < 4; corner++) {
    const int i = corner & 1, j = corner >> 1;
    const float weight = rim * (i ? w[0] : 1.0f - w[0]) * (j ? w[1] : 1.0f - w[1]);
    const np_ground_light_value *near =
        &c->points[(size_t)(lower[1] + j) * (size_t)c->size[0] + (size_t)(lower[0] + i)];
    out.open = np_spectrum_add_scaled(out.open, weight, near->open);
    out.added = np_spectrum_add_scaled(out.added, weight, near->added);
    for (int a = 0; a < 2; a++) out.linear[a] = np_spectrum_add_scaled(out.linear[a], weight, near->linear[a]);
  }
  return out;
}

np_spectrum np_ground_light_add_slope(const np_ground_light_value *value, np_vec3 normal, float share) {
  np_spectrum out = np_spectrum_grey(0.0f);
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out.band[b] = fmaxf(0.0f, share * value->added.band[b] +
                                  0.5f * (normal.x * value->linear[0].band[b] + normal.y * value->linear[1].band[b]));
  return out;
}
