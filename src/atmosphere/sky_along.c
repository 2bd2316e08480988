/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/sky_along.h"

#include "atmosphere/atmosphere_tables.h"
#include "atmosphere/ray_warp.h"

/* Cosine of the sun's zenith angle at a ray's entry into the air. */
static float compute_entry_sun(const neph_sky *sky, const np_ray *ray, np_dvec3 up, double altitude_m, double angle) {
  const double r = sky->atmosphere->medium.planet_radius_m + altitude_m;
  const double cosine = np_dvec3_dot(up, np_vec3_to_double(sky->sun));
  return (float)np_clamp((r * cosine + ray->offset_m * angle) / ray->r, -1.0, 1.0);
}

/* Height over which haze thins by a factor e, in heights of the atmosphere: 1.2 km on the Earth. */
static const double haze_height = 0.012;

/* The least height over which a layer thins by a factor e, at most that of haze. */
static double get_least_height(const np_medium *medium) {
  double least_m = haze_height * medium->top_m;
  for (int i = 0; i < medium->layer_count; i++)
    if (medium->layers[i].profile == NEPH_LAYER_EXPONENTIAL) least_m = fmin(least_m, medium->layers[i].height_m);
  return least_m;
}

/* Rule for a part of a ray, by how much the air along it changes: 4 points, and one more for every two e-foldings of
 * density or transmittance. By day it errs by less than 2e-4 (`test_sky_along`). NULL: no rule for parts
 * suffices, or the air has thin layers. */
static const np_quadrature *choose_rule(const neph_sky *sky, const np_ray *ray, double begin_m, double end_m) {
  const np_medium *medium = &sky->atmosphere->medium;
  const double perigee = np_clamp(np_ray_perigee(ray), begin_m, end_m);
  const double begin = np_ray_altitude(ray, begin_m), end = np_ray_altitude(ray, end_m),
               low = np_ray_altitude(ray, perigee);
  const np_spectrum densest = np_bands_to_spectrum(np_extinction_at(medium, low));
  const double change =
      (fmax(begin, end) - low) / get_least_height(medium) + (double)np_spectrum_max(densest) * (end_m - begin_m);
  for (int i = 0; i < NP_SKY_PART_RULES && !np_warp_is_needed(medium); i++) {
    const np_quadrature *rule = &sky->part_rules[i];
    if (rule->count >= 4.0 + 0.5 * change && rule->count < sky->ray_rule.whole.count) return rule;
  }
  return NULL;
}

/* A ray from a place up to a distance. */
typedef struct placed_ray {
  np_ray ray;
  bool is_cut; /* it ends within the air and above the ground */
  float sun;   /* cosine of the sun's zenith angle at its entry */
} placed_ray;

/* False where the ray misses the air. */
static bool start_ray(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, double distance_m, placed_ray *out) {
  const np_medium *medium = &sky->atmosphere->medium;
  const double altitude = fmax(np_altitude(origin, medium->planet_radius_m), 0.0);
  const np_dvec3 up = np_dvec3_zenith(origin, medium->planet_radius_m);
  out->ray = np_ray_make(medium, altitude, np_dvec3_dot(up, np_vec3_to_double(direction)));
  const double end = distance_m - out->ray.offset_m;
  out->is_cut = end < out->ray.length_m;
  if (out->is_cut) {
    out->ray.length_m = fmax(end, 0.0);
    out->ray.hits_ground = false;
  }
  const double cosine = np_dvec3_dot(np_vec3_to_double(direction), np_vec3_to_double(sky->sun));
  if (out->ray.length_m > 0.0) out->sun = compute_entry_sun(sky, &out->ray, up, altitude, cosine);
  return out->ray.length_m > 0.0;
}

static void build_path(const neph_sky *sky, const placed_ray *a, np_path *out) {
  const np_medium *medium = &sky->atmosphere->medium;
  const np_quadrature *rule = a->is_cut ? choose_rule(sky, &a->ray, 0.0, a->ray.length_m) : NULL;
  np_bands depth = np_bands_grey(0.0f);
  if (rule)
    np_path_build_part(medium, &a->ray, 0.0, a->ray.length_m, rule, &depth, out);
  else
    np_path_build(medium, &a->ray, &sky->ray_rule, out);
}

