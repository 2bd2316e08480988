/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/lit_air.h"

#include <string.h>

#include "atmosphere/atmosphere_private.h"
#include "atmosphere/sky_along.h"
#include "caches/fire_rays.h"
#include "caches/tile_points.h"
#include "core/alloc.h"
#include "core/units.h"

enum {
  DIRECTIONS = 64,
  DIRECTIONS_COARSE = 32,
  TO_EMISSION = 16,
  TO_BOX = 16,
  STEPS_MAX = 64,
  TRIES = 4,
  LEVELS = NP_LIT_AIR_LEVELS
};

/* Number of further orders of scattering in the air. In haze of optical depth 1 each order has about a third of the
 * light of the order before. */
enum { PASSES = 3 };

/* Distance from the clouds, in heights of their tops above the ground, beyond which the air is clear. */
static const double reach_heights = 1.0, fire_reach_heights = 12.0;
/* Steps through clouds, in voxels. */
static const double step_voxels = 2.0;
/* Part of the way to the rim over which the change fades out. */
static const double rim_share = 0.15;
/* Powers of the distance by which light of fires falls off beyond the lattice; 2: in vacuum, of a point. */
static const float fall_min = 1.5f, fall_max = 5.0f;
static const double clearance_m = 1.0; /* least height of places above the ground */

/* Heights of the upper levels above the clouds' tops, in reaches. */
static const double above[] = {0.0, 0.25, 1.0};
enum { ABOVE = sizeof above / sizeof above[0] };

/* A direction, and the clear air along it from each level. */
typedef struct even_direction {
  np_cloud_direction gather;
  np_gather_air air[LEVELS];
} even_direction;

typedef struct air_fill {
  const np_cloud_gather *gather;
  const np_cloud_gather *clear;        /* gather without hills, whose change is sought; NULL: that of clouds is */
  const np_ground_light *ground_light; /* NULL among hills */
  bool is_shade_known;                 /* the shade of hills is part of another lattice */
  unsigned direction_count;
  double step_m;
  np_lit_air *out;
  even_direction *directions;
  np_gather_ray *rays;     /* [point][direction] */
  np_lit_air_value *first; /* change without the air's own */
  np_lit_air_value *next;  /* points of the next pass */
} air_fill;

/* ---- The lattice ---- */

double np_lit_air_get_reach(double height_m, bool is_of_fire) {
  return (is_of_fire ? fire_reach_heights : reach_heights) * fmax(height_m, 1.0);
}

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
  const double reach = np_lit_air_get_reach(high.z - ground, false);
  const double low_m[2] = {low.x, low.y};
  const double beyond = g->fold.period_m > 0.0 ? 0.0 : 2.0 * reach;
  double width[2] = {high.x - low.x + beyond, high.y - low.y + beyond};
  a->fold = g->fold;
  for (int n = 0; n < 2; n++) {
    a->period[n] = g->period[n];
    if (a->period[n].length_m > 0.0) width[n] = a->period[n].length_m;
  }
  a->spacing_m = fmax(width[0], width[1]) / (NP_LIT_AIR_POINTS_MAX - 1);
  if (g->is_coarse) a->spacing_m *= 2.0;
  for (int n = 0; n < 2; n++) {
    a->size[n] = (int32_t)fmax(ceil(width[n] / a->spacing_m), 1.0) + 1;
    a->origin_m[n] = a->period[n].length_m > 0.0 ? low_m[n] : middle[n] - 0.5 * (a->size[n] - 1) * a->spacing_m;
  }
  place_levels(a, ground, high.z, reach);
}

/* ---- Light at a place ---- */

/* Change of the ground's radiance by the clouds. */
static np_spectrum compute_ground_change(const air_fill *f, const np_ground_hit *hit) {
  const np_world *world = f->gather->world;
  const np_ground_light_value light = np_ground_light_get(f->ground_light, hit->position);
  const np_spectrum sky = np_world_level_irradiance(world, hit);
  np_spectrum change = np_spectrum_add(light.added, light.emitted);
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
  if (np_world_may_meet_ground(f->gather->world, at, np_dvec3_make(at.x, at.y, at.z - clearance_m)))
    at.z = fmax(at.z, np_cloud_gather_ground(f->gather, at.x, at.y).z + clearance_m);
  return at;
}

