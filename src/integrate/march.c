/* SPDX-License-Identifier: Apache-2.0 */
/* The march: exponential steps through the clouds, equal in opacity (integrate/step.h).
 *
 * Over a step of optical depth h with source S per unit of extinction, the equation of transfer gives
 * L += T·S·(1 − e^{−h}), T the transmittance to the step: exact where S is constant, whatever the extinction does, and
 * where it is linear too, with S from the mean place of what the step hides. Air between camera and step enters by
 * parts: with I(t) its in-scatter and Tₐ(t) its transmittance to t, ∫T dI = T(end)·I(end) + ∫I·(−dT), so that each step
 * adds (Tₐ·S + I)·(−ΔT).
 *
 * Where the view has a solution of the multiple scattering (light/multi_scatter.c) the march runs in its scaled
 * medium, with σ′ = Σ k·σ for σ. S is sunlight that came as if straight, times the direct term D
 * (light/scaled_phase.c), and the solution's moments towards the camera. What lies behind is seen twice: through the
 * true transmittance, and, spread by the forward peak too little to matter, through what the scaled one has more.
 *
 * Otherwise S is sunlight through the optical depth towards the sun, and light from sky or ground along one drawn
 * direction, and a look (integrate/look.h) may stand for light scattered more than once.
 * Compiled once per instruction-set level.
 */
#include "core/isa.h"
#include "integrate/emission.h"
#include "integrate/look.h"
#include "integrate/step.h"
#include "integrate/surroundings.h"
#include "light/ground_cache.h"
#include "light/sun_cache.h"

void NP_KERNEL(np_march_sample)(const np_scene_view *view, const np_integrator_settings *settings,
                                const np_camera_ray *ray, np_random *random, np_integrator_sample *out);
double NP_KERNEL(np_march_half_distance)(const np_scene_view *view, const np_camera_ray *ray, double distance_max);

/* Opacity of a ray below which its error need not shrink with it. */
static const float opacity_least = 1e-4f;

typedef struct march {
  const np_scene_view *view;
  const np_integrator_settings *settings;
  const np_camera_ray *ray;
  np_random *random;
  np_vec3 to_sun;
  /* np_look_fill_phases() of each cloud of the view: the angle to the sun is constant along the ray. */
  float sun_phase[NP_VIEW_VOLUMES_MAX][NP_LOOK_TERMS_MAX];
  const np_multi_scatter *scatter; /* NULL: a look stands for it */
  np_peak_column columns[NP_VIEW_VOLUMES_MAX];
  float harmonics[NP_HARMONIC_COUNT_MAX]; /* towards the camera */
  np_spectrum scaled;                     /* transmittance of the scaled medium; grey 1 stays where there is none */
  np_spectrum peak_depth;                 /* optical depth that the scaled medium has less */
  float carry;                            /* what later steps can still contribute; 0 ends the ray */
  float transmittance;
  np_step step;         /* being gathered */
  np_step_knot knot;    /* where it ends */
  double step_length_m; /* of the longest */
  np_integrator_sample *out;
} march;

/* Optical depth of one cloud towards the sun: looked up where a cache knows it, else walked for. */
static float find_cloud_depth(const np_scene_view *view, unsigned cloud, np_dvec3 position, np_vec3 to_sun,
                              const np_depth_question *question, float faded) {
  const np_sun_cache *cache = view->sun_cache;
  const float known = cache ? np_sun_lattice_find(&cache->lattices[cloud], cache->depth_end, position, to_sun)
                            : NP_SUN_DEPTH_UNKNOWN;
  if (known != NP_SUN_DEPTH_UNKNOWN) return known;
  return np_track_volume_depth(&view->volumes[cloud], position, to_sun, INFINITY, question, faded);
}

static float find_sun_depth(const np_scene_view *view, np_dvec3 position, np_vec3 to_sun,
                            const np_depth_question *question) {
  float depth = 0.0f;
  for (unsigned v = 0; v < view->volume_count && question->fade * depth < NP_FAINT_DEPTH; v++)
    depth += find_cloud_depth(view, v, position, to_sun, question, question->fade * depth);
  return depth;
}