/* In-scatter of a fan of one ray, per unit of solar irradiance. */
static np_spectrum sum_scattered(const neph_sky *sky, np_vec3 direction, np_bands smooth, np_bands peak) {
  const np_bands phase = np_aerosol_phase(&sky->atmosphere->medium, np_vec3_versine(direction, sky->sun));
  return np_spectrum_multiply(np_bands_to_spectrum(sky->frame.twilight * (smooth + phase * peak)), sky->irradiance);
}

static np_fan make_fan(const neph_sky *sky, const placed_ray *a, np_vec3 direction) {
  return np_fan_make_single(&a->ray, a->sun, 1.0f - np_vec3_versine(direction, sky->sun));
}

np_aerial_perspective np_sky_trace_air(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, double distance_m) {
  np_aerial_perspective air = {np_spectrum_grey(1.0f), np_spectrum_grey(0.0f)};
  placed_ray a;
  np_path path;
  if (!start_ray(sky, origin, direction, distance_m, &a)) return air;
  build_path(sky, &a, &path);
  air.transmittance = np_bands_to_spectrum(path.end_transmittance);
  if (!sky->view) return air;
  const np_sky_light light = np_sky_light_make(sky);
  const np_fan fan = make_fan(sky, &a, direction);
  np_scattered s;
  np_sky_trace(&light, &fan, &path, &s);
  air.inscatter = sum_scattered(sky, direction, s.smooth, s.peak);
  return air;
}

/* Share of what is scattered nearly straight on that comes from above, for a ray that rises by `rise` a length: all of
 * it from an angle of 30 degrees on. */
static float share_ahead(float rise) { return np_smoothstepf(0.5f + rise); }

/* Light that is turned out of each hemisphere: of scattering by molecules, and by aerosols less that nearly straight
 * on, all over the same unit. */
typedef struct turned_light {
  np_spectrum upper, lower;
} turned_light;

static turned_light split_turned(np_bands molecules, np_bands aerosols, np_bands straight,
                                 const np_hemisphere_shares *shares, float rise) {
  const np_spectrum even = np_spectrum_scale(np_bands_to_spectrum(molecules), 0.5f),
                    all = np_bands_to_spectrum(aerosols), ahead = np_bands_to_spectrum(straight);
  const float above = share_ahead(rise);
  const np_spectrum upper = np_spectrum_add(even, np_spectrum_multiply(shares->upper, all)),
                    lower = np_spectrum_add(even, np_spectrum_multiply(shares->lower, all));
  return (turned_light){np_spectrum_add_scaled(upper, -above, ahead),
                        np_spectrum_add_scaled(lower, above - 1.0f, ahead)};
}

/* Sums along a ray. */
typedef struct part_sums {
  np_bands molecules, aerosols;                      /* scattering seen from the ray's start, over 2π */
  np_bands straight;                                 /* optical depth of what aerosols scatter nearly straight on */
  np_bands turned_molecules, turned_aerosols, ahead; /* the same with that light counted as not scattered, and it */
  np_scattered first, later;
} part_sums;

static void add_even(const np_medium *medium, const np_path *path, part_sums *sums) {
  for (int k = 0; k < path->count; k++) {
    const np_path_node *n = &path->node[k];
    const np_bands seen = n->weight_m / (2.0f * NP_PI_F) * n->transmittance;
    const np_bands aerosols = np_aerosol_sum(medium, &n->air, 0), straight = np_aerosol_sum(medium, &n->air, 2);
    const np_bands depth = straight * n->weight_m,
                   passed = seen * np_bands_exp(sums->straight +
                                                np_bands_min(0.5f * depth, np_bands_grey(NP_STRAIGHT_DEPTH_MAX)));
    sums->molecules += seen * n->air.rayleigh;
    sums->aerosols += seen * aerosols;
    sums->turned_molecules += passed * n->air.rayleigh;
    sums->turned_aerosols += passed * aerosols;
    sums->ahead += passed * straight;
    sums->straight = np_bands_min(sums->straight + depth, np_bands_grey(NP_STRAIGHT_DEPTH_MAX));
  }
}