/* The n-th point of a set that fills a cell evenly (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
 * Sequences"). */
static np_dvec3 get_offset(unsigned n) {
  return np_dvec3_make(fmod(0.8191725133961645 * n, 1.0) - 0.5, fmod(0.6710436067037893 * n, 1.0) - 0.5,
                       fmod(0.5497004779019703 * n, 1.0) - 0.5);
}

/* Chooses the origin of a ray in a point's cell: outside of the clouds, if one of a few random places is. */
static np_dvec3 choose_origin(const air_fill *f, np_dvec3 point, int level, unsigned direction) {
  np_dvec3 at = point;
  for (unsigned n = 0; n < TRIES; n++) {
    float extinction[NP_INSTANCES_MAX];
    at = choose_place(f, point, level, get_offset(direction + n * f->direction_count));
    if (!(np_cloud_gather_extinction(f->gather, at, extinction) > 0.0f)) break;
  }
  return at;
}

/* Offset of a direction's steps and places. */
static double get_shift(unsigned direction) { return fmod(0.5 + 0.6180339887498949 * direction, 1.0); }

/* Light of burning clouds at a place: actinic flux, and the sum of its directions. */
typedef struct fire_flux {
  np_spectrum flux;
  np_vec3 way;
} fire_flux;

static void add_fire(const air_fill *f, np_vec3 towards, np_spectrum radiance, fire_flux *sum) {
  const np_spectrum flux = np_spectrum_scale(radiance, 4.0f * NP_PI_F / (float)f->direction_count);
  sum->flux = np_spectrum_add(sum->flux, flux);
  sum->way = np_vec3_add(sum->way, np_vec3_scale(towards, np_spectrum_mean(flux)));
}

static void set_beam(const fire_flux *fires, np_lit_air_value *out) {
  const float all = np_spectrum_mean(fires->flux);
  out->beam = fires->flux;
  out->way = all > 0.0f ? np_vec3_scale(fires->way, 1.0f / all) : fires->way;
}

static np_fire_rays get_fire_rays(const air_fill *f) { return (np_fire_rays){f->gather, TO_EMISSION, TO_BOX}; }

/* Weight of a direction's light beside the rays towards fires. */
static float weigh(const air_fill *f, np_dvec3 position, np_vec3 towards) {
  const np_fire_rays rays = get_fire_rays(f);
  return np_fire_rays_weigh(&rays, position, towards, f->direction_count / (4.0 * NP_PI));
}

/* Change of the radiance along a direction: clear light that is lost, 0 or less, and other light. */
typedef struct radiance_change {
  np_spectrum lost, other;
} radiance_change;

/* Change of the radiance along a direction by clouds and their shadows, but for light that goes to `fires`. Clouds and
 * ground that the ray meets are stored. */
static radiance_change compute_change(const air_fill *f, unsigned direction, np_dvec3 point, int level,
                                      np_gather_ray *out_ray, fire_flux *fires) {
  const np_cloud_gather *g = f->gather;
  const even_direction *d = &f->directions[direction];
  const np_gather_air *air = &d->air[level];
  const np_vec3 towards = d->gather.towards;
  const np_dvec3 origin = choose_origin(f, point, level, direction);
  np_ground_hit hit;
  const double end_m = np_cloud_gather_find_ground(g, origin, towards, &hit);
  const np_cloud_view view = np_cloud_gather_follow(
      g, &d->gather, origin, &(np_cloud_steps){f->step_m, get_shift(direction), end_m, STEPS_MAX});
  *out_ray = (np_gather_ray){np_dvec3_to_float(np_dvec3_subtract(origin, point)), view.transmittance, view.middle_m,
                             (float)end_m};
  const np_spectrum all = np_spectrum_add(view.light, view.emitted),
                    light = np_spectrum_scale(np_gather_air_dim(air, out_ray, all), weigh(f, origin, towards));
  radiance_change change = {np_gather_air_change(g, air, towards, origin, out_ray, get_shift(direction)), {{0.0f}}};
  if (g->world->emission)
    add_fire(f, towards, light, fires);
  else
    change.other = light;
  if (!isfinite(end_m)) return change;
  const np_gather_ray to_ground = {.cloud_m = (float)end_m};
  const np_spectrum ground = np_gather_air_dim(air, &to_ground, compute_ground_change(f, &hit));
  change.other = np_spectrum_add_scaled(change.other, view.transmittance, ground);
  return change;
}