/* Sunlight through the clouds on the ground. Where the clouds' own light on it is known, what the forward peak lets
 * down belongs to the beam. */
static float march_shadow(const np_scene_view *view, const np_integrator_settings *settings, np_dvec3 position,
                          np_vec3 to_sun, np_random *random) {
  (void)random;
  const np_depth_question question = {.fade = 1.0f, .error = settings->tolerance};
  if (!view->ground_cache) return np_transmittance(find_sun_depth(view, position, to_sun, &question));
  float faded = 0.0f;
  for (unsigned v = 0; v < view->volume_count && faded < NP_FAINT_DEPTH; v++) {
    const float fade = view->ground_cache->fade[v];
    const np_depth_question own = {fade, question.error};
    faded += fade * find_cloud_depth(view, v, position, to_sun, &own, faded);
  }
  return np_transmittance(faded);
}

static void set_sun_phases(march *m) {
  const np_vec3 d = m->ray->direction;
  const float versine = np_versine(d.x, d.y, d.z, m->to_sun.x, m->to_sun.y, m->to_sun.z);
  for (unsigned i = 0; i < m->view->volume_count; i++)
    np_look_fill_phases(&m->settings->look, &m->view->volumes[i].phase, versine, m->sun_phase[i]);
}

/* The same for the direct term of the scaled medium. */
static void set_columns(march *m) {
  const np_vec3 d = m->ray->direction;
  const float versine = np_versine(d.x, d.y, d.z, m->to_sun.x, m->to_sun.y, m->to_sun.z);
  for (unsigned i = 0; i < m->view->volume_count; i++)
    np_scaled_phase_fill_column(&m->scatter->phases[i], versine, &m->columns[i]);
  np_harmonics_eval(m->scatter->grid.degree, np_vec3_scale(d, -1.0f), m->harmonics);
}

static void add_scaled(np_integrator_sample *out, np_component component, float scale, np_spectrum radiance) {
  out->component[component] = np_spectrum_add_scaled(out->component[component], scale, radiance);
}

/* Light scattered once, and what stands for more. */
static void add_terms(march *m, np_component single, const float *phases, const float *transmittances,
                      np_spectrum light) {
  const np_look *look = &m->settings->look;
  float multiple = 0.0f;
  for (unsigned n = 1; n < np_look_count_terms(look); n++) multiple += phases[n] * transmittances[n];
  add_scaled(m->out, single, look->gain * phases[0] * transmittances[0], light);
  add_scaled(m->out, NP_COMPONENT_MULTIPLE, look->gain * multiple, light);
}

/* What of the light from `direction` the clouds let through. */
static void fill_transmittances(const march *m, np_dvec3 position, np_vec3 direction, float error,
                                float out[NP_LOOK_TERMS_MAX]) {
  const np_depth_question question = {np_look_fade(&m->settings->look), error};
  np_look_fill_transmittances(&m->settings->look, np_track_depth(m->view, position, direction, &question), out);
}

/* Sunlight scattered towards the camera at `position`, weighted: `share[i]` is what part of the step's opacity, times
 * albedo, its i-th cloud has. */
static void add_sun(march *m, np_dvec3 position, const np_step *s, const np_spectrum *share, float error,
                    np_spectrum weight) {
  const np_look *look = &m->settings->look;
  const np_spectrum sun = np_spectrum_multiply(np_light_sun(m->view, position, m->to_sun), weight);
  if (np_spectrum_is_zero(sun)) return;
  const bool is_slope = look->kind == NP_LOOK_DERIVATIVE;
  float transmittances[NP_LOOK_TERMS_MAX];
  if (is_slope) {
    transmittances[0] = np_look_slope(look, m->view, position, m->to_sun);
  } else {
    const np_depth_question question = {np_look_fade(look), error};
    np_look_fill_transmittances(look, find_sun_depth(m->view, position, m->to_sun, &question), transmittances);
  }
  for (unsigned i = 0; i < s->count; i++) {
    const np_view_volume *volume = s->volume[i];
    const float even = 1.0f / NP_PI_F, *phases = is_slope ? &even : m->sun_phase[volume - m->view->volumes];
    const np_spectrum light = np_spectrum_scale(sun, np_look_weight(look, volume, position));
    add_terms(m, NP_COMPONENT_SUN, phases, transmittances, np_spectrum_multiply(light, share[i]));
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

/* A direction from an even mixture of the phase function and the whole sphere: the first finds what shines through the
 * cloud, the second what shines on it from the side that the cloud does not throw forward. */
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
    value = np_phase_eval(phase, np_versine(forward.x, forward.y, forward.z, direction.x, direction.y, direction.z));
  }
  *out_pdf = 0.5f * (value + even);
  return direction;
}

