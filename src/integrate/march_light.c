/* SPDX-License-Identifier: Apache-2.0 */
/* The lighting of a step in the scaled medium of the multiple scattering's solution (transport/scattering_field.h): σ′
 * = Σ k·σ for σ. Its source is sunlight that the scaled medium counts as straight, times the direct term D
 * (transport/scaled_phase.c), and the solution's moments towards the camera. Compiled once per instruction-set level.
 */
#include "integrate/march.h"
#include "integrate/surroundings.h"

/* Transmittance of optical depths. Grey clouds have equal depths in all bands, so that one exponential suffices. */
static np_spectrum compute_transmittance(const np_march *m, np_spectrum depth) {
  const float first = np_transmittance(depth.band[0]);
  if (m->is_grey) return np_spectrum_grey(first);
  return np_spectrum_make(first, np_transmittance(depth.band[1]), np_transmittance(depth.band[2]));
}

/* Opacity of optical depths. */
static np_spectrum compute_opacity(const np_march *m, np_spectrum depth) {
  const float first = np_opacity(depth.band[0]);
  if (m->is_grey) return np_spectrum_grey(first);
  return np_spectrum_make(first, np_opacity(depth.band[1]), np_opacity(depth.band[2]));
}

void NP_KERNEL(np_march_start_scaled)(np_march *m) {
  const float versine = np_march_get_sun_versine(m);
  for (unsigned i = 0; i < m->world->clouds.count; i++)
    np_scattering_field_fill_column(m->field, i, versine, &m->sun.peak[i].column);
  const np_viewer_light *prepared = m->lighting->viewer_light;
  m->viewer_light = prepared && np_viewer_light_serves(prepared, np_camera_ray_get_view(m->ray).eye) ? prepared : NULL;
  m->has_outgoing = false;
  m->is_grey = np_world_is_grey(m->world);
}

/* Optical depths from a point to the sun: of the scaled medium, of its forward peak, and of the medium whose peak is
 * that of the least degree. */
typedef struct sun_optical_depths {
  np_spectrum scaled, peak, least;
} sun_optical_depths;

/* Returns the least scaled depth of all bands. */
static float track_depths(const np_march *m, np_dvec3 position, float error, sun_optical_depths *out) {
  *out = (sun_optical_depths){0};
  float faded = 0.0f;
  np_place_walk places;
  const np_instance *volume;
  np_lighting_start_depths(m->lighting, position, m->to_sun, &places);
  while (faded < NP_TRACK_DEPTH_MAX && (volume = np_place_walk_next(&places, INFINITY))) {
    const np_scaled_cloud *cloud = &m->medium->clouds[np_instances_get_index(places.clouds, volume)];
    const float forward = cloud->forward, least_forward = cloud->least_forward;
    const np_depth_query query = {np_scaled_cloud_get_scale(cloud, volume->albedo), error};
    const float own = np_lighting_get_cloud_depth(m->lighting, volume, position, m->to_sun, &query, faded);
    faded += query.fade * own;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      const float scattering = own * volume->albedo.band[b];
      out->peak.band[b] += forward * scattering;
      out->scaled.band[b] += own - forward * scattering;
      out->least.band[b] += own - least_forward * scattering;
    }
  }
  return faded;
}

/* Sunlight at a place: before the clouds, as the scaled medium lets it through, and what its peak has become on the
 * way; and, over the first, what was scattered narrowly: into the peak of the least degree, but not into that of the
 * solution. */
typedef struct sunlight {
  float depth;
  np_spectrum outside, irradiance, arriving, delta_m_residual;
  np_peak_place place[NP_BAND_COUNT];
} sunlight;

static void compute_sunlight(const np_march *m, np_dvec3 position, float error, sunlight *out) {
  out->depth = NP_SUN_OPTICAL_DEPTH_UNKNOWN;
  out->outside = out->irradiance = np_world_sunlight(m->world, position, m->to_sun);
  if (np_spectrum_is_zero(out->outside)) return;
  sun_optical_depths depths;
  out->depth = track_depths(m, position, error, &depths);
  const np_spectrum passed = compute_transmittance(m, depths.scaled);
  out->irradiance = np_spectrum_multiply(out->outside, passed);
  out->arriving = compute_transmittance(m, depths.peak);
  if (m->medium->has_delta_m_residual)
    out->delta_m_residual = np_spectrum_subtract(compute_transmittance(m, depths.least), passed);
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out->place[b] = b > 0 && m->is_grey ? out->place[0] : np_peak_place_get(depths.peak.band[b]);
}

