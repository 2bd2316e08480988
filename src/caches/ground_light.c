/* SPDX-License-Identifier: Apache-2.0 */
/* Light on the ground under clouds, gathered from the solution of the multiple scattering (cloud_gather.h).
 *
 * With the directions of one cosine-weighted set, the same at every point, so that neighbours differ by what they see
 * alone, and, where there is emission, rays towards it (fire_rays.h). Hills end the rays that meet them; a slope sees
 * its share of everything.
 */
#include "caches/ground_light.h"

#include <string.h>

#include "caches/fire_rays.h"
#include "caches/tile_points.h"
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

static np_fire_rays get_fire_rays(const ground_fill *f) { return (np_fire_rays){f->gather, TO_EMISSION, TO_BOX}; }

/* Weight of a direction's light beside the rays towards fires. */
static float weigh(const ground_fill *f, np_dvec3 position, np_vec3 towards) {
  const np_fire_rays rays = get_fire_rays(f);
  return np_fire_rays_weigh(&rays, position, towards, (double)towards.z * (DIRECTIONS / NP_PI));
}

/* Offset of the i-th direction's steps. */
static double get_offset(unsigned i) { return fmod(0.5 + 0.6180339887498949 * i, 1.0); }

/* Marches the i-th direction of a set, up to the ground if hills block the ray. */
static np_cloud_view follow(const ground_fill *f, const np_cloud_direction *d, np_dvec3 position, unsigned i,
                            np_ground_hit *out_hill, double *out_end_m) {
  const np_world *world = f->gather->world;
  *out_end_m = world->terrain ? np_cloud_gather_find_ground(f->gather, position, d->towards, out_hill) : HUGE_VAL;
  return np_cloud_gather_follow(f->gather, d, position,
                                &(np_cloud_steps){f->step_m, get_offset(i), *out_end_m, STEPS_MAX});
}

/* Radiances along the even set, summed: of the clear sky, what is left of it, and what the clouds add; behind hills
 * there is no sky, and clouds before them hide their light. */
typedef struct ground_sums {
  np_spectrum clear, seen, added, emitted;
  np_spectrum clear_linear[2],
      linear[2]; /* first moments along x and y of the radiances `clear`, and `seen` and `added` */
  float open;
} ground_sums;

static void add_linear(np_spectrum sums[2], np_vec3 towards, np_spectrum light) {
  sums[0] = np_spectrum_add_scaled(sums[0], towards.x / towards.z, light);
  sums[1] = np_spectrum_add_scaled(sums[1], towards.y / towards.z, light);
}

/* Adds light along the rays towards fires, attenuated by the air. */
static void gather_fires(const ground_fill *f, np_dvec3 position, ground_sums *sums) {
  const np_fire_rays rays = get_fire_rays(f);
  np_cloud_direction d;
  np_ground_hit hill;
  np_vec3 towards;
  double end_m;
  for (unsigned i = 0; np_fire_rays_aim(&rays, position, i, &towards); i++) {
    if (!(towards.z > 0.0f)) continue;
    np_cloud_gather_aim(f->gather, towards, &d);
    const np_cloud_view view = follow(f, &d, position, i, &hill, &end_m);
    const np_spectrum passed = np_spectrum_scale(
        np_gather_air_estimate(f->gather, position, towards, (double)view.middle_m), weigh(f, position, towards));
    sums->added = np_spectrum_add(sums->added, np_spectrum_multiply(passed, view.light));
    sums->emitted = np_spectrum_add(sums->emitted, np_spectrum_multiply(passed, view.emitted));
  }
}