/* Change of the radiance along a direction by hills, which are stored. */
static radiance_change compute_change_by_hills(const air_fill *f, unsigned direction, np_dvec3 point, int level,
                                               np_gather_ray *out_ray) {
  const even_direction *d = &f->directions[direction];
  const np_dvec3 origin = choose_origin(f, point, level, direction);
  out_ray->offset = np_dvec3_to_float(np_dvec3_subtract(origin, point));
  radiance_change change;
  change.lost = np_gather_air_change_by_hills(f->gather, &d->air[level], d->gather.towards, origin,
                                              get_shift(direction), f->is_shade_known, out_ray, &change.other);
  return change;
}

/* Directions around the sun, and sine of the largest angle to it: twice that by which haze scatters nearly straight on,
 * since low light is scattered several times. */
enum { AROUND_SUN = 32 };
static const float around_sun_sine = 0.5f;

/* Share of the directions around the sun in which hills hide the sky; those below the horizon do not count. */
static float compute_sun_hidden(const air_fill *f, np_dvec3 point, int level) {
  const np_vec3 to_sun = f->gather->world->to_sun;
  int open = 0, hidden = 0;
  for (unsigned i = 0; i < AROUND_SUN; i++) {
    const float sine = around_sun_sine * ((float)i + 0.5f) / AROUND_SUN, angle = 2.3999632f * (float)i;
    const np_vec3 towards = np_gather_air_lean(to_sun, sine, angle);
    if (!(towards.z > 0.0f)) continue;
    const np_dvec3 origin = choose_origin(f, point, level, i);
    const bool is_hidden = isfinite(np_world_find_ground(f->gather->world, origin, towards, NULL));
    hidden += is_hidden;
    open += !is_hidden;
  }
  return hidden > 0 ? (float)hidden / (float)(hidden + open) : 0.0f;
}

/* Adds a direction's share of the actinic flux. */
static void add_flux(const air_fill *f, np_vec3 towards, radiance_change radiance, np_lit_air_value *sum) {
  const float share = 4.0f * NP_PI_F / (float)f->direction_count;
  const np_spectrum all = np_spectrum_add(radiance.lost, radiance.other);
  np_spectrum *half = towards.z > 0.0f ? &sum->upper : &sum->lower;
  *half = np_spectrum_add_scaled(*half, share, all);
  if (towards.z > 0.0f) sum->hidden = np_spectrum_add_scaled(sum->hidden, share, radiance.lost);
}

/* Traces the i-th ray towards fires from a place; false past the last. */
static bool trace_fire(const air_fill *f, np_dvec3 origin, unsigned i, np_vec3 *out_towards, np_spectrum *out_light) {
  const np_cloud_gather *g = f->gather;
  const np_fire_rays rays = get_fire_rays(f);
  np_cloud_direction d;
  np_ground_hit hit;
  *out_light = np_spectrum_grey(0.0f);
  if (!np_fire_rays_aim(&rays, origin, i, out_towards)) return false;
  if (np_vec3_length(*out_towards) == 0.0f) return true;
  np_cloud_gather_aim(g, *out_towards, &d);
  const double end_m = np_cloud_gather_find_ground(g, origin, *out_towards, &hit);
  const np_cloud_view view =
      np_cloud_gather_follow(g, &d, origin, &(np_cloud_steps){f->step_m, get_shift(i), end_m, STEPS_MAX});
  const np_spectrum passed = np_gather_air_estimate(g, origin, *out_towards, (double)view.middle_m);
  *out_light = np_spectrum_multiply(passed, np_spectrum_add(view.light, view.emitted));
  return true;
}

