/* SPDX-License-Identifier: Apache-2.0 */
/* An atmosphere: validation of its description, its tables, and queries of them. */
#include "atmosphere/atmosphere_tables.h"

#include "atmosphere/moment_builder.h"
#include "atmosphere/tables_disk.h"
#include "core/alloc.h"
#include "core/given.h"
#include "core/parallel.h"

static neph_result compute_tables(neph_atmosphere *a, np_monitor *monitor) {
  np_monitor_set_range(monitor, 0.0, 0.05);
  neph_result result = np_depth_table_build(a->context, &a->medium, &a->sizes.depth, monitor, &a->depths);
  const bool is_limited = a->order_max != NP_ORDERS_ALL;
  if (!result && !is_limited && a->medium.needs_delta_scaling)
    result = np_delta_moments_build(a->context, &a->depths, &a->sizes, a->has_point_sun, monitor, &a->moments);
  else if (!result && a->order_max > 1)
    result = np_moment_table_build(a->context, &a->depths, &a->sizes.moments, a->order_max - is_limited,
                                   a->has_point_sun, monitor, &a->moments);
  if (!result && is_limited && a->order_max > 2)
    result = np_moment_table_build(a->context, &a->depths, &a->sizes.moments, a->order_max - 2, a->has_point_sun,
                                   monitor, &a->dome_moments);
  if (!result) np_atmosphere_save_tables(a);
  return result;
}

static neph_result build_tables(neph_atmosphere *a, np_monitor *monitor) {
  neph_result result = np_atmosphere_load_tables(a) ? NEPH_OK : compute_tables(a, monitor);
  np_air_shells_build(&a->medium, &a->air_shells);
  if (!result && a->order_max > 1) result = np_gather_kernel_build(a->context, &a->medium, &a->kernel);
  return result;
}

/* Copies a description; its density tables are the medium's copies. */
static neph_result copy_desc(neph_atmosphere *a, const neph_atmosphere_desc *desc) {
  a->layers = np_alloc(a->context, (size_t)desc->layer_count + 1, sizeof *a->layers);
  if (!a->layers) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < desc->layer_count; i++) {
    a->layers[i] = desc->layers[i];
    a->layers[i].table_altitude_m = a->medium.layers[i].altitude_m;
    a->layers[i].table_density = a->medium.layers[i].density;
  }
  a->desc = *desc;
  a->desc.layers = a->layers;
  return NEPH_OK;
}

neph_result neph_atmosphere_create(neph_context *context, const neph_atmosphere_desc *desc,
                                   neph_atmosphere **out_atmosphere) {
  if (NP_LACKS_OUT(context, out_atmosphere)) return NEPH_ERROR_INVALID_ARGUMENT;
  return np_atmosphere_create_orders(context, desc, NP_ORDERS_ALL, false, NULL, out_atmosphere);
}

neph_result np_atmosphere_create_orders(neph_context *context, const neph_atmosphere_desc *desc, unsigned order_max,
                                        bool has_point_sun, np_monitor *monitor, neph_atmosphere **out_atmosphere) {
  return np_atmosphere_create_sized(context, desc, order_max, has_point_sun, NULL, monitor, out_atmosphere);
}

