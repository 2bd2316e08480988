/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/lit_air.h"

#include <string.h>

#include "atmosphere/atmosphere_private.h"
#include "atmosphere/sky_along.h"
#include "core/alloc.h"
#include "core/units.h"

enum { DIRECTIONS = 64, POINTS_MAX = 14, STEPS_MAX = 64, TRIES = 4, LEVELS = NP_LIT_AIR_LEVELS };

/* Distance from the clouds, in heights of their tops above the ground, beyond which the air is clear. */
static const double reach_heights = 1.0;
/* Steps through clouds, in voxels. */
static const double step_voxels = 2.0;
/* Part of the way to the rim over which the change fades out. */
static const double rim_share = 0.15;
static const double clearance_m = 1.0; /* least height of places above the ground */

/* Heights of the upper levels above the clouds' tops, in reaches. */
static const double above[] = {0.0, 0.25, 1.0};
enum { ABOVE = sizeof above / sizeof above[0] };

/* Cells of the air along a direction, whose ends lie as squares of the distance; farther air is in the sun. */
enum { AIR_CELLS = 5 };
static const double air_reach_m = 40e3;

/* A direction, and the radiance of clear air and ground along it; of it that which the air scatters once, by cell. */
typedef struct even_direction {
  np_cloud_direction gather;
  np_spectrum clear, once[AIR_CELLS];
} even_direction;

typedef struct air_fill {
  const np_cloud_gather *gather;
  const np_ground_light *ground_light;
  double step_m;
  np_lit_air *out;
  even_direction *directions;
} air_fill;

/* ---- The lattice ---- */

double np_lit_air_get_reach(double height_m) { return reach_heights * fmax(height_m, 1.0); }

static void place_levels(np_lit_air *a, double ground, double top, double reach) {
  for (int k = 0; k < LEVELS; k++) {
    const int over = k - (LEVELS - ABOVE);
    a->level_m[k] = over >= 0 ? top + above[over] * reach : ground + (top - ground) * k / (LEVELS - ABOVE);
  }
}

static void place(const np_cloud_gather *g, np_lit_air *a) {
  const np_dvec3 low = g->bounds_min, high = g->bounds_max;
  const double middle[2] = {0.5 * (low.x + high.x), 0.5 * (low.y + high.y)};
  const double ground = fmin(np_cloud_gather_ground(g, middle[0], middle[1]).z, low.z);
  const double reach = np_lit_air_get_reach(high.z - ground);
  const double low_m[2] = {low.x, low.y};
  double width[2] = {high.x - low.x + 2.0 * reach, high.y - low.y + 2.0 * reach};
  for (int n = 0; n < 2; n++) {
    a->period_m[n] = g->period_m[n];
    if (a->period_m[n] > 0.0) width[n] = a->period_m[n];
  }
  a->spacing_m = fmax(width[0], width[1]) / (POINTS_MAX - 1);
  for (int n = 0; n < 2; n++) {
    a->size[n] = (int32_t)fmax(ceil(width[n] / a->spacing_m), 1.0) + 1;
    a->origin_m[n] = a->period_m[n] > 0.0 ? low_m[n] : middle[n] - 0.5 * (a->size[n] - 1) * a->spacing_m;
  }
  place_levels(a, ground, high.z, reach);
}

static size_t count_points(const np_lit_air *a) { return (size_t)a->size[0] * (size_t)a->size[1] * LEVELS; }

/* ---- Light at a place ---- */

/* Radiance of clear air, and of the ground beneath it, from the middle of the clouds' top. */
static np_spectrum compute_clear(const np_cloud_gather *g, np_vec3 towards) {
  const np_world *world = g->world;
  const np_dvec3 from = np_dvec3_make(0.5 * (g->bounds_min.x + g->bounds_max.x),
                                      0.5 * (g->bounds_min.y + g->bounds_max.y), g->bounds_max.z);
  np_ground_hit hit;
  if (!np_world_intersect_ground(world, from, towards, &hit))
    return np_world_sky_radiance(world, world->cloud_sky, from, towards);
  const np_spectrum sun = np_world_sunlight(world, hit.position, world->to_sun);
  const float up = np_vec3_dot(np_zenith(hit.position, world->planet_radius_m), world->to_sun);
  const np_spectrum level = np_spectrum_add_scaled(np_world_level_irradiance(world, &hit), np_maxf(up, 0.0f), sun);
  const np_spectrum ground = np_spectrum_scale(np_spectrum_multiply(level, hit.albedo), 1.0f / NP_PI_F);
  if (!world->cloud_sky) return ground;
  const np_aerial_perspective air = np_sky_trace_air(world->cloud_sky, from, towards, hit.distance_m);
  return np_spectrum_add(np_spectrum_multiply(ground, air.transmittance), air.inscatter);
}

