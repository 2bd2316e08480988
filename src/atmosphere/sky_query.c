/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/sky_query.h"

enum { MARCH_POINTS = NP_PATH_MAX, MARCH_ANGLES = 24, MARCH_AZIMUTHS = 24 };

bool np_sky_quantity_is_scattered(np_sky_quantity quantity) {
  return quantity != NP_SKY_TRANSMITTANCE_TOP && quantity != NP_SKY_DIRECT_IRRADIANCE &&
         quantity != NP_SKY_AP_TRANSMITTANCE;
}

static bool is_aerial(np_sky_quantity quantity) {
  return quantity == NP_SKY_AP_INSCATTER || quantity == NP_SKY_AP_TRANSMITTANCE;
}

static np_dvec3 make_direction(double zenith_rad, double azimuth_rad) {
  return np_dvec3_make(sin(zenith_rad) * cos(azimuth_rad), sin(zenith_rad) * sin(azimuth_rad), cos(zenith_rad));
}

static np_dvec3 compute_direction(const np_sky_query *q) {
  if (q->quantity != NP_SKY_TRANSMITTANCE_TOP) return make_direction(q->view_zenith_rad, q->azimuth_rad);
  return np_dvec3_make(sqrt(fmax(1.0 - q->view_cosine * q->view_cosine, 0.0)), 0.0, q->view_cosine);
}

static np_dvec3 compute_origin(const np_sky_query *q) { return np_dvec3_make(0.0, 0.0, q->altitude_m); }

static np_reference_scene make_scene(const np_sky_subject *w, const np_sky_query *q) {
  return (np_reference_scene){.medium = &w->atmosphere->medium,
                              .light = w->light,
                              .to_sun = make_direction(q->sun_zenith_rad, 0.0),
                              .sun_angular_radius_rad = w->sun_angular_radius_rad,
                              .order_min = 1,
                              .order_max = q->order_max,
                              .guide = &w->atmosphere->depths};
}

static np_reference_query make_query(const np_sky_query *q) {
  return (np_reference_query){compute_origin(q), compute_direction(q),
                              is_aerial(q->quantity) ? q->distance_m : (double)INFINITY,
                              q->quantity == NP_SKY_IRRADIANCE};
}

static void set_bands(np_bands value, np_reference_value *out) {
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) out->mean[b] = (double)value[b];
}

static void set_spectrum(np_spectrum value, np_reference_value *out) { set_bands(np_bands_from_spectrum(value), out); }

/* Builds the subject's sky for a query, with a solar irradiance of 1. */
static neph_result build_sky(np_sky_subject *w, const np_sky_query *q) {
  if (w->sky && w->sky_altitude_m == q->altitude_m && w->sky_sun_rad == q->sun_zenith_rad) return NEPH_OK;
  np_sky_subject_clear(w);
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  const np_dvec3 sun = make_direction(q->sun_zenith_rad, 0.0);
  desc.sun_direction[0] = sun.x;
  desc.sun_direction[1] = sun.y;
  desc.sun_direction[2] = sun.z;
  for (int b = 0; b < 3; b++) desc.sun_irradiance_w_m2_nm[b] = 1.0;
  desc.sun_angular_radius_rad = w->sun_angular_radius_rad;
  desc.observer_m[2] = q->altitude_m;
  w->sky_altitude_m = q->altitude_m;
  w->sky_sun_rad = q->sun_zenith_rad;
  return neph_sky_create(w->atmosphere, &desc, &w->sky);
}

void np_sky_subject_clear(np_sky_subject *subject) {
  neph_sky_destroy(subject->sky);
  subject->sky = NULL;
}

/* ---- Tables ---- */

/* Distance, at most to the sea-level sphere: below it the tables continue and the tracer stops. */
static double compute_end(const np_sky_subject *w, const np_sky_query *q) {
  const np_ray ray = np_ray_make(&w->atmosphere->medium, q->altitude_m, cos(q->view_zenith_rad));
  return ray.hits_ground ? fmin(q->distance_m, ray.offset_m + ray.length_m) : q->distance_m;
}

static void lookup_light(const np_sky_subject *w, const np_sky_query *q, np_reference_value *out) {
  const np_vec3 direction = np_dvec3_to_float(compute_direction(q));
  if (q->quantity == NP_SKY_IRRADIANCE) {
    double sun[3];
    neph_sky_get_irradiance(w->sky, sun, out->mean);
  } else if (is_aerial(q->quantity)) {
    const np_aerial_perspective ap = np_sky_aerial_perspective(w->sky, direction, compute_end(w, q));
    set_spectrum(q->quantity == NP_SKY_AP_INSCATTER ? ap.inscatter : ap.transmittance, out);
  } else {
    set_spectrum(np_sky_radiance(w->sky, direction), out);
  }
}

static neph_result lookup(np_sky_subject *w, const np_sky_query *q, np_reference_value *out) {
  const np_vec3 sun = np_dvec3_to_float(make_direction(q->sun_zenith_rad, 0.0));
  if (q->quantity == NP_SKY_TRANSMITTANCE_TOP) {
    set_spectrum(
        np_atmosphere_transmittance_to_space(w->atmosphere, compute_origin(q), np_dvec3_to_float(compute_direction(q))),
        out);
    return NEPH_OK;
  }
  if (q->quantity == NP_SKY_DIRECT_IRRADIANCE) {
    const np_spectrum t =
        np_atmosphere_transmittance_to_sun(w->atmosphere, compute_origin(q), sun, (float)w->sun_angular_radius_rad);
    set_spectrum(np_spectrum_scale(t, np_maxf(sun.z, 0.0f)), out);
    return NEPH_OK;
  }
  neph_result result = build_sky(w, q);
  if (!result) lookup_light(w, q, out);
  return result;
}