neph_result np_atmosphere_create_sized(neph_context *context, const neph_atmosphere_desc *desc, unsigned order_max,
                                       bool has_point_sun, const np_table_sizes *sizes, np_monitor *monitor,
                                       neph_atmosphere **out_atmosphere) {
  *out_atmosphere = NULL;
  const neph_atmosphere_desc defaults = NEPH_ATMOSPHERE_DESC_DEFAULT;
  neph_atmosphere_desc read;
  neph_result result = np_desc_read(context, "neph_atmosphere_desc", &defaults, sizeof read, desc, &read);
  np_medium medium;
  if (!result) result = np_medium_init(context, &read, &medium);
  if (result) return result;
  neph_atmosphere *a = np_alloc(context, 1, sizeof *a);
  if (!a) {
    np_medium_free(context, &medium);
    return NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_context_retain(context);
  a->context = context;
  atomic_init(&a->references, 1);
  a->medium = medium;
  a->sizes = sizes ? *sizes : np_table_sizes_make(read.tolerance);
  if (!sizes) np_table_sizes_adapt(&a->sizes, &a->medium);
  a->order_max = order_max;
  a->has_point_sun = has_point_sun;
  const unsigned mode = np_float_mode_enter();
  result = copy_desc(a, &read);
  if (!result) result = build_tables(a, monitor);
  np_float_mode_leave(mode);
  if (result) {
    neph_atmosphere_release(a);
    return result;
  }
  *out_atmosphere = a;
  return NEPH_OK;
}

void np_atmosphere_set_sea(neph_atmosphere *atmosphere, const np_sea *sea) { atmosphere->sea = *sea; }

neph_atmosphere *neph_atmosphere_retain(neph_atmosphere *atmosphere) {
  if (atmosphere) atomic_fetch_add(&atmosphere->references, 1);
  return atmosphere;
}

void neph_atmosphere_release(neph_atmosphere *atmosphere) {
  if (!atmosphere || atomic_fetch_sub(&atmosphere->references, 1) != 1) return;
  neph_context *context = atmosphere->context;
  np_moment_table_free(context, &atmosphere->moments);
  np_moment_table_free(context, &atmosphere->dome_moments);
  np_depth_table_free(context, &atmosphere->depths);
  np_gather_kernel_free(context, &atmosphere->kernel);
  np_medium_free(context, &atmosphere->medium);
  np_alloc_free(context, atmosphere->layers);
  np_alloc_free(context, atmosphere);
  np_context_release(context);
}

neph_context *np_atmosphere_get_context(const neph_atmosphere *atmosphere) { return atmosphere->context; }

const neph_atmosphere_desc *np_atmosphere_get_desc(const neph_atmosphere *atmosphere) { return &atmosphere->desc; }

float np_atmosphere_get_glint(const neph_atmosphere *atmosphere) { return atmosphere->sea.glint; }

double np_atmosphere_compute_haze(const neph_atmosphere *atmosphere) {
  double depth = 0.0;
  for (int i = 0; i < atmosphere->medium.aerosol_count; i++)
    depth += (double)np_aerosol_column(&atmosphere->medium, i, 0.0)[1];
  return depth;
}

double np_atmosphere_get_planet_radius(const neph_atmosphere *atmosphere) { return atmosphere->medium.planet_radius_m; }

/* Altitude of a world point, and the cosine of a direction's angle with its zenith. */
static double compute_altitude(const np_medium *medium, np_dvec3 position) {
  return np_altitude(position, medium->planet_radius_m);
}
static double compute_cosine(const np_medium *medium, np_dvec3 position, np_vec3 direction) {
  return np_clamp((double)np_vec3_dot(np_zenith(position, medium->planet_radius_m), direction), -1.0, 1.0);
}

/* Transmittance to space along a ray that does not meet the ground, from the table. */
static np_bands transmit_to_space(const neph_atmosphere *a, double altitude_m, double cosine) {
  const np_ray ray = np_ray_on_side(&a->medium, altitude_m, cosine, false);
  if (!(ray.length_m > 0.0)) return np_bands_grey(1.0f);
  const np_depth_row row = np_depth_table_row(&a->depths, ray.altitude_m);
  return np_bands_exp(-np_depth_row_lookup(&row, (float)ray.cosine));
}

np_spectrum np_atmosphere_transmittance_to_space(const neph_atmosphere *atmosphere, np_dvec3 position,
                                                 np_vec3 direction) {
  const double h = fmax(compute_altitude(&atmosphere->medium, position), 0.0);
  const double cosine = compute_cosine(&atmosphere->medium, position, direction);
  if (cosine < np_horizon_cosine(&atmosphere->medium, h)) return np_spectrum_grey(0.0f);
  return np_bands_to_spectrum(transmit_to_space(atmosphere, h, cosine));
}

/* Rays steeper than this cosine use five panels, with an error of 3e-5 in depth for twenty times the Earth's aerosol.
 */
static const double steep = 0.1;
enum { STEEP_PANELS = 5 };

np_spectrum np_atmosphere_integrate_to_space(const neph_atmosphere *atmosphere, np_dvec3 position, np_vec3 direction) {
  const np_medium *medium = &atmosphere->medium;
  const double h = fmax(compute_altitude(medium, position), 0.0), cosine = compute_cosine(medium, position, direction);
  const np_ray ray = np_ray_make(medium, h, cosine);
  if (ray.hits_ground) return np_spectrum_grey(0.0f);
  if (!(ray.length_m > 0.0)) return np_spectrum_grey(1.0f);
  const np_bands depth = ray.cosine > steep ? np_ray_optical_depth_in(medium, &ray, 0.0, ray.length_m, STEEP_PANELS)
                                            : np_ray_optical_depth(medium, &ray, 0.0, ray.length_m);
  return np_bands_to_spectrum(np_bands_exp(-depth));
}

np_spectrum np_atmosphere_transmittance_to_sun(const neph_atmosphere *atmosphere, np_dvec3 position, np_vec3 to_sun,
                                               float angular_radius) {
  const np_medium *medium = &atmosphere->medium;
  const double h = fmax(compute_altitude(medium, position), 0.0), horizon = np_horizon_cosine(medium, h);
  const double cosine = compute_cosine(medium, position, to_sun);
  const double span =
      (medium->planet_radius_m + h) / medium->planet_radius_m; /* radians per unit of cosine at the horizon */
  const double above = (cosine - horizon) * span, radius = fmax((double)angular_radius, 1e-6);
  const float edge = (float)fmax(-above / radius, -2.0);
  if (edge >= 1.0f) return np_spectrum_grey(0.0f);
  if (atmosphere->has_point_sun)
    return np_bands_to_spectrum(np_point_sun_visible(np_maxf(edge, -1.0f)) *
                                transmit_to_space(atmosphere, h, fmax(cosine, horizon)));
  if (above > 0.2) return np_bands_to_spectrum(transmit_to_space(atmosphere, h, cosine));
  const np_disk_rule rule = np_disk_rule_make(edge);
  const double low = cosine + (double)rule.low * radius / span, high = cosine + (double)rule.high * radius / span;
  return np_bands_to_spectrum(0.5f * rule.visible *
                              (transmit_to_space(atmosphere, h, np_clamp(low, horizon, 1.0)) +
                               transmit_to_space(atmosphere, h, np_clamp(high, horizon, 1.0))));
}

np_spectrum np_atmosphere_transmittance_between(const neph_atmosphere *atmosphere, np_dvec3 from, np_dvec3 to) {
  const np_dvec3 step = np_dvec3_subtract(to, from);
  const double distance = np_dvec3_length(step);
  if (!(distance > 0.0)) return np_spectrum_grey(1.0f);
  const np_vec3 direction = np_dvec3_to_float(np_dvec3_scale(step, 1.0 / distance));
  const np_ray ray = np_ray_make_free(&atmosphere->medium, from, direction);
  const double end = np_clamp(distance - ray.offset_m, 0.0, ray.length_m);
  if (!(end > 0.0)) return np_spectrum_grey(1.0f);
  return np_bands_to_spectrum(np_bands_exp(-np_ray_optical_depth(&atmosphere->medium, &ray, 0.0, end)));
}

bool np_atmosphere_has_moments(const neph_atmosphere *atmosphere) { return atmosphere->order_max > 1; }

np_spectrum np_atmosphere_ground_irradiance(const neph_atmosphere *atmosphere, double altitude_m, float sun_cosine) {
  return np_bands_to_spectrum(np_moment_table_irradiance(&atmosphere->moments, altitude_m, sun_cosine));
}

void neph_atmosphere_get_transmittance(const neph_atmosphere *atmosphere, const double position_m[3],
                                       const double direction[3], double out_transmittance[3]) {
  if (!out_transmittance) return;
  memset(out_transmittance, 0, 3 * sizeof *out_transmittance);
  if (!atmosphere || !position_m || !direction) return;
  const np_medium *medium = &atmosphere->medium;
  const np_dvec3 p = np_dvec3_make(position_m[0], position_m[1], position_m[2]);
  const double h = fmax(compute_altitude(medium, p), 0.0);
  const np_dvec3 up = np_dvec3_zenith(p, medium->planet_radius_m);
  const double cosine = np_dvec3_dot(up, np_dvec3_make(direction[0], direction[1], direction[2]));
  const np_ray ray = np_ray_make(medium, h, np_clamp(cosine, -1.0, 1.0));
  np_bands transmittance = np_bands_grey(0.0f);
  if (!ray.hits_ground) transmittance = np_bands_exp(-np_ray_optical_depth(medium, &ray, 0.0, ray.length_m));
  for (int i = 0; i < 3; i++) out_transmittance[i] = (double)transmittance[i];
}