/* Change of the ground's radiance by the clouds. */
static np_spectrum compute_ground_change(const air_fill *f, const np_ground_hit *hit) {
  const np_world *world = f->gather->world;
  const np_ground_light_value light = np_ground_light_get(f->ground_light, hit->position);
  const np_spectrum sky = np_world_level_irradiance(world, hit);
  np_spectrum change = light.added;
  for (int b = 0; b < NP_BAND_COUNT; b++) change.band[b] -= (1.0f - light.open.band[b]) * sky.band[b];
  const float up = np_vec3_dot(np_zenith(hit->position, world->planet_radius_m), world->to_sun);
  const np_spectrum sun = np_world_sunlight(world, hit->position, world->to_sun);
  if (up > 0.0f && !np_spectrum_is_zero(sun)) {
    const float depth =
        np_sun_optical_depths_get_scaled(f->gather->depths, hit->position, world->to_sun, f->gather->fade, 16.0f);
    change = np_spectrum_add_scaled(change, -up * np_opacity(depth), sun);
  }
  return np_spectrum_scale(np_spectrum_multiply(change, hit->albedo), 1.0f / NP_PI_F);
}

static double get_spacing(const np_lit_air *a, int level) {
  const int low = level > 0 ? level - 1 : 0, high = level + 1 < LEVELS ? level + 1 : level;
  return (a->level_m[high] - a->level_m[low]) / (high - low);
}

/* The n-th place of a point's cell, above the ground. */
static np_dvec3 choose_place(const air_fill *f, np_dvec3 point, int level, np_dvec3 offset) {
  const double spacing_m = f->out->spacing_m;
  np_dvec3 at = np_dvec3_make(point.x + offset.x * spacing_m, point.y + offset.y * spacing_m,
                              point.z + offset.z * get_spacing(f->out, level));
  const double least = np_cloud_gather_ground(f->gather, at.x, at.y).z + clearance_m;
  at.z = fmax(at.z, least);
  return at;
}

/* The n-th point of a set that fills a cell evenly (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
 * Sequences"). */
static np_dvec3 get_offset(unsigned n) {
  return np_dvec3_make(fmod(0.8191725133961645 * n, 1.0) - 0.5, fmod(0.6710436067037893 * n, 1.0) - 0.5,
                       fmod(0.5497004779019703 * n, 1.0) - 0.5);
}

/* Origin of a direction in a point's cell: outside of the clouds, if a few tries find such a place. */
static np_dvec3 choose_origin(const air_fill *f, np_dvec3 point, int level, unsigned direction) {
  np_dvec3 at = point;
  for (unsigned n = 0; n < TRIES; n++) {
    float extinction[NP_INSTANCES_MAX];
    at = choose_place(f, point, level, get_offset(direction + n * DIRECTIONS));
    if (!(np_cloud_gather_extinction(f->gather, at, extinction) > 0.0f)) break;
  }
  return at;
}

static double compute_cell_end(int cell) { return air_reach_m * cell * cell / (AIR_CELLS * AIR_CELLS); }

/* Light that the air along a direction lacks because clouds and hills shade it from the sun. */
static np_spectrum compute_shaded(const air_fill *f, const even_direction *d, np_dvec3 origin, double end_m,
                                  double offset) {
  const np_world *world = f->gather->world;
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int c = 0; c < AIR_CELLS && compute_cell_end(c) < end_m; c++) {
    const double near = compute_cell_end(c), far = fmin(compute_cell_end(c + 1), end_m),
                 share = (far - near) / (compute_cell_end(c + 1) - near);
    const np_dvec3 place = np_dvec3_along(origin, d->gather.towards, near + offset * (far - near));
    float shade = 1.0f;
    if (!np_world_is_behind_terrain(world, place, world->to_sun))
      shade =
          np_opacity(np_sun_optical_depths_get_scaled(f->gather->depths, place, world->to_sun, f->gather->fade, 16.0f));
    sum = np_spectrum_add_scaled(sum, (float)share * shade, d->once[c]);
  }
  return sum;
}