/* Adds the flux along the rays towards fires. */
static void add_fires(const air_fill *f, np_dvec3 point, int level, fire_flux *fires) {
  for (unsigned i = 0;; i++) {
    const np_dvec3 origin = choose_origin(f, point, level, i);
    np_vec3 towards;
    np_spectrum light;
    if (!trace_fire(f, origin, i, &towards, &light)) return;
    if (np_spectrum_is_zero(light)) continue;
    add_fire(f, towards, np_spectrum_scale(light, weigh(f, origin, towards)), fires);
  }
}

/* Place of a point of the lattice. */
static np_dvec3 get_point(const np_lit_air *a, size_t n, int *out_level) {
  const size_t width = (size_t)a->size[0], height = (size_t)a->size[1];
  *out_level = (int)(n / (width * height));
  return np_dvec3_make(a->origin_m[0] + a->spacing_m * (double)(n % width),
                       a->origin_m[1] + a->spacing_m * (double)(n / width % height), a->level_m[*out_level]);
}

/* Number of directions of a point; 0: look-ups do not meet it. */
static unsigned count_directions(const air_fill *f, np_dvec3 point) {
  return np_tile_meets_point(&f->out->fold, point, f->out->spacing_m) ? f->direction_count : 0;
}

static neph_result gather_points(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const air_fill *f = user;
  for (size_t n = begin; n < end; n++) {
    int level;
    const np_dvec3 point = get_point(f->out, n, &level);
    np_lit_air_value sum = {.way = {0}};
    fire_flux fires = {.way = {0}};
    const unsigned count = count_directions(f, point);
    for (unsigned i = 0; i < count; i++) {
      np_gather_ray *ray = &f->rays[n * f->direction_count + i];
      const radiance_change change =
          f->clear ? compute_change_by_hills(f, i, point, level, ray) : compute_change(f, i, point, level, ray, &fires);
      add_flux(f, f->directions[i].gather.towards, change, &sum);
    }
    if (f->clear && count > 0) sum.sun_hidden = compute_sun_hidden(f, point, level);
    if (f->gather->world->emission) {
      add_fires(f, point, level, &fires);
      set_beam(&fires, &sum);
    }
    f->first[n] = f->out->points[n] = sum;
  }
  return NEPH_OK;
}

/* Change of the air's light along a ray by the lattice's change of its light. */
static radiance_change scatter_along(const np_lit_air *light, const np_gather_air *air, np_vec3 towards, np_dvec3 point,
                                     const np_gather_ray *ray, double offset) {
  const np_dvec3 origin = np_dvec3_add(point, np_vec3_to_double(ray->offset));
  radiance_change out = {{{0.0f}}, {{0.0f}}};
  float share;
  double place;
  for (int c = 0; np_gather_air_get_cell(ray, c, offset, &share, &place); c++) {
    const np_lit_air_value change = np_lit_air_get(light, np_dvec3_along(origin, towards, place));
    const np_spectrum upper = np_spectrum_subtract(air->up_to[c + 1].turned_upper, air->up_to[c].turned_upper),
                      lower = np_spectrum_subtract(air->up_to[c + 1].turned_lower, air->up_to[c].turned_lower);
    const float up = 0.5f + 0.5f * change.way.z; /* the beam's share from above, as that of light spread around it */
    const np_spectrum other = np_spectrum_subtract(change.upper, change.hidden);
    const np_spectrum from_above = np_spectrum_add_scaled(other, up, change.beam),
                      from_below = np_spectrum_add_scaled(change.lower, 1.0f - up, change.beam);
    out.lost = np_spectrum_add_scaled(out.lost, share, np_spectrum_multiply(upper, change.hidden));
    out.other = np_spectrum_add_scaled(out.other, share, np_spectrum_multiply(upper, from_above));
    out.other = np_spectrum_add_scaled(out.other, share, np_spectrum_multiply(lower, from_below));
  }
  return out;
}