/* The aerosol's source cut after degree 2 may be negative where the sky is darkest. */
static np_air_parts finish_parts(const neph_sky *sky, np_vec3 direction, const np_hemisphere_shares *shares,
                                 const part_sums *sums, np_bands transmittance) {
  const turned_light turned =
      split_turned(sums->turned_molecules, sums->turned_aerosols, sums->ahead, shares, direction.z);
  const np_spectrum even = np_spectrum_scale(np_bands_to_spectrum(sums->molecules), 0.5f);
  const np_spectrum aerosols = np_bands_to_spectrum(sums->aerosols);
  np_air_parts out = {.transmittance = np_bands_to_spectrum(transmittance),
                      .upper = np_spectrum_add(even, np_spectrum_multiply(shares->upper, aerosols)),
                      .lower = np_spectrum_add(even, np_spectrum_multiply(shares->lower, aerosols))};
  out.straight = np_bands_to_spectrum(sums->straight);
  out.turned_upper = turned.upper;
  out.turned_lower = turned.lower;
  const np_bands smooth = np_bands_max(sums->first.smooth + sums->later.smooth, np_bands_grey(0.0f));
  out.all = sum_scattered(sky, direction, smooth, sums->first.peak);
  out.first = sum_scattered(sky, direction, sums->first.smooth, sums->first.peak);
  return out;
}

void np_sky_trace_parts(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, const double *distances_m, int count,
                        const np_hemisphere_shares *shares, np_air_parts *out) {
  const np_medium *medium = &sky->atmosphere->medium;
  placed_ray a;
  np_path path = {.end_transmittance = np_bands_grey(1.0f)};
  part_sums sums = {.molecules = np_bands_grey(0.0f)};
  np_bands depth = np_bands_grey(0.0f);
  const bool has_air = start_ray(sky, origin, direction, distances_m[count - 1], &a);
  const np_sky_light light = np_sky_light_make(sky);
  const np_fan fan = has_air ? make_fan(sky, &a, direction) : (np_fan){.count = 0};
  double begin = 0.0;
  for (int i = 0; i < count; i++) {
    const double end = has_air ? fmin(distances_m[i] - a.ray.offset_m, a.ray.length_m) : 0.0;
    if (end > begin) {
      const np_quadrature *rule = choose_rule(sky, &a.ray, begin, end);
      np_path_build_part(medium, &a.ray, begin, end, rule ? rule : &sky->ray_rule.whole, &depth, &path);
      add_even(medium, &path, &sums);
      if (sky->view) np_sky_add_orders(&light, &fan, &path, &sums.first, &sums.later);
      begin = end;
    }
    out[i] = finish_parts(sky, direction, shares, &sums, path.end_transmittance);
  }
}

np_spectrum np_air_cell_get_passed(const neph_atmosphere *atmosphere, np_dvec3 middle, double length_m) {
  const np_medium *medium = &atmosphere->medium;
  const double altitude_m = np_altitude(middle, medium->planet_radius_m);
  np_scattering air;
  np_scattering_at(medium, altitude_m, &air);
  const np_bands taken = np_extinction_at(medium, altitude_m) - np_aerosol_sum(medium, &air, 2);
  return np_bands_to_spectrum(np_bands_exp(-taken * (float)length_m));
}

/* Mean cosines from which a beam has the aerosols' own phase function, with its peak: at the first the directions lie
 * within some 14 degrees. */
static const float narrow_from = 0.97f, narrow_all = 1.0f;

/* Phase functions over the directions of a beam that spread as those of Henyey and Greenstein's function, whose l-th
 * moment is the l-th power of its first: moments are multiplied. Of molecules these are 1 and, in the second degree, a
 * tenth; aerosols are taken as Henyey and Greenstein's. */
