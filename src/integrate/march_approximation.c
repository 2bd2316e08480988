/* SPDX-License-Identifier: Apache-2.0 */
/* The lighting of a step where no solution of the multiple scattering is there: sunlight through the optical depth
 * towards the sun, light from sky or ground along one drawn direction, and an approximation (integrate/approximation.h)
 * that may represent light scattered more than once. Compiled once per instruction-set level. */
#include "integrate/approximation_gain.h"
#include "integrate/march.h"
#include "integrate/surroundings.h"
#include "caches/ground_light.h"

extern np_approximation_rows NP_KERNEL(np_approximation_rows);

static float get_sun_optical_depth(const np_lighting *lighting, np_dvec3 position, np_vec3 to_sun,
                                   const np_depth_query *query) {
  float depth = 0.0f;
  np_place_walk places;
  const np_instance *volume;
  np_lighting_start_depths(lighting, position, to_sun, &places);
  while (query->fade * depth < NP_TRACK_DEPTH_MAX && (volume = np_place_walk_next(&places, INFINITY)))
    depth += np_lighting_get_cloud_depth(lighting, volume, position, to_sun, query, query->fade * depth);
  return depth;
}

float NP_KERNEL(np_march_sun_transmittance)(const np_world *world, const np_lighting *lighting,
                                            const np_integrator_settings *settings, np_dvec3 position, np_vec3 to_sun,
                                            np_random *random) {
  (void)world, (void)random;
  const np_depth_query query = {.fade = 1.0f, .error = settings->tolerance};
  return np_transmittance(get_sun_optical_depth(lighting, position, to_sun, &query));
}

/* Transmittance of the clouds for sunlight on the ground. If ground_light has the light that clouds scatter to the
 * ground, light in the forward peak counts as unscattered here. */
float NP_KERNEL(np_march_shadow)(const np_world *world, const np_lighting *lighting,
                                 const np_integrator_settings *settings, np_dvec3 position, np_vec3 to_sun,
                                 np_random *random) {
  if (!lighting->ground_light)
    return NP_KERNEL(np_march_sun_transmittance)(world, lighting, settings, position, to_sun, random);
  float faded = 0.0f;
  np_place_walk places;
  const np_instance *volume;
  np_lighting_start_depths(lighting, position, to_sun, &places);
  while (faded < NP_TRACK_DEPTH_MAX && (volume = np_place_walk_next(&places, INFINITY))) {
    const float fade =
        lighting->ground_light->fade[np_instances_get_index(lighting->sun_optical_depths.clouds, volume)];
    const np_depth_query own = {fade, settings->tolerance};
    faded += fade * np_lighting_get_cloud_depth(lighting, volume, position, to_sun, &own, faded);
  }
  return np_transmittance(faded);
}

/* Terms of one cloud at one angle to the sun, or to a direction of its surroundings. */
static void fill_terms(const np_march *m, unsigned cloud, bool is_sun, float versine, np_march_terms *out) {
  const np_approximation *a = &m->settings->approximation;
  const np_cloud_gain *gain = m->lighting->gains ? &m->lighting->gains[cloud] : NULL;
  if (is_sun && m->method->get_slope)
    out->own[0] = out->smooth[0] = 1.0f / NP_PI_F;
  else
    m->method->fill_phases(a, &m->world->clouds.at[cloud].phase, versine, out->own);
  if (!gain) return;
  if (!is_sun || !m->method->get_slope) m->method->fill_phases(a, &gain->phase, versine, out->smooth);
  const np_spectrum factor = np_cloud_gain_get(is_sun ? gain->sun : gain->surroundings, versine);
  out->excess = np_spectrum_subtract(factor, np_spectrum_grey(1.0f));
}

void NP_KERNEL(np_march_start_approximation)(np_march *m) {
  const np_approximation *a = &m->settings->approximation;
  const float versine = np_march_get_sun_versine(m);
  m->method = &NP_KERNEL(np_approximation_rows)[m->settings->multiple_scattering];
  m->term_count = m->method->count_terms(a);
  for (unsigned i = 0; i < m->world->clouds.count; i++) fill_terms(m, i, true, versine, &m->sun.terms[i]);
}

static float sum_multiple(const np_march *m, const float *phases, const float *transmittances) {
  float sum = 0.0f;
  for (unsigned n = 1; n < m->term_count; n++) sum += phases[n] * transmittances[n];
  return sum;
}