/* Light from sky or ground along one direction. */
static void add_surroundings(march *m, np_dvec3 position, const np_step *s, const np_spectrum *share, float error,
                             np_spectrum weight) {
  float draw_weight, pdf;
  const unsigned chosen = draw_cloud(share, s->count, m->random, &draw_weight);
  if (draw_weight <= 0.0f) return;
  const np_phase *phase = &s->volume[chosen]->phase;
  const np_vec3 forward = m->ray->direction;
  const np_vec3 direction = draw_direction(phase, forward, m->random, &pdf);
  bool is_ground;
  np_spectrum light =
      np_surroundings_incoming(m->view, m->settings, position, direction, march_shadow, m->random, &is_ground);
  light = np_spectrum_multiply(light, np_spectrum_multiply(weight, share[chosen]));
  if (np_spectrum_is_zero(light)) return;
  float transmittances[NP_LOOK_TERMS_MAX], phases[NP_LOOK_TERMS_MAX];
  fill_transmittances(m, position, direction, error, transmittances);
  np_look_fill_phases(&m->settings->look, phase,
                      np_versine(forward.x, forward.y, forward.z, direction.x, direction.y, direction.z), phases);
  light = np_spectrum_scale(light, draw_weight / pdf);
  add_terms(m, is_ground ? NP_COMPONENT_GROUND : NP_COMPONENT_SKY, phases, transmittances, light);
}

/* Optical depths of the scaled medium and of its forward peak from a point to the sun. */
static void track_scaled_depth(const march *m, np_dvec3 position, float error, np_spectrum *out_scaled,
                               np_spectrum *out_peak) {
  *out_scaled = *out_peak = np_spectrum_grey(0.0f);
  float faded = 0.0f;
  for (unsigned v = 0; v < m->view->volume_count && faded < NP_FAINT_DEPTH; v++) {
    const np_view_volume *volume = &m->view->volumes[v];
    const float forward = m->scatter->phases[v].forward;
    const np_depth_question question = {1.0f - forward * np_spectrum_max(volume->albedo), error};
    const float own = find_cloud_depth(m->view, v, position, m->to_sun, &question, faded);
    faded += question.fade * own;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      const float peak = own * forward * volume->albedo.band[b];
      out_peak->band[b] += peak;
      out_scaled->band[b] += own - peak;
    }
  }
}

/* Sunlight thrown towards the camera by each cloud of a step; `scattering` is its ϖτ times what one unit of that counts
 * for. Scattered once it is T·p·e^{−τ}, which is part of D. */
static void add_scaled_sun(march *m, np_dvec3 position, const np_step *s, float error, const np_spectrum *scattering) {
  const np_spectrum sun = np_light_sun(m->view, position, m->to_sun);
  if (np_spectrum_is_zero(sun)) return;
  np_spectrum depth, peak;
  track_scaled_depth(m, position, error, &depth, &peak);
  for (unsigned i = 0; i < s->count; i++) {
    const np_peak_column *column = &m->columns[s->volume[i] - m->view->volumes];
    np_spectrum single, multiple;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      const float light = sun.band[b] * np_transmittance(depth.band[b]) * scattering[i].band[b];
      const float once = np_transmittance(peak.band[b] + m->peak_depth.band[b]) * (column->broad + column->sharp);
      single.band[b] = light * once;
      multiple.band[b] = light * (np_peak_column_eval(column, peak.band[b], m->peak_depth.band[b]) - once);
    }
    add_scaled(m->out, NP_COMPONENT_SUN, 1.0f, single);
    add_scaled(m->out, NP_COMPONENT_MULTIPLE, 1.0f, multiple);
  }
}