static float eval_molecules(const np_air_beam *beam) {
  const float cosine = 1.0f - beam->versine, square = beam->mean_cosine * beam->mean_cosine;
  return 0.25f / NP_PI_F * (1.0f + 0.5f * square * (1.5f * cosine * cosine - 0.5f));
}

static float eval_aerosol(const np_aerosol *aerosol, const np_air_beam *beam) {
  const float narrow = np_smoothstepf((beam->mean_cosine - narrow_from) / (narrow_all - narrow_from));
  const float g = np_clampf(beam->mean_cosine * aerosol->moment[1], -0.99f, 0.99f), cosine = 1.0f - beam->versine,
              d = 1.0f + g * g - 2.0f * g * cosine, spread = 0.25f / NP_PI_F * (1.0f - g * g) / (d * sqrtf(d));
  return np_mixf(spread, np_phase_eval(&aerosol->phase, beam->versine), narrow);
}

np_air_cell np_air_cell_cross(const neph_atmosphere *atmosphere, np_dvec3 middle, double length_m,
                              const np_hemisphere_shares *shares, float rise, const np_air_beam *beam,
                              np_spectrum *transmittance) {
  const np_medium *medium = &atmosphere->medium;
  const double altitude_m = np_altitude(middle, medium->planet_radius_m);
  const float length = (float)length_m;
  np_scattering air;
  np_scattering_at(medium, altitude_m, &air);
  const np_bands depth = np_extinction_at(medium, altitude_m) * length, end = np_bands_exp(-depth);
  const np_bands thin = 1.0f - depth * (0.5f - depth / 6.0f),
                 thick = (1.0f - end) / np_bands_max(depth, np_bands_grey(1e-3f));
  const np_spectrum before = *transmittance;
  const np_spectrum seen = np_spectrum_scale(
      np_spectrum_multiply(before, np_bands_to_spectrum(np_bands_select(depth > 1e-2f, thick, thin))), length);
  np_bands scattered = eval_molecules(beam) * air.rayleigh;
  for (int i = 0; i < medium->aerosol_count; i++) scattered += eval_aerosol(&medium->aerosol[i], beam) * air.aerosol[i];
  const np_bands straight = np_aerosol_sum(medium, &air, 2);
  const turned_light turned = split_turned(air.rayleigh, np_aerosol_sum(medium, &air, 0), straight, shares, rise);
  const np_spectrum over = np_spectrum_scale(seen, 0.5f / NP_PI_F);
  *transmittance = np_spectrum_multiply(before, np_bands_to_spectrum(end));
  return (np_air_cell){np_spectrum_multiply(over, turned.upper), np_spectrum_multiply(over, turned.lower),
                       np_spectrum_multiply(seen, np_bands_to_spectrum(scattered)),
                       np_bands_to_spectrum(straight * length)};
}

/* Steps to a height without haze, short near the ground. */
enum { FORWARD_STEPS = 48 };
static const double forward_top_m = 60e3;
static const float forward_sine_min = 0.0175f;

np_spectrum np_atmosphere_get_forward_depth(const neph_atmosphere *atmosphere, double height_m, np_vec3 direction) {
  const np_medium *medium = &atmosphere->medium;
  direction.z = np_maxf(direction.z, forward_sine_min);
  direction = np_vec3_normalize(direction);
  const double length = forward_top_m / (double)direction.z;
  np_bands depth = np_bands_grey(0.0f);
  double begin = 0.0;
  for (int k = 1; k <= FORWARD_STEPS; k++) {
    const double s = (double)k / FORWARD_STEPS, end = length * s * s * s;
    const np_dvec3 middle = np_dvec3_along(np_dvec3_make(0.0, 0.0, height_m), direction, 0.5 * (begin + end));
    np_scattering air;
    np_scattering_at(medium, np_altitude(middle, medium->planet_radius_m), &air);
    depth += np_aerosol_sum(medium, &air, 2) * (float)(end - begin);
    begin = end;
  }
  return np_bands_to_spectrum(depth);
}