np_spectrum np_lit_air_along(const np_lit_air *light, const np_gather_air *air, np_vec3 towards, np_dvec3 point,
                             const np_gather_ray *ray, double offset) {
  const radiance_change change = scatter_along(light, air, towards, point, ray, offset);
  return np_spectrum_add(change.lost, change.other);
}

/* Adds one order of scattering in the air to the change by the clouds. */
static neph_result scatter_points(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const air_fill *f = user;
  for (size_t n = begin; n < end; n++) {
    int level;
    const np_dvec3 point = get_point(f->out, n, &level);
    f->next[n] = f->first[n];
    const unsigned count = count_directions(f, point);
    for (unsigned i = 0; i < count; i++) {
      const even_direction *d = &f->directions[i];
      add_flux(f, d->gather.towards,
               scatter_along(f->out, &d->air[level], d->gather.towards, point, &f->rays[n * f->direction_count + i],
                             get_shift(i)),
               &f->next[n]);
    }
  }
  return NEPH_OK;
}

/* Directions spread evenly over the sphere, and their air, from the middle of the lattice. */
static neph_result aim_directions(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const air_fill *f = user;
  const np_cloud_gather *g = f->gather;
  const double x = 0.5 * (g->bounds_min.x + g->bounds_max.x), y = 0.5 * (g->bounds_min.y + g->bounds_max.y);
  const np_cloud_gather *clear = f->clear ? f->clear : g;
  const double ground = np_cloud_gather_ground(clear, x, y).z + clearance_m;
  for (size_t i = begin; i < end; i++) {
    const double z = 1.0 - (2.0 * (double)i + 1.0) / f->direction_count,
                 azimuth = (double)i * (NP_PI * (3.0 - sqrt(5.0)));
    const float r = (float)sqrt(1.0 - z * z);
    const np_vec3 towards = np_vec3_make(r * (float)cos(azimuth), r * (float)sin(azimuth), (float)z);
    np_cloud_gather_aim(g, towards, &f->directions[i].gather);
    for (int k = 0; k < LEVELS; k++)
      np_gather_air_trace(clear, np_dvec3_make(x, y, fmax(f->out->level_m[k], ground)), towards,
                          &f->directions[i].air[k]);
  }
  return NEPH_OK;
}

/* ---- Beyond the lattice ---- */

/* Mean of places drawn by emission, within the lattice. */
static np_dvec3 find_fire(const air_fill *f) {
  enum { DRAWN = 64 };
  const np_lit_air *a = f->out;
  np_random random = np_random_start(0, 0, 0, 0, 0);
  np_dvec3 sum = np_dvec3_make(0.0, 0.0, 0.0), place;
  for (int i = 0; i < DRAWN; i++)
    if (np_emission_draw(f->gather->world->emission, (i + 0.5) / DRAWN, &random, &place))
      sum = np_dvec3_add(sum, np_dvec3_scale(place, 1.0 / DRAWN));
  const double far_m[2] = {a->spacing_m * (a->size[0] - 1), a->spacing_m * (a->size[1] - 1)};
  return np_dvec3_make(np_clamp(sum.x, a->origin_m[0] + 0.1 * far_m[0], a->origin_m[0] + 0.9 * far_m[0]),
                       np_clamp(sum.y, a->origin_m[1] + 0.1 * far_m[1], a->origin_m[1] + 0.9 * far_m[1]),
                       np_clamp(sum.z, a->level_m[0], a->level_m[LEVELS - 1]));
}