static void add_solution(march *m, np_dvec3 position, const np_step *s, const np_spectrum *scattering) {
  np_light_moments moments;
  np_multi_scatter_gather(m->scatter, position, &moments);
  for (unsigned i = 0; i < s->count; i++) {
    const np_scaled_phase *phase = &m->scatter->phases[s->volume[i] - m->view->volumes];
    const np_spectrum light = np_multi_scatter_towards(&moments, phase, m->harmonics);
    add_scaled(m->out, NP_COMPONENT_MULTIPLE, 1.0f, np_spectrum_multiply(light, scattering[i]));
  }
}

/* A weight below `least` becomes `least` with that probability which keeps its mean, or nothing: so that a light which
 * counts for little is seldom walked for. */
static float settle(float weight, float least, np_random *random) {
  if (weight >= least) return weight;
  return np_random_float(random) * least < weight ? least : 0.0f;
}

/* Carries the ray past a step of the scaled medium, and ends a faint one or makes it stand for others. */
static void pass_scaled(march *m, const np_spectrum *depth, const np_spectrum *peak, float opacity) {
  m->scaled = np_spectrum_multiply(m->scaled, np_spectrum_exp_negative(*depth));
  m->peak_depth = np_spectrum_add(m->peak_depth, *peak);
  m->transmittance *= 1.0f - opacity;
  m->carry = np_spectrum_max(m->scaled);
  const float settled = settle(m->carry, m->settings->transmittance_end, m->random);
  if (settled == m->carry) return;
  const float factor = settled / m->carry;
  m->scaled = np_spectrum_scale(m->scaled, factor);
  m->transmittance *= factor;
  m->carry = settled;
}

/* What the light of a step that hides `opacity` may be wrong by, so that the ray's is right to the tolerance: with
 * look-ups that go as error^{−½}, the fewest are needed where it is as opacity^{−⅔}. A step hides a quarter of its ray
 * or so. */
static float find_light_error(const march *m, float opacity) {
  const float all = np_maxf(1.0f - m->carry + opacity, opacity_least);
  const float ratio = 0.25f * all / np_maxf(opacity, 1e-6f);
  return m->settings->tolerance * cbrtf(ratio * ratio);
}

/* One exponential step in the scaled medium. What a step sees of the peak's depth is that at its middle. */
static void light_scaled(march *m, const np_step *s) {
  const double middle = np_step_middle(s);
  np_spectrum scattering[NP_VIEW_VOLUMES_MAX], depth = np_spectrum_grey(0.0f), peak = depth, whole = depth, weight;
  float total = 0.0f;
  for (unsigned i = 0; i < s->count; i++) {
    scattering[i] = np_spectrum_scale(s->volume[i]->albedo, s->depth[i]);
    peak = np_spectrum_add_scaled(peak, m->scatter->phases[s->volume[i] - m->view->volumes].forward, scattering[i]);
    whole = np_spectrum_add(whole, scattering[i]);
    total += s->depth[i];
  }
  const np_aerial_perspective air =
      np_light_air(m->view, m->view->camera_sky, m->ray->origin, m->ray->direction, middle);
  const float opacity = -expm1f(-total);
  add_scaled(m->out, NP_COMPONENT_AIR, m->transmittance * opacity, air.inscatter);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    depth.band[b] = total - peak.band[b];
    weight.band[b] = m->scaled.band[b] * np_step_weight(depth.band[b]) * air.transmittance.band[b];
  }
  np_integrator_add_opaque(m->out, m->transmittance * opacity, middle, np_spectrum_scale(whole, 1.0f / total));
  const float loss = m->carry * -expm1f(-np_spectrum_max(depth));
  const np_spectrum half_peak = np_spectrum_scale(peak, 0.5f);
  m->peak_depth = np_spectrum_add(m->peak_depth, half_peak);
  for (unsigned i = 0; i < s->count; i++) scattering[i] = np_spectrum_multiply(scattering[i], weight);
  const np_dvec3 position = np_dvec3_along(m->ray->origin, m->ray->direction, middle);
  add_solution(m, position, s, scattering);
  add_scaled_sun(m, position, s, find_light_error(m, loss), scattering);
  pass_scaled(m, &depth, &half_peak, opacity);
}