/* Sunlight scattered to the camera by each cloud of a step; `scattering` is its ϖτ times what one unit of that counts
 * for. Scattered once it is T·p·e^{−τ}, which is part of D. `leaving` is what the peak's depth lets through from here
 * to the camera. */
static void add_sun(np_march *m, const np_step *s, const sunlight *sun, const np_spectrum *scattering,
                    np_spectrum leaving) {
  if (np_spectrum_is_zero(sun->irradiance)) return;
  for (unsigned i = 0; i < s->count; i++) {
    const np_peak_column *column = &m->sun.peak[np_instances_get_index(&m->world->clouds, s->volume[i])].column;
    np_spectrum once, all;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      once.band[b] = sun->arriving.band[b] * leaving.band[b] * (column->broad + column->sharp.band[b]);
      all.band[b] = np_peak_column_mix(column, b, sun->place[b], sun->arriving.band[b], leaving.band[b]);
    }
    const np_spectrum light = np_spectrum_multiply(sun->irradiance, scattering[i]);
    np_march_add(m, NP_COMPONENT_SUN, 1.0f, np_spectrum_multiply(light, once));
    np_march_add(m, NP_COMPONENT_MULTIPLE, 1.0f, np_spectrum_multiply(light, np_spectrum_subtract(all, once)));
  }
}

static void fill_outgoing(np_march *m) {
  float harmonics[NP_HARMONIC_COUNT_MAX]; /* towards the camera */
  np_scattering_field_fill_harmonics(m->field, np_vec3_scale(m->ray->direction, -1.0f), harmonics);
  for (unsigned i = 0; i < m->world->clouds.count; i++)
    np_scattering_field_fill_outgoing(m->field, i, harmonics, m->sun.peak[i].outgoing);
  m->has_outgoing = true;
}

/* The solution at a place: the cells around it, for which light towards the camera is prepared, or its moments. */
typedef struct solution {
  bool is_prepared;
  np_scattering_cells cells;
  np_light_moments moments;
} solution;

static void sample_solution(np_march *m, const np_step *s, np_dvec3 position, solution *out) {
  out->is_prepared = m->viewer_light && m->ray->begin_m + np_step_middle(s) >= m->viewer_light->distance_min &&
                     np_scattering_field_holds(m->field, position);
  if (out->is_prepared) {
    np_scattering_field_gather_cells(m->field, position, &out->cells);
    return;
  }
  if (!m->has_outgoing) fill_outgoing(m);
  np_scattering_field_gather(m->field, position, &out->moments);
}

static np_spectrum eval_solution(const np_march *m, const solution *at, unsigned cloud) {
  if (at->is_prepared)
    return np_viewer_light_outgoing(m->viewer_light, &at->cells, m->medium->clouds[cloud].phase_kind);
  return np_scattering_field_get_outgoing(m->field, &at->moments, m->sun.peak[cloud].outgoing);
}

/* Share of the light scattered into the forward peak that follows the depth of the straight way to the sun within a
 * cell: measured where clouds are lit from behind (docs/results/march.md). */
static const float straightness = 0.75f;

/* Correction of sunlight in the forward peak, which varies most within a cell: its value at the step less its mean in
 * the cell. */
static np_spectrum compute_detail(const np_march *m, const solution *at, const sunlight *sun) {
  np_spectrum detail = np_spectrum_grey(0.0f);
  if (!m->medium->has_delta_m_residual || np_spectrum_is_zero(sun->outside)) return detail;
  const float *mean = at->is_prepared ? at->cells.delta_m_residual : at->moments.delta_m_residual;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    detail.band[b] = sun->outside.band[b] * (sun->delta_m_residual.band[b] - mean[b % m->medium->band_count]);
  return np_spectrum_scale(detail, straightness);
}