/* own + excess·smooth of each band; a gain below 1 takes no more away than there is. */
static np_spectrum add_excess(float own, float smooth, np_spectrum excess) {
  for (int b = 0; b < NP_BAND_COUNT; b++) excess.band[b] = np_maxf(own + excess.band[b] * smooth, 0.0f);
  return excess;
}

/* Adds single scattering, and the approximation of multiple scattering. */
static void add_terms(np_march *m, np_component single, const np_march_terms *terms, const float *transmittances,
                      np_spectrum light) {
  const float gain = (float)m->settings->approximation.gain;
  const float multiple = sum_multiple(m, terms->own, transmittances);
  if (!m->lighting->gains) {
    np_march_add(m, single, gain * terms->own[0] * transmittances[0], light);
    np_march_add(m, NP_COMPONENT_MULTIPLE, gain * multiple, light);
    return;
  }
  const float smooth = sum_multiple(m, terms->smooth, transmittances);
  const np_spectrum first = add_excess(terms->own[0], terms->smooth[0], terms->excess);
  np_march_add(m, single, transmittances[0], np_spectrum_multiply(light, first));
  np_march_add(m, NP_COMPONENT_MULTIPLE, 1.0f,
               np_spectrum_multiply(light, add_excess(multiple, smooth, terms->excess)));
}

/* Transmittance of the clouds towards `direction`. */
static void fill_transmittances(const np_march *m, np_dvec3 position, np_vec3 direction, float error,
                                float out[NP_APPROXIMATION_TERMS_MAX]) {
  const np_approximation *a = &m->settings->approximation;
  const np_depth_query query = {m->method->get_fade(a), error};
  m->method->fill_transmittances(a, np_track_depth(&m->world->clouds, position, direction, &query), out);
}

/* Adds sunlight that is scattered towards the camera at `position`, times `weight`. `share[i]`: opacity of the step's
 * i-th cloud, as a share of the step's, times albedo. */
static void add_sun(np_march *m, np_dvec3 position, np_dvec3 lit_place, const np_step *s, const np_spectrum *share,
                    float error, np_spectrum weight) {
  const np_approximation *a = &m->settings->approximation;
  const np_spectrum sun = np_spectrum_multiply(np_world_sunlight(m->world, position, m->to_sun), weight);
  if (np_spectrum_is_zero(sun)) return;
  float transmittances[NP_APPROXIMATION_TERMS_MAX];
  if (m->method->get_slope) {
    transmittances[0] = m->method->get_slope(a, m->world, position, m->to_sun);
  } else {
    const np_depth_query query = {m->method->get_fade(a), error};
    m->method->fill_transmittances(a, get_sun_optical_depth(m->lighting, lit_place, m->to_sun, &query), transmittances);
  }
  for (unsigned i = 0; i < s->count; i++) {
    const np_instance *volume = s->volume[i];
    const np_march_terms *terms = &m->sun.terms[np_instances_get_index(&m->world->clouds, volume)];
    const float weight_here = m->method->get_weight ? m->method->get_weight(a, volume, position) : 1.0f;
    const np_spectrum light = np_spectrum_scale(sun, weight_here);
    add_terms(m, NP_COMPONENT_SUN, terms, transmittances, np_spectrum_multiply(light, share[i]));
  }
}

/* One active cloud, drawn by its share; 1 over the probability of the draw goes to `out_weight`. */
static unsigned draw_cloud(const np_spectrum *share, unsigned count, np_random *random, float *out_weight) {
  float total = 0.0f;
  for (unsigned i = 0; i < count; i++) total += np_spectrum_max(share[i]);
  float rest = np_random_float(random) * total;
  unsigned chosen = 0;
  while (chosen + 1 < count && (rest -= np_spectrum_max(share[chosen])) >= 0.0f) chosen++;
  *out_weight = total > 0.0f ? total / np_spectrum_max(share[chosen]) : 0.0f;
  return chosen;
}

/* Draws a direction from the phase function or uniformly, with equal probability: the phase function finds light from
 * behind the cloud, the uniform density light from other sides. */