/* One exponential step. */
static void light_single(march *m, const np_step *s) {
  const double middle = np_step_middle(s);
  float total = 0.0f;
  for (unsigned i = 0; i < s->count; i++) total += s->depth[i];
  const np_aerial_perspective air =
      np_light_air(m->view, m->view->camera_sky, m->ray->origin, m->ray->direction, middle);
  const float opacity = -expm1f(-total), loss = m->transmittance * opacity, error = find_light_error(m, loss);
  add_scaled(m->out, NP_COMPONENT_AIR, loss, air.inscatter);
  m->carry = m->transmittance = settle(m->transmittance * (1.0f - opacity), m->settings->transmittance_end, m->random);
  np_spectrum share[NP_VIEW_VOLUMES_MAX];
  for (unsigned i = 0; i < s->count; i++) {
    share[i] = np_spectrum_scale(s->volume[i]->albedo, s->depth[i] / total);
    np_integrator_add_opaque(m->out, loss * s->depth[i] / total, middle, s->volume[i]->albedo);
  }
  if (m->settings->scattering_max == 0) return;
  const np_dvec3 position = np_dvec3_along(m->ray->origin, m->ray->direction, middle);
  const float sun = settle(loss, 0.1f * m->settings->tolerance, m->random), sky = settle(loss, 0.1f, m->random);
  if (sun > 0.0f) add_sun(m, position, s, share, error, np_spectrum_scale(air.transmittance, sun));
  if (sky > 0.0f) add_surroundings(m, position, s, share, error, np_spectrum_scale(air.transmittance, sky));
}

/* What glows, seen through the clouds; what the forward peak of their scattering brings beyond that, as if it had come
 * straight, counts as scattered. */
static void add_emission(march *m, double distance_end) {
  np_spectrum factors[NP_VIEW_VOLUMES_MAX], straight, scaled;
  for (unsigned v = 0; v < m->view->volume_count && m->scatter; v++)
    factors[v] = np_spectrum_subtract(np_spectrum_grey(1.0f),
                                      np_spectrum_scale(m->view->volumes[v].albedo, m->scatter->phases[v].forward));
  np_emission_march(m->view, m->ray, distance_end, m->scatter ? factors : NULL, &straight, &scaled);
  add_scaled(m->out, NP_COMPONENT_EMISSION, 1.0f, straight);
  add_scaled(m->out, NP_COMPONENT_MULTIPLE, 1.0f, np_spectrum_subtract(scaled, straight));
}

/* ---- From cells to steps ---- */

/* Sets out for the next knot, `share` of a step away. */
static void set_knot(march *m, float share) {
  m->knot = (np_step_knot){.budget = share * share * share * np_step_budget(m->settings->tolerance, m->carry),
                           .distance = (double)share * m->step_length_m};
}

/* Lights what has been gathered. */
static void close_step(march *m) {
  if (m->step.hiding > 0.0f) (m->scatter ? light_scaled : light_single)(m, &m->step);
  m->step.count = 0;
}

/* Ends a step where its clouds do. What comes next goes on towards the same knot. */
static void break_step(march *m) {
  if (m->step.count == 0) return;
  const float gone = cbrtf(m->knot.hiding * m->knot.bound * m->knot.bound / m->knot.budget);
  close_step(m);
  set_knot(m, np_clampf(1.0f - gone, 0.1f, 1.0f));
}

/* Gathers a piece of constant extinction, of which steps count `hiding` a metre, and `bound` at the cell's densest
 * point; lights the steps that end in it. */