/* Actinic flux from fires at a place, by the rays towards them alone. */
static np_spectrum gather_fires(const air_fill *f, np_dvec3 place) {
  static const double even = 1e-6; /* rays per steradian of an even set: in effect none */
  const np_fire_rays rays = get_fire_rays(f);
  np_vec3 towards;
  np_spectrum sum = np_spectrum_grey(0.0f), light;
  for (unsigned i = 0; trace_fire(f, place, i, &towards, &light); i++)
    if (!np_spectrum_is_zero(light))
      sum = np_spectrum_add_scaled(sum, np_fire_rays_weigh(&rays, place, towards, even), light);
  return sum;
}

/* Share of the way from the fire to a position that lies within the lattice: 1 inside. */
static double compute_inner_share(const np_lit_air *a, np_dvec3 away) {
  const double low[3] = {a->origin_m[0] - a->fire.x, a->origin_m[1] - a->fire.y, a->level_m[0] - a->fire.z},
               high[3] = {low[0] + a->spacing_m * (a->size[0] - 1), low[1] + a->spacing_m * (a->size[1] - 1),
                          a->level_m[LEVELS - 1] - a->fire.z},
               way[3] = {away.x, away.y, away.z};
  double share = 1.0;
  for (int n = 0; n < 3; n++) {
    if (way[n] > high[n]) share = fmin(share, high[n] / way[n]);
    if (way[n] < low[n]) share = fmin(share, low[n] / way[n]);
  }
  return share;
}

/* Compares the light of fires on the lattice's four sides with that three times as far from them. */
static void measure_fall(const air_fill *f) {
  static const double far = 3.0;
  np_lit_air *a = f->out;
  np_spectrum near_light = np_spectrum_grey(0.0f), far_light = near_light;
  for (int side = 0; side < 4; side++) {
    const double way_m = (side & 1 ? 1.0 : -1.0) * a->spacing_m * (a->size[0] + a->size[1]);
    const np_dvec3 away = side & 2 ? np_dvec3_make(0.0, way_m, 0.0) : np_dvec3_make(way_m, 0.0, 0.0);
    const np_dvec3 on_rim = np_dvec3_scale(away, compute_inner_share(a, away));
    near_light = np_spectrum_add(near_light, gather_fires(f, np_dvec3_add(a->fire, on_rim)));
    far_light = np_spectrum_add(far_light, gather_fires(f, np_dvec3_add(a->fire, np_dvec3_scale(on_rim, far))));
  }
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float ratio = far_light.band[b] > 0.0f ? near_light.band[b] / far_light.band[b] : 9.0f;
    a->fall.band[b] = np_clampf(logf(ratio) / logf((float)far), fall_min, fall_max);
  }
}

/* ---- All of it ---- */

/* Sums the clear air's light over the directions, from the lattice's middle. */
static void sum_clear(const air_fill *f) {
  for (int k = 0; k < LEVELS; k++) {
    np_clear_flux *clear = &f->out->clear[k];
    for (unsigned i = 0; i < f->direction_count; i++) {
      np_spectrum *half = f->directions[i].gather.towards.z > 0.0f ? &clear->upper : &clear->lower;
      *half = np_spectrum_add_scaled(*half, 4.0f * NP_PI_F / (float)f->direction_count, f->directions[i].air[k].clear);
    }
  }
}

static neph_result fill_points(neph_context *context, air_fill *f, np_monitor *monitor) {
  const size_t count = np_lit_air_count_points(f->out);
  np_monitor_set_stage(monitor, "lighting the air");
  neph_result result = np_parallel_for(context, monitor, f->direction_count, 1, aim_directions, f);
  if (!result) result = np_parallel_for(context, monitor, count, 8, gather_points, f);
  for (int pass = 0; pass < PASSES && !result; pass++) {
    result = np_parallel_for(context, monitor, count, 8, scatter_points, f);
    np_lit_air_value *points = f->out->points;
    f->out->points = f->next;
    f->next = points;
  }
  if (!result) sum_clear(f);
  if (!result && f->out->is_of_fire) {
    f->out->fire = find_fire(f);
    measure_fall(f);
  }
  return result;
}

