/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/sky_verify.h"

enum { DEPTHS = 4096, VIEWS = 64, TRACED = 24 };

/* Golden ratio conjugate, for a spiral of directions over the sphere. */
static const double golden = 0.6180339887498949;

static void add_error(np_sky_error *e, const double value[NP_REFERENCE_BANDS], const np_reference_value *reference) {
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
    if (!(reference->mean[b] > 0.0)) continue;
    const double off = value[b] / reference->mean[b] - 1.0, noise = reference->error[b] / reference->mean[b];
    e->rms[b] += off * off;
    e->noise[b] += noise * noise;
    e->worst[b] = fmax(e->worst[b], fabs(off));
  }
  e->count++;
}

static void finish(np_sky_error *e) {
  const double count = fmax(e->count, 1.0);
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
    e->rms[b] = sqrt(fmax(e->rms[b] - e->noise[b], 0.0) / count);
    e->noise[b] = sqrt(e->noise[b] / count);
  }
}

/* Compares the depths. */
static np_sky_error verify_depths(const np_depth_table *table) {
  const np_medium *medium = table->medium;
  np_sky_error e = {0};
  for (int i = 0; i < DEPTHS; i++) {
    const double u = (i + 0.5) / DEPTHS, v = fmod(i * golden, 1.0), h = 0.4 * medium->top_m * u * u;
    const double horizon = np_horizon_cosine(medium, h), cosine = horizon + (1.0 - horizon) * v * v;
    const np_ray ray = np_ray_on_side(medium, h, cosine, false);
    const np_depth_row row = np_depth_table_row(table, h);
    const np_bands depth = np_depth_row_lookup(&row, (float)cosine);
    const np_bands integral = np_ray_optical_depth(medium, &ray, 0.0, ray.length_m);
    double value[NP_REFERENCE_BANDS];
    np_reference_value reference = {{0}, {0}};
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
      value[b] = (double)depth[b];
      reference.mean[b] = (double)integral[b];
    }
    add_error(&e, value, &reference);
  }
  finish(&e);
  return e;
}

/* Query number i of `count`: directions uniform over the part of the sphere with air, and a distance. */
static np_sky_query make_query(const neph_sky *sky, np_sky_quantity quantity, int i, int count) {
  const np_sky_frame *frame = &sky->frame;
  const double top = cos(frame->top_angle), cosine = top - (top + 1.0) * (i + 0.5) / count;
  return (np_sky_query){.quantity = quantity,
                        .order_max = sky->atmosphere->order_max,
                        .altitude_m = frame->altitude_m,
                        .sun_zenith_rad = acos((double)frame->sun_cosine),
                        .view_zenith_rad = acos(cosine),
                        .azimuth_rad = NP_PI * fmod(i * golden, 1.0),
                        .distance_m = 1000.0 * (1 << i % 8)};
}

static neph_result eval_query(np_sky_subject *w, np_sky_method method, const np_sky_query *q, uint64_t seed,
                              np_monitor *monitor, np_reference_value *out) {
  w->method = method;
  return np_sky_query_eval(w, q, seed, monitor, out);
}

static neph_result compare(np_sky_subject *w, const neph_sky *sky, np_sky_quantity quantity, np_sky_method method,
                           int count, uint64_t seed, np_monitor *monitor, np_sky_error *out) {
  neph_result result = NEPH_OK;
  *out = (np_sky_error){0};
  for (int i = 0; !result && i < count; i++) {
    const np_sky_query q = make_query(sky, quantity, i, count);
    np_reference_value table, reference;
    np_monitor_set_range(monitor, (double)i / count, (i + 1.0) / count);
    result = eval_query(w, NP_SKY_LUT, &q, 0, NULL, &table);
    if (!result) result = eval_query(w, method, &q, seed + (uint64_t)i, monitor, &reference);
    if (!result) add_error(out, table.mean, &reference);
  }
  finish(out);
  return result;
}

neph_result np_sky_verify(neph_sky *sky, unsigned paths, uint64_t seed, np_monitor *monitor,
                          np_sky_errors *out_errors) {
  neph_atmosphere *a = sky->atmosphere;
  np_sky_subject w = {.atmosphere = a,
                      .light = a->has_point_sun ? NP_REFERENCE_POINT : NP_REFERENCE_DISK,
                      .sun_angular_radius_rad = (double)sky->sun_angular_radius,
                      .irradiance_w_m2_nm = {1.0, 1.0, 1.0},
                      .paths = paths};
  out_errors->depths = verify_depths(&a->depths);
  neph_result result = compare(&w, sky, NP_SKY_RADIANCE, NP_SKY_MARCH, VIEWS, 0, NULL, &out_errors->view);
  if (!result) result = compare(&w, sky, NP_SKY_AP_INSCATTER, NP_SKY_MARCH, VIEWS, 0, NULL, &out_errors->aerial);
  if (!result) result = compare(&w, sky, NP_SKY_RADIANCE, NP_SKY_TRACE, TRACED, seed, monitor, &out_errors->all);
  np_sky_subject_clear(&w);
  return result;
}