/* ---- March ---- */

/* In-scatter along one ray from the sources behind the sky's tables, at other sample points than the tables'. */
static np_bands march_ray(const np_sky_subject *w, const np_sky_query *q, np_dvec3 direction) {
  const np_medium *medium = &w->atmosphere->medium;
  const np_dvec3 to_sun = make_direction(q->sun_zenith_rad, 0.0);
  const np_sky_light light = np_sky_light_make(w->sky);
  np_ray ray = np_ray_make(medium, q->altitude_m, direction.z);
  const double end = q->distance_m - ray.offset_m;
  if (is_aerial(q->quantity) && end < ray.length_m) {
    ray.length_m = fmax(end, 0.0);
    ray.hits_ground = false;
  }
  const np_path_rule rule = np_path_rule_make(MARCH_POINTS);
  np_path path;
  np_path_build(medium, &ray, &rule, &path);
  const double angle = np_dvec3_dot(direction, to_sun);
  const double sun = ((medium->planet_radius_m + fmax(q->altitude_m, 0.0)) * to_sun.z + ray.offset_m * angle) / ray.r;
  const np_fan fan = np_fan_make_single(&ray, (float)np_clamp(sun, -1.0, 1.0), (float)angle);
  np_scattered s;
  np_sky_trace(&light, &fan, &path, &s);
  return s.smooth + np_aerosol_phase(medium, (float)(1.0 - angle)) * s.peak;
}

/* Irradiance from marched rays, by the quadrature around the sun that the tables use. */
static np_bands march_dome(const np_sky_subject *w, const np_sky_query *q) {
  const np_quadrature rule = np_quadrature_gauss(MARCH_ANGLES);
  const np_dvec3 to_sun = make_direction(q->sun_zenith_rad, 0.0);
  np_vec3 a, b;
  np_frame_around(np_dvec3_to_float(to_sun), &a, &b);
  np_bands sum = np_bands_grey(0.0f);
  for (int i = 0; i < MARCH_ANGLES; i++) {
    const double angle = NP_PI * rule.x[i] * rule.x[i], s = sin(angle);
    const double weight = 2.0 * NP_PI * rule.x[i] * rule.weight[i] * s * 2.0 * NP_PI / MARCH_AZIMUTHS;
    for (int k = 0; k < MARCH_AZIMUTHS; k++) {
      const double turn = 2.0 * NP_PI * (k + 0.5) / MARCH_AZIMUTHS;
      const np_dvec3 across = np_dvec3_add(np_dvec3_scale(np_vec3_to_double(a), s * cos(turn)),
                                           np_dvec3_scale(np_vec3_to_double(b), s * sin(turn)));
      const np_dvec3 d = np_dvec3_normalize(np_dvec3_add(np_dvec3_scale(to_sun, cos(angle)), across));
      if (d.z > 0.0) sum += (float)(weight * d.z) * march_ray(w, q, d);
    }
  }
  return sum;
}

static neph_result march_light(np_sky_subject *w, const np_sky_query *q, np_reference_value *out) {
  if (q->order_max == 1 && q->quantity != NP_SKY_IRRADIANCE) {
    const np_reference_scene scene = make_scene(w, q);
    const np_reference_query query = make_query(q);
    np_reference_first_order(&scene, &query, 1e-5, out->mean);
    return NEPH_OK;
  }
  neph_result result = build_sky(w, q);
  if (!result)
    set_bands(q->quantity == NP_SKY_IRRADIANCE ? march_dome(w, q) : march_ray(w, q, compute_direction(q)), out);
  return result;
}

/* ---- Entry points ---- */

/* Transmittance along a ray or to the sun, which needs neither a table nor random numbers. */
static void integrate_transmittance(const np_sky_subject *w, const np_sky_query *q, np_reference_value *out) {
  const np_reference_scene scene = make_scene(w, q);
  const np_reference_query query = make_query(q);
  if (q->quantity == NP_SKY_DIRECT_IRRADIANCE) {
    np_reference_sunlight(&scene, query.origin, out->mean);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) out->mean[b] *= fmax(scene.to_sun.z, 0.0);
    return;
  }
  np_reference_transmittance(scene.medium, &query, q->quantity == NP_SKY_TRANSMITTANCE_TOP, out->mean);
}

static neph_result eval_query(np_sky_subject *w, const np_sky_query *q, uint64_t seed, np_monitor *monitor,
                              np_reference_value *out) {
  if (np_sky_quantity_is_scattered(q->quantity) && q->order_max == 0) return NEPH_OK;
  if (w->method == NP_SKY_LUT) return lookup(w, q, out);
  if (!np_sky_quantity_is_scattered(q->quantity)) return integrate_transmittance(w, q, out), NEPH_OK;
  if (w->method == NP_SKY_MARCH) return march_light(w, q, out);
  const np_reference_scene scene = make_scene(w, q);
  const np_reference_query query = make_query(q);
  return np_reference_radiance(w->atmosphere->context, monitor, &scene, &query, w->paths, seed, out);
}

neph_result np_sky_query_eval(np_sky_subject *subject, const np_sky_query *query, uint64_t seed, np_monitor *monitor,
                              np_reference_value *out_value) {
  *out_value = (np_reference_value){0};
  neph_result result = eval_query(subject, query, seed, monitor, out_value);
  const np_sky_quantity quantity = query->quantity;
  if (quantity == NP_SKY_TRANSMITTANCE_TOP || quantity == NP_SKY_AP_TRANSMITTANCE) return result;
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
    out_value->mean[b] *= subject->irradiance_w_m2_nm[b];
    out_value->error[b] *= subject->irradiance_w_m2_nm[b];
  }
  return result;
}
