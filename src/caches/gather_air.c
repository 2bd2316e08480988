/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/gather_air.h"

#include "core/units.h"

enum { CELLS = NP_GATHER_AIR_CELLS };

/* Air farther off is in the sun. */
static const double reach_m = 40e3;

static double compute_cell_end(int cell) { return reach_m * cell * cell / (CELLS * CELLS); }

np_vec3 np_gather_air_lean(np_vec3 from, float sine, float angle) {
  const np_vec3 aside = fabsf(from.z) < 0.9f ? np_vec3_make(0.0f, 0.0f, 1.0f) : np_vec3_make(1.0f, 0.0f, 0.0f);
  const np_vec3 first = np_vec3_normalize(np_vec3_cross(from, aside)), second = np_vec3_cross(from, first);
  const np_vec3 away = np_vec3_add(np_vec3_scale(first, cosf(angle)), np_vec3_scale(second, sinf(angle)));
  return np_vec3_normalize(np_vec3_add(from, np_vec3_scale(away, sine)));
}

/* ---- Clear air ---- */

np_spectrum np_gather_air_light_ground(const np_world *world, const np_ground_hit *hit) {
  const np_spectrum sun = np_world_sunlight(world, hit->position, world->to_sun);
  const float up = np_vec3_dot(np_zenith(hit->position, world->planet_radius_m), world->to_sun);
  const np_spectrum level = np_spectrum_add_scaled(np_world_level_irradiance(world, hit), np_maxf(up, 0.0f), sun);
  return np_spectrum_scale(np_spectrum_multiply(level, hit->albedo), 1.0f / NP_PI_F);
}

void np_gather_air_trace(const np_cloud_gather *g, np_dvec3 from, np_vec3 towards, np_gather_air *out) {
  const np_world *world = g->world;
  const neph_sky *sky = world->cloud_sky;
  const np_air_parts none = {.transmittance = np_spectrum_grey(1.0f)};
  np_ground_hit hit;
  const bool has_hit = np_world_intersect_ground(world, from, towards, &hit);
  np_hemisphere_shares shares = {none.first, none.first};
  if (sky) shares = np_sky_compute_hemisphere_shares(sky, towards);
  double ends[CELLS];
  for (int c = 0; c < CELLS; c++) {
    ends[c] = has_hit ? fmin(compute_cell_end(c + 1), hit.distance_m) : compute_cell_end(c + 1);
    out->up_to[c + 1] = none;
  }
  out->up_to[0] = none;
  if (sky) np_sky_trace_parts(sky, from, towards, ends, CELLS, &shares, &out->up_to[1]);
  if (!has_hit) {
    const np_spectrum whole = sky ? np_sky_trace_air(sky, from, towards, INFINITY).inscatter : none.all;
    out->clear = np_world_add_beyond(world, from, towards, whole);
    return;
  }
  const np_aerial_perspective air = np_world_air(world, NULL, from, towards, hit.distance_m);
  const np_spectrum light = sky ? np_sky_trace_air(sky, from, towards, hit.distance_m).inscatter : none.all;
  out->clear = np_spectrum_add(np_spectrum_multiply(np_gather_air_light_ground(world, &hit), air.transmittance), light);
}

/* Clear air up to a distance, between the ends of cells: transmittance, what is scattered straight on as not scattered,
 * and light of all orders. */
typedef struct clear_air {
  np_spectrum transmittance, passed, light;
} clear_air;

static clear_air interpolate(const np_gather_air *a, double distance_m) {
  int c = 0;
  while (c < CELLS - 1 && compute_cell_end(c + 1) < distance_m) c++;
  const double near = compute_cell_end(c), far = compute_cell_end(c + 1);
  const float part = (float)np_clamp((distance_m - near) / (far - near), 0.0, 1.0);
  const np_air_parts *before = &a->up_to[c], *behind = before + 1;
  clear_air out = {np_spectrum_mix(before->transmittance, behind->transmittance, part),
                   {{0.0f}},
                   np_spectrum_mix(before->all, behind->all, part)};
  const np_spectrum straight = np_spectrum_mix(before->straight, behind->straight, part);
  for (int b = 0; b < NP_BAND_COUNT; b++) out.passed.band[b] = expf(straight.band[b]);
  return out;
}