static void gather_along(const ground_fill *f, np_dvec3 position, unsigned i, np_gather_ray *out_ray,
                         ground_sums *sums) {
  const np_ground_direction *d = &f->rays->directions[i];
  const np_vec3 towards = d->gather.towards;
  np_ground_hit hill;
  double end_m;
  const np_cloud_view view = follow(f, &d->gather, position, i, &hill, &end_m);
  *out_ray = (np_gather_ray){{0}, view.transmittance, view.middle_m, (float)end_m};
  const float weight = weigh(f, position, towards);
  np_spectrum added = np_spectrum_scale(np_gather_air_dim(&d->air, out_ray, view.light), weight), seen = {{0}};
  if (isfinite(end_m)) {
    if (view.transmittance < 1.0f)
      added = np_spectrum_add_scaled(added, view.transmittance - 1.0f,
                                     np_gather_air_dim(&d->air, out_ray, np_cloud_gather_light_hill(f->gather, &hill)));
  } else {
    const np_spectrum change = np_gather_air_change(f->gather, &d->air, towards, position, out_ray, get_offset(i));
    seen = np_spectrum_add(d->air.clear, change);
    sums->open += view.transmittance;
    sums->clear = np_spectrum_add(sums->clear, d->air.clear);
    add_linear(sums->clear_linear, towards, d->air.clear);
  }
  sums->seen = np_spectrum_add(sums->seen, seen);
  sums->added = np_spectrum_add(sums->added, added);
  sums->emitted = np_spectrum_add_scaled(sums->emitted, weight, np_gather_air_dim(&d->air, out_ray, view.emitted));
  add_linear(sums->linear, towards, np_spectrum_add(seen, added));
}

static np_ground_light_value gather_at(const ground_fill *f, np_dvec3 position, np_gather_ray *rays) {
  ground_sums sums = {.open = 0.0f};
  np_ground_light_value out;
  for (unsigned i = 0; i < DIRECTIONS; i++) gather_along(f, position, i, &rays[i], &sums);
  if (f->gather->world->emission) gather_fires(f, position, &sums);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    out.added.band[b] = fmaxf(0.0f, sums.added.band[b]) * NP_PI_F / DIRECTIONS;
    out.emitted.band[b] = sums.emitted.band[b] * NP_PI_F / DIRECTIONS;
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
  for (size_t n = begin; n < end; n++) {
    const np_dvec3 place = np_ground_light_get_place(f->cache, f->gather, n);
    if (np_tile_meets_point(&f->cache->fold, place, f->cache->spacing_m))
      f->cache->points[n] = gather_at(f, place, &f->rays->at[n * DIRECTIONS]);
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
  const double beyond = g->fold.period_m > 0.0 ? 0.0 : 2.0 * reach;
  double width[2] = {high.x - low.x + beyond, high.y - low.y + beyond};
  c->fold = g->fold;
  for (int a = 0; a < 2; a++) {
    c->period[a] = g->period[a];
    if (c->period[a].length_m > 0.0) width[a] = c->period[a].length_m;
  }
  const double wanted = fmax((low.z - ground) / 3.0, reach / 24.0);
  c->spacing_m = fmax(wanted, fmax(width[0], width[1]) / (POINTS_MAX - 1));
  if (g->is_coarse) c->spacing_m *= 2.0;
  for (int a = 0; a < 2; a++) {
    c->size[a] = (int32_t)ceil(width[a] / c->spacing_m) + 1;
    c->origin_m[a] = c->period[a].length_m > 0.0 ? low_m[a] : middle[a] - 0.5 * (c->size[a] - 1) * c->spacing_m;
  }
}

/* Steps through clouds, in voxels: two are 0.7 % too bright below a deck of seven voxels, and enough for a draft. */
static const double step_voxels = 1.0, step_voxels_coarse = 2.0;

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
  const double step = gather->is_coarse ? step_voxels_coarse : step_voxels;
  ground_fill f = {gather, step * np_cloud_gather_compute_voxel(gather->world), out, out_rays};
  memcpy(out->fade, gather->fade, sizeof out->fade);
  place(gather, out);
  out->is_of_fire = gather->world->emission != NULL;
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
  const uint64_t is_of_fire = cache->is_of_fire;
  NP_CACHE_WRITE(entry, cache->size);
  NP_CACHE_WRITE(entry, is_of_fire);
  NP_CACHE_WRITE(entry, cache->origin_m);
  NP_CACHE_WRITE(entry, cache->spacing_m);
  NP_CACHE_WRITE(entry, cache->period);
  NP_CACHE_WRITE(entry, cache->fold);
  NP_CACHE_WRITE(entry, cache->fade);
  np_cache_write(entry, cache->points, np_ground_light_count_points(cache) * sizeof *cache->points);
}