static np_vec3 draw_direction(const np_phase *phase, np_vec3 forward, np_random *random, float *out_pdf) {
  const float choice = np_random_float(random);
  const float u[3] = {np_random_float(random), np_random_float(random), np_random_float(random)};
  const float even = 1.0f / (4.0f * NP_PI_F);
  np_vec3 direction;
  float value;
  if (choice < 0.5f) {
    direction = np_phase_sample(phase, forward, u, &value);
  } else {
    const float z = 1.0f - 2.0f * u[0], r = sqrtf(np_maxf(0.0f, 1.0f - z * z)), azimuth = 2.0f * NP_PI_F * u[1];
    direction = np_vec3_make(r * cosf(azimuth), r * sinf(azimuth), z);
    value = np_phase_eval(phase, np_vec3_versine(forward, direction));
  }
  *out_pdf = 0.5f * (value + even);
  return direction;
}

/* Light from sky or ground along one direction. */
static void add_surroundings(np_march *m, np_dvec3 position, const np_step *s, const np_spectrum *share, float error,
                             np_spectrum weight) {
  float draw_weight, pdf;
  const unsigned chosen = draw_cloud(share, s->count, m->random, &draw_weight);
  if (draw_weight <= 0.0f) return;
  const np_phase *phase = &s->volume[chosen]->phase;
  const np_vec3 forward = m->ray->direction;
  const np_vec3 direction = draw_direction(phase, forward, m->random, &pdf);
  bool is_ground;
  np_spectrum light = np_surroundings_incoming(m->world, m->lighting, m->settings, m->world->cloud_sky, position,
                                               direction, NP_KERNEL(np_march_shadow), m->random, &is_ground);
  light = np_spectrum_multiply(light, np_spectrum_multiply(weight, share[chosen]));
  if (np_spectrum_is_zero(light)) return;
  float transmittances[NP_APPROXIMATION_TERMS_MAX];
  np_march_terms terms;
  fill_transmittances(m, position, direction, error, transmittances);
  fill_terms(m, np_instances_get_index(&m->world->clouds, s->volume[chosen]), false,
             np_vec3_versine(forward, direction), &terms);
  light = np_spectrum_scale(light, draw_weight / pdf);
  add_terms(m, is_ground ? NP_COMPONENT_GROUND : NP_COMPONENT_SKY, &terms, transmittances, light);
}

/* One exponential step. */
void NP_KERNEL(np_march_light_approximation)(np_march *m, const np_step *s) {
  const double middle = np_step_middle(s);
  float total = 0.0f;
  for (unsigned i = 0; i < s->count; i++) total += s->depth[i];
  const np_aerial_perspective air = np_march_get_air(m, middle);
  const float opacity = np_opacity(total), loss = m->transmittance * opacity, error = np_march_get_light_error(m, loss);
  const float shown_share = np_march_get_shown_share(m, s);
  np_march_add(m, NP_COMPONENT_AIR, loss * shown_share, air.inscatter);
  m->out->held_out += loss - loss * shown_share;
  m->carry = m->transmittance =
      np_march_roulette(m->transmittance * (1.0f - opacity), m->settings->transmittance_end, m->random);
  const np_dvec3 position = np_dvec3_along(m->ray->origin, m->ray->direction, middle),
                 lit_place = np_march_get_lit_place(m, s, middle);
  const float sun_share = np_surroundings_get_sun_share(m->world, m->lighting, m->settings, lit_place,
                                                        NP_KERNEL(np_march_sun_transmittance), m->random);
  np_spectrum share[NP_INSTANCES_MAX];
  for (unsigned i = 0; i < s->count; i++) {
    share[i] = np_spectrum_grey(0.0f);
    if (s->volume[i]->is_held_out) continue;
    np_integrator_add_cloud(m->ray, s->volume[i], loss * s->depth[i] / total);
    share[i] = np_spectrum_scale(s->volume[i]->albedo, s->depth[i] / total);
    np_integrator_add_opaque(
        m->out, loss * s->depth[i] / total,
        &(np_opaque){.distance_m = middle, .albedo = s->volume[i]->albedo, .sun_share = sun_share});
  }
  if (m->settings->scattering_max == 0) return;
  const float sun = np_march_roulette(loss, 0.1f * m->settings->tolerance, m->random),
              sky = np_march_roulette(loss, 0.1f, m->random);
  if (sun > 0.0f) add_sun(m, position, lit_place, s, share, error, np_spectrum_scale(air.transmittance, sun));
  if (sky > 0.0f) add_surroundings(m, position, s, share, error, np_spectrum_scale(air.transmittance, sky));
}