static void add_solution(np_march *m, np_dvec3 position, const np_step *s, const sunlight *sun,
                         const np_spectrum *scattering) {
  solution at;
  sample_solution(m, s, position, &at);
  const np_spectrum detail = compute_detail(m, &at, sun);
  for (unsigned i = 0; i < s->count; i++) {
    const unsigned cloud = np_instances_get_index(&m->world->clouds, s->volume[i]);
    np_spectrum light = eval_solution(m, &at, cloud);
    light = np_spectrum_add_scaled(light, m->sun.peak[cloud].column.broad, detail);
    for (int b = 0; b < NP_BAND_COUNT; b++) light.band[b] = np_maxf(light.band[b], 0.0f);
    np_march_add(m, NP_COMPONENT_MULTIPLE, 1.0f, np_spectrum_multiply(light, scattering[i]));
  }
}

/* Russian roulette on a faint ray. */
static void roulette(np_march *m) {
  m->carry = np_spectrum_max(m->scaled);
  const float settled = np_march_roulette(m->carry, m->settings->transmittance_end, m->random);
  if (settled == m->carry) return;
  const float factor = settled / m->carry;
  m->scaled = np_spectrum_scale(m->scaled, factor);
  m->transmittance *= factor;
  m->carry = settled;
}

/* Optical depth, scattering, scattering into the forward peak, and opacity of a step. */
typedef struct step_optics {
  float depth, opacity;
  np_spectrum scattering[NP_INSTANCES_MAX], all_scattering, peak, scaled_opacity;
} step_optics;

static void compute_optics(const np_march *m, const np_step *s, step_optics *out) {
  out->depth = 0.0f;
  out->all_scattering = out->peak = np_spectrum_grey(0.0f);
  for (unsigned i = 0; i < s->count; i++) {
    const float forward = m->medium->clouds[np_instances_get_index(&m->world->clouds, s->volume[i])].forward;
    out->scattering[i] = np_spectrum_scale(s->volume[i]->albedo, s->depth[i]);
    out->peak = np_spectrum_add_scaled(out->peak, forward, out->scattering[i]);
    out->all_scattering = np_spectrum_add(out->all_scattering, out->scattering[i]);
    out->depth += s->depth[i];
  }
  out->opacity = np_opacity(out->depth);
  out->scaled_opacity = compute_opacity(m, np_spectrum_subtract(np_spectrum_grey(out->depth), out->peak));
}

/* Least transmittance of sunlight that is worth finer steps; rates at which steps are right already, and which they do
 * not follow any further. */
static const float sunlight_least = 0.02f, sun_rate_least = 2.0f, sun_rate_max = 12.0f;

/* Whether the sun is so low that steps follow its light: under a high sun the optical depth to it changes slowly along
 * the ray. */
static bool is_sun_low(const np_march *m) { return fabsf(m->to_sun.z) * sun_rate_least < 1.0f; }

/* Sets the rate of change of the sun optical depth along the ray, from its values at two points whose optical distance
 * is `apart`. */
static void set_sun_rate(np_march *m, float before, float after, float apart) {
  const bool is_lit = np_transmittance(np_minf(before, after)) > sunlight_least;
  const float rate = is_lit ? fabsf(after - before) / np_maxf(apart, 1e-6f) : 1.0f;
  m->sun_rate = np_clampf(rate, sun_rate_least, sun_rate_max) * (1.0f / sun_rate_least);
}

/* Parts in which the first step in a cloud, whose length is a guess, must be lit: by the law of its budget. Where it
 * would be lit well enough even if its begin were in full sun, that need not be examined. */
static unsigned count_parts(np_march *m, const np_step *s, float depth, float error) {
  const float half = 0.5f * s->hiding;
  if (!is_sun_low(m) || depth < 2.0f * sun_rate_least * half) return 1;
  sun_optical_depths depths;
  const np_dvec3 begin = np_march_get_lit_place(m, s, s->begin);
  set_sun_rate(m, track_depths(m, begin, error, &depths), depth, half);
  return (unsigned)ceilf(cbrtf(m->sun_rate * m->sun_rate));
}

/* Updates the rate at which sunlight changes along the ray by the sun optical depth of a lit step. */
static void learn_sun_rate(np_march *m, const np_step *s, float depth) {
  const float place = m->passed + 0.5f * s->hiding;
  if (is_sun_low(m) && depth >= 0.0f && m->sun_optical_depth >= 0.0f)
    set_sun_rate(m, m->sun_optical_depth, depth, place - m->sun_place);
  m->sun_optical_depth = depth;
  m->sun_place = place;
  m->passed += s->hiding;
}