/* Whether a loaded cache is valid: a look-up needs two points along each axis. */
static bool is_sound(const np_ground_light *cache) {
  for (int a = 0; a < 2; a++)
    if (cache->size[a] < 2 || cache->size[a] > POINTS_MAX + 1 || !isfinite(cache->origin_m[a]) ||
        !np_light_period_is_sound(cache->period[a]))
      return false;
  return cache->spacing_m > 0.0 && isfinite(cache->spacing_m) && np_tile_is_sound(&cache->fold) &&
         np_cache_are_finite(cache->fade, NP_INSTANCES_MAX);
}

bool np_ground_light_load(neph_context *context, np_cache_entry *entry, np_ground_light *out) {
  uint64_t is_of_fire;
  *out = (np_ground_light){.context = context};
  if (!NP_CACHE_READ(entry, out->size) || !NP_CACHE_READ(entry, is_of_fire) || !NP_CACHE_READ(entry, out->origin_m) ||
      !NP_CACHE_READ(entry, out->spacing_m) || !NP_CACHE_READ(entry, out->period) || !NP_CACHE_READ(entry, out->fold) ||
      !NP_CACHE_READ(entry, out->fade))
    return false;
  if (!np_cache_read_check(entry, is_of_fire <= 1 && is_sound(out))) return false;
  out->is_of_fire = is_of_fire;
  out->points = np_cache_read_block(entry, np_ground_light_count_points(out), sizeof *out->points);
  return out->points;
}

/* Share of a fire's light on the grid's rim that is left at a position beyond it. */
static float compute_left(const np_ground_light *c, const double position[2]) {
  double near2 = 0.0, far2 = 0.0;
  for (int a = 0; a < 2; a++) {
    const double half_m = 0.5 * c->spacing_m * (c->size[a] - 1), away = position[a] - c->origin_m[a] - half_m,
                 on_rim = np_clamp(away, -half_m, half_m);
    near2 += on_rim * on_rim;
    far2 += away * away;
  }
  return far2 > near2 ? (float)(near2 / far2) : 1.0f;
}

np_ground_light_value np_ground_light_get(const np_ground_light *c, np_dvec3 position) {
  const bool is_folded = c->fold.period_m > 0.0;
  if (is_folded) position = np_transport_fold_match(&c->fold, position);
  const double p[2] = {position.x, position.y};
  int32_t lower[2];
  float w[2], rim = 1.0f;
  for (int a = 0; a < 2; a++) {
    const bool is_wrapped = c->period[a].length_m > 0.0;
    const double at = np_light_period_match(c->period[a], p[a]) - c->origin_m[a];
    const double last = c->size[a] - 1, u = np_clamp(at / c->spacing_m, 0.0, last);
    lower[a] = (int32_t)u < c->size[a] - 2 ? (int32_t)u : c->size[a] - 2;
    w[a] = (float)(u - lower[a]);
    if (!is_wrapped && !is_folded) rim *= np_smoothstepf((float)(fmin(u, last - u) / (0.15 * last)));
  }
  const float added = c->is_of_fire ? compute_left(c, p) : rim;
  np_ground_light_value out = {.open = np_spectrum_grey(1.0f - rim)};
  for (int corner = 0; corner < 4; corner++) {
    const int i = corner & 1, j = corner >> 1;
    const float weight = (i ? w[0] : 1.0f - w[0]) * (j ? w[1] : 1.0f - w[1]);
    const np_ground_light_value *near =
        &c->points[(size_t)(lower[1] + j) * (size_t)c->size[0] + (size_t)(lower[0] + i)];
    out.open = np_spectrum_add_scaled(out.open, rim * weight, near->open);
    out.added = np_spectrum_add_scaled(out.added, added * weight, near->added);
    out.emitted = np_spectrum_add_scaled(out.emitted, added * weight, near->emitted);
    for (int a = 0; a < 2; a++) out.linear[a] = np_spectrum_add_scaled(out.linear[a], added * weight, near->linear[a]);
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