/* ---- A ray ---- */

np_spectrum np_gather_air_dim(const np_gather_air *air, const np_gather_ray *ray, np_spectrum light) {
  const clear_air before = interpolate(air, (double)ray->cloud_m);
  return np_spectrum_multiply(light, np_spectrum_multiply(before.transmittance, before.passed));
}

np_spectrum np_gather_air_estimate(const np_cloud_gather *g, np_dvec3 origin, np_vec3 towards, double cloud_m) {
  const neph_atmosphere *air = g->world->atmosphere;
  if (!air) return np_spectrum_grey(1.0f);
  return np_air_cell_get_passed(air, np_dvec3_along(origin, towards, 0.5 * cloud_m), cloud_m);
}

bool np_gather_air_get_cell(const np_gather_ray *ray, int cell, double offset, float *out_share, double *out_place) {
  const double near = compute_cell_end(cell), whole = compute_cell_end(cell + 1) - near;
  const double far = fmin(near + whole, (double)ray->end_m);
  if (cell >= CELLS || !(near < far)) return false;
  *out_place = near + offset * (far - near);
  *out_share = (float)((far - near) / whole) * (*out_place < (double)ray->cloud_m ? 1.0f : ray->transmittance);
  return true;
}

static float compute_shade(const np_cloud_gather *g, np_dvec3 place) {
  const np_vec3 to_sun = g->world->to_sun;
  if (np_world_is_behind_terrain(g->world, place, to_sun)) return 1.0f;
  return np_opacity(np_sun_optical_depths_get_scaled(g->depths, place, to_sun, g->fade, 16.0f));
}

/* Clear light that clouds or a hill hide. */
static np_spectrum hide(const np_gather_air *a, const np_gather_ray *ray) {
  const clear_air before = interpolate(a, (double)ray->cloud_m);
  const np_spectrum hidden = np_spectrum_multiply(np_spectrum_subtract(a->clear, before.light), before.passed);
  return np_spectrum_scale(hidden, ray->transmittance - 1.0f);
}

np_spectrum np_gather_air_change(const np_cloud_gather *g, const np_gather_air *a, np_vec3 towards, np_dvec3 origin,
                                 const np_gather_ray *ray, double offset) {
  np_spectrum out = hide(a, ray);
  float share;
  double place;
  for (int c = 0; np_gather_air_get_cell(ray, c, offset, &share, &place); c++) {
    const np_spectrum first = np_spectrum_subtract(a->up_to[c + 1].first, a->up_to[c].first);
    if (np_spectrum_is_zero(first)) continue;
    const np_spectrum passed = interpolate(a, place).passed;
    out = np_spectrum_add_scaled(out, -share * compute_shade(g, np_dvec3_along(origin, towards, place)),
                                 np_spectrum_multiply(first, passed));
  }
  return out;
}

np_spectrum np_gather_air_change_by_hills(const np_cloud_gather *g, const np_gather_air *a, np_vec3 towards,
                                          np_dvec3 origin, double offset, bool is_shade_known, np_gather_ray *ray,
                                          np_spectrum *out_shine) {
  np_ground_hit hill;
  const double end_m = np_cloud_gather_find_ground(g, origin, towards, &hill);
  const bool is_hidden = end_m < reach_m;
  ray->end_m = is_hidden ? (float)end_m : INFINITY;
  ray->cloud_m = is_hidden ? (float)end_m : 0.0f;
  ray->transmittance = is_hidden ? 0.0f : 1.0f;
  *out_shine = is_hidden ? np_gather_air_dim(a, ray, np_cloud_gather_light_hill(g, &hill)) : np_spectrum_grey(0.0f);
  return is_shade_known ? hide(a, ray) : np_gather_air_change(g, a, towards, origin, ray, offset);
}
