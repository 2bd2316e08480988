/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/sky_along.h"

#include "atmosphere/atmosphere_tables.h"

/* Cosine of the sun's zenith angle at a ray's entry into the air. */
static float compute_entry_sun(const neph_sky *sky, const np_ray *ray, np_dvec3 up, double altitude_m, double angle) {
  const double r = sky->atmosphere->medium.planet_radius_m + altitude_m;
  const double cosine = np_dvec3_dot(up, np_vec3_to_double(sky->sun));
  return (float)np_clamp((r * cosine + ray->offset_m * angle) / ray->r, -1.0, 1.0);
}

/* A ray from a place, and its path through the air up to a distance. */
typedef struct placed_ray {
  np_ray ray;
  np_path path; /* no points where the ray misses the air */
  float sun;    /* cosine of the sun's zenith angle at its entry */
} placed_ray;

static void start_ray(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, double distance_m, placed_ray *out) {
  const np_medium *medium = &sky->atmosphere->medium;
  const double altitude = fmax(np_altitude(origin, medium->planet_radius_m), 0.0);
  const np_dvec3 up = np_dvec3_zenith(origin, medium->planet_radius_m);
  out->ray = np_ray_make(medium, altitude, np_dvec3_dot(up, np_vec3_to_double(direction)));
  out->path.count = 0;
  const double end = distance_m - out->ray.offset_m;
  if (end < out->ray.length_m) {
    out->ray.length_m = fmax(end, 0.0);
    out->ray.hits_ground = false;
  }
  if (!(out->ray.length_m > 0.0)) return;
  np_path_build(medium, &out->ray, &sky->ray_rule, &out->path);
  const double cosine = np_dvec3_dot(np_vec3_to_double(direction), np_vec3_to_double(sky->sun));
  out->sun = compute_entry_sun(sky, &out->ray, up, altitude, cosine);
}

/* In-scatter along a ray, of the requested orders of scattering. */
static np_spectrum trace(const neph_sky *sky, const np_sky_light *light, const placed_ray *a, np_vec3 direction) {
  const float versine = np_vec3_versine(direction, sky->sun);
  const np_fan fan = np_fan_make_single(&a->ray, a->sun, 1.0f - versine);
  np_scattered s;
  np_sky_trace(light, &fan, &a->ray, &a->path, false, &s);
  const np_bands sum = sky->frame.twilight * (s.smooth + np_aerosol_phase(&sky->atmosphere->medium, versine) * s.peak);
  return np_spectrum_multiply(np_bands_to_spectrum(sum), sky->irradiance);
}

np_aerial_perspective np_sky_trace_air(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, double distance_m) {
  np_aerial_perspective air = {np_spectrum_grey(1.0f), np_spectrum_grey(0.0f)};
  placed_ray a;
  start_ray(sky, origin, direction, distance_m, &a);
  if (!a.path.count) return air;
  air.transmittance = np_bands_to_spectrum(a.path.end_transmittance);
  if (!sky->view) return air;
  const np_sky_light light = np_sky_light_make(sky);
  air.inscatter = trace(sky, &light, &a, direction);
  return air;
}

np_air_parts np_sky_trace_parts(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, double distance_m,
                                const np_hemisphere_shares *shares) {
  const np_medium *medium = &sky->atmosphere->medium;
  np_air_parts out = {.transmittance = np_spectrum_grey(1.0f)};
  placed_ray a;
  start_ray(sky, origin, direction, distance_m, &a);
  if (!a.path.count) return out;
  out.transmittance = np_bands_to_spectrum(a.path.end_transmittance);
  np_bands molecules = np_bands_grey(0.0f), aerosols = molecules;
  for (int k = 0; k < a.path.count; k++) {
    const np_path_node *n = &a.path.node[k];
    const np_bands seen = n->weight_m / (2.0f * NP_PI_F) * n->transmittance;
    molecules += seen * n->air.rayleigh;
    aerosols += seen * np_aerosol_sum(medium, &n->air, 0);
  }
  const np_spectrum even = np_spectrum_scale(np_bands_to_spectrum(molecules), 0.5f);
  out.upper = np_spectrum_add(even, np_spectrum_multiply(shares->upper, np_bands_to_spectrum(aerosols)));
  out.lower = np_spectrum_add(even, np_spectrum_multiply(shares->lower, np_bands_to_spectrum(aerosols)));
  if (!sky->view) return out;
  np_sky_light light = np_sky_light_make(sky);
  out.all = trace(sky, &light, &a, direction);
  light.moments = NULL;
  light.gather = NULL;
  out.first = trace(sky, &light, &a, direction);
  return out;
}

np_spectrum np_air_cell_get_transmittance(const neph_atmosphere *atmosphere, np_dvec3 middle, double length_m) {
  const np_medium *medium = &atmosphere->medium;
  const np_bands extinction = np_extinction_at(medium, np_altitude(middle, medium->planet_radius_m));
  return np_bands_to_spectrum(np_bands_exp(-extinction * (float)length_m));
}

np_air_cell np_air_cell_cross(const neph_atmosphere *atmosphere, np_dvec3 middle, double length_m,
                              const np_hemisphere_shares *shares, float versine, np_spectrum *transmittance) {
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
  np_bands beam = np_phase_rayleigh_eval(1.0f - versine) * air.rayleigh;
  for (int i = 0; i < medium->aerosol_count; i++)
    beam += np_phase_eval(&medium->aerosol[i].phase, versine) * air.aerosol[i];
  const np_spectrum molecules = np_spectrum_scale(np_bands_to_spectrum(air.rayleigh), 0.25f / NP_PI_F),
                    aerosols = np_spectrum_scale(np_bands_to_spectrum(np_aerosol_sum(medium, &air, 0)), 0.5f / NP_PI_F);
  const np_spectrum upper = np_spectrum_add(molecules, np_spectrum_multiply(shares->upper, aerosols)),
                    lower = np_spectrum_add(molecules, np_spectrum_multiply(shares->lower, aerosols));
  *transmittance = np_spectrum_multiply(before, np_bands_to_spectrum(end));
  return (np_air_cell){np_spectrum_multiply(seen, upper), np_spectrum_multiply(seen, lower),
                       np_spectrum_multiply(seen, np_bands_to_spectrum(beam))};
}