static np_dvec3 compute_middle(const np_march *m, const np_step *s) {
  return np_march_get_lit_place(m, s, np_step_middle(s));
}

static void add_opacities(const np_march *m, const np_step *s, float weight) {
  for (unsigned i = 0; i < s->count; i++) np_integrator_add_cloud(m->ray, s->volume[i], weight * s->depth[i]);
}

static void clear_held_out(const np_step *s, np_spectrum *scattering) {
  for (unsigned i = 0; i < s->count; i++)
    if (s->volume[i]->is_held_out) scattering[i] = np_spectrum_grey(0.0f);
}

/* Lights a step. The forward peak's depth is that at its middle. */
static void light(np_march *m, const np_step *s, step_optics *optics, const sunlight *sun) {
  const double middle = np_step_middle(s);
  const np_aerial_perspective air = np_march_get_air(m, middle);
  const float hidden = m->transmittance * optics->opacity, shown = hidden * np_march_get_shown_share(m, s);
  m->out->held_out += hidden - shown;
  if (m->ray->layers) add_opacities(m, s, hidden / optics->depth);
  /* The rest of the ray is seen through the scaled transmittance with the air before this step in it. */
  np_march_add(m, NP_COMPONENT_AIR, np_march_get_shown_share(m, s),
               np_spectrum_multiply(np_spectrum_multiply(m->scaled, optics->scaled_opacity), air.inscatter));
  np_integrator_add_opaque(
      m->out, shown,
      &(np_opaque){.distance_m = middle,
                   .albedo = np_spectrum_scale(optics->all_scattering, 1.0f / optics->depth),
                   .sun_share = np_surroundings_get_sun_share(m->world, m->lighting, m->settings, compute_middle(m, s),
                                                              NP_KERNEL(np_march_sun_transmittance), m->random)});

  const np_spectrum half_peak = np_spectrum_scale(optics->peak, 0.5f);
  m->peak_depth = np_spectrum_add(m->peak_depth, half_peak);
  np_spectrum weight = np_spectrum_multiply(m->scaled, air.transmittance);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float depth = optics->depth - optics->peak.band[b];
    weight.band[b] *= depth > 1e-6f ? optics->scaled_opacity.band[b] / depth : 1.0f;
  }
  for (unsigned i = 0; i < s->count; i++) optics->scattering[i] = np_spectrum_multiply(optics->scattering[i], weight);
  if (m->settings->has_holdout) clear_held_out(s, optics->scattering);
  add_solution(m, compute_middle(m, s), s, sun, optics->scattering);
  add_sun(m, s, sun, optics->scattering, compute_transmittance(m, m->peak_depth));

  m->peak_depth = np_spectrum_add(m->peak_depth, half_peak);
  m->scaled = np_spectrum_multiply(m->scaled, np_spectrum_subtract(np_spectrum_grey(1.0f), optics->scaled_opacity));
  m->transmittance *= 1.0f - optics->opacity;
  learn_sun_rate(m, s, sun->depth);
  roulette(m);
}

static float compute_error(const np_march *m, const step_optics *optics) {
  return np_march_get_light_error(m, m->carry * np_spectrum_max(optics->scaled_opacity));
}

void NP_KERNEL(np_march_light_scaled)(np_march *m, const np_step *s) {
  step_optics optics;
  sunlight sun;
  compute_optics(m, s, &optics);
  const float error = compute_error(m, &optics);
  compute_sunlight(m, compute_middle(m, s), error, &sun);
  const unsigned count = m->sun_optical_depth < 0.0f ? count_parts(m, s, sun.depth, error) : 1;
  if (count == 1) light(m, s, &optics, &sun);
  for (unsigned n = 0; n < count && count > 1 && m->carry > 0.0f; n++) {
    const np_step part = np_step_split(s, n, count);
    compute_optics(m, &part, &optics);
    compute_sunlight(m, compute_middle(m, &part), compute_error(m, &optics), &sun);
    light(m, &part, &optics, &sun);
  }
}