/* Change by the clouds of the radiance along a direction. */
static np_spectrum compute_change(const air_fill *f, const even_direction *d, np_dvec3 origin, double offset) {
  const np_cloud_steps steps = {f->step_m, offset, STEPS_MAX};
  np_spectrum light;
  np_ground_hit hit;
  const float transmittance = np_cloud_gather_follow(f->gather, &d->gather, origin, &steps, &light);
  np_spectrum change = np_spectrum_add_scaled(light, transmittance - 1.0f, d->clear);
  const bool has_hit = np_world_intersect_ground(f->gather->world, origin, d->gather.towards, &hit);
  if (has_hit) change = np_spectrum_add_scaled(change, transmittance, compute_ground_change(f, &hit));
  const np_spectrum shaded = compute_shaded(f, d, origin, has_hit ? hit.distance_m : (double)INFINITY, offset);
  return np_spectrum_add_scaled(change, -transmittance, shaded);
}

static np_lit_air_value gather_at(const air_fill *f, np_dvec3 point, int level) {
  np_lit_air_value out = {np_spectrum_grey(0.0f), np_spectrum_grey(0.0f)};
  for (unsigned i = 0; i < DIRECTIONS; i++) {
    const even_direction *d = &f->directions[i];
    const np_dvec3 origin = choose_origin(f, point, level, i);
    const np_spectrum change = compute_change(f, d, origin, fmod(0.5 + 0.6180339887498949 * i, 1.0));
    np_spectrum *sum = d->gather.towards.z > 0.0f ? &out.upper : &out.lower;
    *sum = np_spectrum_add_scaled(*sum, 4.0f * NP_PI_F / DIRECTIONS, change);
  }
  return out;
}

static neph_result gather_points(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const air_fill *f = user;
  const np_lit_air *a = f->out;
  for (size_t n = begin; n < end; n++) {
    const size_t width = (size_t)a->size[0], height = (size_t)a->size[1];
    const int level = (int)(n / (width * height));
    const np_dvec3 point =
        np_dvec3_make(a->origin_m[0] + a->spacing_m * (double)(n % width),
                      a->origin_m[1] + a->spacing_m * (double)(n / width % height), a->level_m[level]);
    a->points[n] = gather_at(f, point, level);
  }
  return NEPH_OK;
}

static void fill_once(const np_cloud_gather *g, np_vec3 towards, np_spectrum out[AIR_CELLS]) {
  np_spectrum before = np_spectrum_grey(0.0f);
  for (int c = 0; c < AIR_CELLS; c++) {
    np_spectrum up_to = before;
    if (g->world->cloud_sky) (void)np_sky_aerial_orders(g->world->cloud_sky, towards, compute_cell_end(c + 1), &up_to);
    out[c] = np_spectrum_subtract(up_to, before);
    before = up_to;
  }
}

static void aim_directions(const np_cloud_gather *g, even_direction *out) {
  for (unsigned i = 0; i < DIRECTIONS; i++) {
    const double z = 1.0 - (2.0 * i + 1.0) / DIRECTIONS, azimuth = i * (NP_PI * (3.0 - sqrt(5.0)));
    const float r = (float)sqrt(1.0 - z * z);
    const np_vec3 towards = np_vec3_make(r * (float)cos(azimuth), r * (float)sin(azimuth), (float)z);
    np_cloud_gather_aim(g, towards, &out[i].gather);
    out[i].clear = compute_clear(g, towards);
    fill_once(g, towards, out[i].once);
  }
}

neph_result np_lit_air_build(neph_context *context, const np_cloud_gather *gather, const np_ground_light *ground_light,
                             np_monitor *monitor, np_lit_air *out) {
  *out = (np_lit_air){.context = context};
  place(gather, out);
  air_fill f = {gather, ground_light, step_voxels * np_cloud_gather_compute_voxel(gather->world), out, NULL};
  out->points = np_alloc(context, count_points(out), sizeof *out->points);
  f.directions = np_alloc(context, DIRECTIONS, sizeof *f.directions);
  neph_result result = out->points && f.directions ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) {
    aim_directions(gather, f.directions);
    np_monitor_set_stage(monitor, "lighting the air");
    result = np_parallel_for(context, monitor, count_points(out), 8, gather_points, &f);
  }
  np_alloc_free(context, f.directions);
  if (result) np_lit_air_clear(out);
  return result;
}