/* Places the lattice and fills it. */
static neph_result fill(neph_context *context, air_fill *f, np_monitor *monitor) {
  np_lit_air *out = f->out;
  *out = (np_lit_air){.context = context, .is_of_fire = f->gather->world->emission != NULL};
  place(f->gather, out);
  const size_t count = np_lit_air_count_points(out);
  out->points = np_alloc(context, count, sizeof *out->points);
  f->directions = np_alloc(context, f->direction_count, sizeof *f->directions);
  f->rays = np_alloc(context, count * f->direction_count, sizeof *f->rays);
  f->first = np_alloc(context, count, sizeof *f->first);
  f->next = np_alloc(context, count, sizeof *f->next);
  const bool has_all = out->points && f->directions && f->rays && f->first && f->next;
  const neph_result result = has_all ? fill_points(context, f, monitor) : NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(context, f->next);
  np_alloc_free(context, f->first);
  np_alloc_free(context, f->rays);
  np_alloc_free(context, f->directions);
  if (result) np_lit_air_clear(out);
  return result;
}

neph_result np_lit_air_build(neph_context *context, const np_cloud_gather *gather, const np_ground_light *ground_light,
                             np_monitor *monitor, np_lit_air *out) {
  air_fill f = {.gather = gather,
                .ground_light = ground_light,
                .direction_count = gather->is_coarse ? DIRECTIONS_COARSE : DIRECTIONS,
                .step_m = step_voxels * np_cloud_gather_compute_voxel(gather->world),
                .out = out};
  return fill(context, &f, monitor);
}

neph_result np_lit_air_build_among_hills(neph_context *context, const np_world *world,
                                         const np_sun_optical_depths *depths, const np_hill_reach *reach,
                                         np_monitor *monitor, np_lit_air *out) {
  *out = (np_lit_air){.context = context};
  np_world hilly = *world;
  hilly.cloud_sky = world->camera_sky;
  hilly.emission = NULL; /* the light of fires is that of their clouds */
  np_world bare = hilly;
  bare.terrain = NULL;
  const np_dvec3 low = world->terrain_min, high = world->terrain_max, eye = reach->eye;
  const double begin[2] = {fmax(low.x, eye.x - reach->distance_m), fmax(low.y, eye.y - reach->distance_m)},
               end[2] = {fmin(high.x, eye.x + reach->distance_m), fmin(high.y, eye.y + reach->distance_m)};
  const double rim = rim_share / (1.0 - 2.0 * rim_share); /* the change fades out beside the hills */
  const double wider[2] = {rim * (end[0] - begin[0]), rim * (end[1] - begin[1])};
  if (!(wider[0] > 0.0 && wider[1] > 0.0)) return NEPH_OK;
  const np_cloud_gather hills = {.world = &hilly,
                                 .depths = depths,
                                 .is_coarse = reach->is_coarse,
                                 .bounds_min = {begin[0] - wider[0], begin[1] - wider[1], low.z},
                                 .bounds_max = {end[0] + wider[0], end[1] + wider[1], high.z}};
  np_cloud_gather clear = hills;
  clear.world = &bare;
  air_fill f = {.gather = &hills,
                .clear = &clear,
                .is_shade_known = reach->is_shade_known,
                .direction_count = DIRECTIONS_COARSE,
                .step_m = 1.0,
                .out = out};
  return fill(context, &f, monitor);
}

void np_lit_air_clear(np_lit_air *light) {
  np_alloc_free(light->context, light->points);
  *light = (np_lit_air){0};
}

/* ---- Look-ups ---- */

/* Lower neighbour along a level, and the fraction to the next; returns how much of the change the rim leaves. */
static float locate(const np_lit_air *a, int axis, double x, int32_t *out_lower, float *out_part) {
  const bool is_wrapped = a->period[axis].length_m > 0.0;
  const double last = a->size[axis] - 1,
               u = np_clamp((np_light_period_match(a->period[axis], x) - a->origin_m[axis]) / a->spacing_m, 0.0, last);
  *out_lower = (int32_t)u < a->size[axis] - 2 ? (int32_t)u : a->size[axis] - 2;
  *out_part = (float)(u - *out_lower);
  return is_wrapped || a->fold.period_m > 0.0 ? 1.0f : np_smoothstepf((float)(fmin(u, last - u) / (rim_share * last)));
}