static void pass_piece(march *m, const np_media *all, const np_stretch *s, const float *extinction, double begin,
                       double length, float hiding, float bound) {
  if (!(hiding > 0.0f)) {
    break_step(m);
    return;
  }
  while (length > 0.0 && m->carry > 0.0f) {
    if (m->step.count == 0) np_step_open(&m->step, all, s, begin);
    const float u = m->knot.hiding + hiding * (float)length, v = m->knot.bound + bound * (float)length;
    double part = fmin(length, fmax(m->knot.distance, 0.0));
    if (u * v * v > m->knot.budget) part = fmin(part, (double)np_step_room(&m->knot, hiding, bound));
    np_step_add(&m->step, extinction, part, hiding * (float)part);
    m->knot.hiding += hiding * (float)part;
    m->knot.bound += bound * (float)part;
    m->knot.distance -= part;
    const bool is_knot = part < length;
    begin += part;
    length -= part;
    if (!is_knot) continue;
    close_step(m);
    set_knot(m, 1.0f);
  }
}

/* What one metre of a cloud of the view counts for in a step's hiding, over its extinction. */
static float find_hiding(const march *m, const np_view_volume *volume) {
  if (!m->scatter) return 1.0f;
  return 1.0f - m->scatter->phases[volume - m->view->volumes].forward * np_spectrum_max(volume->albedo);
}

/* The same of all that is active in a stretch, at the densest points of its cells. */
static float find_bound(const np_media *all, const np_stretch *s, const float *hiding) {
  float sum = 0.0f;
  for (unsigned i = 0; i < s->count; i++) sum += hiding[i] * np_medium_bound(&all->medium[s->active[i]]);
  return sum;
}

/* The cloud of a stretch whose voxels are smallest. */
static const np_medium *find_finest(const np_media *all, const np_stretch *s) {
  const np_medium *finest = &all->medium[s->active[0]];
  for (unsigned i = 1; i < s->count; i++)
    if (all->medium[s->active[i]].voxels_per_m > finest->voxels_per_m) finest = &all->medium[s->active[i]];
  return finest;
}

/* Pieces of a stretch whose error is small against what the ray has hidden with them. The depth counts for more than
 * one towards a light, as all that lies behind is seen through it. */
static int count_pieces(const march *m, const np_media *all, const np_stretch *s, const float *hiding, float bound) {
  const float length = (float)(s->end - s->begin);
  float variation = 0.0f;
  for (unsigned i = 0; i < s->count; i++)
    variation += hiding[i] * np_medium_variation(&all->medium[s->active[i]]) * length;
  const float sheet = bound / find_finest(all, s)->voxels_per_m;
  const float hidden = np_minf(np_maxf(1.0f - m->carry + m->carry * sheet, opacity_least), 1.0f);
  const int count = np_track_count_samples(2.0f * variation * m->carry / (m->settings->tolerance * hidden));
  return count > 1 ? count : 1;
}

/* Cuts a part of a stretch into equal pieces, and those into steps. */
static void cross_part(march *m, const np_media *all, const np_stretch *s, double from, double to, int count,
                       const float *hiding, float bound) {
  float found[NP_VIEW_VOLUMES_MAX][NP_BRICK_LINE];
  const double length = (to - from) / count;
  for (int first = 0; first < count && m->carry > 0.0f; first += NP_BRICK_LINE) {
    const int some = count - first < NP_BRICK_LINE ? count - first : NP_BRICK_LINE;
    const double begin = from + length * first;
    for (unsigned i = 0; i < s->count; i++)
      np_medium_fill_extinction(&all->medium[s->active[i]], begin, length, some, found[i]);
    for (int k = 0; k < some && m->carry > 0.0f; k++) {
      float extinction[NP_VIEW_VOLUMES_MAX], sum = 0.0f;
      for (unsigned i = 0; i < s->count; i++) sum += hiding[i] * (extinction[i] = found[i][k]);
      pass_piece(m, all, s, extinction, begin + length * k, length, sum, bound);
    }
  }
}

/* Cuts a stretch into pieces, which end at voxels' faces where there are as many of them: between faces the field is
 * smooth. */
static void cross(march *m, const np_media *all, const np_stretch *s) {
  float hiding[NP_VIEW_VOLUMES_MAX];
  for (unsigned i = 0; i < s->count; i++) hiding[i] = find_hiding(m, all->medium[s->active[i]].volume);
  if (!np_step_goes_on(&m->step, all, s)) break_step(m);
  const float bound = find_bound(all, s, hiding);
  const int count = count_pieces(m, all, s, hiding, bound);
  const np_medium *finest = find_finest(all, s);
  const double pieces_per_m = count / (s->end - s->begin);
  if (pieces_per_m < (double)finest->voxels_per_m) {
    cross_part(m, all, s, s->begin, s->end, count, hiding, bound);
    return;
  }
  for (double t = s->begin, face; t < s->end && m->carry > 0.0f; t = face) {
    face = np_medium_find_face(finest, t, s->end);
    cross_part(m, all, s, t, face, (int)ceil((face - t) * pieces_per_m), hiding, bound);
  }
}