void np_lit_air_clear(np_lit_air *light) {
  np_alloc_free(light->context, light->points);
  *light = (np_lit_air){0};
}

/* ---- Copies on disk ---- */

void np_lit_air_save(const np_lit_air *light, np_cache_entry *entry) {
  NP_CACHE_WRITE(entry, light->size);
  NP_CACHE_WRITE(entry, light->origin_m);
  NP_CACHE_WRITE(entry, light->spacing_m);
  NP_CACHE_WRITE(entry, light->period_m);
  NP_CACHE_WRITE(entry, light->level_m);
  np_cache_write(entry, light->points, count_points(light) * sizeof *light->points);
}

/* Whether a loaded lattice is valid: a look-up needs two points along each axis. */
static bool is_sound(const np_lit_air *light) {
  for (int n = 0; n < 2; n++)
    if (light->size[n] < 2 || light->size[n] > POINTS_MAX + 1 || !isfinite(light->origin_m[n]) ||
        !(light->period_m[n] >= 0.0 && isfinite(light->period_m[n])))
      return false;
  for (int k = 0; k < LEVELS; k++)
    if (!isfinite(light->level_m[k]) || (k > 0 && !(light->level_m[k] > light->level_m[k - 1]))) return false;
  return light->spacing_m > 0.0 && isfinite(light->spacing_m);
}

bool np_lit_air_load(neph_context *context, np_cache_entry *entry, np_lit_air *out) {
  *out = (np_lit_air){.context = context};
  if (!NP_CACHE_READ(entry, out->size) || !NP_CACHE_READ(entry, out->origin_m) ||
      !NP_CACHE_READ(entry, out->spacing_m) || !NP_CACHE_READ(entry, out->period_m) ||
      !NP_CACHE_READ(entry, out->level_m))
    return false;
  if (!np_cache_read_check(entry, is_sound(out))) return false;
  out->points = np_cache_read_block(entry, count_points(out), sizeof *out->points);
  return out->points;
}

/* ---- Look-ups ---- */

/* Lower neighbour along a level, and the fraction to the next; returns how much of the change the rim leaves. */
static float locate(const np_lit_air *a, int axis, double x, int32_t *out_lower, float *out_part) {
  const bool is_wrapped = a->period_m[axis] > 0.0;
  const double turns = is_wrapped ? floor((x - a->origin_m[axis]) / a->period_m[axis]) : 0.0;
  const double last = a->size[axis] - 1,
               u = np_clamp((x - turns * a->period_m[axis] - a->origin_m[axis]) / a->spacing_m, 0.0, last);
  *out_lower = (int32_t)u < a->size[axis] - 2 ? (int32_t)u : a->size[axis] - 2;
  *out_part = (float)(u - *out_lower);
  return is_wrapped ? 1.0f : np_smoothstepf((float)(fmin(u, last - u) / (rim_share * last)));
}

static int locate_level(const np_lit_air *a, double z, float *out_part) {
  int level = 0;
  while (level < LEVELS - 2 && z >= a->level_m[level + 1]) level++;
  const double part = (z - a->level_m[level]) / (a->level_m[level + 1] - a->level_m[level]);
  *out_part = (float)np_clamp(part, 0.0, 1.0);
  return level;
}

np_lit_air_value np_lit_air_get(const np_lit_air *a, np_dvec3 position) {
  int32_t lower[2];
  float w[3];
  const float rim = locate(a, 0, position.x, &lower[0], &w[0]) * locate(a, 1, position.y, &lower[1], &w[1]);
  const int level = locate_level(a, position.z, &w[2]);
  np_lit_air_value out = {np_spectrum_grey(0.0f), np_spectrum_grey(0.0f)};
  for (int corner = 0; corner < 8 && rim > 0.0f; corner++) {
    const int n[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
    float weight = rim;
    for (int k = 0; k < 3; k++) weight *= n[k] ? w[k] : 1.0f - w[k];
    const size_t row = (size_t)(level + n[2]) * (size_t)a->size[1] + (size_t)(lower[1] + n[1]);
    const np_lit_air_value *near = &a->points[row * (size_t)a->size[0] + (size_t)(lower[0] + n[0])];
    out.upper = np_spectrum_add_scaled(out.upper, weight, near->upper);
    out.lower = np_spectrum_add_scaled(out.lower, weight, near->lower);
  }
  return out;
}