static int locate_level(const np_lit_air *a, double z, float *out_part) {
  int level = 0;
  while (level < LEVELS - 2 && z >= a->level_m[level + 1]) level++;
  const double part = (z - a->level_m[level]) / (a->level_m[level + 1] - a->level_m[level]);
  *out_part = (float)np_clamp(part, 0.0, 1.0);
  return level;
}

np_clear_flux np_lit_air_get_clear(const np_lit_air *a, double height_m) {
  float part;
  const np_clear_flux *below = &a->clear[locate_level(a, height_m, &part)];
  return (np_clear_flux){np_spectrum_mix(below[0].upper, below[1].upper, part),
                         np_spectrum_mix(below[0].lower, below[1].lower, part)};
}

/* Value within the lattice; towards its sides it fades out, but for fires. */
static np_lit_air_value interpolate(const np_lit_air *a, np_dvec3 position) {
  int32_t lower[2];
  float w[3];
  float rim = locate(a, 0, position.x, &lower[0], &w[0]) * locate(a, 1, position.y, &lower[1], &w[1]);
  if (a->is_of_fire) rim = 1.0f;
  const int level = locate_level(a, position.z, &w[2]);
  np_lit_air_value out = {.way = {0}};
  for (int corner = 0; corner < 8 && rim > 0.0f; corner++) {
    const int n[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
    float weight = rim;
    for (int k = 0; k < 3; k++) weight *= n[k] ? w[k] : 1.0f - w[k];
    const size_t row = (size_t)(level + n[2]) * (size_t)a->size[1] + (size_t)(lower[1] + n[1]);
    const np_lit_air_value *near = &a->points[row * (size_t)a->size[0] + (size_t)(lower[0] + n[0])];
    out.upper = np_spectrum_add_scaled(out.upper, weight, near->upper);
    out.hidden = np_spectrum_add_scaled(out.hidden, weight, near->hidden);
    out.lower = np_spectrum_add_scaled(out.lower, weight, near->lower);
    out.beam = np_spectrum_add_scaled(out.beam, weight, near->beam);
    out.sun_hidden += weight * near->sun_hidden;
    out.way = np_vec3_add(out.way, np_vec3_scale(near->way, weight));
  }
  return out;
}

/* Beyond the lattice, the value where the way to the fire enters it, weaker; the farther off, the more its light comes
 * from one direction. */
static np_lit_air_value extrapolate(const np_lit_air *a, np_dvec3 away, double share) {
  const np_lit_air_value rim = interpolate(a, np_dvec3_add(a->fire, np_dvec3_scale(away, share)));
  const float spread = fmaxf(1.0f - np_vec3_length(rim.way), 0.0f) * (float)(share * share);
  np_spectrum left;
  for (int b = 0; b < NP_BAND_COUNT; b++) left.band[b] = powf((float)share, a->fall.band[b]);
  return (np_lit_air_value){.upper = np_spectrum_multiply(left, rim.upper),
                            .hidden = np_spectrum_multiply(left, rim.hidden),
                            .lower = np_spectrum_multiply(left, rim.lower),
                            .beam = np_spectrum_multiply(left, rim.beam),
                            .way = np_vec3_scale(np_vec3_normalize(np_dvec3_to_float(away)), spread - 1.0f)};
}

np_lit_air_value np_lit_air_get(const np_lit_air *a, np_dvec3 position) {
  if (a->fold.period_m > 0.0) position = np_transport_fold_match(&a->fold, position);
  if (!a->is_of_fire) return interpolate(a, position);
  position.z = fmax(position.z, a->level_m[0]);
  const np_dvec3 away = np_dvec3_subtract(position, a->fire);
  const double share = compute_inner_share(a, away);
  return share < 1.0 ? extrapolate(a, away, share) : interpolate(a, position);
}
