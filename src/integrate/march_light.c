/* SPDX-License-Identifier: Apache-2.0 */
/* The lighting of a step in the scaled medium of the multiple scattering's solution (light/multi_scatter.h): σ′ = Σ k·σ
 * for σ. Its source is sunlight that came as if straight, times the direct term D (light/scaled_phase.c), and the
 * solution's moments towards the camera. Compiled once per instruction-set level. */
#include "integrate/march.h"

static bool is_grey(const np_scene_view *view) {
  for (unsigned v = 0; v < view->volume_count; v++)
    for (int b = 1; b < NP_BAND_COUNT; b++)
      if (view->volumes[v].albedo.band[b] != view->volumes[v].albedo.band[0]) return false;
  return true;
}

/* What depths let through, found once where they are the same in all bands. */
static np_spectrum find_transmittance(const np_march *m, np_spectrum depth) {
  const float first = np_transmittance(depth.band[0]);
  if (m->is_grey) return np_spectrum_grey(first);
  return np_spectrum_make(first, np_transmittance(depth.band[1]), np_transmittance(depth.band[2]));
}

/* What they hide. */
static np_spectrum find_opacity(const np_march *m, np_spectrum depth) {
  const float first = -expm1f(-depth.band[0]);
  if (m->is_grey) return np_spectrum_grey(first);
  return np_spectrum_make(first, -expm1f(-depth.band[1]), -expm1f(-depth.band[2]));
}

void NP_KERNEL(np_march_start_scaled)(np_march *m) {
  const float versine = np_march_find_sun_versine(m);
  float harmonics[NP_HARMONIC_COUNT_MAX]; /* towards the camera */
  np_harmonics_eval(m->scatter->grid.degree, np_vec3_scale(m->ray->direction, -1.0f), harmonics);
  for (unsigned i = 0; i < m->view->volume_count; i++) {
    const np_scaled_phase *phase = &m->scatter->phases[i];
    np_scaled_phase_fill_column(phase, versine, &m->sun.peak[i].column);
    np_multi_scatter_fill_thrown(phase, harmonics, m->sun.peak[i].thrown);
  }
  m->is_grey = is_grey(m->view);
}

/* Optical depths of the scaled medium and of its forward peak from a point to the sun. */
static void track_scaled_depth(const np_march *m, np_dvec3 position, float error, np_spectrum *out_scaled,
                               np_spectrum *out_peak) {
  *out_scaled = *out_peak = np_spectrum_grey(0.0f);
  float faded = 0.0f;
  for (unsigned v = 0; v < m->view->volume_count && faded < NP_FAINT_DEPTH; v++) {
    const np_view_volume *volume = &m->view->volumes[v];
    const float forward = m->scatter->phases[v].forward;
    const np_depth_question question = {1.0f - forward * np_spectrum_max(volume->albedo), error};
    const float own = np_march_find_cloud_depth(m->view, v, position, m->to_sun, &question, faded);
    faded += question.fade * own;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      const float peak = own * forward * volume->albedo.band[b];
      out_peak->band[b] += peak;
      out_scaled->band[b] += own - peak;
    }
  }
}

/* Sunlight at a place as the scaled medium lets it through, and what its peak has become on the way. */
typedef struct sunlight {
  np_spectrum irradiance, arriving;
  np_peak_place place[NP_BAND_COUNT];
} sunlight;

static void find_sunlight(const np_march *m, np_dvec3 position, float error, sunlight *out) {
  np_spectrum depth, peak;
  out->irradiance = np_light_sun(m->view, position, m->to_sun);
  if (np_spectrum_is_zero(out->irradiance)) return;
  track_scaled_depth(m, position, error, &depth, &peak);
  out->irradiance = np_spectrum_multiply(out->irradiance, find_transmittance(m, depth));
  out->arriving = find_transmittance(m, peak);
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out->place[b] = b > 0 && m->is_grey ? out->place[0] : np_peak_place_find(peak.band[b]);
}

/* Sunlight thrown towards the camera by each cloud of a step; `scattering` is its ϖτ times what one unit of that counts
 * for. Scattered once it is T·p·e^{−τ}, which is part of D. `leaving` is what the peak's depth lets through from here
 * to the camera. */