/* The longest step, m: of that cloud whose voxels are smallest. */
static double find_step_length(const march *m, const np_media *all) {
  float voxels_per_m = 0.0f;
  for (unsigned i = 0; i < all->count; i++) voxels_per_m = np_maxf(voxels_per_m, all->medium[i].voxels_per_m);
  return (double)(m->settings->step_voxels / voxels_per_m);
}

static void start(march *m, const np_scene_view *view, const np_integrator_settings *settings, const np_camera_ray *ray,
                  np_random *random, np_integrator_sample *out) {
  m->view = view;
  m->settings = settings;
  m->ray = ray;
  m->random = random;
  m->scatter = settings->scattering_max > 1 ? view->multi_scatter : NULL;
  m->scaled = np_spectrum_grey(1.0f);
  m->peak_depth = np_spectrum_grey(0.0f);
  m->carry = m->transmittance = 1.0f;
  m->step.count = 0;
  m->out = out;
}

void NP_KERNEL(np_march_sample)(const np_scene_view *view, const np_integrator_settings *settings,
                                const np_camera_ray *ray, np_random *random, np_integrator_sample *out) {
  *out = (np_integrator_sample){.transmittance = 1.0f};
  np_ground_hit hit;
  out->is_ground_behind = np_ground_intersect(view, ray->origin, ray->direction, &hit);
  march m; /* member by member: its tables are large, and filled for the clouds there are */
  start(&m, view, settings, ray, random, out);
  np_media all;
  np_media_start(&all, view, ray, out->is_ground_behind ? hit.distance_m : HUGE_VAL);
  if (all.count > 0) {
    m.to_sun = np_light_sample_sun(view, np_random_float(random), np_random_float(random));
    m.scatter ? set_columns(&m) : set_sun_phases(&m);
    m.step_length_m = find_step_length(&m, &all);
    set_knot(&m, ray->jitter);
    np_stretch s;
    while (m.carry > 0.0f && np_media_next(&all, &s)) cross(&m, &all, &s);
    close_step(&m);
  }
  if (view->emission) add_emission(&m, out->is_ground_behind ? hit.distance_m : HUGE_VAL);
  out->transmittance = m.transmittance;
  np_surroundings_add_behind(view, settings, ray, out->is_ground_behind ? &hit : NULL, m.transmittance, march_shadow,
                             random, out);
  if (m.scatter)
    np_surroundings_add_peak(view, settings, ray, out->is_ground_behind ? &hit : NULL,
                             np_spectrum_subtract(m.scaled, np_spectrum_grey(m.transmittance)), march_shadow, random,
                             out);
}

double NP_KERNEL(np_march_half_distance)(const np_scene_view *view, const np_camera_ray *ray, double distance_max) {
  np_media all;
  np_stretch s;
  float depth = 0.0f;
  np_media_start(&all, view, ray, distance_max);
  while (np_media_next(&all, &s)) {
    const double length = (s.end - s.begin) / NP_BRICK_EDGE;
    float extinction[NP_BRICK_EDGE] = {0.0f}, own[NP_BRICK_LINE];
    for (unsigned i = 0; i < s.count; i++) {
      np_medium_fill_extinction(&all.medium[s.active[i]], s.begin, length, NP_BRICK_EDGE, own);
      for (int k = 0; k < NP_BRICK_EDGE; k++) extinction[k] += own[k];
    }
    for (int k = 0; k < NP_BRICK_EDGE; k++) {
      const float added = extinction[k] * (float)length, missing = NP_LN2_F - depth;
      if (added >= missing) return s.begin + length * ((double)k + (double)(missing / added));
      depth += added;
    }
  }
  return INFINITY;
}