static void add_sun(np_march *m, np_dvec3 position, const np_step *s, float error, const np_spectrum *scattering,
                    np_spectrum leaving) {
  sunlight sun;
  find_sunlight(m, position, error, &sun);
  if (np_spectrum_is_zero(sun.irradiance)) return;
  for (unsigned i = 0; i < s->count; i++) {
    const np_peak_column *column = &m->sun.peak[s->volume[i] - m->view->volumes].column;
    np_spectrum once, all;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      once.band[b] = sun.arriving.band[b] * leaving.band[b] * (column->broad + column->sharp);
      all.band[b] = np_peak_column_mix(column, sun.place[b], sun.arriving.band[b], leaving.band[b]);
    }
    const np_spectrum light = np_spectrum_multiply(sun.irradiance, scattering[i]);
    np_march_add(m, NP_COMPONENT_SUN, 1.0f, np_spectrum_multiply(light, once));
    np_march_add(m, NP_COMPONENT_MULTIPLE, 1.0f, np_spectrum_multiply(light, np_spectrum_subtract(all, once)));
  }
}

static void add_solution(np_march *m, np_dvec3 position, const np_step *s, const np_spectrum *scattering) {
  np_light_moments moments;
  np_multi_scatter_gather(m->scatter, position, &moments);
  for (unsigned i = 0; i < s->count; i++) {
    const float *thrown = m->sun.peak[s->volume[i] - m->view->volumes].thrown;
    const np_spectrum light = np_multi_scatter_throw(&moments, m->scatter->grid.degree, thrown);
    np_march_add(m, NP_COMPONENT_MULTIPLE, 1.0f, np_spectrum_multiply(light, scattering[i]));
  }
}

/* Ends a faint ray, or makes it stand for others. */
static void settle(np_march *m) {
  m->carry = np_spectrum_max(m->scaled);
  const float settled = np_march_settle(m->carry, m->settings->transmittance_end, m->random);
  if (settled == m->carry) return;
  const float factor = settled / m->carry;
  m->scaled = np_spectrum_scale(m->scaled, factor);
  m->transmittance *= factor;
  m->carry = settled;
}

/* Optical depth of a step, and what of it is scattering, in all and in the peak. */
typedef struct step_optics {
  float depth;
  np_spectrum scattering[NP_VIEW_VOLUMES_MAX], all_scattering, peak;
} step_optics;

static void find_optics(const np_march *m, const np_step *s, step_optics *out) {
  out->depth = 0.0f;
  out->all_scattering = out->peak = np_spectrum_grey(0.0f);
  for (unsigned i = 0; i < s->count; i++) {
    const float forward = m->scatter->phases[s->volume[i] - m->view->volumes].forward;
    out->scattering[i] = np_spectrum_scale(s->volume[i]->albedo, s->depth[i]);
    out->peak = np_spectrum_add_scaled(out->peak, forward, out->scattering[i]);
    out->all_scattering = np_spectrum_add(out->all_scattering, out->scattering[i]);
    out->depth += s->depth[i];
  }
}

/* What a step sees of the peak's depth is that at its middle. */
void NP_KERNEL(np_march_light_scaled)(np_march *m, const np_step *s) {
  const double middle = np_step_middle(s);
  step_optics optics;
  find_optics(m, s, &optics);
  const np_aerial_perspective air =
      np_light_air(m->view, m->view->camera_sky, m->ray->origin, m->ray->direction, middle);
  const float opacity = -expm1f(-optics.depth), hidden = m->transmittance * opacity;
  np_march_add(m, NP_COMPONENT_AIR, hidden, air.inscatter);
  np_integrator_add_opaque(m->out, hidden, middle, np_spectrum_scale(optics.all_scattering, 1.0f / optics.depth));

  const np_spectrum half_peak = np_spectrum_scale(optics.peak, 0.5f);
  const np_spectrum depth = np_spectrum_subtract(np_spectrum_grey(optics.depth), optics.peak);
  const np_spectrum scaled_opacity = find_opacity(m, depth);
  m->peak_depth = np_spectrum_add(m->peak_depth, half_peak);
  np_spectrum weight = np_spectrum_multiply(m->scaled, air.transmittance);
  for (int b = 0; b < NP_BAND_COUNT; b++)
    weight.band[b] *= depth.band[b] > 1e-6f ? scaled_opacity.band[b] / depth.band[b] : 1.0f;
  for (unsigned i = 0; i < s->count; i++) optics.scattering[i] = np_spectrum_multiply(optics.scattering[i], weight);

  const float error = np_march_find_light_error(m, m->carry * np_spectrum_max(scaled_opacity));
  const np_dvec3 position = np_dvec3_along(m->ray->origin, m->ray->direction, middle);
  add_solution(m, position, s, optics.scattering);
  add_sun(m, position, s, error, optics.scattering, find_transmittance(m, m->peak_depth));

  m->peak_depth = np_spectrum_add(m->peak_depth, half_peak);
  m->scaled = np_spectrum_multiply(m->scaled, np_spectrum_subtract(np_spectrum_grey(1.0f), scaled_opacity));
  m->transmittance *= 1.0f - opacity;
  settle(m);
}
